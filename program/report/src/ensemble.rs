//! The page of an ensemble: its observables over time, drifts, failures.

use serde::Serialize;

use super::axis::{Axis, Frame};
use super::canvas::{AXIS, Canvas, FAINT, GRID, SERIES};
use super::data::{InvariantSeries, Outcome, SectionPoints};
use super::drift::{drift_figure, looked_at};
use super::error::ReportError;
use super::figure::Figure;
use super::number::number;
use super::section::section_figure;
use super::template::render;

/// Contents of an ensemble's page.
#[derive(Clone, Debug, Default, Serialize)]
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
    /// Changes to the scene that are advised, as pairs: the finding, measured, and the line to write instead.
    pub advice: Vec<(String, String)>,
    /// Label and value for each line of the summary.
    pub facts: Vec<(String, String)>,
    /// Label and text for each line about the method.
    pub method: Vec<(String, String)>,
    /// The quantiles that were asked for.
    pub parts: Vec<f64>,
    /// Between which ranks they lie, where they are not those of the members themselves.
    pub ranks: Option<String>,
    /// The observables.
    #[serde(skip)]
    pub bands: Vec<Band>,
    /// The invariants' largest deviations over all members.
    #[serde(skip)]
    pub drifts: Vec<InvariantSeries>,
    /// The part of the members that the scene's condition has ended; no times without one.
    #[serde(skip)]
    pub losses: Losses,
    /// The states where members cross a section.
    #[serde(skip)]
    pub section: Option<SectionPoints>,
    /// Every how many steps deviations were taken in.
    pub drift_every: u64,
    /// Members that failed, and why.
    pub failures: Vec<(String, String)>,
}

/// The part of the members that have ended, at several times.
#[derive(Clone, Debug, Default)]
pub struct Losses {
    /// The condition that ends them.
    pub condition: String,
    /// The times.
    pub times: Vec<f64>,
    /// The parts.
    pub fractions: Vec<f64>,
    /// Confidence intervals of the probability.
    pub intervals: Vec<[f64; 2]>,
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
    /// Half the lengths of the 95 % confidence intervals about them.
    pub confidences: Vec<f64>,
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
    let shown = data.bands.iter().filter(|band| band.times.len() > 1);
    let bands: Result<Vec<Figure>, ReportError> =
        shown.map(|band| band_figure(band, &data.parts)).collect();
    let page = Page {
        data,
        ends: data.bands.iter().filter_map(End::of).collect(),
        losses: match data.losses.times.len() {
            0 => None,
            _ => Some(loss_figure(&data.losses)?),
        },
        section: data.section.as_ref().map(section_figure).transpose()?,
        bands: bands?,
        drift: drift(data)?,
    };
    render("ensemble.html", &page)
}

/// Values for the template `ensemble.html`.
#[derive(Serialize)]
struct Page<'a> {
    data: &'a EnsembleData,
    ends: Vec<End<'a>>,
    losses: Option<Figure>,
    section: Option<Figure>,
    bands: Vec<Figure>,
    drift: Option<Figure>,
}

/// An observable at its last time.
#[derive(Serialize)]
struct End<'a> {
    name: &'a str,
    /// Mean, half of its confidence interval, deviation, smallest, largest.
    moments: [f64; 5],
    quantiles: &'a [f64],
}

impl<'a> End<'a> {
    fn of(band: &'a Band) -> Option<Self> {
        let last = band.times.len().checked_sub(1)?;
        let (smallest, largest) = band.ranges[last];
        Some(Self {
            name: &band.name,
            moments: [
                band.means[last],
                band.confidences[last],
                band.deviations[last],
                smallest,
                largest,
            ],
            quantiles: &band.quantiles[last],
        })
    }
}

/// The drifts over all members, where there are some.
fn drift(data: &EnsembleData) -> Result<Option<Figure>, ReportError> {
    if data.drifts.iter().all(|series| series.times.is_empty()) {
        return Ok(None);
    }
    let mut figure = drift_figure(&data.drifts, false, data.drift_every, None)?;
    let over = looked_at(data.drift_every);
    figure.caption = format!(
        "The largest deviation of each invariant from its initial value over all members and \
         {over} of each window."
    );
    Ok(Some(figure))
}

/// The part of the members that have ended, and its confidence interval.
fn loss_figure(losses: &Losses) -> Result<Figure, ReportError> {
    let (width, height) = (480.0, 226.0);
    let x = Axis::linear(losses.times.iter().copied(), 0.0);
    let highest = losses.intervals.iter().map(|interval| interval[1]);
    let y = Axis::linear(highest.chain([0.0]), 0.0);
    let frame = Frame::new(width, height, x, y);
    let mut canvas = Canvas::new(width, height);
    let line = |values: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let times = losses.times.iter().enumerate();
        times
            .map(|(k, time)| frame.point(*time, values(k)))
            .collect()
    };
    let mut outline = line(&|k| losses.intervals[k][1]);
    outline.extend(line(&|k| losses.intervals[k][0]).into_iter().rev());
    canvas.area(&outline, FAINT);
    frame.draw(&mut canvas, "time t", "part of the members");
    canvas.path(&line(&|k| losses.fractions[k]), SERIES[0], 1.6);
    Ok(Figure {
        title: format!("Stopped by {}", losses.condition),
        svg: canvas.finish("The part of the members that the condition has ended, over time")?,
        legend: Vec::new(),
        caption: "The part of the members that have ended by a time (line), and the 95 % confidence interval of that \
                  probability at each time (band, after Wilson)."
            .to_owned(),
        colors: Vec::new(),
        notes: Vec::new(),
    })
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
    let confidences = &band.confidences;
    let surely = |sign: f64| move |k: usize| means[k] + sign * confidences[k];
    canvas.area(&outline(&surely(1.0), &surely(-1.0)), AXIS);
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
    let [left, _, right, _] = frame.edges;
    if canvas.are_sparse(line.len(), right - left) {
        line.iter()
            .for_each(|place| canvas.disc(*place, 2.4, SERIES[0]));
    }
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
            "The members' mean (line) with its 95 % confidence interval (narrow band), one standard deviation about it (dark \
             band) and their range (light band).{quantiles}"
        ),
        colors: Vec::new(),
        notes: Vec::new(),
    })
}
