//! Bodies in a plane: a line each, or of many their last places with trails.

use std::collections::BTreeMap;
use std::ops::Range;

use plotters::style::RGBColor;

use super::axis::{Axis, Frame};
use super::canvas::{Canvas, FAINT, Ink, SERIES};
use super::chart::equal;
use super::data::BodyPath;
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, color, draw_scale_of};
use super::stroke::{Stroke, draw_orbit, is_line};

/// The most bodies that have a line each, over the whole run.
const MOST_LINES: usize = 32;

/// Colours of bodies behind those of the series: none as light or as dark as paper.
const MORE: [Ink; 10] = [
    RGBColor(0x00, 0xA3, 0xB4),
    RGBColor(0x7D, 0x8A, 0x00),
    RGBColor(0xE0, 0x60, 0x8A),
    RGBColor(0x5B, 0x6E, 0xE1),
    RGBColor(0x8D, 0x6E, 0x63),
    RGBColor(0x6B, 0xAA, 0x2E),
    RGBColor(0xB0, 0x7C, 0xC6),
    RGBColor(0xD9, 0x82, 0x00),
    RGBColor(0x6E, 0x7F, 0x8D),
    RGBColor(0x00, 0xB3, 0x86),
];

/// The most bodies that have a colour and a name each in the legend.
const MOST_NAMES: usize = SERIES.len() + MORE.len();

/// The length of a trail in pixels: of many bodies, and of few whose whole lines would cover one another.
const TRAILS: [f64; 2] = [52.0, 340.0];

/// The side of a cell that lines share, and the most of a step that is looked at, in pixels.
const CELL: f64 = 4.0;
const LONGEST: f64 = 40.0;

/// The part of all cells that lines share from which on they cover one another.
const SHARED: f64 = 0.4;

/// The cosine of an eighth of a turn.
const STRAIGHT: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The most places of all lines together.
const MOST_PLACES: usize = 40_000;

/// The width and the height of the frame, at most, and the room around it: left, top, right and bottom.
const WIDEST: f64 = 800.0;
const HIGHEST: f64 = 520.0;
const AROUND: [f64; 4] = [62.0, 34.0, 18.0, 44.0];

/// Colours of more bodies than have names: those that stand out from light and dark paper.
const LEVELS: Range<usize> = 5..27;

