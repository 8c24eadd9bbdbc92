//! The page of a comparison of methods: figures, legend, table, how to reproduce.

use super::error::ReportError;
use super::html::escape;
use super::page::{ending, head, two_columns};
use super::work_precision::{Curve, Plot, work_precision_figure};

/// Methods compared on a scene, ready to be drawn.
#[derive(Clone, Debug, PartialEq)]
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
    /// What was compared, and against what.
    pub facts: Vec<(String, String)>,
    /// The families of methods, in the order of their colours.
    pub families: Vec<String>,
    /// The methods.
    pub curves: Vec<Curve>,
    /// The pictures.
    pub plots: Vec<Plot>,
    /// The table's headings, numbers from `numbers_from` on.
    pub headings: Vec<String>,
    /// The first column of numbers.
    pub numbers_from: usize,
    /// The table's rows.
    pub rows: Vec<Vec<String>>,
    /// How to read the table.
    pub reading: String,
    /// What could not be measured, with reasons.
    pub failures: Vec<(String, String)>,
}

/// A comparison as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// Only if the drawing library refuses a figure.
pub fn render_comparison(data: &ComparisonData) -> Result<String, ReportError> {
    let mut page = head(&data.title, &data.scene_name, &data.version);
    page.push_str(&two_columns(&data.facts));
    page.push_str("<h2>Work and precision</h2>\n");
    page.push_str(&legend(data));
    page.push_str("<div class=\"figures\">\n");
    let mut small = Vec::new();
    for plot in &data.plots {
        let figure = work_precision_figure(plot, &data.curves)?.html();
        if plot.is_wide {
            page.push_str(&figure);
        } else {
            small.push(figure);
        }
    }
    for pair in small.chunks(2) {
        page.push_str(&format!("<div class=\"pair\">\n{}</div>\n", pair.concat()));
    }
    page.push_str("</div>\n<h2>The fronts</h2>\n");
    page.push_str(&table(data));
    if !data.failures.is_empty() {
        let count = data.failures.len();
        page.push_str(&format!(
            "<details class=\"card\"><summary>What could not be measured ({count})</summary>\n{}\
             </details>\n",
            two_columns(&data.failures)
        ));
    }
    page.push_str(&ending(
        &data.scene_name,
        &data.version,
        &data.command,
        &data.scene_text,
    ));
    Ok(page)
}

/// The numbered methods, family by family.
fn legend(data: &ComparisonData) -> String {
    let mut html = "<div class=\"card methods\">\n".to_owned();
    for (at, family) in data.families.iter().enumerate() {
        let of_family = data.curves.iter().filter(|curve| curve.family == at);
        let items: String = of_family
            .filter_map(|curve| Some((curve.number?, &curve.name)))
            .map(|(number, name)| format!("<li value=\"{number}\">{}</li>", escape(name)))
            .collect();
        if items.is_empty() {
            continue;
        }
        html.push_str(&format!(
            "<section class=\"s{at}\"><h3>{}</h3><ol>{items}</ol></section>\n",
            escape(family)
        ));
    }
    let others = data.curves.iter().filter(|curve| curve.number.is_none());
    let names: Vec<String> = others.map(|curve| escape(&curve.name)).collect();
    html.push_str("</div>\n");
    if !names.is_empty() {
        html.push_str(&format!(
            "<p class=\"reading\">In the background, on no front: {}.</p>\n",
            names.join("; ")
        ));
    }
    html
}

fn table(data: &ComparisonData) -> String {
    let class = |at: usize| {
        if at >= data.numbers_from {
            " class=\"number\""
        } else {
            ""
        }
    };
    let mut html = "<div class=\"card scroll\"><table>\n<thead><tr>".to_owned();
    for (at, heading) in data.headings.iter().enumerate() {
        html.push_str(&format!(
            "<th scope=\"col\"{}>{}</th>",
            class(at),
            escape(heading)
        ));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in &data.rows {
        html.push_str("<tr>");
        for (at, cell) in row.iter().enumerate() {
            html.push_str(&format!("<td{}>{}</td>", class(at), escape(cell)));
        }
        html.push_str("</tr>\n");
    }
    html.push_str(&format!(
        "</tbody></table>\n<p class=\"reading\">{}</p></div>\n",
        escape(&data.reading)
    ));
    html
}
