//! Section 5 of the paper: every figure and number, measured beside what the paper prints.
//!
//! - [`FIGURES`]: what the paper prints;
//! - [`reproduce`]: one figure, measured;
//! - [`RealizationPoint`]: the paper's realization error at a point;
//! - [`reproduction_page`]: figures as a page;
//! - `realization`, `tensor`, `drift`, `ode45`: the four kinds of figures;
//! - `scene`, `order`, `figure`: runs, fitted orders, results.

mod drift;
mod error;
mod figure;
mod ode45;
mod order;
mod page;
mod paper;
mod realization;
mod scene;
mod tensor;

use leafwise_core::Registry;

pub use error::ReproduceError;
pub use figure::{Finding, Reproduced};
pub use order::ErrorCurve;
pub use page::reproduction_page;
pub use paper::{Claim, FIGURES, PaperFigure, find};
pub use realization::RealizationPoint;

/// Measures a figure of the paper.
///
/// # Errors
/// [`ReproduceError`]; with the built-in parts, a defect of the program.
pub fn reproduce(
    figure: &'static PaperFigure,
    registry: &Registry,
) -> Result<Reproduced, ReproduceError> {
    match figure.number {
        1 | 2 | 9 => realization::reproduce(figure, registry),
        3 => drift::rigid_body(figure, registry),
        4 => ode45::reproduce(figure, registry),
        5 | 8 => tensor::reproduce(figure, registry),
        _ => drift::lotka_volterra(figure, registry),
    }
}
