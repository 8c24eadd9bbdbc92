//! Maps of a field over a lattice of several axes: in colour, with arrows.

use plotters::style::RGBColor;

use super::axis::{Axis, Frame};
use super::canvas::{Anchor, Canvas, Ink, PAPER, WIDER};
use super::data::{FieldMaps, PlaneMap};
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, draw_row, draw_scale, farthest, level};
use super::letters::width_of;

/// The most maps side by side, of planes that are less than so many times as wide as high; wider ones stand one below the other.
const COLUMNS: [(f64, usize); 3] = [(0.5, 6), (1.6, 3), (6.5, 2)];

/// The height of a map, at most: of three or more in a row, and of fewer.
const HEIGHTS: [f64; 2] = [242.0, 342.0];

/// The width of the picture, at most, and the room around a row of maps: left, top and bottom.
const WIDTH: f64 = 960.0;
const AROUND: [f64; 3] = [62.0, 34.0, 44.0];

/// From one map to the next.
const BETWEEN: f64 = 40.0;

/// The size of titles, and the room behind one.
const TITLES: f64 = 13.0;
const BESIDE: f64 = 14.0;

/// The most cells of a map across and up: of planes as long as wide, and of the longer side of others.
const CELLS: usize = 64;
const CELLS_OF_LONG: usize = 200;

/// The most arrows across and up; more across wide maps, where they are no closer than those of a square.
const ARROWS: usize = 20;

/// The length of the longest arrow over the distance of two, and its width over its length.
const ARROW: (f64, f64) = (0.95, 0.36);

/// Arrows over darker colours are white, over lighter ones black; neither is the page's, which dark mode changes.
const ARROW_INKS: [Ink; 2] = [RGBColor(0xFF, 0xFF, 0xFF), RGBColor(0x05, 0x05, 0x05)];

/// Longer sides than so many times the other are drawn shorter, with cells that are no squares.
const LONGEST: f64 = 8.0;

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
        let rows = MapRows::of(&self.maps);
        let mut canvas = Canvas::new(rows.width(), rows.height());
        canvas.cell((0.0, 0.0), (canvas.width, canvas.height), PAPER);
        draw(&mut canvas, &rows, self);
        canvas
    }
}

/// The picture in words.
const DESCRIPTION: &str = "Maps of the field over two axes of the lattice";

/// Where maps stand: in rows, each in a slot that has room for it and its title.
#[derive(Clone, Copy, Debug)]
struct MapRows {
    /// How many maps there are.
    maps: usize,
    /// How many of them stand in a row.
    columns: usize,
    /// The width of a slot.
    slot: f64,
    /// The width and the height of a map, at most.
    most: [f64; 2],
}

impl MapRows {
    fn of(maps: &[PlaneMap]) -> Self {
        let ratio = maps.iter().map(ratio).fold(1.0 / LONGEST, f64::max);
        let title = |map: &PlaneMap| WIDER * width_of(&map.title, TITLES) + BESIDE;
        let title = maps.iter().map(title).fold(0.0, f64::max);
        let side_by_side = COLUMNS.iter().find(|(below, _)| ratio < *below);
        let columns = side_by_side.map_or(1, |(_, columns)| *columns);
        let room = |columns: usize| WIDTH - BAR - AROUND[0] - BETWEEN * (columns - 1) as f64;
        // As many as have room for their titles, and no row much shorter than another.
        let fitting = (1..=columns.min(maps.len()))
            .rev()
            .find(|columns| title * *columns as f64 <= room(*columns))
            .unwrap_or(1);
        let columns = maps
            .len()
            .div_ceil(maps.len().div_ceil(fitting).max(1))
            .max(1);
        let own = room(columns) / columns as f64;
        let is_many = columns >= 3 && ratio > COLUMNS[0].0;
        let height = HEIGHTS[usize::from(!is_many)].min(own / ratio);
        let most = [own.min(height * ratio), height];
        Self {
            maps: maps.len(),
            columns,
            slot: most[0].max(title.min(own)),
            most,
        }
    }

