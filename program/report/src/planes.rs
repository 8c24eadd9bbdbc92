//! Maps of a field over a lattice of several axes: in colour, with arrows.

use plotters::style::RGBColor;

use super::axis::{Axis, Frame};
use super::canvas::{Canvas, Ink, PAPER};
use super::data::PlaneMap;
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, draw_row, draw_scale, farthest, level};

/// The most maps of a row, and the height of a row of these and of fewer.
const ROW: usize = 3;
const HEIGHTS: [f64; 2] = [320.0, 420.0];

/// The width of the picture.
const WIDTH: f64 = 960.0;

/// From one map to the next.
const BETWEEN: f64 = 40.0;

/// The most cells of a map across and up.
const CELLS: usize = 64;

/// The most arrows across and up.
const ARROWS: usize = 20;

/// The length of the longest arrow over the distance of two, and its width over its length.
const ARROW: (f64, f64) = (0.95, 0.36);

/// Arrows over darker colours are white, over lighter ones black; neither is the page's, which dark mode changes.
const ARROW_INKS: [Ink; 2] = [RGBColor(0xFF, 0xFF, 0xFF), RGBColor(0x05, 0x05, 0x05)];

/// Longer sides than so many times the other are drawn shorter, with cells that are no squares.
const LONGEST: f64 = 8.0;

/// Maps of a field over two axes of a lattice at some times, as a file.
#[derive(Clone, Debug)]
pub struct FieldMaps {
    /// The maps, in the order in which they are drawn.
    pub maps: Vec<PlaneMap>,
    /// The quantity in colour, as "s.z".
    pub color: String,
}

impl FieldMaps {
    /// The figure as an SVG file, on white.
    ///
    /// # Errors
    /// [`ReportError`] if the drawing library refuses it.
    pub fn svg(&self) -> Result<String, ReportError> {
        let svg = self.drawn().finish_alone(DESCRIPTION)?;
        // Cells side by side have no seams.
        Ok(svg.replace("<rect ", "<rect shape-rendering=\"crispEdges\" "))
    }

    /// The figure as a PDF file of one page, with text in Helvetica.
    ///
    /// # Errors
    /// [`ReportError::Letter`] for a label with a letter that the fonts of PDF do not have.
    pub fn pdf(&self) -> Result<Vec<u8>, ReportError> {
        self.drawn().finish_pdf(DESCRIPTION)
    }

    fn drawn(&self) -> Canvas {
        let [width, height] = size(self.maps.len());
        let mut canvas = Canvas::new(width, height);
        canvas.cell((0.0, 0.0), (width, height), PAPER);
        draw(&mut canvas, &self.maps, &self.color);
        canvas
    }
}

/// The picture in words.
const DESCRIPTION: &str = "Maps of the field over two axes of the lattice";

/// How many maps a row has, and how high it is.
fn row(maps: usize) -> (usize, f64) {
    let columns = maps.clamp(1, ROW);
    (columns, HEIGHTS[usize::from(columns < ROW)])
}

/// The width and the height of a picture of so many maps.
fn size(maps: usize) -> [f64; 2] {
    let (columns, height) = row(maps);
    [WIDTH, height * maps.div_ceil(columns).max(1) as f64]
}

