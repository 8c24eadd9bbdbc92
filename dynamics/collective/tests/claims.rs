//! Claims about collective integrators, a module each.

mod common;
mod midpoint;
mod numbers;
mod orders;
mod part;
mod tensor_defect;
