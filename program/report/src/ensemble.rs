//! The page of an ensemble: its observables over time, drifts, failures.

use super::axis::{Axis, Frame};
use super::canvas::{Canvas, FAINT, GRID, SERIES};
use super::data::{InvariantSeries, Outcome};
use super::drift::drift_figure;
use super::error::ReportError;
use super::figure::Figure;
use super::html::{escape, number};
use super::page::{advice, banner, ending, head, two_columns};

/// What the page of an ensemble is made from.
#[derive(Clone, Debug, Default)]
pub struct EnsembleData {
    /// The heading.
    pub title: String,
    /// The program and its version.
    pub version: String,
    /// The command that repeats it.
    pub command: String,
    /// The scene's file name.
    pub scene_name: String,
    /// The scene as run.
    pub scene_text: String,
    /// How it ended.
    pub outcome: Outcome,
    /// What to change in the scene: what was measured, and the line to write instead.
    pub advice: Vec<(String, String)>,
    /// Label and value for each line of the summary.
    pub facts: Vec<(String, String)>,
    /// Label and text for each line about the method.
    pub method: Vec<(String, String)>,
    /// The quantiles that were asked for.
    pub parts: Vec<f64>,
    /// The observables.
    pub bands: Vec<Band>,
    /// The invariants' largest deviations over all members.
    pub drifts: Vec<InvariantSeries>,
    /// Every how many steps deviations were taken in.
    pub drift_every: u64,
    /// Members that failed, and why.
    pub failures: Vec<(String, String)>,
}

/// An observable over the members, at several times.
#[derive(Clone, Debug, Default)]
pub struct Band {
    /// Its name.
    pub name: String,
    /// The times.
    pub times: Vec<f64>,
    /// The means.
    pub means: Vec<f64>,
    /// The standard deviations.
    pub deviations: Vec<f64>,
    /// Smallest and largest value.
    pub ranges: Vec<(f64, f64)>,
    /// The quantiles, a list for each time.
    pub quantiles: Vec<Vec<f64>>,
}

impl Band {
    /// No time yet.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }
}

/// An ensemble as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// Only if the drawing library refuses a figure.
pub fn render_ensemble(data: &EnsembleData) -> Result<String, ReportError> {
    let mut page = head(&data.title, &data.scene_name, &data.version);
    page.push_str(&banner(&data.outcome));
    page.push_str(&advice(&data.advice));
    page.push_str(&format!("<h2>Summary</h2>\n{}", two_columns(&data.facts)));
    page.push_str(&format!("<h2>At the end</h2>\n{}", table(data)));
    page.push_str("<h2>Figures</h2>\n<div class=\"figures\">\n");
    let mut figures = Vec::new();
    for band in data.bands.iter().filter(|band| band.times.len() > 1) {
        figures.push(band_figure(band, &data.parts)?.html());
    }
    for pair in figures.chunks(2) {
        page.push_str(&format!("<div class=\"pair\">\n{}</div>\n", pair.concat()));
    }
    if data.drifts.iter().any(|series| !series.times.is_empty()) {
        let mut figure = drift_figure(&data.drifts, false)?;
        let over = match data.drift_every {
            1 => "every step".to_owned(),
            every => format!("every {every}th step"),
        };
        figure.caption = format!(
            "The largest deviation of each invariant from its initial value over all members and \
             {over} of each window."
        );
        page.push_str(&figure.html());
    }
    page.push_str("</div>\n");
    if !data.failures.is_empty() {
        page.push_str(&format!(
            "<h2>Failed members</h2>\n{}",
            two_columns(&data.failures)
        ));
    }
    page.push_str(&format!("<h2>Method</h2>\n{}", two_columns(&data.method)));
    page.push_str(&ending(
        &data.scene_name,
        &data.version,
        &data.command,
        &data.scene_text,
    ));
    Ok(page)
}

