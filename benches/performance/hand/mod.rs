//! Baselines written by hand for one dimension and one trajectory: no solver that serves others, no
//! function called through a pointer, the platform's own elementary functions.

pub mod dop853;
pub mod formulas;
pub mod gauss;
pub mod newton;
pub mod splitting;
