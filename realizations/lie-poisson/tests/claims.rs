//! Claims about the realization of Lie–Poisson tensors, a module each.

mod closed_form;
mod common;
mod realization;
mod steps;
