//! Cost against accuracy of many methods, log–log.

use serde::Serialize;

use super::axis::{Axis, Frame};
use super::canvas::{AXIS, Anchor, Canvas, Ink, LEAF, PAPER, SERIES, SURFACE, TEXT};
use super::error::ReportError;
use super::figure::Figure;

/// A method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// Its family, which gives the colour.
    pub family: usize,
    /// The number it is marked with; a method without one stays in the background.
    pub number: Option<usize>,
}

/// One measurement of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// The cost.
    pub cost: f64,
    /// The error.
    pub error: f64,
    /// Whether no other point is cheaper and more accurate.
    pub on_front: bool,
    /// The same among a part of the methods.
    pub on_inner_front: bool,
}

/// One picture: an error of each method against a cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// The heading.
    pub title: String,
    /// Caption: the quantities shown and how to read the picture.
    pub caption: String,
    /// The horizontal axis.
    pub cost: String,
    /// The vertical axis.
    pub error: String,
    /// The points of each curve, coarse to fine.
    pub points: Vec<Vec<CurvePoint>>,
    /// Errors below this cannot be told from the reference's own.
    pub floor: Option<f64>,
    /// Whether the picture takes the page's whole width.
    pub is_wide: bool,
}

/// Where exact zeros are drawn, unless an error is smaller.
const ZERO: f64 = 1e-17;

/// The radius of the disc that holds a curve's number.
const BADGE: f64 = 8.0;

/// The size of a wide picture, and of one that stands beside another.
const WIDE: (f64, f64) = (960.0, 560.0);
const NARROW: (f64, f64) = (480.0, 340.0);

/// Draws a plot of `curves`.
pub(super) fn work_precision_figure(plot: &Plot, curves: &[Curve]) -> Result<Figure, ReportError> {
    let (width, height) = if plot.is_wide { WIDE } else { NARROW };
    let mut canvas = Canvas::new(width, height);
    let notes = draw(&mut canvas, (width, height), plot, curves);
    Ok(Figure {
        title: plot.title.clone(),
        svg: canvas.finish(&plot.title)?,
        legend: Vec::new(),
        caption: plot.caption.clone(),
        colors: Vec::new(),
        notes,
    })
}

/// The height of a line below a picture that stands alone.
const LINE: f64 = 18.0;

impl Plot {
    /// The picture as an SVG file of its own, on white, with its title and the numbered curves below.
    ///
    /// # Errors
    /// [`ReportError`] if the drawing library refuses it.
    pub fn svg(&self, curves: &[Curve]) -> Result<String, ReportError> {
        let (width, height) = WIDE;
        let mut named: Vec<(usize, &Curve)> = curves
            .iter()
            .filter_map(|curve| Some((curve.number?, curve)))
            .collect();
        named.sort_by_key(|(number, _)| *number);
        let rows = named.len().div_ceil(2);
        let whole = height + LINE * (rows as f64 + 2.2);
        let mut canvas = Canvas::new(width, whole);
        canvas.cell((0.0, 0.0), (width, whole), PAPER);
        draw(&mut canvas, WIDE, self, curves);
        let at = (0.02 * width, height + 0.8 * LINE);
        canvas.label_in(&self.title, at, Anchor::Start, TEXT, 14.0);
        let points = || self.points.iter().flatten();
        let fronts = match (
            points().any(|p| p.on_front),
            points().any(|p| p.on_inner_front),
        ) {
            (true, true) => "solid stairs: the front of all methods; dashed: of the Poisson maps",
            (true, false) => "solid stairs: the front of all methods",
            _ => "",
        };
        let at = (0.52 * width, height + 0.8 * LINE);
        canvas.label_in(fronts, at, Anchor::Start, TEXT, 12.0);
        for (place, (number, curve)) in named.into_iter().enumerate() {
            let x = width * (0.02 + 0.5 * (place / rows) as f64) + BADGE;
            let y = height + LINE * ((place % rows) as f64 + 2.1);
            let ink = SERIES[curve.family % SERIES.len()];
            canvas.ring((x, y), BADGE, ink, 1.3);
            canvas.label_in(&number.to_string(), (x, y), Anchor::Middle, TEXT, 10.5);
            let at = (x + 2.0 * BADGE, y);
            canvas.label_in(&curve.name, at, Anchor::Start, TEXT, 12.0);
        }
        canvas.finish_alone(&self.title)
    }
}

