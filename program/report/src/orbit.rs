//! The orbit: a projection of three coordinates, or the plane of two.

use super::axis::{Axis, Frame};
use super::canvas::Canvas;
use super::data::{Ellipsoid, TimeSeries};
use super::error::ReportError;
use super::figure::Figure;
use super::history::{Dense, history};
use super::space::space_picture;
use super::stroke::{Stroke, draw_ends, draw_orbit};

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
        colors: Vec::new(),
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
