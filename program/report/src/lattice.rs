//! A field on a lattice: space against time in colour, and profiles.

use super::axis::{Axis, Frame};
use super::canvas::{Canvas, SERIES};
use super::decimate::envelope;
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, draw_row, draw_scale, farthest, level};
use super::number::number;

/// The most cells across and up.
const CELLS: (usize, usize) = (96, 60);

/// The radius of the dot of a site that has no neighbours.
const DOT: f64 = 1.6;

/// Space–time picture and profiles of the recorded fields.
pub(super) fn lattice_figures(
    name: &str,
    times: &[f64],
    (spacing, has_neighbours): (usize, bool),
    fields: &[Vec<f64>],
) -> Result<Vec<Figure>, ReportError> {
    let sites = fields.iter().map(Vec::len).max().unwrap_or(0);
    let mut figures = Vec::new();
    if fields.len() > 2 && sites > 0 {
        figures.push(heat_figure(
            name,
            times,
            (spacing, has_neighbours),
            fields,
            sites,
        )?);
    }
    if sites > 0 {
        figures.push(profile_figure(
            name,
            times,
            (spacing, has_neighbours),
            fields,
            sites,
        )?);
    }
    Ok(figures)
}

fn heat_figure(
    name: &str,
    times: &[f64],
    (spacing, has_neighbours): (usize, bool),
    fields: &[Vec<f64>],
    sites: usize,
) -> Result<Figure, ReportError> {
    let (width, height) = (960.0, 440.0);
    let values = || {
        fields
            .iter()
            .flatten()
            .copied()
            .filter(|value| value.is_finite())
    };
    let (sum, count) = values().fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    let color_axis = Axis::linear(values(), 0.0);
    let x = Axis::Sites {
        count: sites * spacing.max(1),
    };
    let y = Axis::linear(times.iter().copied(), 0.0);
    let mut frame = Frame::new(width, height, x, y);
    frame.edges[2] = width - BAR;
    let mut canvas = Canvas::new(width, height);
    frame.draw(&mut canvas, &format!("site i of {name}[i]"), "time t");
    let (columns, rows) = (sites.min(CELLS.0), fields.len().min(CELLS.1));
    let [left, top, right, bottom] = frame.edges;
    // A row ends half-way between two recorded times.
    let edge = |field: usize| match (times.get(field.wrapping_sub(1)), times.get(field)) {
        (Some(before), Some(after)) => frame.point(0.0, f64::midpoint(*before, *after)).1,
        (None, _) => bottom,
        (_, None) => top,
    };
    let mut broken = 0;
    for row in 0..rows {
        let span = row * fields.len() / rows..(row + 1) * fields.len() / rows;
        let levels: Vec<Option<usize>> = (0..columns)
            .map(|column| {
                let stretch = column * sites / columns..(column + 1) * sites / columns;
                let block = fields[span.clone()].iter();
                let block = block.filter_map(|field| field.get(stretch.clone()));
                let value = farthest(block.flatten(), mean)?;
                Some(level(color_axis, value))
            })
            .collect();
        let heights = [edge(span.end), edge(span.start)];
        broken += draw_row(&mut canvas, [left, right], heights, &levels);
    }
    draw_scale(&mut canvas, frame.edges, color_axis, name);
    let mut notes = Vec::new();
    if broken > 0 {
        notes.push(format!(
            "{broken} cells hold values that are not finite (red)."
        ));
    }
    Ok(Figure {
        title: format!("{name} over space and time"),
        svg: canvas.finish("The field over space and time")?,
        legend: Vec::new(),
        caption: format!(
            "Each cell shows, among the sites and recorded times it covers, the value farthest from the mean{}.",
            match has_neighbours {
                true => "; a wave travelling at constant speed is a straight stripe",
                false => "",
            }
        ),
        colors: Vec::new(),
        notes,
    })
}

