//! Poisson integrators by splitting: H = Σ H_i with exact flows of the pieces.
//!
//! Each H_i generates a flow that is known in closed form. It is a Poisson map and keeps every Casimir, and so does
//! the product of these flows. Sources are McLachlan, Quispel, *Splitting methods*, Acta Numerica 11, 341–434 (2002);
//! Hairer, Lubich, Wanner, *Geometric Numerical Integration*, section VII.4.2. Strang's product φ¹_{h/2} ∘ … ∘ φʳ_h ∘
//! … ∘ φ¹_{h/2} has order 2 and is self-adjoint. So every symmetric composition applies over it.
//!
//! - [`field`]: vector fields in exact algebra.
//! - [`flow`]: the motion of one coordinate under a piece, found by its Lie series in exact algebra.
//! - [`piece`](mod@piece): a Hamiltonian with an exact flow, and what can be added to it.
//! - [`probe`]: Lie series in numbers, which rule out in microseconds that they end.
//! - `body`: the free rigid body, with vectors that turn with it.
//! - `kepler`: bodies that a centre attracts by the inverse square of the distance.
//! - `turning`: two vectors that turn about one axis.
//! - `sums`: sums of products as code.
//! - [`pieces`]: the pieces of a system's Hamiltonian.
//! - `rounding`: whether the flows round like the formulas; from code where they do not.
//! - [`entire`]: the entire functions that close the Lie series.
//! - [`code`]: flows as straight-line code.
//! - [`schedule`]: which flows a step takes.
//! - `arrangement`: the order in which the flows follow each other.
//! - [`splitting`]: Strang's product as a step map.
//! - `product`: its factors χ and χ*, the flows' product in one order and its adjoint, and products of both.
//! - `shears`: the same of systems of numbers that name parts with flows x + tX(x).
//! - `terms`: the flows of sites and of pairs of sites, for sums over pairs in a loop.
//! - [`lattice`]: the same on long lattices, by sweeps.
//! - `sublattices`: the same for damped spins, each in the field of the others.
//! - `tensor`: fields of Hamiltonians in exact algebra.
//! - `rates`, `display`: rates that are multiples of one, elements of the ring as text.

mod arrangement;
mod body;
pub mod code;
mod display;
pub mod entire;
pub mod field;
pub mod flow;
mod kepler;
pub mod lattice;
pub mod piece;
pub mod pieces;
pub mod probe;
mod product;
mod rates;
mod rounding;
mod rounds;
pub mod schedule;
mod shears;
pub mod splitting;
mod sublattices;
mod sums;
mod tensor;
mod terms;
mod turning;

pub use lattice::LatticeSplitting;
pub use piece::Piece;
pub use splitting::Splitting;
