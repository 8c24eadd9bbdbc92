//! Three coordinates in orthographic projection: box, shadow, leaf, orbit.

use super::canvas::{AXIS, Anchor, Canvas, GRID, LEAF, SURFACE, TEXT};
use super::data::Ellipsoid;
use super::error::ReportError;
use super::number::number;
use super::stroke::{Stroke, draw_ends, draw_orbit};

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 500.0;

/// The direction of view: turned by the azimuth about the third axis, then raised.
const AZIMUTH: f64 = 0.6;
const ELEVATION: f64 = 0.42;

/// A point of the box [−1, 1]³.
type Point = [f64; 3];

/// How coordinates are placed into the box and the box onto the picture.
struct View {
    center: Point,
    half: Point,
    scale: f64,
    middle: (f64, f64),
}

impl View {
    /// The box around the leaf, with equal scales, or around the states, each axis by itself.
    fn new(states: &[&[f64]], leaf: Option<&Ellipsoid>) -> Self {
        if let Some(leaf) = leaf {
            let longest = leaf.semi_axes.iter().copied().fold(0.0, f64::max);
            let reach = if longest > 0.0 { longest } else { 1.0 };
            let middle = (WIDTH / 2.0, HEIGHT / 2.0);
            return Self {
                center: leaf.center,
                half: [reach; 3],
                scale: 196.0,
                middle,
            };
        }
        let mut center = [0.0; 3];
        let mut half = [1.0; 3];
        for axis in 0..3 {
            let values = || states.iter().map(|state| state[axis]);
            let low = values().fold(f64::INFINITY, f64::min);
            let high = values().fold(f64::NEG_INFINITY, f64::max);
            if low <= high {
                center[axis] = low / 2.0 + high / 2.0;
                half[axis] = high / 2.0 - low / 2.0;
            }
            if half[axis] <= center[axis].abs() * f64::EPSILON * 8.0 {
                half[axis] = center[axis].abs().max(1.0);
            }
        }
        Self {
            center,
            half,
            scale: 138.0,
            middle: (WIDTH / 2.0 + 8.0, HEIGHT / 2.0 - 4.0),
        }
    }

    /// A state's place in the box.
    fn place(&self, state: &[f64]) -> Point {
        let mut point = [0.0; 3];
        for axis in 0..3 {
            point[axis] = (state[axis] - self.center[axis]) / self.half[axis];
        }
        point
    }

    /// The picture's point and the nearness to the eye of a point of the box.
    fn project(&self, point: Point) -> ((f64, f64), f64) {
        let (sine, cosine) = (libm::sin(AZIMUTH), libm::cos(AZIMUTH));
        let across = -sine * point[0] + cosine * point[1];
        let along = cosine * point[0] + sine * point[1];
        let up = libm::cos(ELEVATION) * point[2] - libm::sin(ELEVATION) * along;
        let near = libm::sin(ELEVATION) * point[2] + libm::cos(ELEVATION) * along;
        let (x, y) = self.middle;
        ((x + self.scale * across, y - self.scale * up), near)
    }

    fn line(&self, canvas: &mut Canvas, from: Point, to: Point, ink: super::canvas::Ink) {
        canvas.path(&[self.project(from).0, self.project(to).0], ink, 1.0);
    }
}

/// The picture of an orbit in its first three coordinates.
pub(super) fn space_picture(
    names: &[String],
    states: &[&[f64]],
    leaf: Option<&Ellipsoid>,
) -> Result<String, ReportError> {
    let leaf = leaf.filter(|leaf| {
        let mut numbers = leaf.center.iter().chain(&leaf.semi_axes);
        numbers.all(|value| value.is_finite()) && leaf.semi_axes.iter().all(|axis| *axis > 0.0)
    });
    let view = View::new(states, leaf);
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let places: Vec<_> = states.iter().map(|state| view.place(state)).collect();
    let projected: Vec<_> = places.iter().map(|place| view.project(*place).0).collect();
    match leaf {
        Some(leaf) => {
            draw_leaf(&mut canvas, &view, leaf);
            let is_near = |index: usize| is_near_side(&view, places[index], leaf);
            draw_orbit(&mut canvas, &projected, |index| match is_near(index) {
                true => Stroke::NEAR_SIDE,
                false => Stroke::FAR_SIDE,
            });
            draw_leaf_axes(&mut canvas, &view, names, leaf);
        }
        None => {
            draw_box(&mut canvas, &view, names);
            let shadow: Vec<_> = places
                .iter()
                .map(|place| view.project([place[0], place[1], -1.0]).0)
                .collect();
            draw_orbit(&mut canvas, &shadow, |_| Stroke {
                ink: LEAF,
                width: 1.0,
            });
            draw_orbit(&mut canvas, &projected, |_| Stroke::NEAR_SIDE);
        }
    }
    draw_ends(&mut canvas, &projected);
    canvas.finish("The orbit in three coordinates")
}

/// Whether the surface's normal at a point of it faces the eye.
fn is_near_side(view: &View, place: Point, leaf: &Ellipsoid) -> bool {
    let reach = view.half[0];
    let mut normal = [0.0; 3];
    for axis in 0..3 {
        let shape = leaf.semi_axes[axis] / reach;
        normal[axis] = place[axis] / (shape * shape);
    }
    view.project(normal).1 >= 0.0
}

