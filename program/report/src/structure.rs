//! Structure factors: a line over q of a chain, colours over two wave numbers of a plane.

use std::f64::consts::PI;
use std::ops::Range;

use super::axis::{Axis, Frame};
use super::canvas::{Canvas, SERIES};
use super::data::StructureFactor;
use super::decimate::maxima;
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, color, draw_scale, level};

/// Values below this part of the largest are drawn there.
const FLOOR: f64 = 1e-12;

/// The most cells across and up; beyond, a cell shows the largest of several.
const CELLS: usize = 64;

/// S(q) for q from −π to π along each axis; nothing where it is 0 or has no value.
pub(super) fn structure_figure(factor: &StructureFactor) -> Result<Option<Figure>, ReportError> {
    let finite = factor.values.iter().filter(|value| value.is_finite());
    let largest = finite.fold(0.0, |most: f64, value| most.max(*value));
    let sites: usize = factor.lengths.iter().product();
    if largest <= 0.0 || sites != factor.values.len() {
        return Ok(None);
    }
    let floor = FLOOR * largest;
    let shown = factor.values.iter().map(|value| match value.is_finite() {
        true => value.max(floor),
        false => f64::NAN,
    });
    let shown: Vec<f64> = shown.collect();
    let svg = match factor.lengths[..] {
        [length] => line(&shown, length, &along(factor, 0))?,
        [rows, columns] => plane(&shown, [rows, columns], [0, 1].map(|at| along(factor, at)))?,
        _ => return Ok(None),
    };
    let [used, recorded] = factor.states;
    let states = match used == recorded {
        true => format!("{recorded} recorded states"),
        false => format!("{used} of {recorded} recorded states"),
    };
    let lowest = factor.values.iter().filter(|value| **value < floor).count();
    let mut notes = factor.notes.clone();
    if lowest > 0 {
        notes.push("Values below 10⁻¹² of the largest are drawn as 10⁻¹² of it.".to_owned());
    }
    let many = match factor.lengths.iter().any(|length| *length > CELLS) && factor.lengths.len() > 1
    {
        true => " Each cell shows the largest value that it covers.",
        false => "",
    };
    Ok(Some(Figure {
        title: format!("Structure factor of {}", factor.name),
        svg,
        legend: Vec::new(),
        caption: format!(
            "S(q) = ⟨|Σ {}(r) exp(−i q·r)|²⟩/N, the mean over {states}, q in radians a site.{many}",
            factor.name
        ),
        colors: Vec::new(),
        notes,
    }))
}

/// The wave number along an axis, as "q along j".
fn along(factor: &StructureFactor, axis: usize) -> String {
    factor
        .axes
        .get(axis)
        .map_or_else(|| "q".to_owned(), |letter| format!("q along {letter}"))
}

/// The places m of the wave numbers 2πm/L from −π to π, both ends where they are wave numbers.
fn places(length: usize) -> Vec<usize> {
    let half = length / 2;
    (0..length + usize::from(length.is_multiple_of(2)))
        .map(|k| (k + length - half) % length)
        .collect()
}

/// The wave number at a place from the left.
fn wave_number(at: usize, length: usize) -> f64 {
    let half = (length / 2) as f64;
    2.0 * PI * (at as f64 - half) / length as f64
}

fn line(values: &[f64], length: usize, title: &str) -> Result<String, ReportError> {
    let (width, height) = (480.0, 300.0);
    let frame = Frame::new(
        width,
        height,
        Axis::Turn,
        Axis::logarithmic(values.iter().copied()),
    );
    let mut canvas = Canvas::new(width, height);
    frame.draw(&mut canvas, title, "S(q)");
    let points = places(length).into_iter().enumerate();
    let points: Vec<_> = points
        .map(|(at, place)| (frame.x.fraction(wave_number(at, length)), values[place]))
        .filter(|(_, value)| value.is_finite())
        .collect();
    let [left, _, right, _] = frame.edges;
    let points: Vec<_> = maxima(&points, frame.columns())
        .into_iter()
        .map(|(at, value)| (left + at * (right - left), frame.point(0.0, value).1))
        .collect();
    canvas.samples(&points, right - left, SERIES[0], 1.5);
    canvas.finish("The structure factor over the wave number")
}

/// A cell along an axis: where it lies, from 0 at −π to 1 at π, and the wave numbers that it covers.
fn cells(length: usize) -> Vec<([f64; 2], Range<usize>)> {
    let count = places(length).len();
    let edge = |at: usize| {
        // Half-way between two wave numbers.
        let q = wave_number(at, length) - PI / length as f64;
        Axis::Turn.fraction(q)
    };
    let cells = count.min(CELLS);
    let cell = |k: usize| {
        let range = k * count / cells..(k + 1) * count / cells;
        ([edge(range.start), edge(range.end)], range)
    };
    (0..cells).map(cell).collect()
}