    /// The height of a row.
    fn row(&self) -> f64 {
        AROUND[1] + self.most[1] + AROUND[2]
    }

    /// The right edge of the last slot of a row.
    fn right(&self) -> f64 {
        let columns = self.columns as f64;
        AROUND[0] + columns * self.slot + (columns - 1.0) * BETWEEN
    }

    fn width(&self) -> f64 {
        (self.right() + BAR).ceil()
    }

    fn height(&self) -> f64 {
        (self.row() * self.maps.div_ceil(self.columns).max(1) as f64).ceil()
    }

    /// The frame of a map: a site is as wide as high, where one side is not much longer than the other.
    fn frame(&self, at: usize, map: &PlaneMap) -> Frame {
        let (row, column) = ((at / self.columns) as f64, (at % self.columns) as f64);
        let left = AROUND[0] + column * (self.slot + BETWEEN);
        let bottom = row * self.row() + AROUND[1] + self.most[1];
        let height = self.most[1].min(self.most[0] / ratio(map));
        let [x, y] = shape(map).map(|sites| Axis::Sites {
            count: sites.max(1),
        });
        Frame {
            edges: [left, bottom - height, left + height * ratio(map), bottom],
            x,
            y,
        }
    }
}

/// The width of a map over its height.
fn ratio(map: &PlaneMap) -> f64 {
    let [across, up] = shape(map).map(|sites| sites.max(1) as f64);
    (across / up).clamp(1.0 / LONGEST, LONGEST)
}

