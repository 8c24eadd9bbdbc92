//! The page of a reproduction: what was printed beside what was measured.

use super::error::ReportError;
use super::html::escape;
use super::page::head;
use super::panel::{Panel, panel_figure};

/// Printed and measured, ready to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ReproductionData {
    /// The heading.
    pub title: String,
    /// What is reproduced.
    pub source: String,
    /// The program and its version.
    pub version: String,
    /// The command that repeats it.
    pub command: String,
    /// What to know before reading.
    pub introduction: Vec<String>,
    /// The figures.
    pub figures: Vec<ReproducedFigure>,
}

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct ReproducedFigure {
    /// Its name in the page's table, such as "Figure 3".
    pub label: String,
    /// The heading.
    pub title: String,
    /// What is set, and where the source leaves it open.
    pub setting: String,
    /// The pictures.
    pub panels: Vec<Panel>,
    /// What was printed, and what was measured.
    pub comparisons: Vec<Compared>,
    /// The command that repeats it, where a scene does.
    pub scene: Option<String>,
}

/// A statement of the source beside the measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// What it is about.
    pub quantity: String,
    /// As printed.
    pub printed: String,
    /// As measured.
    pub measured: String,
    /// Whether they agree, in a word.
    pub verdict: String,
    /// Whether the word is good news.
    pub is_good: bool,
    /// What theory says, and why the two differ where they do.
    pub explanation: String,
}

/// A reproduction as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// Only if the drawing library refuses a figure.
pub fn render_reproduction(data: &ReproductionData) -> Result<String, ReportError> {
    let mut page = head(&data.title, &data.source, &data.version);
    for paragraph in &data.introduction {
        page.push_str(&format!("<p>{}</p>\n", escape(paragraph)));
    }
    page.push_str("<h2>All statements</h2>\n");
    page.push_str(&overview(&data.figures));
    for (at, figure) in data.figures.iter().enumerate() {
        page.push_str(&format!(
            "<h2 id=\"f{at}\">{}</h2>\n<p>{}</p>\n",
            escape(&format!("{}: {}", figure.label, figure.title)),
            escape(&figure.setting)
        ));
        page.push_str("<div class=\"figures\">\n");
        for pair in figure.panels.chunks(2) {
            let drawn = pair.iter().map(|panel| Ok(panel_figure(panel)?.html()));
            let drawn: Result<String, ReportError> = drawn.collect();
            page.push_str(&format!("<div class=\"pair\">\n{}</div>\n", drawn?));
        }
        page.push_str("</div>\n");
        page.push_str(&comparisons(figure));
        if let Some(scene) = &figure.scene {
            page.push_str(&format!(
                "<details><summary>The scene</summary><pre><code>{}</code></pre></details>\n",
                escape(scene)
            ));
        }
    }
    page.push_str(&format!(
        "<h2>How to reproduce</h2>\n<div class=\"card\"><p>With {}:</p><pre><code>{}</code></pre>\
         </div>\n<footer>Written by {0}.</footer>\n</main>\n</body>\n</html>\n",
        escape(&data.version),
        escape(&data.command)
    ));
    Ok(page)
}

const HEADINGS: [&str; 5] = ["Figure", "Quantity", "Printed", "Measured", ""];

fn overview(figures: &[ReproducedFigure]) -> String {
    let headings = HEADINGS.map(|heading| format!("<th scope=\"col\">{heading}</th>"));
    let mut html = format!(
        "<div class=\"card scroll\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n",
        headings.concat()
    );
    for (at, figure) in figures.iter().enumerate() {
        for compared in &figure.comparisons {
            html.push_str(&format!(
                "<tr><td><a href=\"#f{at}\">{}</a></td><td>{}</td><td>{}</td><td>{}</td>{}</tr>\n",
                escape(&figure.label),
                escape(&compared.quantity),
                escape(&compared.printed),
                escape(&compared.measured),
                verdict(compared)
            ));
        }
    }
    html.push_str("</tbody></table></div>\n");
    html
}

fn verdict(compared: &Compared) -> String {
    let class = if compared.is_good { "good" } else { "bad" };
    format!("<td class=\"{class}\">{}</td>", escape(&compared.verdict))
}

fn comparisons(figure: &ReproducedFigure) -> String {
    let mut html = "<div class=\"card compared\">\n".to_owned();
    for compared in &figure.comparisons {
        html.push_str(&format!(
            "<section><h3>{}</h3>\n<dl><dt>The paper</dt><dd>{}</dd><dt>Here</dt><dd>{}</dd>\
             <dt>Theory</dt><dd>{}</dd></dl></section>\n",
            escape(&compared.quantity),
            escape(&compared.printed),
            escape(&compared.measured),
            escape(&compared.explanation)
        ));
    }
    html.push_str("</div>\n");
    html
}