fn plane(
    values: &[f64],
    [rows, columns]: [usize; 2],
    titles: [String; 2],
) -> Result<String, ReportError> {
    let (width, height) = (480.0, 420.0);
    let mut frame = Frame::new(width, height, Axis::Turn, Axis::Turn);
    frame.edges[2] = width - BAR;
    let side = (frame.edges[2] - frame.edges[0]).min(frame.edges[3] - frame.edges[1]);
    (frame.edges[1], frame.edges[2]) = (frame.edges[3] - side, frame.edges[0] + side);
    let logarithms: Vec<f64> = values.iter().map(|value| libm::log10(*value)).collect();
    let axis = Axis::linear(logarithms.iter().copied(), 0.0);
    let mut canvas = Canvas::new(width, height);
    frame.draw(&mut canvas, &titles[0], &titles[1]);
    let [left, top, right, bottom] = frame.edges;
    // The first axis lies across, as in maps of the field.
    let (across, up) = (places(rows), places(columns));
    let vertical = cells(columns);
    for ([from, to], own) in cells(rows) {
        for ([low, high], other) in &vertical {
            let covered = own.clone().flat_map(|i| {
                let row = across[i] * columns;
                other
                    .clone()
                    .map(|j| logarithms[row + up[j]])
                    .collect::<Vec<_>>()
            });
            let value = covered.fold(f64::NEG_INFINITY, f64::max);
            if value.is_finite() {
                let at = |x: f64, y: f64| (left + x * (right - left), bottom - y * (bottom - top));
                canvas.cell(at(from, *high), at(to, *low), color(level(axis, value)));
            }
        }
    }
    draw_scale(&mut canvas, frame.edges, axis, "log₁₀ S");
    canvas.finish("The structure factor over two wave numbers")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(lengths: Vec<usize>, peak: usize) -> StructureFactor {
        let mut values = vec![1e-3; lengths.iter().product()];
        values[peak] = 10.0;
        StructureFactor {
            name: "s".to_owned(),
            axes: ["i", "j"].map(str::to_owned).to_vec(),
            lengths,
            values,
            states: [3, 5],
            notes: vec!["q = 0 along k.".to_owned()],
        }
    }

    /// Cells of every lattice cover −π to π without gaps, and each wave number lies in its own.
    #[test]
    fn cells_cover_all_wave_numbers() {
        for length in [1, 2, 3, 8, 9, 63, 64, 65, 300] {
            let (cells, places) = (cells(length), places(length));
            assert_eq!(cells[0].0[0], 0.0);
            assert_eq!(cells[cells.len() - 1].0[1], 1.0);
            assert!(cells.windows(2).all(|pair| pair[0].0[1] == pair[1].0[0]));
            for ([from, to], range) in cells {
                for at in range {
                    let m = places[at] as f64;
                    let q = 2.0 * PI * m / length as f64;
                    // The same wave number modulo 2π.
                    let turns = (q - wave_number(at, length)) / (2.0 * PI);
                    assert!((turns - turns.round()).abs() < 1e-12);
                    let place = Axis::Turn.fraction(wave_number(at, length));
                    assert!(from <= place && place <= to);
                }
            }
        }
    }

    /// The peak of a wave along the first axis lies to the right of the middle, at its height.
    #[test]
    fn a_peak_stands_at_its_wave_number() {
        // q = (2π·2/16, 0): the place 2·8 of 16 × 8 sites.
        let figure = structure_figure(&factor(vec![16, 8], 16)).expect("a picture");
        let svg = figure.expect("values").svg;
        let brightest: Vec<&str> = svg.split('<').filter(|it| it.contains("#FDE725")).collect();
        let [x, y, width, height] = ["x=\"", "y=\"", "width=\"", "height=\""].map(|key| {
            let cell = brightest[0];
            let rest = cell.split(&format!(" {key}")).nth(1).expect("an attribute");
            rest.split('"')
                .next()
                .and_then(|it| it.parse::<f64>().ok())
                .expect("a number")
        });
        let side = 4.0 * 326.0;
        let middle = [
            4.0 * 62.0 + side * (0.5 + 2.0 / 16.0),
            4.0 * (420.0 - 44.0) - side * 0.5,
        ];
        assert!((x + width / 2.0 - middle[0]).abs() <= 2.0, "{x} {width}");
        assert!((y + height / 2.0 - middle[1]).abs() <= 2.0, "{y} {height}");
    }

    #[test]
    fn a_chain_has_a_line_and_zeros_have_a_floor() {
        let mut chain = factor(vec![64], 4);
        chain.values[9] = 0.0;
        chain.values[10] = f64::NAN;
        let figure = structure_figure(&chain)
            .expect("a picture")
            .expect("values");
        assert!(figure.svg.contains("polyline") && !figure.svg.contains("NaN"));
        assert_eq!(figure.notes[0], "q = 0 along k.");
        assert!(figure.notes[1].contains("10⁻¹²"), "{:?}", figure.notes);
        assert!(figure.svg.contains("q along i"), "{}", figure.svg);
        assert!(
            figure.caption.contains("3 of 5 recorded states"),
            "{}",
            figure.caption
        );
        chain.values.fill(0.0);
        assert_eq!(structure_figure(&chain).expect("nothing"), None);
    }
}
