//! Values as colours.

use std::ops::Range;

use super::axis::Axis;
use super::canvas::{ALARM, Anchor, Canvas, Ink};

/// How many colours the scale has.
const LEVELS: usize = 32;

/// The room that the bar and its labels take to the right of a frame.
pub(super) const BAR: f64 = 92.0;

/// Letters that go into it.
const WIDEST: usize = 12;

/// The colour's number of a value on an axis.
pub(super) fn level(axis: Axis, value: f64) -> usize {
    (axis.fraction(value) * (LEVELS - 1) as f64).round() as usize
}

/// Draws a row of cells between two heights, those of one colour as one; `None` is what is not finite. Returns how many
/// of these there are.
pub(super) fn draw_row(
    canvas: &mut Canvas,
    [left, right]: [f64; 2],
    [top, bottom]: [f64; 2],
    levels: &[Option<usize>],
) -> usize {
    let at = |cell: usize| left + (right - left) * cell as f64 / levels.len().max(1) as f64;
    let (mut start, mut broken) = (0, 0);
    for run in levels.chunk_by(|a, b| a == b) {
        let ink = run[0].map_or(ALARM, color);
        broken += if run[0].is_none() { run.len() } else { 0 };
        canvas.cell((at(start), top), (at(start + run.len()), bottom), ink);
        start += run.len();
    }
    broken
}

/// The value farthest from the mean; nothing where one is not finite.
pub(super) fn farthest<'a>(values: impl Iterator<Item = &'a f64>, mean: f64) -> Option<f64> {
    let mut best: Option<f64> = None;
    for value in values {
        if !value.is_finite() {
            return None;
        }
        if best.is_none_or(|kept| (value - mean).abs() > (kept - mean).abs()) {
            best = Some(*value);
        }
    }
    best
}

/// The bar of colours to the right of a frame, with labels and a name.
pub(super) fn draw_scale(canvas: &mut Canvas, edges: [f64; 4], axis: Axis, name: &str) {
    draw_scale_of(canvas, edges, axis, name, 0..LEVELS);
}

/// The bar of some of the colours.
pub(super) fn draw_scale_of(
    canvas: &mut Canvas,
    edges: [f64; 4],
    axis: Axis,
    name: &str,
    levels: Range<usize>,
) {
    let [_, top, right, bottom] = edges;
    let at = |fraction: f64| bottom - fraction * (bottom - top);
    let (first, count) = (levels.start, levels.len() as f64);
    for level in levels {
        let (low, high) = (
            (level - first) as f64 / count,
            (level - first + 1) as f64 / count,
        );
        canvas.cell(
            (right + 18.0, at(high)),
            (right + 32.0, at(low)),
            color(level),
        );
    }
    let ticks = axis.ticks(5);
    for (value, label) in &ticks.labels {
        canvas.label(
            label,
            (right + 38.0, at(axis.fraction(*value))),
            Anchor::Start,
        );
    }
    let title = format!("{name} {}", ticks.factor);
    let title = title.trim();
    // What is wider than the bar and its labels ends with them.
    let (at, anchor) = match title.chars().count() > WIDEST {
        true => (right + BAR, Anchor::End),
        false => (right + 18.0, Anchor::Start),
    };
    canvas.label(title, (at, top - 17.0), anchor);
}

/// From dark blue over green to yellow, lighter throughout, so that it reads in grey too.
pub(super) fn color(level: usize) -> Ink {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let place = level as f64 / (LEVELS - 1) as f64 * (STOPS.len() - 1) as f64;
    let below = (place as usize).min(STOPS.len() - 2);
    let part = place - below as f64;
    let [red, green, blue] = [0, 1, 2].map(|channel| {
        let (from, to) = (STOPS[below][channel], STOPS[below + 1][channel]);
        (from + part * (to - from)).round() as u8
    });
    plotters::style::RGBColor(red, green, blue)
}
