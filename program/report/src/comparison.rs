//! The page of a comparison of methods: figures, legend, table, how to reproduce.

use serde::Serialize;

use super::error::ReportError;
use super::figure::Figure;
use super::template::render;
use super::work_precision::{Curve, Plot, work_precision_figure};

/// Methods compared on a scene, ready to be drawn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparisonData {
    /// The heading.
    pub title: String,
    /// The scene's file name.
    pub scene_name: String,
    /// The scene as compared.
    pub scene_text: String,
    /// The program and its version.
    pub version: String,
    /// The command that repeats the comparison.
    pub command: String,
    /// Facts of the comparison, as labels and texts: among them the methods compared and the reference.
    pub facts: Vec<(String, String)>,
    /// The families of methods, in the order of their colours.
    pub families: Vec<String>,
    /// The methods.
    pub curves: Vec<Curve>,
    /// The pictures.
    #[serde(skip)]
    pub plots: Vec<Plot>,
    /// The table's headings, numbers from `numbers_from` on.
    pub headings: Vec<String>,
    /// The first column of numbers.
    pub numbers_from: usize,
    /// The table's rows.
    pub rows: Vec<Vec<String>>,
    /// How to read the table.
    pub reading: String,
    /// Failures: the methods or points that could not be measured, with reasons.
    pub failures: Vec<(String, String)>,
}

/// A comparison as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// Only if the drawing library refuses a figure.
pub fn render_comparison(data: &ComparisonData) -> Result<String, ReportError> {
    let mut page = Page {
        data,
        wide: Vec::new(),
        small: Vec::new(),
    };
    for plot in &data.plots {
        let figures = if plot.is_wide {
            &mut page.wide
        } else {
            &mut page.small
        };
        figures.push(work_precision_figure(plot, &data.curves)?);
    }
    render("comparison.html", &page)
}

/// Values for the template `comparison.html`.
#[derive(Serialize)]
struct Page<'a> {
    data: &'a ComparisonData,
    wide: Vec<Figure>,
    small: Vec<Figure>,
}