fn profile_figure(
    name: &str,
    times: &[f64],
    (spacing, has_neighbours): (usize, bool),
    fields: &[Vec<f64>],
    sites: usize,
) -> Result<Figure, ReportError> {
    let (width, height) = (960.0, 320.0);
    let mut chosen = vec![0, fields.len() / 2, fields.len().saturating_sub(1)];
    chosen.dedup();
    let values = chosen.iter().flat_map(|index| &fields[*index]).copied();
    let x = Axis::Linear {
        low: 0.0,
        high: sites.saturating_sub(1).max(1) as f64 * spacing.max(1) as f64,
    };
    let frame = Frame::new(width, height, x, Axis::linear(values, 0.06));
    let mut canvas = Canvas::new(width, height);
    frame.draw(&mut canvas, &format!("site i of {name}[i]"), name);
    let [left, _, right, _] = frame.edges;
    for (series, index) in chosen.iter().enumerate() {
        let placed: Vec<_> = fields[*index]
            .iter()
            .enumerate()
            .map(|(site, value)| (frame.x.fraction(site as f64 * spacing as f64), *value))
            .collect();
        let ink = SERIES[series % SERIES.len()];
        let at = |(at, value): (f64, f64)| (left + at * (right - left), frame.point(0.0, value).1);
        for stretch in placed.chunk_by(|a, b| a.1.is_finite() == b.1.is_finite()) {
            if !stretch[0].1.is_finite() {
                continue;
            }
            if has_neighbours {
                let line: Vec<_> = envelope(stretch, frame.columns())
                    .into_iter()
                    .map(at)
                    .collect();
                canvas.path(&line, ink, 1.5);
            } else {
                let dots = stretch.iter().copied().map(at);
                dots.for_each(|dot| canvas.disc(dot, DOT, ink));
            }
        }
    }
    let time = |index: &usize| times.get(*index).copied().unwrap_or(f64::NAN);
    Ok(Figure {
        title: format!("Profiles of {name}"),
        svg: canvas.finish("The field at several times")?,
        legend: chosen
            .iter()
            .map(|index| format!("t = {}", number(time(index), 4)))
            .collect(),
        caption: match has_neighbours {
            true => "The field at the first, the middle and the last recorded time.",
            false => "A dot a site, at the first, the middle and the last recorded time.",
        }
        .to_owned(),
        colors: Vec::new(),
        notes: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of uneven times end half-way between these, and labels of sites stand in the middle of their cells.
    #[test]
    fn cells_stand_at_their_sites_and_times() {
        let fields: Vec<Vec<f64>> = (0..4)
            .map(|row| vec![f64::from(row), 10.0 + f64::from(row)])
            .collect();
        let figures =
            lattice_figures("q", &[0.0, 1.0, 3.0, 10.0], (1, true), &fields).expect("pictures");
        let svg = &figures[0].svg;
        let number = |element: &str, key: &str| -> f64 {
            let rest = element
                .split(&format!(" {key}=\""))
                .nth(1)
                .expect("an attribute");
            rest.split('"')
                .next()
                .and_then(|it| it.parse().ok())
                .expect("a number")
        };
        let cells: Vec<&str> = svg.split('<').filter(|it| it.starts_with("rect")).collect();
        let heights: Vec<f64> = cells[..8]
            .iter()
            .step_by(2)
            .map(|it| number(it, "height"))
            .collect();
        // The frame is 440 - 34 - 44 pixels high, four units each.
        let unit = 4.0 * 362.0 / 10.0;
        for (height, time) in heights.iter().zip([0.5, 1.5, 4.5, 3.5]) {
            // Both ends are rounded to whole units.
            assert!((height - time * unit).abs() <= 1.0, "{height} {time}");
        }
        let labels = svg.split("<text ").filter(|it| it.contains("\n1\n"));
        let right = labels
            .map(|it| number(&format!(" {it}"), "x"))
            .fold(0.0, f64::max);
        let middle = number(cells[1], "x") + 0.5 * number(cells[1], "width");
        assert!((right - middle).abs() <= 1.0, "{right} {middle}");
    }

    /// Sites without neighbours are dots, and their picture tells of no waves.
    #[test]
    fn sites_without_neighbours_are_dots() {
        let fields = vec![vec![0.0, 1.0, 5.0, f64::NAN, 2.0]; 3];
        let drawn = |has_neighbours: bool| {
            lattice_figures("q", &[0.0, 1.0, 2.0], (1, has_neighbours), &fields).expect("pictures")
        };
        let (chain, apart) = (drawn(true), drawn(false));
        assert!(chain[0].caption.contains("wave") && !apart[0].caption.contains("wave"));
        let dots = |figure: &Figure| figure.svg.matches("<circle").count();
        assert_eq!(dots(&apart[1]), 12);
        assert!(dots(&chain[1]) < 12);
    }
}
