//! Long lattices: one template of code a class of sites, never one a site.
//!
//! A lattice of N sites is built on a *proxy lattice* of a few sites, written out. Every map of the method is local,
//! so the code of a site at the proxy's centre is the code of every interior site. Next to an open boundary each of
//! the first and last W sites has code of its own. A step is a sequence of *stages* that sweep over the sites, each
//! reading the fields of earlier stages in a neighbourhood. Time and memory are O(N).
//!
//! - [`geometry`]: families, axes, proxies, classes of sites.
//! - [`cells`]: lattices whose code repeats every few sites.
//! - `source`: lattice systems that can be written out at any length.
//! - [`reach`]: how far templates look, as they are written.
//! - [`locality`]: which lattice is written out in the place of a long one.
//! - [`stages`]: how a realization writes its maps as stages.
//! - `edges`: inputs of the sites at the ends of axes, looked up once.
//! - `blocks`: sites as lanes of a kernel.
//! - `fields`: what stages read and write.
//! - `ranges`: ranges of sites.
//! - `stencil`: the code of one class of sites in one stage, and its sweep over them.
//! - [`program`]: stages compiled to stencils.
//! - [`map`](mod@map): step maps of long lattices.
//! - [`implicit`]: step maps that solve for one point.
//! - [`swept`]: maps that are products of flows by sweeps.
//! - `stepper`: the linear iteration for β̂(L(y)) = x.
//! - [`slopes`]: tangents and covectors by sweeps.
//! - `differential`: the differential of that iteration's solution.
//! - `sites`: numbers of every site.
//! - [`observables`]: sums over sites.
//! - [`numbers`]: a lattice as a system of numbers.
//! - `poles`: what no step crosses.

mod blocks;
pub mod cells;
mod differential;
mod edges;
mod fields;
pub mod geometry;
pub mod implicit;
pub mod locality;
pub mod map;
pub mod numbers;
pub mod observables;
mod poles;
pub mod program;
mod ranges;
pub mod reach;
mod sites;
pub mod slopes;
mod source;
pub mod stages;
mod stencil;
mod stepper;
pub mod swept;
#[cfg(test)]
mod tests;
pub mod wavefront;

pub use cells::Cells;
pub use fields::Fields;
pub use geometry::{Axis, LatticeGeometry, PerAxis, Proxy};
pub use implicit::{ImplicitSweeps, ProxyCode};
pub use locality::proxy_of;
pub use map::LatticeMap;
pub use numbers::LatticeNumbers;
pub use observables::LatticeObservables;
pub use program::{LatticeProgram, Prepared};
pub use reach::TemplateReach;
pub use slopes::{LatticeSlopes, SlopesAlong};
pub use source::LatticeSource;
pub use stages::{Field, StageBuilder, StageCode, StageEnds};
pub use swept::{Swept, SweptKernels, add_from_field};
pub use wavefront::{Finite, Front, PartSites, SweptPart, wavefront};
