//! Recorded data as one self-contained HTML page.
//!
//! - `data`: what a report is made from;
//! - `page`, `html`, `figure`: the page and its pieces;
//! - `drift`, `history`, `orbit`, `space`, `lattice`: the figures;
//! - `axis`, `decimate`, `canvas`: axes, long series reduced to pixels, drawing.

mod axis;
mod canvas;
mod data;
mod decimate;
mod drift;
mod error;
mod figure;
mod history;
mod html;
mod lattice;
mod orbit;
mod page;
mod space;
#[cfg(test)]
mod tests;

pub use data::{Ellipsoid, InvariantSeries, Outcome, ReportData, TimeSeries, Trajectory};
pub use error::ReportError;
pub use page::render_report;