fn table(data: &EnsembleData) -> String {
    let mut headings = ["mean", "deviation", "smallest", "largest"]
        .map(str::to_owned)
        .to_vec();
    headings.extend(
        data.parts
            .iter()
            .map(|p| format!("{}%", number(100.0 * p, 4))),
    );
    let cell = |text: &str| format!("<td class=\"number\">{text}</td>");
    let mut html = "<div class=\"card scroll\"><table>\n<thead><tr>\
                    <th scope=\"col\">Observable</th>"
        .to_owned();
    for heading in headings {
        html.push_str(&format!(
            "<th scope=\"col\" class=\"number\">{heading}</th>"
        ));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for band in data.bands.iter().filter(|band| !band.times.is_empty()) {
        let last = band.times.len() - 1;
        let (smallest, largest) = band.ranges[last];
        let mut row = [band.means[last], band.deviations[last], smallest, largest].to_vec();
        row.extend(&band.quantiles[last]);
        html.push_str(&format!(
            "<tr><th scope=\"row\" class=\"name\">{}</th>{}</tr>\n",
            escape(&band.name),
            row.iter()
                .map(|value| cell(&number(*value, 8)))
                .collect::<String>()
        ));
    }
    html.push_str(
        "</tbody></table>\n<p class=\"reading\">Over the members that reached the end. A percentage \
         heads the value that this part of them does not exceed.</p></div>\n",
    );
    html
}

/// Mean, one standard deviation about it, and the range.
fn band_figure(band: &Band, parts: &[f64]) -> Result<Figure, ReportError> {
    let (width, height) = (480.0, 226.0);
    let x = Axis::linear(band.times.iter().copied(), 0.0);
    let ends = band.ranges.iter().flat_map(|range| [range.0, range.1]);
    let frame = Frame::new(width, height, x, Axis::linear(ends, 0.06));
    let mut canvas = Canvas::new(width, height);
    let at = |time: f64, value: f64| frame.point(time, value);
    let outline = |upper: &dyn Fn(usize) -> f64, lower: &dyn Fn(usize) -> f64| {
        let count = band.times.len();
        let there = (0..count).map(|k| at(band.times[k], upper(k)));
        let back = (0..count).rev().map(|k| at(band.times[k], lower(k)));
        there.chain(back).collect::<Vec<_>>()
    };
    canvas.area(&outline(&|k| band.ranges[k].1, &|k| band.ranges[k].0), GRID);
    let (means, deviations) = (&band.means, &band.deviations);
    let above = |k: usize| (means[k] + deviations[k]).min(band.ranges[k].1);
    let below = |k: usize| (means[k] - deviations[k]).max(band.ranges[k].0);
    canvas.area(&outline(&above, &below), FAINT);
    frame.draw(&mut canvas, "time t", &band.name);
    let line: Vec<_> = band
        .times
        .iter()
        .zip(means)
        .map(|(t, mean)| at(*t, *mean))
        .collect();
    for part in 0..parts.len() {
        let quantile = |k: usize| band.quantiles[k].get(part).map(|q| at(band.times[k], *q));
        let line: Vec<_> = (0..band.times.len()).filter_map(quantile).collect();
        canvas.path(&line, SERIES[1], 1.0);
    }
    canvas.path(&line, SERIES[0], 1.6);
    let percentages: Vec<String> = parts
        .iter()
        .map(|p| format!("{}%", number(100.0 * p, 4)))
        .collect();
    let quantiles = match percentages.as_slice() {
        [] => String::new(),
        some => format!(
            " Thin lines, from below: the quantiles {}.",
            some.join(", ")
        ),
    };
    Ok(Figure {
        title: band.name.clone(),
        svg: canvas.finish(&format!("{} over time, over the members", band.name))?,
        legend: Vec::new(),
        caption: format!(
            "The members' mean (line), one standard deviation about it (dark band) and their range (light \
             band).{quantiles}"
        ),
        notes: Vec::new(),
    })
}