/// Maps side by side, three a row, with one scale of colours.
pub(super) fn plane_figure(
    maps: &[PlaneMap],
    color: &str,
    slice: Option<&str>,
) -> Result<Figure, ReportError> {
    let [width, height] = size(maps.len());
    let mut canvas = Canvas::new(width, height);
    let broken = draw(&mut canvas, maps, color);
    let mut notes: Vec<String> = slice.map(str::to_owned).into_iter().collect();
    if broken > 0 {
        notes.push(format!(
            "{broken} cells hold values that are not finite (red)."
        ));
    }
    let is_above = |most: usize| {
        let mut shapes = maps.iter().flat_map(shape);
        shapes.any(|sites| sites > most)
    };
    let arrows = match maps.iter().any(|map| !map.arrows.is_empty()) {
        true if is_above(ARROWS) => {
            " Arrows: the other two components, across and up, of some of the sites."
        }
        true => " Arrows: the other two components, across and up.",
        false => "",
    };
    Ok(Figure {
        title: "The field over the lattice".to_owned(),
        svg: canvas.finish(DESCRIPTION)?,
        legend: Vec::new(),
        caption: match is_above(CELLS) {
            true => format!(
                "Each cell shows, among the sites that it covers, the value farthest from the mean; all maps share the scale of \
                 colours.{arrows}"
            ),
            false => format!("Each cell is a site; all maps share the scale of colours.{arrows}"),
        },
        notes,
    })
}

/// Draws maps with one scale of colours; returns how many cells have no finite value.
fn draw(canvas: &mut Canvas, maps: &[PlaneMap], color: &str) -> usize {
    let (columns, height) = row(maps.len());
    let lengths = maps.iter().flat_map(vector_lengths);
    let most = lengths
        .filter(|length| length.is_finite())
        .fold(0.0, f64::max);
    // The third component of vectors is between minus and plus their length.
    let values = maps.iter().flat_map(|map| &map.values).copied();
    let color_axis = match most > 0.0 {
        true => Axis::linear([-most, most], 0.0),
        false => Axis::linear(values, 0.0),
    };
    let each = (WIDTH - BAR - 62.0 - BETWEEN * (columns - 1) as f64) / columns as f64;
    let frame = |at: usize, map: &PlaneMap| {
        let (row, column) = ((at / columns) as f64, (at % columns) as f64);
        let left = 62.0 + column * (each + BETWEEN);
        let top = 34.0 + row * height;
        frame_of(map, [left, top, left + each, (row + 1.0) * height - 44.0])
    };
    let frames: Vec<Frame> = maps
        .iter()
        .enumerate()
        .map(|(at, map)| frame(at, map))
        .collect();
    // All lines of the frames lie beneath all cells.
    for (frame, map) in frames.iter().zip(maps) {
        let [across, up] = &map.axes;
        frame.draw(canvas, across, &format!("{} over {up}", map.title));
    }
    let finite = maps
        .iter()
        .flat_map(|map| &map.values)
        .filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    let mut broken = 0;
    for (frame, map) in frames.iter().zip(maps) {
        broken += cells(canvas, frame, map, (color_axis, mean));
    }
    let lengths = maps.iter().flat_map(|map| &map.arrows);
    let longest = lengths
        .map(|[x, y]| libm::hypot(*x, *y))
        .filter(|length| length.is_finite())
        .fold(0.0, f64::max);
    for (frame, map) in frames.iter().zip(maps) {
        if longest > 0.0 && map.arrows.len() == map.values.len() {
            arrows(canvas, frame, map, (color_axis, longest));
        }
    }
    let right = frames
        .iter()
        .map(|frame| frame.edges[2])
        .fold(0.0, f64::max);
    let edges = [62.0, 34.0, right, height - 44.0];
    draw_scale(canvas, edges, color_axis, color);
    broken
}

/// The lengths of the vectors of a map: those in colour and the two of arrows are their components.
fn vector_lengths(map: &PlaneMap) -> impl Iterator<Item = f64> + '_ {
    let vectors = map.arrows.iter().zip(&map.values);
    vectors.map(|([x, y], z)| libm::hypot(libm::hypot(*x, *y), *z))
}

