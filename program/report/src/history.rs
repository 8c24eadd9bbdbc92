//! One quantity over time: energy, solver evaluations.

use super::axis::{Axis, Frame};
use super::canvas::{ALARM, Canvas, FAINT, SERIES};
use super::data::TimeSeries;
use super::decimate::{envelope, means};
use super::error::ReportError;
use super::figure::Figure;
use super::number::number;

/// Relative variation below which the initial energy is subtracted.
const OFFSET_BELOW: f64 = 1e-2;

/// Energy over time, as H(t) − H(0) where it varies little.
///
/// `work` says how the motion itself changes it.
pub(super) fn energy_figure(
    energy: &TimeSeries,
    work: Option<&str>,
) -> Result<Figure, ReportError> {
    let initial = energy.values.first().copied().unwrap_or(0.0);
    let spread = energy
        .values
        .iter()
        .filter(|value| value.is_finite())
        .map(|value| (value - initial).abs())
        .fold(0.0, f64::max);
    let is_offset = initial.is_finite() && spread < OFFSET_BELOW * initial.abs();
    let (title, values) = match is_offset {
        true => (
            "H(t) − H(0)",
            energy.values.iter().map(|value| value - initial).collect(),
        ),
        false => ("H(t)", energy.values.clone()),
    };
    let series = TimeSeries {
        times: energy.times.clone(),
        values,
    };
    let (svg, notes) = history(&series, title, "Energy over time", Dense::Envelope)?;
    let expected = match work {
        Some(work) => format!("It {work}: these deviations are not errors."),
        None => {
            "The error of a Poisson map is expected to oscillate, not to grow; its amplitude is \
                 set by the dynamic approximation and the step."
                .to_owned()
        }
    };
    Ok(Figure {
        title: "Energy".to_owned(),
        svg,
        legend: Vec::new(),
        caption: format!(
            "Energy at the recorded states; H(0) = {}, largest deviation {}. {expected}",
            number(initial, 12),
            number(spread, 3)
        ),
        colors: Vec::new(),
        notes,
    })
}

/// A recorded formula over time.
pub(super) fn observable_figure(name: &str, series: &TimeSeries) -> Result<Figure, ReportError> {
    let (svg, notes) = history(series, name, "An observable over time", Dense::Envelope)?;
    Ok(Figure {
        title: name.to_owned(),
        svg,
        legend: Vec::new(),
        caption: format!("{name} at the recorded states."),
        colors: Vec::new(),
        notes,
    })
}

/// Solver evaluations a step over time.
pub(super) fn solver_figure(solver: &TimeSeries) -> Result<Figure, ReportError> {
    let (svg, notes) = history(
        solver,
        "evaluations per step",
        "Solver evaluations over time",
        Dense::Mean,
    )?;
    Ok(Figure {
        title: "Solver".to_owned(),
        svg,
        legend: Vec::new(),
        caption: "Evaluations of the target map in each step's solve. Where steps are too \
                  many to tell apart, the line is their mean and the band their range. A rise \
                  warns that the orbit \
                  nears the edge of the chart."
            .to_owned(),
        colors: Vec::new(),
        notes,
    })
}

/// Marks that stand for many values under one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dense {
    /// Their range.
    Envelope,
    /// Their range, faint, and their mean.
    Mean,
}

/// A picture of one series and notes on values that are not finite.
pub(super) fn history(
    series: &TimeSeries,
    title: &str,
    description: &str,
    dense: Dense,
) -> Result<(String, Vec<String>), ReportError> {
    let (width, height) = (480.0, 226.0);
    let x = Axis::linear(series.times.iter().copied(), 0.0);
    let y = Axis::linear(series.values.iter().copied(), 0.06);
    let frame = Frame::new(width, height, x, y);
    let mut canvas = Canvas::new(width, height);
    frame.draw(&mut canvas, "time t", title);
    let placed: Vec<_> = series
        .times
        .iter()
        .zip(&series.values)
        .map(|(time, value)| (frame.x.fraction(*time), *value))
        .collect();
    let [left, top, right, _] = frame.edges;
    for stretch in placed.chunk_by(|a, b| a.1.is_finite() == b.1.is_finite()) {
        let at = |fraction: f64| left + fraction * (right - left);
        if stretch[0].1.is_finite() {
            let points: Vec<_> = envelope(stretch, frame.columns())
                .into_iter()
                .map(|(fraction, value)| (at(fraction), frame.point(0.0, value).1))
                .collect();
            if dense == Dense::Mean && stretch.len() > frame.columns() {
                canvas.path(&points, FAINT, 1.4);
                let averages: Vec<_> = means(stretch, frame.columns() / 2)
                    .into_iter()
                    .map(|(fraction, value)| (at(fraction), frame.point(0.0, value).1))
                    .collect();
                canvas.path(&averages, SERIES[0], 1.6);
            } else {
                canvas.samples(&points, right - left, SERIES[0], 1.4);
            }
        } else {
            let x = at(stretch[0].0);
            canvas.path(&[(x, top), (x, top + 9.0)], ALARM, 1.6);
        }
    }
    let mut notes = Vec::new();
    if let Some(first) = series.values.iter().position(|value| !value.is_finite()) {
        let count = series
            .values
            .iter()
            .filter(|value| !value.is_finite())
            .count();
        let time = series.times.get(first).copied().unwrap_or(f64::NAN);
        notes.push(format!(
            "Not finite: {count} of {} values, the first at t = {} (red marks).",
            series.values.len(),
            number(time, 4)
        ));
    }
    Ok((canvas.finish(description)?, notes))
}
