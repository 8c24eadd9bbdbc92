//! Claims about the exact realizations of so(3)*.
//!
//! - [`realizations`]: dual pairs, sections, charts that agree, Karasev's series.
//! - [`steps`]: Hamilton–Jacobi steps over each of them.
//! - [`refusals`]: systems and parameters that do not fit.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

mod common;
mod realizations;
mod refusals;
mod steps;