/// The outline seen from the eye: where the normal is across the direction of view.
fn outline(view: &View, leaf: &Ellipsoid) -> Vec<Point> {
    let shape = leaf.semi_axes.map(|axis| axis / view.half[0]);
    let toward = [
        libm::cos(ELEVATION) * libm::cos(AZIMUTH),
        libm::cos(ELEVATION) * libm::sin(AZIMUTH),
        libm::sin(ELEVATION),
    ];
    let pole = [0, 1, 2].map(|axis| toward[axis] / shape[axis]);
    let level = libm::hypot(pole[0], pole[1]);
    let length = libm::hypot(level, pole[2]);
    let first = [-pole[1] / level, pole[0] / level, 0.0];
    let up = [-pole[0] * pole[2], -pole[1] * pole[2], level * level];
    let second = up.map(|component| component / (level * length));
    (0..=120)
        .map(|k| {
            let angle = std::f64::consts::PI * f64::from(k) / 60.0;
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            [0, 1, 2].map(|axis| shape[axis] * (cosine * first[axis] + sine * second[axis]))
        })
        .collect()
}

/// Outline, meridians and parallels, the far side faint.
fn draw_leaf(canvas: &mut Canvas, view: &View, leaf: &Ellipsoid) {
    let reach = view.half[0];
    let rim: Vec<_> = outline(view, leaf)
        .iter()
        .map(|place| view.project(*place).0)
        .collect();
    canvas.area(&rim, SURFACE);
    let point = |latitude: f64, longitude: f64| -> Point {
        let across = libm::cos(latitude);
        let unit = [
            across * libm::cos(longitude),
            across * libm::sin(longitude),
            libm::sin(latitude),
        ];
        [0, 1, 2].map(|axis| unit[axis] * leaf.semi_axes[axis] / reach)
    };
    let pi = std::f64::consts::PI;
    let mut curves: Vec<Vec<Point>> = Vec::new();
    for meridian in 0..12 {
        let longitude = pi * f64::from(meridian) / 6.0;
        curves.push(
            (0..=48)
                .map(|k| point(pi * (f64::from(k) / 48.0 - 0.5), longitude))
                .collect(),
        );
    }
    for parallel in 1..6 {
        let latitude = pi * (f64::from(parallel) / 6.0 - 0.5);
        curves.push(
            (0..=96)
                .map(|k| point(latitude, pi * f64::from(k) / 48.0))
                .collect(),
        );
    }
    for is_front in [false, true] {
        let ink = if is_front { LEAF } else { GRID };
        for curve in &curves {
            for run in
                curve.chunk_by(|a, b| is_near_side(view, *a, leaf) == is_near_side(view, *b, leaf))
            {
                if is_near_side(view, run[0], leaf) == is_front {
                    let line: Vec<_> = run.iter().map(|place| view.project(*place).0).collect();
                    canvas.path(&line, ink, 1.0);
                }
            }
        }
    }
    canvas.path(&rim, AXIS, 1.0);
}

/// Half-axes that reach out of the surface, with names.
fn draw_leaf_axes(canvas: &mut Canvas, view: &View, names: &[String], leaf: &Ellipsoid) {
    for axis in 0..3 {
        let mut from = [0.0; 3];
        from[axis] = leaf.semi_axes[axis] / view.half[0];
        let mut to = from;
        to[axis] += 0.22;
        view.line(canvas, from, to, AXIS);
        let mut end = to;
        end[axis] += 0.08;
        canvas.label(&names[axis], view.project(end).0, Anchor::Middle);
    }
}

/// The far faces of the box, and three of its edges named and numbered.
fn draw_box(canvas: &mut Canvas, view: &View, names: &[String]) {
    for a in [-1.0, 1.0] {
        for b in [-1.0, 1.0] {
            if a + b < 2.0 {
                view.line(canvas, [-1.0, a, b], [1.0, a, b], GRID);
                view.line(canvas, [a, -1.0, b], [a, 1.0, b], GRID);
                view.line(canvas, [a, b, -1.0], [a, b, 1.0], GRID);
            }
        }
    }
    let edges = [
        (
            [-1.0, 1.0, -1.0],
            [1.0, 1.0, -1.0],
            (8.0, 13.0),
            Anchor::Start,
        ),
        (
            [1.0, -1.0, -1.0],
            [1.0, 1.0, -1.0],
            (-8.0, 13.0),
            Anchor::End,
        ),
        (
            [1.0, -1.0, -1.0],
            [1.0, -1.0, 1.0],
            (-9.0, 0.0),
            Anchor::End,
        ),
    ];
    for (axis, (from, to, (dx, dy), anchor)) in edges.into_iter().enumerate() {
        view.line(canvas, from, to, AXIS);
        let low = view.center[axis] - view.half[axis];
        let high = view.center[axis] + view.half[axis];
        let at = |s: f64| {
            let point = [0, 1, 2].map(|k| from[k] + s * (to[k] - from[k]));
            let (x, y) = view.project(point).0;
            (x + dx, y + dy)
        };
        canvas.label(&number(low, 3), at(0.1), anchor);
        canvas.label_in(&names[axis], at(0.5), anchor, TEXT, 14.0);
        canvas.label(&number(high, 3), at(0.92), anchor);
    }
}
