//! The orbit: a projection of three coordinates, or the plane of two.

use std::collections::BTreeSet;

use super::axis::{Axis, Frame};
use super::canvas::{Canvas, FAINT, SERIES};
use super::data::{Ellipsoid, TimeSeries};
use super::error::ReportError;
use super::figure::Figure;
use super::history::{Dense, history};
use super::space::space_picture;

/// Points closer than this many pixels to the last one kept are left out.
const NEAR: f64 = 0.6;

/// The most points of a line.
const MOST_JOINED: usize = 9000;

/// The most dots of an orbit drawn without a line.
const MOST_DOTS: usize = 3000;

/// The orbit through the recorded states.
pub(super) fn orbit_figure(
    names: &[String],
    times: &[f64],
    points: &[Vec<f64>],
    leaf: Option<&Ellipsoid>,
) -> Result<Figure, ReportError> {
    let dimension = names.len().min(3);
    let is_drawable = |point: &&Vec<f64>| {
        point.len() >= dimension && point[..dimension].iter().all(|value| value.is_finite())
    };
    let states: Vec<_> = points
        .iter()
        .filter(is_drawable)
        .map(Vec::as_slice)
        .collect();
    let mut notes = Vec::new();
    if states.len() < points.len() {
        let count = points.len() - states.len();
        notes.push(format!(
            "Not finite and not drawn: {count} of {} states.",
            points.len()
        ));
    }
    let (title, svg, caption) = match dimension {
        0 | 1 => {
            let name = names.first().map_or("x", String::as_str);
            let values = points
                .iter()
                .map(|p| p.first().copied().unwrap_or(f64::NAN))
                .collect();
            let series = TimeSeries {
                times: times.to_vec(),
                values,
            };
            let (svg, _) = history(&series, name, "The state over time", Dense::Envelope)?;
            (
                "State".to_owned(),
                svg,
                format!("{name} at the recorded states."),
            )
        }
        2 => {
            let svg = plane_picture(names, &states)?;
            let caption = "The orbit in the plane of the two coordinates";
            (
                format!("Phase plane ({}, {})", names[0], names[1]),
                svg,
                ended(caption),
            )
        }
        _ => {
            let svg = space_picture(names, &states, leaf)?;
            let caption = match leaf {
                Some(_) => {
                    "The orbit on its symplectic leaf, the level surface of the Casimir through \
                     the initial state; the far side is drawn faint"
                }
                None => {
                    "The orbit in three coordinates, with its shadow on the floor of the box; \
                     each axis spans the values the orbit takes"
                }
            };
            let title = format!("Orbit in ({}, {}, {})", names[0], names[1], names[2]);
            (title, svg, ended(caption))
        }
    };
    Ok(Figure {
        title,
        svg,
        legend: Vec::new(),
        caption,
        notes,
    })
}

fn ended(caption: &str) -> String {
    format!("{caption}. Disc: initial state; ring: last recorded state.")
}

fn plane_picture(names: &[String], states: &[&[f64]]) -> Result<String, ReportError> {
    let (width, height) = (480.0, 480.0);
    let x = Axis::linear(states.iter().map(|state| state[0]), 0.06);
    let y = Axis::linear(states.iter().map(|state| state[1]), 0.06);
    let frame = Frame::new(width, height, x, y);
    let mut canvas = Canvas::new(width, height);
    frame.draw(&mut canvas, &names[0], &names[1]);
    let points: Vec<_> = states
        .iter()
        .map(|state| frame.point(state[0], state[1]))
        .collect();
    draw_orbit(&mut canvas, &points, |_| Stroke::NEAR_SIDE);
    draw_ends(&mut canvas, &points);
    canvas.finish("The orbit in the phase plane")
}

/// How a piece of an orbit is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    /// Its colour.
    pub ink: super::canvas::Ink,
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

/// A line through the points, or dots where neighbours lie too far apart or points too dense
/// for a line to mean anything; `stroke` chooses by the index of the point.
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
    for index in spread(points, kept) {
        let Stroke { ink, width } = stroke(index);
        canvas.disc(points[index], width, ink);
    }
}

/// One point of each cell of a grid just coarse enough to leave few enough dots.
fn spread(points: &[(f64, f64)], mut kept: Vec<usize>) -> Vec<usize> {
    let mut cell = 1.5;
    loop {
        let mut taken = BTreeSet::new();
        kept.retain(|index| {
            let (x, y) = points[*index];
            taken.insert(((x / cell) as i64, (y / cell) as i64))
        });
        if kept.len() <= MOST_DOTS {
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
fn is_line(points: &[(f64, f64)]) -> bool {
    let near = points
        .windows(2)
        .filter(|pair| distance(pair[0], pair[1]) < 40.0)
        .count();
    2 * near >= points.len().saturating_sub(1)
}

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    libm::hypot(a.0 - b.0, a.1 - b.1)
}