/// The paths of bodies, a unit as long across as up.
pub(super) fn bodies_figure(
    axes: &[String; 2],
    bodies: &[BodyPath],
    count: usize,
) -> Result<Figure, ReportError> {
    let is_finite = |place: &&[f64; 2]| place.iter().all(|value| value.is_finite());
    let is_crowd = bodies.len() > MOST_LINES;
    let all = || {
        bodies
            .iter()
            .flat_map(|body| &body.places)
            .filter(is_finite)
    };
    let [mut x, mut y] = [0, 1].map(|axis| Axis::linear(all().map(|place| place[axis]), 0.04));
    let ratio = equal(&mut x, &mut y);
    let width = WIDEST.min(HIGHEST / ratio);
    let height = width * ratio;
    let is_scaled = bodies.len() > MOST_NAMES;
    let right = AROUND[0] + width;
    let bar = if is_scaled { BAR } else { AROUND[2] };
    let frame = Frame {
        edges: [AROUND[0], AROUND[1], right, AROUND[1] + height],
        x,
        y,
    };
    let mut canvas = Canvas::new(right + bar, AROUND[1] + height + AROUND[3]);
    frame.draw(&mut canvas, &axes[0], &axes[1]);
    let last = count.saturating_sub(1).max(1) as f64;
    let inks = bodies.iter().enumerate().map(|(at, body)| match is_scaled {
        true => {
            let level = (LEVELS.len() - 1) as f64 * body.number as f64 / last;
            color(LEVELS.start + level.round() as usize)
        }
        false => *SERIES.iter().chain(&MORE).nth(at).unwrap_or(&SERIES[0]),
    });
    let inks: Vec<Ink> = inks.collect();
    let paths = bodies.iter().map(|body| -> Vec<(f64, f64)> {
        let places = body.places.iter().filter(is_finite);
        places.map(|[x, y]| frame.point(*x, *y)).collect()
    });
    let paths: Vec<Vec<(f64, f64)>> = paths.collect();
    let places = paths.iter().map(Vec::len).sum::<usize>();
    let stride = places.div_ceil(MOST_PLACES).max(1);
    let thinned = |path: &Vec<(f64, f64)>| path.iter().step_by(stride).copied().collect();
    let is_covered = !is_crowd && cover_one_another(paths.iter().map(thinned));
    let trail = |path: &[(f64, f64)]| match (is_crowd, is_covered) {
        (true, _) => trail_of(path, TRAILS[0]),
        (_, true) => trail_of(path, TRAILS[1]),
        _ => 0,
    };
    // Pale things lie beneath all lines, and lines beneath all places.
    for path in &paths {
        let before = &path[..path.len().min(trail(path) + 1)];
        match is_crowd {
            true => path
                .iter()
                .take(1)
                .for_each(|at| canvas.disc(*at, 1.0, FAINT)),
            false => draw_line(&mut canvas, before, stride, (FAINT, 0.6)),
        }
    }
    let line = if is_crowd {
        0.8
    } else {
        Stroke::NEAR_SIDE.width
    };
    for (path, ink) in paths.iter().zip(&inks) {
        let own = &path[trail(path)..];
        match is_crowd {
            true if is_trail(own) => canvas.path(own, *ink, line),
            true => {}
            false => draw_line(&mut canvas, own, stride, (*ink, line)),
        }
    }
    for (path, ink) in paths.iter().zip(&inks) {
        if let (Some(first), Some(last)) = (path.first(), path.last()) {
            if is_crowd {
                canvas.disc(*last, 2.0, *ink);
            } else {
                canvas.ring(*last, 4.0, *ink, 2.0);
                canvas.disc(*first, 4.0, *ink);
            }
        }
    }
    if is_scaled {
        let numbers = Axis::Linear {
            low: 0.0,
            high: last,
        };
        draw_scale_of(&mut canvas, frame.edges, numbers, "body", LEVELS);
    }
    let mut notes = Vec::new();
    let are_apart = |path: &Vec<(f64, f64)>| path.len() > 2 && !is_line(path) && !is_smooth(path);
    if !is_crowd && paths.iter().any(are_apart) {
        notes.push("Places too far apart for a line are dots: record more of them.".to_owned());
    }
    if bodies.len() < count {
        notes.push(format!("Drawn: {} of {count} bodies.", bodies.len()));
    }
    let recorded = bodies.iter().map(|body| body.places.len()).sum::<usize>();
    if places < recorded {
        let lost = recorded - places;
        notes.push(format!(
            "Not finite and not drawn: {lost} of {recorded} places."
        ));
    }
    let svg = canvas.finish_in_own_size("The paths of the bodies in a plane")?;
    let has_names = !is_scaled && bodies.len() > 1;
    let named = bodies.iter().filter(|_| has_names);
    let behind = inks.iter().skip(SERIES.len()).filter(|_| has_names);
    Ok(Figure {
        title: format!("Trajectories in ({}, {})", axes[0], axes[1]),
        svg: svg.replacen("<svg ", "<svg class=\"paths\" ", 1),
        legend: named.map(|body| body.name.clone()).collect(),
        colors: behind.map(|ink| hexadecimal(*ink)).collect(),
        caption: match (is_crowd, is_covered) {
            (true, _) => "Every body where it is last, with the trail that it came by; pale: where it began.",
            (_, true) => {
                "The end of each body's line, and pale the way before. Disc: where it begins; ring: where it is last."
            }
            _ => "A line for each body. Disc: where it begins; ring: where it is last.",
        }
        .to_owned(),
        notes,
    })
}

/// A colour in HTML.
fn hexadecimal(RGBColor(red, green, blue): Ink) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// Draws every `stride`-th point of a line and the last.
fn draw_line(canvas: &mut Canvas, path: &[(f64, f64)], stride: usize, (ink, width): (Ink, f64)) {
    let last = path
        .last()
        .filter(|_| !(path.len() - 1).is_multiple_of(stride));
    let kept: Vec<_> = path.iter().step_by(stride).chain(last).copied().collect();
    if !is_line(&kept) && is_smooth(&kept) {
        canvas.path(&kept, ink, width);
    } else if kept.len() > 1 {
        draw_orbit(canvas, &kept, |_| Stroke { ink, width });
    }
}