/// Draws axes, curves and fronts; returns what is to be said of them.
fn draw(
    canvas: &mut Canvas,
    (width, height): (f64, f64),
    plot: &Plot,
    curves: &[Curve],
) -> Vec<String> {
    let shown = || plot.points.iter().flatten().filter(|p| is_shown(p));
    let zero = zero_level(shown());
    let level = |error: f64| if error > 0.0 { error } else { zero };
    let x = Axis::logarithmic(shown().map(|p| p.cost));
    let y = Axis::logarithmic(shown().map(|p| level(p.error)));
    let frame = Frame::new(width, height, x, y);
    draw_floor(canvas, &frame, plot.floor);
    frame.draw(canvas, &plot.cost, &plot.error);
    let place = |p: &CurvePoint| frame.point(p.cost, level(p.error));
    let lines: Vec<Vec<(f64, f64)>> = plot
        .points
        .iter()
        .map(|points| points.iter().filter(|p| is_shown(p)).map(place).collect())
        .collect();
    for (line, curve) in lines.iter().zip(curves) {
        if curve.number.is_none() {
            canvas.path(line, LEAF, 1.1);
        }
    }
    let mut badges = Vec::new();
    for ((line, curve), points) in lines.iter().zip(curves).zip(&plot.points) {
        let Some(number) = curve.number else {
            continue;
        };
        let ink = SERIES[curve.family % SERIES.len()];
        canvas.path(line, ink, 1.6);
        for point in points.iter().filter(|p| is_shown(p)) {
            let radius = if point.on_front || point.on_inner_front {
                3.4
            } else {
                1.9
            };
            canvas.disc(place(point), radius, ink);
        }
        if let Some(&end) = line.last() {
            badges.push((end, number, ink));
        }
    }
    draw_front(
        canvas,
        shown().filter(|p| p.on_inner_front).map(place),
        false,
    );
    draw_front(canvas, shown().filter(|p| p.on_front).map(place), true);
    draw_badges(canvas, &frame, badges);
    let zeros = shown().filter(|p| p.error == 0.0).count();
    match zeros {
        0 => Vec::new(),
        1 => vec![format!("One exact zero is drawn at {zero:.0e}.")],
        _ => vec![format!("{zeros} exact zeros are drawn at {zero:.0e}.")],
    }
}

fn is_shown(point: &CurvePoint) -> bool {
    point.cost.is_finite() && point.cost > 0.0 && point.error.is_finite()
}

/// The power of ten at which exact zeros are drawn: 10⁻¹⁷, or below the smallest error.
fn zero_level<'a>(points: impl Iterator<Item = &'a CurvePoint>) -> f64 {
    let smallest = points
        .map(|p| p.error)
        .filter(|error| *error > 0.0)
        .fold(ZERO, f64::min);
    libm::pow(10.0, libm::floor(libm::log10(smallest)))
}

/// Shades the errors below the reference's own error, under a dashed line with a label.
fn draw_floor(canvas: &mut Canvas, frame: &Frame, floor: Option<f64>) {
    let [left, _, right, bottom] = frame.edges;
    let Some(floor) = floor.filter(|floor| frame.y.fraction(*floor) > 0.0) else {
        return;
    };
    let (_, y) = frame.point(1.0, floor);
    canvas.cell((left, y), (right, bottom), SURFACE);
    canvas.dashes((left, y), (right, y), AXIS, 1.0);
    let text = "below: not distinguishable from the reference's own error";
    canvas.label_in(text, (left + 8.0, y + 10.0), Anchor::Start, TEXT, 11.0);
}

/// A staircase through the points of a front: what can be had for a cost.
fn draw_front(canvas: &mut Canvas, points: impl Iterator<Item = (f64, f64)>, is_outer: bool) {
    let mut points: Vec<_> = points.collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    for pair in points.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let corner = (b.0, a.1);
        if is_outer {
            canvas.path(&[a, corner, b], TEXT, 1.0);
        } else {
            canvas.dashes(a, corner, TEXT, 1.0);
            canvas.dashes(corner, b, TEXT, 1.0);
        }
    }
}

/// Numbers at the ends of the curves, moved apart.
fn draw_badges(canvas: &mut Canvas, frame: &Frame, mut badges: Vec<((f64, f64), usize, Ink)>) {
    badges.sort_by(|a, b| a.0.1.total_cmp(&b.0.1).then(a.1.cmp(&b.1)));
    let [_, top, right, bottom] = frame.edges;
    let mut placed: Vec<(f64, f64)> = Vec::new();
    for ((x, y), number, ink) in badges {
        let near = |at: (f64, f64)| {
            let apart = 2.0 * BADGE + 1.0;
            placed
                .iter()
                .any(|other| libm::hypot(other.0 - at.0, other.1 - at.1) < apart)
        };
        // Rings of places around the end, the nearest free one inside the frame.
        let inside = |at: &(f64, f64)| {
            at.0 <= right - BADGE && at.1 >= top + BADGE && at.1 <= bottom - BADGE
        };
        let places = (1..8).flat_map(|ring| {
            let distance = (BADGE + 5.0) * f64::from(ring);
            [
                (1.0, 0.0),
                (0.7, -0.7),
                (0.7, 0.7),
                (0.0, 1.0),
                (0.0, -1.0),
                (-0.7, 0.7),
                (-1.0, 0.0),
            ]
            .map(|(dx, dy)| (x + distance * dx, y + distance * dy))
        });
        let free = places.filter(inside).find(|at| !near(*at));
        let at = free.unwrap_or((x.min(right - BADGE), y));
        if libm::hypot(at.0 - x, at.1 - y) > 2.0 * BADGE {
            canvas.path(&[(x, y), at], ink, 0.8);
        }
        canvas.ring(at, BADGE, ink, 1.3);
        canvas.label_in(&number.to_string(), at, Anchor::Middle, TEXT, 10.5);
        placed.push(at);
    }
}
