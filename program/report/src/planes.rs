//! Maps of a field over a lattice of several axes, in colour.

use super::axis::{Axis, Frame};
use super::canvas::Canvas;
use super::data::PlaneMap;
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, draw_row, draw_scale, farthest, level};

/// Height of a row of maps, and the maps of a row.
const ROW: (f64, usize) = (320.0, 3);

/// From one map to the next.
const BETWEEN: f64 = 40.0;

/// The most cells of a map across and up.
const CELLS: usize = 64;

/// Longer sides than so many times the other are drawn shorter, with cells that are no squares.
const LONGEST: f64 = 8.0;

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
    let finite = maps
        .iter()
        .flat_map(|map| &map.values)
        .filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    let mut broken = 0;
    for (frame, map) in frames.iter().zip(maps) {
        broken += cells(&mut canvas, frame, map, (color_axis, mean));
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
        caption: match maps.iter().any(|map| shape(map).iter().any(|sites| *sites > CELLS)) {
            true => "Each cell shows, among the sites that it covers, the value farthest from the mean; all maps share the \
                     scale of colours.",
            false => "Each cell is a site; all maps share the scale of colours.",
        }
        .to_owned(),
        notes,
    })
}

/// The sites of a map across and up.
fn shape(map: &PlaneMap) -> [usize; 2] {
    let columns = map.columns.max(1);
    [columns, map.values.len() / columns]
}

/// The frame of a map within these edges: a site is as wide as high, where one side is not much longer than the other.
fn frame_of(map: &PlaneMap, edges: [f64; 4]) -> Frame {
    let [left, top, right, bottom] = edges;
    let sites = shape(map).map(|sites| sites.max(1) as f64);
    let longest = sites[0].max(sites[1]);
    let [across, up] = sites.map(|sites| sites.max(longest / LONGEST));
    let size = ((right - left) / across).min((bottom - top) / up);
    let [x, y] = sites.map(|high| Axis::Linear { low: 0.0, high });
    Frame {
        edges: [left, bottom - size * up, left + size * across, bottom],
        x,
        y,
    }
}

/// Draws the sites of a map, many as one cell; returns how many cells have no finite value.
fn cells(
    canvas: &mut Canvas,
    frame: &Frame,
    map: &PlaneMap,
    (color_axis, mean): (Axis, f64),
) -> usize {
    let [left, top, right, bottom] = frame.edges;
    let [across, up] = shape(map);
    let [columns, rows] = [across, up].map(|sites| sites.min(CELLS));
    let height = |row: usize| bottom - (bottom - top) * row as f64 / rows.max(1) as f64;
    let mut broken = 0;
    for row in 0..rows {
        let own = row * up / rows..(row + 1) * up / rows;
        let cell = |column: usize| {
            let stretch = column * across / columns..(column + 1) * across / columns;
            let sites = own
                .clone()
                .flat_map(|row| &map.values[row * across..][stretch.clone()]);
            Some(level(color_axis, farthest(sites, mean)?))
        };
        let levels: Vec<Option<usize>> = (0..columns).map(cell).collect();
        broken += draw_row(
            canvas,
            [left, right],
            [height(row + 1), height(row)],
            &levels,
        );
    }
    broken
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(columns: usize, rows: usize) -> PlaneMap {
        let mut values = vec![0.0; columns * rows];
        values[columns * (rows / 2) + columns / 2] = 1.0;
        PlaneMap {
            title: "q at t = 0".to_owned(),
            axes: ["j", "i"].map(str::to_owned),
            columns,
            values,
        }
    }

    /// A peak of one site is seen however many sites there are, and a thin plane fills a frame that can be looked at.
    #[test]
    fn a_peak_of_one_site_is_drawn_on_planes_of_any_shape() {
        for (columns, rows) in [(8, 8), (512, 512), (5000, 2), (2, 5000), (1, 1), (65, 64)] {
            let figure = plane_figure(&[map(columns, rows)], None).expect("a picture");
            // The brightest colour of the scale: its bar, and the peak where there is another value.
            let brightest = figure.svg.to_lowercase().matches("#fde725").count();
            let expected = if columns * rows > 1 { 2 } else { 1 };
            assert!(brightest >= expected, "{columns} × {rows}: {brightest}");
            let [left, top, right, bottom] =
                frame_of(&map(columns, rows), [0.0, 0.0, 240.0, 240.0]).edges;
            let (width, height) = (right - left, bottom - top);
            assert!(width >= 29.9 && height >= 29.9, "{width} × {height}");
        }
    }
}
