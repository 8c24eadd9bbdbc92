//! Recorded data as one self-contained HTML page.
//!
//! - `data`: contents of a report;
//! - `template`: pages from `templates/`, with every value escaped;
//! - `run`, `figure`: the page of a run, and a picture with its title, legend, caption and notes;
//! - `explored`: the recorded states within the page, which its script turns and zooms;
//! - `comparison`, `work_precision`: methods compared, as a page of its own;
//! - `ensemble`: many members, as a page of its own;
//! - `sweep`: one run for each of many settings, as a page of its own;
//! - `reproduction`, `panel`: a paper's printed values beside measured ones, as a page of its own;
//! - `survey`: declarations of parts beside measurements, as a page of its own;
//! - `drift`, `history`, `orbit`, `space`, `bodies`, `lattice`, `planes`, `structure`: the figures;
//! - `chart`: a figure of several runs for a paper, with labels of one's own; `pdf`: pictures as PDF;
//! - `heat`: values as colours;
//! - `axis`, `decimate`, `canvas`, `stroke`: axes, long series reduced to pixels, drawing, points of orbits;
//! - `html`, `number`: text and numbers in HTML.

mod axis;
mod bodies;
mod canvas;
mod chart;
mod comparison;
mod data;
mod decimate;
mod drift;
mod ensemble;
mod error;
mod explored;
mod figure;
mod heat;
mod history;
mod html;
mod lattice;
mod letters;
mod number;
mod orbit;
mod panel;
mod pdf;
mod planes;
mod reproduction;
mod run;
mod section;
mod space;
mod stroke;
mod structure;
mod survey;
mod sweep;
mod template;
#[cfg(test)]
mod tests;
mod work_precision;

pub use chart::{Chart, ChartAxis, ChartScale};
pub use comparison::{ComparisonData, render_comparison};
pub use data::{
    BodyPath, Ellipsoid, FieldMaps, InvariantSeries, Outcome, PlaneMap, Recorded, ReportData,
    SectionPoints, StructureFactor, TimeSeries, Trajectory,
};
pub use ensemble::{Band, EnsembleData, Losses, render_ensemble};
pub use error::ReportError;
pub use panel::{Panel, PanelAxis, PanelSeries, Stroke};
pub use reproduction::{Compared, ReproducedFigure, ReproductionData, render_reproduction};
pub use run::render_report;
pub use survey::{
    ErrorLine, RefusedParts, SurveyData, SurveyedMap, SurveyedProblem, render_survey,
};
pub use sweep::{SweepData, SweptColumn, SweptDirection, SweptKind, render_sweep};
pub use work_precision::{Curve, CurvePoint, Plot};
