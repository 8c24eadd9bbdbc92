//! The page of a reproduction: what was printed beside what was measured.

use serde::Serialize;

use super::error::ReportError;
use super::figure::Figure;
use super::panel::{Panel, panel_figure};
use super::template::render;

/// Printed and measured, ready to be drawn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReproductionData {
    /// The heading.
    pub title: String,
    /// Source whose figures are reproduced, as a citation.
    pub source: String,
    /// The program and its version.
    pub version: String,
    /// The command that repeats it.
    pub command: String,
    /// Introduction: paragraphs to read before the figures.
    pub introduction: Vec<String>,
    /// The figures.
    pub figures: Vec<ReproducedFigure>,
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReproducedFigure {
    /// Its name in the page's table, such as "Figure 3".
    pub label: String,
    /// The heading.
    pub title: String,
    /// Settings of the figure, and the places where the source leaves them open.
    pub setting: String,
    /// The pictures.
    #[serde(skip)]
    pub panels: Vec<Panel>,
    /// Statements of the source: printed values beside measured ones.
    pub comparisons: Vec<Compared>,
    /// The command that repeats it, where a scene does.
    pub scene: Option<String>,
}

/// A statement of the source beside the measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// Quantity that the statement is about.
    pub quantity: String,
    /// As printed.
    pub printed: String,
    /// As measured.
    pub measured: String,
    /// Whether they agree, in a word.
    pub verdict: String,
    /// Whether the word is good news.
    pub is_good: bool,
    /// Explanation: the result of the theory, and the reason where printed and measured values differ.
    pub explanation: String,
}

/// A reproduction as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// Only if the drawing library refuses a figure.
pub fn render_reproduction(data: &ReproductionData) -> Result<String, ReportError> {
    let drawn = |figure: &ReproducedFigure| figure.panels.iter().map(panel_figure).collect();
    let panels: Result<Vec<Vec<Figure>>, ReportError> = data.figures.iter().map(drawn).collect();
    let page = Page {
        data,
        panels: panels?,
    };
    render("reproduction.html", &page)
}

/// Values for the template `reproduction.html`.
#[derive(Serialize)]
struct Page<'a> {
    data: &'a ReproductionData,
    /// The pictures of each figure.
    panels: Vec<Vec<Figure>>,
}
