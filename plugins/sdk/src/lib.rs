//! Leafwise plugins in Rust: implement a trait for each part, name the parts in [`export_plugin!`],
//! build a `cdylib`.
//!
//! ```
//! use leafwise_plugin_sdk::{Create, Fail, Info, Part, System, export_plugin};
//!
//! /// ẋ = {H, x} with {x1, x2} = −1 and H = (x1² + x2²)/2.
//! struct Oscillator;
//!
//! impl Part for Oscillator {
//!     const INFO: Info = Info::new(c"acme/oscillator", c"harmonic oscillator");
//!     fn create(_: &Create<'_>) -> Result<Self, Fail> {
//!         Ok(Self)
//!     }
//! }
//!
//! impl System for Oscillator {
//!     fn dimension(&self) -> usize {
//!         2
//!     }
//!     fn tensor(&mut self, _y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Fail> {
//!         out.copy_from_slice(&[-v[1], v[0]]);
//!         Ok(())
//!     }
//!     fn hamiltonian(&mut self, y: &[f64]) -> Result<f64, Fail> {
//!         Ok(0.5 * (y[0] * y[0] + y[1] * y[1]))
//!     }
//!     fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), Fail> {
//!         out.copy_from_slice(y);
//!         Ok(())
//!     }
//! }
//!
//! export_plugin! { id: "acme", license: "MIT", parts: [system Oscillator] }
//! # fn main() {}
//! ```
//!
//! Every part is a [`Part`]. By kind it is a [`System`], a [`Realization`] (in a cotangent chart:
//! [`ChartRealization`]), a dynamic approximation ([`OneForm`], [`Embedding`] or [`Flow`]) or a
//! [`StepMap`]. With [`Info::formulas`] a part offers formulas as well, or, in the macro as
//! `system_formulas INFO` and so on, nothing else: then everything works for it that works for a
//! built-in part.
//!
//! Panics are caught at the boundary and end the instance. What a plugin must not do, threads and
//! floating-point state above all, is said in `leafwise-plugin-abi`.

#[cfg(panic = "abort")]
compile_error!(
    "a Leafwise plugin needs panic = \"unwind\": with \"abort\" a panic would end the host"
);

mod chart;
mod create;
mod dynamics;
mod export;
mod fail;
mod guard;
mod host;
mod info;
mod instance;
mod map;
mod realization;
mod step_map;
mod system;

pub use chart::ChartRealization;
pub use create::Create;
pub use dynamics::{Embedding, Flow, OneForm};
pub use export::{PartPointer, abi, formulas_part};
pub use fail::Fail;
pub use host::{HostRealization, HostSystem};
pub use info::{Formula, Info, Parameter, Structure};
pub use instance::Part;
pub use map::Steps;
pub use realization::Realization;
pub use step_map::StepMap;
pub use system::System;

#[doc(hidden)]
pub use {
    dynamics::{embedding_part, flow_part, one_form_part},
    realization::realization_part,
    step_map::step_map_part,
    system::system_part,
};
