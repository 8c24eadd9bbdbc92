//! Maps of a field over a lattice of several axes, in colour.

use super::axis::{Axis, Frame};
use super::canvas::{ALARM, Canvas};
use super::data::PlaneMap;
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, color, draw_scale, level};

/// Height of a row of maps, and the maps of a row.
const ROW: (f64, usize) = (320.0, 3);

/// From one map to the next.
const BETWEEN: f64 = 40.0;

/// Maps side by side, three a row, with one scale of colours.
pub(super) fn plane_figure(maps: &[PlaneMap], slice: Option<&str>) -> Result<Figure, ReportError> {
    let rows = maps.len().div_ceil(ROW.1).max(1);
    let (width, height) = (960.0, ROW.0 * rows as f64);
    let values = maps.iter().flat_map(|map| &map.values).copied();
    let color_axis = Axis::linear(values, 0.0);
    let mut canvas = Canvas::new(width, height);
    let each = (width - BAR - 62.0 - BETWEEN * (ROW.1 - 1) as f64) / ROW.1 as f64;
    let frame = |at: usize, map: &PlaneMap| {
        let (row, column) = ((at / ROW.1) as f64, (at % ROW.1) as f64);
        let left = 62.0 + column * (each + BETWEEN);
        let top = 34.0 + row * ROW.0;
        frame_of(map, [left, top, left + each, (row + 1.0) * ROW.0 - 44.0])
    };
    let frames: Vec<Frame> = maps
        .iter()
        .enumerate()
        .map(|(at, map)| frame(at, map))
        .collect();
    // All lines of the frames lie beneath all cells.
    for (frame, map) in frames.iter().zip(maps) {
        let [across, up] = &map.axes;
        frame.draw(&mut canvas, across, &format!("{} over {up}", map.title));
    }
    let mut broken = 0;
    for (frame, map) in frames.iter().zip(maps) {
        broken += cells(&mut canvas, frame, map, color_axis);
    }
    let right = frames
        .iter()
        .map(|frame| frame.edges[2])
        .fold(0.0, f64::max);
    let edges = [62.0, 34.0, right, ROW.0 - 44.0];
    draw_scale(&mut canvas, edges, color_axis, "");
    let mut notes: Vec<String> = slice.map(str::to_owned).into_iter().collect();
    if broken > 0 {
        notes.push(format!(
            "{broken} cells hold values that are not finite (red)."
        ));
    }
    Ok(Figure {
        title: "The field over the lattice".to_owned(),
        svg: canvas.finish("Maps of the field over two axes of the lattice")?,
        legend: Vec::new(),
        caption: match maps.iter().map(|map| map.spacing).max() {
            Some(spacing) if spacing > 1 => format!(
                "Each cell is one site of {spacing} along each axis; all maps share the scale of colours."
            ),
            _ => "Each cell is a site; all maps share the scale of colours.".to_owned(),
        },
        notes,
    })
}

/// The frame of a map within these edges: a site is as wide as high.
fn frame_of(map: &PlaneMap, edges: [f64; 4]) -> Frame {
    let [left, top, right, bottom] = edges;
    let rows = map.values.len() / map.columns.max(1);
    let (across, up) = (map.columns.max(1) as f64, rows.max(1) as f64);
    let cell = ((right - left) / across).min((bottom - top) / up);
    let linear = |high: f64| Axis::Linear {
        low: 0.0,
        high: high * map.spacing.max(1) as f64,
    };
    Frame {
        edges: [left, bottom - cell * up, left + cell * across, bottom],
        x: linear(across),
        y: linear(up),
    }
}

/// Draws the sites of a map; returns how many have no finite value.
fn cells(canvas: &mut Canvas, frame: &Frame, map: &PlaneMap, color_axis: Axis) -> usize {
    let [left, top, right, bottom] = frame.edges;
    let columns = map.columns.max(1);
    let rows = map.values.len() / columns;
    let at = |k: usize| left + (right - left) * k as f64 / columns as f64;
    let up = |k: usize| bottom - (bottom - top) * k as f64 / rows.max(1) as f64;
    let mut broken = 0;
    for (row, values) in map.values.chunks_exact(columns).enumerate() {
        let levels = values.iter();
        let levels: Vec<Option<usize>> = levels
            .map(|value| value.is_finite().then(|| level(color_axis, *value)))
            .collect();
        let mut start = 0;
        for run in levels.chunk_by(|a, b| a == b) {
            let ink = run[0].map_or(ALARM, color);
            broken += if run[0].is_none() { run.len() } else { 0 };
            canvas.cell(
                (at(start), up(row + 1)),
                (at(start + run.len()), up(row)),
                ink,
            );
            start += run.len();
        }
    }
    broken
}