/// Whether most corners of a line turn by less than an eighth of a turn, however far apart its points are.
fn is_smooth(path: &[(f64, f64)]) -> bool {
    let is_bent = |corner: &[(f64, f64)]| {
        let [a, b] = [0, 1].map(|at| {
            let ((x0, y0), (x1, y1)) = (corner[at], corner[at + 1]);
            (x1 - x0, y1 - y0)
        });
        a.0 * b.0 + a.1 * b.1 < STRAIGHT * libm::hypot(a.0, a.1) * libm::hypot(b.0, b.1)
    };
    let bent = path.windows(3).filter(|corner| is_bent(corner)).count();
    path.len() > 2 && bent * 10 <= path.len()
}

/// The point from which on the rest of a line is at least so long, the first where the whole is shorter.
fn trail_of(path: &[(f64, f64)], length: f64) -> usize {
    let mut left = length;
    for at in (1..path.len()).rev() {
        let (from, to) = (path[at - 1], path[at]);
        left -= libm::hypot(to.0 - from.0, to.1 - from.1);
        if left <= 0.0 {
            return at - 1;
        }
    }
    0
}

/// Whether the end of a path is one: places so far apart that a chord says nothing are none.
fn is_trail(path: &[(f64, f64)]) -> bool {
    let longest = 2.0 * TRAILS[0];
    path.windows(2)
        .all(|pair| libm::hypot(pair[1].0 - pair[0].0, pair[1].1 - pair[0].1) < longest)
}