/// Draws the vectors of some sites as arrows about these, in an ink that stands out from the colour beneath.
fn arrows(canvas: &mut Canvas, frame: &Frame, map: &PlaneMap, (color_axis, longest): (Axis, f64)) {
    let [across, up] = shape(map);
    let every = across.max(up).div_ceil(ARROWS).max(1);
    let [left, top, right, bottom] = frame.edges;
    let side = (right - left) / across.max(1) as f64;
    let of = ((bottom - top) / up.max(1) as f64).min(side) * every as f64;
    let scale = ARROW.0 * of / longest;
    let middle = every / 2;
    for row in (middle..up).step_by(every) {
        for column in (middle..across).step_by(every) {
            let site = row * across + column;
            let [dx, dy] = map.arrows[site].map(|part| part * scale);
            let length = libm::hypot(dx, dy);
            if !length.is_finite() || length < 1.0 {
                continue;
            }
            let (x, y) = frame.point(column as f64 + 0.5, row as f64 + 0.5);
            // The picture's second axis points down.
            let at = |along: f64, beside: f64| {
                (x + along * dx + beside * dy, y - along * dy + beside * dx)
            };
            let shape = [
                at(0.5, 0.0),
                at(-0.5, 0.5 * ARROW.1),
                at(-0.28, 0.0),
                at(-0.5, -0.5 * ARROW.1),
            ];
            let value = map.values[site];
            let is_light = value.is_finite() && color_axis.fraction(value) > LIGHT;
            canvas.area(&shape, ARROW_INKS[usize::from(is_light)]);
        }
    }
}

/// The place on the scale of colours from which on these are light.
const LIGHT: f64 = 0.62;

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
            arrows: Vec::new(),
        }
    }

    /// An arrow a site of few, at most twenty across of many, each along its vector: its tip is farthest from its tail.
    #[test]
    fn vectors_are_arrows_along_them() {
        for (sites, drawn) in [(6, 36), (20, 400), (64, 256), (400, 400)] {
            let mut of = map(sites, sites);
            // Right and up, twice as far up.
            of.arrows = vec![[0.5, 1.0]; sites * sites];
            let svg = plane_figure(&[of], "s.z", None).expect("a picture").svg;
            let arrows: Vec<Vec<f64>> = svg
                .split("<polygon")
                .skip(1)
                .filter_map(|rest| rest.split("points=\"").nth(1)?.split('"').next())
                .map(|points| {
                    let numbers = points.split([' ', ',']);
                    numbers.filter_map(|number| number.parse().ok()).collect()
                })
                .collect();
            assert_eq!(arrows.len(), drawn, "{sites}");
            for arrow in arrows {
                let (dx, dy) = (arrow[0] - arrow[4], arrow[1] - arrow[5]);
                // Down is positive in SVG; corners are rounded to whole units.
                assert!(dx > 0.0 && dy < 0.0);
                assert!((dy + 2.0 * dx).abs() <= 3.0, "{dx} {dy}");
            }
        }
    }

    /// Vectors that are 0, or not finite, have no arrow.
    #[test]
    fn no_arrow_is_drawn_of_nothing() {
        for arrow in [[0.0, 0.0], [f64::NAN, 1.0]] {
            let mut of = map(4, 4);
            of.arrows = vec![arrow; 16];
            let svg = plane_figure(&[of], "s.z", None).expect("a picture").svg;
            assert!(!svg.contains("<polygon") && !svg.contains("NaN"));
        }
    }

    /// A file stands on white, in both formats.
    #[test]
    fn maps_are_files() {
        let maps = FieldMaps {
            maps: vec![map(8, 8), map(8, 8)],
            color: "q".to_owned(),
        };
        let svg = maps.svg().expect("a file");
        assert!(svg.contains("width=\"960\"") && svg.contains("FEFEFE"));
        assert!(maps.pdf().expect("a file").starts_with(b"%PDF-1.7"));
    }

    /// A peak of one site is seen however many sites there are, and a thin plane fills a frame that can be looked at.
    #[test]
    fn a_peak_of_one_site_is_drawn_on_planes_of_any_shape() {
        for (columns, rows) in [(8, 8), (512, 512), (5000, 2), (2, 5000), (1, 1), (65, 64)] {
            let figure = plane_figure(&[map(columns, rows)], "q", None).expect("a picture");
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
