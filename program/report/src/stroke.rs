//! An orbit's points as strokes, or as dots.

use std::collections::BTreeSet;

use super::canvas::{Canvas, FAINT, Ink, SERIES};

/// Points closer than this many pixels to the last one kept are left out.
const NEAR: f64 = 0.6;

/// The most points of a line.
const MOST_JOINED: usize = 9000;

/// The most dots of an orbit drawn without a line.
const MOST_DOTS: usize = 3000;

/// The most dots of many orbits, and their radius.
const MOST_DOTS_OF_MANY: usize = 12_000;
const FINE: f64 = 1.0;

/// How a piece of an orbit is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width.
    pub width: f64,
}

impl Stroke {
    /// The visible side.
    pub const NEAR_SIDE: Self = Self {
        ink: SERIES[0],
        width: 1.4,
    };
    /// The side behind a surface.
    pub const FAR_SIDE: Self = Self {
        ink: FAINT,
        width: 1.0,
    };
}

/// Draws a line through the points. Where neighbours lie too far apart, or points too dense, for a line to mean
/// anything, it draws dots. Ink and width are those that `stroke` gives for the point's index.
pub(super) fn draw_orbit(
    canvas: &mut Canvas,
    points: &[(f64, f64)],
    stroke: impl Fn(usize) -> Stroke,
) {
    let kept = thinned(points);
    if kept.len() <= MOST_JOINED && is_line(points) {
        for run in kept.chunk_by(|a, b| stroke(*a) == stroke(*b)) {
            let after = run
                .last()
                .and_then(|last| kept.iter().find(|index| *index > last));
            let line: Vec<_> = run
                .iter()
                .chain(after)
                .map(|index| points[*index])
                .collect();
            let Stroke { ink, width } = stroke(run[0]);
            canvas.path(&line, ink, width);
        }
        return;
    }
    for index in spread(points, kept, MOST_DOTS) {
        let Stroke { ink, width } = stroke(index);
        canvas.disc(points[index], width, ink);
    }
}

/// A dot for each point in its ink, as many as can be told apart, more and smaller ones of many orbits.
pub(super) fn draw_dots(
    canvas: &mut Canvas,
    points: &[(f64, f64)],
    ink: impl Fn(usize) -> Ink,
    is_of_many: bool,
) {
    let (most, radius) = match is_of_many {
        true => (MOST_DOTS_OF_MANY, FINE),
        false => (MOST_DOTS, Stroke::NEAR_SIDE.width),
    };
    for index in spread(points, (0..points.len()).collect(), most) {
        canvas.disc(points[index], radius, ink(index));
    }
}

/// One point of each cell of a grid just coarse enough to leave few enough dots.
fn spread(points: &[(f64, f64)], mut kept: Vec<usize>, most: usize) -> Vec<usize> {
    let mut cell = 1.5;
    loop {
        let mut taken = BTreeSet::new();
        kept.retain(|index| {
            let (x, y) = points[*index];
            taken.insert(((x / cell) as i64, (y / cell) as i64))
        });
        if kept.len() <= most {
            return kept;
        }
        cell *= 1.3;
    }
}

/// Marks the first and the last point.
pub(super) fn draw_ends(canvas: &mut Canvas, points: &[(f64, f64)]) {
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        canvas.ring(*last, 4.5, SERIES[1], 2.0);
        canvas.disc(*first, 4.5, SERIES[1]);
    }
}

/// Indices of points far enough from each other, the ends always among them.
fn thinned(points: &[(f64, f64)]) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        let is_far = kept
            .last()
            .is_none_or(|last| distance(points[*last], *point) >= NEAR);
        if is_far || index + 1 == points.len() {
            kept.push(index);
        }
    }
    kept
}

/// Whether consecutive points are near: half of the segments are shorter than 40 pixels.
pub(super) fn is_line(points: &[(f64, f64)]) -> bool {
    let near = points
        .windows(2)
        .filter(|pair| distance(pair[0], pair[1]) < 40.0)
        .count();
    2 * near >= points.len().saturating_sub(1)
}

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    libm::hypot(a.0 - b.0, a.1 - b.1)
}