/// Whether a good part of all places on the picture belong to lines of several bodies.
fn cover_one_another(paths: impl Iterator<Item = Vec<(f64, f64)>>) -> bool {
    let mut cells: BTreeMap<(i64, i64), (usize, bool)> = BTreeMap::new();
    for (body, path) in paths.enumerate() {
        for pair in path.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let length = libm::hypot(to.0 - from.0, to.1 - from.1).min(LONGEST);
            let parts = (length / CELL).ceil().max(1.0);
            for part in 0..parts as usize {
                let s = part as f64 / parts;
                let [x, y] = [from.0 + s * (to.0 - from.0), from.1 + s * (to.1 - from.1)];
                let cell = ((x / CELL) as i64, (y / CELL) as i64);
                let (first, is_shared) = cells.entry(cell).or_insert((body, false));
                *is_shared |= *first != body;
            }
        }
    }
    let shared = cells.values().filter(|(_, is_shared)| *is_shared).count();
    shared as f64 > SHARED * cells.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bodies on circles about the origin, each with a radius of its own.
    fn bodies(count: usize) -> Vec<BodyPath> {
        let body = |number: usize| BodyPath {
            name: format!("q[{number}]"),
            number,
            places: (0..200)
                .map(|k| {
                    let (sine, cosine) = libm::sincos(0.02 * f64::from(k));
                    let radius = 1.0 + number as f64;
                    [radius * cosine, radius * sine]
                })
                .collect(),
        };
        (0..count).map(body).collect()
    }

    fn figure(bodies: &[BodyPath], count: usize) -> Figure {
        let axes = ["q.x", "q.y"].map(str::to_owned);
        bodies_figure(&axes, bodies, count).expect("a picture")
    }

    /// Every one of few bodies has a line, a disc and a ring in a colour that no other has.
    #[test]
    fn few_bodies_are_told_apart_by_colours_and_names() {
        let figure = figure(&bodies(6), 6);
        assert_eq!(figure.legend.len(), 6);
        for ink in SERIES {
            let ink = hexadecimal(ink);
            let drawn = figure
                .svg
                .split('<')
                .filter(|element| element.contains(&ink));
            let kinds: Vec<&str> = drawn.filter_map(|it| it.split(' ').next()).collect();
            assert_eq!(kinds.iter().filter(|kind| **kind == "polyline").count(), 1);
            assert_eq!(kinds.iter().filter(|kind| **kind == "circle").count(), 2);
        }
    }

    /// More bodies than there are series have names too, each in a colour of its own; a crowd has a bar of colours and no names.
    #[test]
    fn a_dozen_bodies_have_names_in_colours_of_their_own() {
        let dozen = figure(&bodies(16), 16);
        assert_eq!((dozen.legend.len(), dozen.colors.len()), (16, 10));
        let mut colors = dozen.colors.clone();
        colors.extend(SERIES.map(hexadecimal));
        colors.sort();
        colors.dedup();
        assert_eq!(colors.len(), 16);
        for color in &colors {
            assert!(dozen.svg.contains(color.as_str()), "{color}");
        }
        let crowd = figure(&bodies(17), 17);
        assert!(crowd.legend.is_empty() && crowd.colors.is_empty());
    }

    /// Places that lie far apart on a smooth curve are joined, those of a curve that turns between any two are dots.
    #[test]
    fn smooth_paths_are_lines() {
        for (turn, lines) in [(0.2, 1), (2.1, 0)] {
            let mut one = bodies(1);
            one[0].places = (0..40)
                .map(|k| {
                    let (sine, cosine) = libm::sincos(turn * f64::from(k));
                    [cosine, sine]
                })
                .collect();
            let svg = figure(&one, 1).svg;
            let ink = hexadecimal(SERIES[0]);
            let own = svg
                .split('<')
                .filter(|it| it.starts_with("polyline") && it.contains(&ink));
            assert_eq!(own.count(), lines, "{turn}");
        }
    }

    /// A circle is as wide as high on the picture, to a pixel.
    #[test]
    fn a_circle_is_round() {
        let mut one = bodies(1);
        one[0].places = (0..=100)
            .map(|k| {
                let (sine, cosine) = libm::sincos(0.062_831_853 * f64::from(k));
                [5.0 + 3.0 * cosine, 3.0 * sine]
            })
            .collect();
        let svg = figure(&one, 1).svg;
        let lines = svg.split("points=\"").skip(1);
        let longest = lines.map(|line| line.split('"').next().unwrap_or_default());
        let longest = longest.max_by_key(|line| line.len()).expect("a line");
        let numbers: Vec<f64> = longest
            .split([' ', ','])
            .filter_map(|number| number.parse().ok())
            .collect();
        let span = |axis: usize| {
            let values = || numbers.iter().skip(axis).step_by(2).copied();
            values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
        };
        // The back end rounds to whole units.
        assert!((span(0) - span(1)).abs() <= 2.0, "{} {}", span(0), span(1));
        assert!(span(0) > 800.0, "{}", span(0));
    }

    /// Of many bodies each has a place and none the line of the whole run; how many are left out is said.
    #[test]
    fn many_bodies_are_places_with_trails() {
        let crowd = bodies(100);
        let figure = figure(&crowd, 300);
        assert!(figure.legend.is_empty());
        assert_eq!(figure.notes, ["Drawn: 100 of 300 bodies."]);
        assert!(figure.svg.matches("<circle").count() >= 200);
        for line in figure.svg.split("points=\"").skip(1) {
            let points = line.split('"').next().unwrap_or_default();
            let points: Vec<Vec<f64>> = points
                .split_whitespace()
                .map(|point| point.split(',').filter_map(|it| it.parse().ok()).collect())
                .collect();
            let steps = points.windows(2);
            let length: f64 = steps
                .map(|pair| libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]))
                .sum();
            // A grid line, or a trail and the one step that goes beyond it, of at most 0.02 of the frame's half; the back
            // end draws four units a pixel.
            let is_straight = points.len() <= 3;
            assert!(
                is_straight || length <= 4.0 * (TRAILS[0] + 0.02 * WIDEST),
                "{length}"
            );
        }
    }

    /// Bodies that follow one another on one curve have the way before their trails drawn pale.
    #[test]
    fn lines_that_cover_one_another_are_trails() {
        let mut chase = bodies(3);
        for (at, body) in chase.iter_mut().enumerate() {
            body.places = (0..3000)
                .map(|k| {
                    let (sine, cosine) = libm::sincos(0.02 * f64::from(k) + 2.0 * at as f64);
                    [cosine, sine]
                })
                .collect();
        }
        let pale = "#A9C6E0";
        assert!(figure(&chase, 3).svg.contains(pale));
        assert!(!figure(&bodies(3), 3).svg.contains(pale));
    }

    /// Places that are not finite are left out and counted; bodies without places, and none at all, are no error.
    #[test]
    fn places_that_are_not_finite_are_counted() {
        let mut broken = bodies(2);
        broken[1].places[7][1] = f64::NAN;
        assert_eq!(
            figure(&broken, 2).notes,
            ["Not finite and not drawn: 1 of 400 places."]
        );
        broken[0].places.clear();
        for bodies in [&broken[..], &[]] {
            assert!(!figure(bodies, bodies.len()).svg.contains("NaN"));
        }
    }
}
