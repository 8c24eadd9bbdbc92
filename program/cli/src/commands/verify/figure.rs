//! Global errors against the step, one line a map, both axes logarithmic.

use std::fmt::Write as _;

use leafwise::verify::Row;

use super::html::escaped;

/// The edges of the frame: left, top, right, bottom.
const FRAME: [f64; 4] = [56.0, 16.0, 700.0, 344.0];

/// Errors below this are round-off.
const SMALLEST: f64 = 1e-16;

/// Declared orders with a colour of their own; what declares another has that of the next lower.
pub(super) const ORDERS: [(usize, &str); 6] = [
    (0, "#7a8794"),
    (2, "#1f6fb2"),
    (4, "#c8501e"),
    (6, "#1d8a5f"),
    (8, "#8e4ba8"),
    (10, "#a87a0a"),
];

/// The picture of one problem's rows, `None` where nothing was measured. Lines are coloured by the
/// declared order, so that lines of one colour run parallel; a line's title names its map.
pub(super) fn figure(rows: &[&Row]) -> Option<String> {
    let lines: Vec<(&Row, Vec<(f64, f64)>)> = rows
        .iter()
        .filter_map(|row| {
            let errors = row.measured.as_ref()?.errors.iter();
            let finite = errors.filter(|(_, error)| error.is_finite());
            let logarithms = finite.map(|(t, e)| (libm::log10(*t), libm::log10(e.max(SMALLEST))));
            Some((*row, logarithms.collect()))
        })
        .collect();
    let frame = Frame::around(lines.iter().flat_map(|(_, points)| points))?;
    let mut svg = String::from(
        "<svg role=\"img\" aria-label=\"Global errors against the step\" \
         viewBox=\"0 0 720 390\" width=\"720\" height=\"390\">",
    );
    frame.draw(&mut svg);
    for (row, points) in &lines {
        let points: Vec<String> = points
            .iter()
            .map(|point| frame.place(*point))
            .map(|(x, y)| format!("{x:.1},{y:.1}"))
            .collect();
        // Writing to a String cannot fail.
        let _ = write!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-opacity=\"0.7\">\
             <title>{}</title></polyline>",
            points.join(" "),
            color(row.declared_order),
            escaped(&row.map)
        );
    }
    svg.push_str("</svg>");
    Some(svg)
}

fn color(order: usize) -> &'static str {
    let known = ORDERS.iter().rev().find(|(known, _)| *known <= order);
    known.map_or(ORDERS[0].1, |(_, color)| color)
}

/// The ranges of log₁₀ t and log₁₀ error.
struct Frame {
    x: [f64; 2],
    y: [f64; 2],
}

impl Frame {
    fn around<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> Option<Self> {
        let floor = libm::log10(SMALLEST);
        let mut frame = Self {
            x: [f64::INFINITY, f64::NEG_INFINITY],
            y: [floor, floor],
        };
        for (x, y) in points {
            frame.x = [frame.x[0].min(*x), frame.x[1].max(*x)];
            frame.y[1] = frame.y[1].max(libm::ceil(*y));
        }
        (frame.x[0] < frame.x[1] && frame.y[0] < frame.y[1]).then_some(frame)
    }

    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let [left, top, right, bottom] = FRAME;
        let fraction = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        (
            left + fraction(x, self.x) * (right - left),
            bottom - fraction(y, self.y) * (bottom - top),
        )
    }

    /// Grid lines with their labels: every other decade of errors, steps that are powers of two.
    fn draw(&self, svg: &mut String) {
        let [left, top, right, bottom] = FRAME;
        for exponent in (self.y[0] as i32..=self.y[1] as i32).step_by(2) {
            let (_, y) = self.place((self.x[0], f64::from(exponent)));
            let _ = write!(
                svg,
                "<path d=\"M{left} {y:.1}H{right}\" class=\"grid\"/>\
                 <text x=\"{:.1}\" y=\"{y:.1}\" dx=\"-6\" dy=\"4\" text-anchor=\"end\">1e{exponent}</text>",
                left
            );
        }
        let octave = libm::log10(2.0);
        let (first, last) = (self.x[0] / octave, self.x[1] / octave);
        for exponent in libm::ceil(first) as i32..=libm::floor(last) as i32 {
            let (x, _) = self.place((f64::from(exponent) * octave, self.y[0]));
            let step = libm::exp2(f64::from(exponent));
            let _ = write!(
                svg,
                "<path d=\"M{x:.1} {top}V{bottom}\" class=\"grid\"/>\
                 <text x=\"{x:.1}\" y=\"{bottom}\" dy=\"18\" text-anchor=\"middle\">{step}</text>"
            );
        }
        let middle = (left + right) / 2.0;
        let _ = write!(
            svg,
            "<text x=\"{middle}\" y=\"{bottom}\" dy=\"38\" text-anchor=\"middle\">step t</text>"
        );
    }
}
