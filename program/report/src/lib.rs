//! Recorded data as one self-contained HTML page.
//!
//! - `data`: what a report is made from;
//! - `page`, `html`, `figure`: the page and its pieces;
//! - `comparison`, `work_precision`: methods compared, as a page of its own;
//! - `ensemble`: many members, as a page of its own;
//! - `reproduction`, `panel`: what a paper prints beside what was measured, as a page of its own;
//! - `drift`, `history`, `orbit`, `space`, `lattice`: the figures;
//! - `axis`, `decimate`, `canvas`, `stroke`: axes, long series reduced to pixels, drawing, points of orbits.

mod axis;
mod canvas;
mod comparison;
mod data;
mod decimate;
mod drift;
mod ensemble;
mod error;
mod figure;
mod history;
mod html;
mod lattice;
mod orbit;
mod page;
mod panel;
mod reproduction;
mod space;
mod stroke;
#[cfg(test)]
mod tests;
mod work_precision;

pub use comparison::{ComparisonData, render_comparison};
pub use data::{Ellipsoid, InvariantSeries, Outcome, ReportData, TimeSeries, Trajectory};
pub use ensemble::{Band, EnsembleData, render_ensemble};
pub use error::ReportError;
pub use page::render_report;
pub use panel::{Panel, PanelAxis, PanelSeries, Stroke};
pub use reproduction::{Compared, ReproducedFigure, ReproductionData, render_reproduction};
pub use work_precision::{Curve, CurvePoint, Plot};