/// Maps side by side with one scale of colours.
pub(super) fn plane_figure(field: &FieldMaps, slice: Option<&str>) -> Result<Figure, ReportError> {
    let maps = &field.maps;
    let rows = MapRows::of(maps);
    let mut canvas = Canvas::new(rows.width(), rows.height());
    let broken = draw(&mut canvas, &rows, field);
    let mut notes: Vec<String> = slice.map(str::to_owned).into_iter().collect();
    if broken > 0 {
        notes.push(format!(
            "{broken} cells hold values that are not finite (red)."
        ));
    }
    let mut framed = maps.iter().enumerate();
    let are_some = framed.any(|(at, map)| strides(&rows.frame(at, map), map) != [1, 1]);
    let arrows = match maps.iter().any(|map| !map.arrows.is_empty()) {
        true if are_some => {
            " Arrows: the other two components, across and up, of some of the sites."
        }
        true => " Arrows: the other two components, across and up.",
        false => "",
    };
    Ok(Figure {
        title: format!("{} over the lattice", field.name),
        svg: canvas.finish_in_own_size(DESCRIPTION)?,
        legend: Vec::new(),
        colors: Vec::new(),
        caption: match maps.iter().any(|map| grid(map) != shape(map)) {
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
fn draw(canvas: &mut Canvas, rows: &MapRows, field: &FieldMaps) -> usize {
    let maps = &field.maps;
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
    let frames = maps.iter().enumerate();
    let frames: Vec<Frame> = frames.map(|(at, map)| rows.frame(at, map)).collect();
    // All lines of the frames lie beneath all cells.
    for (frame, map) in frames.iter().zip(maps) {
        let [across, up] = &map.axes;
        frame.draw(canvas, across, &map.title);
        let [left, top, ..] = frame.edges;
        canvas.label(up, (left - 20.0, top - 17.0), Anchor::Middle);
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
    let edges = [AROUND[0], AROUND[1], rows.right(), AROUND[1] + rows.most[1]];
    draw_scale(canvas, edges, color_axis, &field.color);
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
    let [left, top, right, bottom] = frame.edges;
    let sides = [
        (right - left) / across.max(1) as f64,
        (bottom - top) / up.max(1) as f64,
    ];
    let [every, along] = strides(frame, map);
    let apart = (sides[0] * every as f64).min(sides[1] * along as f64);
    let scale = ARROW.0 * apart / longest;
    for row in (along / 2..up).step_by(along) {
        for column in (every / 2..across).step_by(every) {
            let site = row * across + column;
            let [dx, dy] = map.arrows[site].map(|part| part * scale);
            let length = libm::hypot(dx, dy);
            if !length.is_finite() || length < 1.0 {
                continue;
            }
            let (x, y) = frame.point(column as f64, row as f64);
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

/// Sites from one arrow to the next, across and up.
fn strides(frame: &Frame, map: &PlaneMap) -> [usize; 2] {
    let [left, top, right, bottom] = frame.edges;
    let sides = [right - left, bottom - top];
    let apart = (sides[0].max(sides[1]) / ARROWS as f64).min(HEIGHTS[1] / ARROWS as f64);
    let sites = shape(map);
    [0, 1].map(|axis| {
        let strides = apart * sites[axis].max(1) as f64 / sides[axis];
        // Quotients are rounded.
        ((strides - 1e-9).ceil() as usize).max(1)
    })
}

/// The place on the scale of colours from which on these are light.
const LIGHT: f64 = 0.62;

/// The sites of a map across and up.
fn shape(map: &PlaneMap) -> [usize; 2] {
    let columns = map.columns.max(1);
    [columns, map.values.len() / columns]
}

/// The cells of a map across and up, at most as many together as those of a plane as long as wide.
fn grid(map: &PlaneMap) -> [usize; 2] {
    let [across, up] = shape(map);
    let most = |other: usize| (CELLS * CELLS / other.max(1)).clamp(CELLS, CELLS_OF_LONG);
    [across.min(most(up)), up.min(most(across))]
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
    let [columns, rows] = grid(map);
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

    fn field(maps: Vec<PlaneMap>) -> FieldMaps {
        FieldMaps {
            name: "q".to_owned(),
            color: "q".to_owned(),
            maps,
        }
    }

    /// An arrow a site of few, at most twenty across of many, each along its vector: its tip is farthest from its tail.
    #[test]
    fn vectors_are_arrows_along_them() {
        for (sites, drawn) in [(6, 36), (20, 400), (64, 256), (400, 400)] {
            let mut of = map(sites, sites);
            // Right and up, twice as far up.
            of.arrows = vec![[0.5, 1.0]; sites * sites];
            let svg = plane_figure(&field(vec![of]), None).expect("a picture").svg;
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

    /// A strip of sites has arrows in every row, whose length is at most that from one to the next.
    #[test]
    fn arrows_of_a_strip_keep_apart() {
        for (across, up) in [(100, 2), (2, 100), (40, 10)] {
            let of = map(across, up);
            let frame = MapRows::of(std::slice::from_ref(&of)).frame(0, &of);
            let [every, along] = strides(&frame, &of);
            let short = if across < up { every } else { along };
            assert_eq!(short, 1);
            let [left, top, right, bottom] = frame.edges;
            let apart = [
                (right - left) * every as f64 / across as f64,
                (bottom - top) * along as f64 / up as f64,
            ];
            assert!(
                apart
                    .iter()
                    .all(|apart| *apart >= HEIGHTS[1] / ARROWS as f64 - 1e-9),
                "{apart:?}"
            );
        }
    }

    /// Vectors that are 0, or not finite, have no arrow.
    #[test]
    fn no_arrow_is_drawn_of_nothing() {
        for arrow in [[0.0, 0.0], [f64::NAN, 1.0]] {
            let mut of = map(4, 4);
            of.arrows = vec![arrow; 16];
            let svg = plane_figure(&field(vec![of]), None).expect("a picture").svg;
            assert!(!svg.contains("<polygon") && !svg.contains("NaN"));
        }
    }

    /// A file stands on white, in both formats.
    #[test]
    fn maps_are_files() {
        let maps = field(vec![map(8, 8), map(8, 8)]);
        let svg = maps.svg().expect("a file");
        // Two maps as wide as high, their distance, and what stands to the left and to the right of them.
        let width = 62.0 + 2.0 * HEIGHTS[1] + BETWEEN + BAR;
        assert!(
            svg.contains(&format!("width=\"{width}\"")) && svg.contains("FEFEFE"),
            "{svg}"
        );
        assert!(maps.pdf().expect("a file").starts_with(b"%PDF-1.7"));
    }

    /// A peak of one site is seen however many sites there are, and a thin plane fills a frame that can be looked at.
    #[test]
    fn a_peak_of_one_site_is_drawn_on_planes_of_any_shape() {
        for (columns, rows) in [(8, 8), (512, 512), (5000, 2), (2, 5000), (1, 1), (65, 64)] {
            let figure = plane_figure(&field(vec![map(columns, rows)]), None).expect("a picture");
            // The brightest colour of the scale: its bar, and the peak where there is another value.
            let brightest = figure.svg.to_lowercase().matches("#fde725").count();
            let expected = if columns * rows > 1 { 2 } else { 1 };
            assert!(brightest >= expected, "{columns} × {rows}: {brightest}");
        }
    }

    /// Maps of planes of any shape lie within the picture, neither thin nor huge, beside each other and with room for their titles.
    #[test]
    fn maps_of_any_shape_have_a_place_of_their_own() {
        for (across, up) in [
            (8, 8),
            (100, 3),
            (3, 200),
            (40, 10),
            (12, 8),
            (5000, 1),
            (1, 5000),
            (1, 1),
        ] {
            for count in 0..=6 {
                let maps = vec![map(across, up); count];
                let rows = MapRows::of(&maps);
                let (width, height) = (rows.width(), rows.height());
                assert!(
                    width <= WIDTH && height <= 1200.0,
                    "{across} × {up}, {count}: {width} × {height}"
                );
                let frames: Vec<Frame> = (maps.iter().enumerate())
                    .map(|(at, map)| rows.frame(at, map))
                    .collect();
                let title = WIDER * width_of("q at t = 0", TITLES);
                for (at, frame) in frames.iter().enumerate() {
                    let [left, top, right, bottom] = frame.edges;
                    let (wide, high) = (right - left, bottom - top);
                    assert!(
                        wide >= 40.0 && high >= 40.0,
                        "{across} × {up}: {wide} × {high}"
                    );
                    assert!(top >= AROUND[1] - 1e-9 && bottom <= height - AROUND[2] + 1e-9);
                    assert!(left + title.max(wide) <= width - BAR + 1e-9);
                    let next = frames.get(at + 1).filter(|next| next.edges[3] == bottom);
                    if let Some(next) = next {
                        assert!(left + title.max(wide) < next.edges[0]);
                    }
                }
            }
        }
    }

    /// The label of a site stands in the middle of its cell, on both axes.
    #[test]
    fn labels_of_sites_stand_in_the_middle_of_their_cells() {
        let maps = [map(3, 2)];
        let frame = MapRows::of(&maps).frame(0, &maps[0]);
        let [left, top, right, bottom] = frame.edges;
        for (site, part) in [(0.0, 1.0 / 6.0), (1.0, 0.5), (2.0, 5.0 / 6.0)] {
            let (x, _) = frame.point(site, 0.0);
            assert!((x - left - part * (right - left)).abs() < 1e-9);
        }
        let (_, y) = frame.point(0.0, 1.0);
        assert!((y - top - 0.25 * (bottom - top)).abs() < 1e-9);
        let labels = |axis: &Axis| -> Vec<String> {
            let labels = axis.ticks(4).labels;
            labels.into_iter().map(|(_, text)| text).collect()
        };
        assert_eq!(labels(&frame.x), ["0", "1", "2"]);
        assert_eq!(labels(&frame.y), ["0", "1"]);
    }
}
