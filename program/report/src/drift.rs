//! How far the invariants strayed, on a logarithmic axis.

use super::axis::{Axis, Frame};
use super::canvas::{ALARM, AXIS, Canvas, SERIES};
use super::data::InvariantSeries;
use super::decimate::maxima;
use super::error::ReportError;
use super::figure::Figure;
use super::number::number;

/// Where exact zeros are drawn, unless a deviation is smaller.
const FLOOR: f64 = 1e-17;

/// The steps of which a drift is the largest.
pub(super) fn looked_at(every: u64) -> String {
    match every {
        1 => "every step".to_owned(),
        2 => "every second step".to_owned(),
        3 => "every third step".to_owned(),
        every => format!("one step in {every}"),
    }
}

/// max |I − I(0)| of every invariant over time; log–log when `logarithmic_time`. The text `work` says how the motion
/// itself changes the energy.
pub(super) fn drift_figure(
    invariants: &[InvariantSeries],
    logarithmic_time: bool,
    drift_every: u64,
    work: Option<&str>,
) -> Result<Figure, ReportError> {
    let (width, height) = (960.0, 380.0);
    let times = || {
        invariants
            .iter()
            .flat_map(|series| &series.times)
            .map(|time| time.abs())
    };
    let x = if logarithmic_time {
        Axis::logarithmic(times())
    } else {
        Axis::linear(times(), 0.0)
    };
    let floor = floor_of(invariants);
    let drawn = invariants
        .iter()
        .flat_map(|series| series.times.iter().zip(&series.deviations));
    let drawn = drawn
        .filter(|(time, _)| **time != 0.0)
        .map(|(_, value)| value.abs().max(floor));
    let frame = Frame::new(width, height, x, Axis::logarithmic(drawn));
    let mut canvas = Canvas::new(width, height);
    frame.draw(
        &mut canvas,
        "time t",
        &format!("|I(t) − I(0)|, maximum over {}", looked_at(drift_every)),
    );
    let mut notes = Vec::new();
    notes.extend(work.map(|work| format!("The energy {work}: its deviation is not an error.")));
    if draw_round_off(&mut canvas, &frame, invariants) {
        notes.push("Dashed: 2⁻⁵² max |I(0)|, the round-off of the largest invariant.".to_owned());
    }
    let mut zeros = 0;
    for (index, series) in invariants.iter().enumerate() {
        zeros += zeros_of(series);
        let unseen = draw_series(
            &mut canvas,
            &frame,
            series,
            SERIES[index % SERIES.len()],
            floor,
        );
        if let Some(time) = unseen {
            notes.push(format!(
                "{} is not finite from t = {} on (red marks).",
                series.name,
                number(time, 4)
            ));
        }
    }
    if zeros > 0 {
        let windows = if zeros == 1 { "window" } else { "windows" };
        let level = number(floor, 2);
        notes.push(format!(
            "In {zeros} {windows} the deviation is exactly zero, drawn at {level}."
        ));
    }
    Ok(Figure {
        title: "Drift of the invariants".to_owned(),
        svg: canvas.finish("Deviation of each invariant from its initial value over time")?,
        legend: invariants
            .iter()
            .map(|series| series.name.clone())
            .collect(),
        caption: "The largest deviation of each invariant from its initial value, taken over \
                  every step of each window, not only over the recorded states. A level curve is \
                  a bounded error; growth like √t is the random walk of round-off, growth like t \
                  a secular drift."
            .to_owned(),
        colors: Vec::new(),
        notes,
    })
}

/// The power of ten at which exact zeros are drawn: 10⁻¹⁷, or below the smallest deviation.
fn floor_of(invariants: &[InvariantSeries]) -> f64 {
    let deviations = invariants.iter().flat_map(|series| &series.deviations);
    let smallest = deviations
        .map(|value| value.abs())
        .filter(|value| *value > 0.0 && value.is_finite())
        .fold(FLOOR, f64::min);
    libm::pow(10.0, libm::floor(libm::log10(smallest)))
}

/// The windows without any deviation; at t = 0 there is none by definition.
fn zeros_of(series: &InvariantSeries) -> usize {
    let windows = series.times.iter().zip(&series.deviations);
    windows
        .filter(|(time, value)| **time != 0.0 && **value == 0.0)
        .count()
}

/// Draws one series; gives the time of the first value that is not finite.
fn draw_series(
    canvas: &mut Canvas,
    frame: &Frame,
    series: &InvariantSeries,
    ink: super::canvas::Ink,
    floor: f64,
) -> Option<f64> {
    let placed: Vec<_> = series
        .times
        .iter()
        .zip(&series.deviations)
        .filter(|(time, _)| **time != 0.0)
        .map(|(time, value)| (frame.x.fraction(time.abs()), *value))
        .collect();
    let [left, top, right, _] = frame.edges;
    let mut stretch = Vec::new();
    for (fraction, value) in maxima(&placed, frame.columns()) {
        let x = left + fraction * (right - left);
        if value.is_finite() {
            stretch.push((x, frame.point(0.0, value.abs().max(floor)).1));
        } else {
            canvas.path(&stretch, ink, 1.6);
            stretch.clear();
            canvas.path(&[(x, top), (x, top + 9.0)], ALARM, 1.6);
        }
    }
    canvas.path(&stretch, ink, 1.6);
    let first = series
        .deviations
        .iter()
        .position(|value| !value.is_finite())?;
    series.times.get(first).copied()
}

/// The rounding of the largest invariant's value, ε|I(0)|, where it lies on the axis.
fn draw_round_off(canvas: &mut Canvas, frame: &Frame, invariants: &[InvariantSeries]) -> bool {
    let largest = invariants
        .iter()
        .map(|series| series.reference.abs())
        .filter(|value| value.is_finite())
        .fold(0.0, f64::max);
    let level = largest * f64::EPSILON;
    let fraction = frame.y.fraction(level);
    if fraction <= 0.0 || fraction >= 1.0 {
        return false;
    }
    let [left, _, right, _] = frame.edges;
    let (_, y) = frame.point(0.0, level);
    canvas.dashes((left, y), (right, y), AXIS, 1.0);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texts of a picture, each with where it stands.
    fn texts(svg: &str) -> Vec<&str> {
        let texts = svg.split("<text ").skip(1);
        texts
            .map(|text| text.split("</text>").next().unwrap_or(text))
            .collect()
    }

    /// A curve may run along the level of round-off: what the dashes are stands below the picture.
    #[test]
    fn what_the_dashed_level_means_is_not_written_into_the_picture() {
        let drift = |reference: f64| {
            let series = InvariantSeries {
                name: "energy".to_owned(),
                reference,
                times: (0..50).map(f64::from).collect(),
                deviations: (0..50).map(|k| f64::EPSILON * f64::from(1 + k)).collect(),
            };
            drift_figure(&[series], false, 1, None).expect("a figure")
        };
        let (with, without) = (drift(4.0), drift(1e30));
        let told = "Dashed: 2⁻⁵² max |I(0)|, the round-off of the largest invariant.";
        assert_eq!(
            (with.notes, without.notes),
            (vec![told.to_owned()], Vec::new())
        );
        assert!(with.svg.len() > without.svg.len(), "no dashes");
        assert_eq!(texts(&with.svg), texts(&without.svg));
    }
}
