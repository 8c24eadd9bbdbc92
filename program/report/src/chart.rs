//! A figure for a paper: curves of several runs in one frame, with labels of one's own, as SVG or PDF.

use std::f64::consts::PI;

use super::axis::{Axis, Frame};
use super::canvas::{Anchor, Canvas, PAPER, SERIES};
use super::error::ReportError;
use super::letters::width_of;
use super::panel::{PanelSeries, Stroke};

/// How values stand along an axis of a chart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChartScale {
    /// Equal differences, equal distances.
    #[default]
    Linear,
    /// Equal ratios, equal distances; values that are not positive are left out.
    Logarithmic,
    /// Angles modulo 2π, from −π to π.
    Turn,
}

/// An axis of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartAxis {
    /// The quantity that it shows, and its unit.
    pub title: String,
    /// How values stand along it.
    pub scale: ChartScale,
}

/// A figure with a legend.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// The horizontal axis.
    pub x: ChartAxis,
    /// The vertical axis.
    pub y: ChartAxis,
    /// The curves; guides among them are not drawn.
    pub series: Vec<PanelSeries>,
    /// Whether a unit is as long along both axes.
    pub is_equal: bool,
}

/// The frame's width, and its height where nothing asks for another, in logical pixels.
const FRAME: (f64, f64) = (400.0, 260.0);

/// Room around the frame: left, top, right and bottom.
const AROUND: [f64; 4] = [62.0, 34.0, 18.0, 44.0];

/// The height over the width of a frame of equal units, at least and at most; beyond that one axis is longer than its values.
const FLATTEST: f64 = 0.3;
const TALLEST: f64 = 1.25;

/// A line of the legend, the length of its mark, the space behind an entry, and the size of its letters.
const LINE: f64 = 19.0;
const MARK: f64 = 22.0;
const BEHIND: f64 = 18.0;
const LETTERS: f64 = 12.5;

impl ChartAxis {
    /// Whether a value has a place on it.
    pub fn shows(&self, value: f64) -> bool {
        self.shown(value).is_some()
    }

    /// The value as it is shown; `None` where it has no place.
    fn shown(&self, value: f64) -> Option<f64> {
        let is_shown = value.is_finite() && (self.scale != ChartScale::Logarithmic || value > 0.0);
        let shown = match self.scale {
            ChartScale::Turn => value - 2.0 * PI * libm::floor((value + PI) / (2.0 * PI)),
            _ => value,
        };
        is_shown.then_some(shown)
    }

    fn over(&self, values: impl Iterator<Item = f64>, padding: f64) -> Axis {
        match self.scale {
            ChartScale::Linear => Axis::linear(values, padding),
            ChartScale::Logarithmic => Axis::logarithmic(values),
            ChartScale::Turn => Axis::Turn,
        }
    }
}

impl Chart {
    /// The figure as an SVG file, on white.
    ///
    /// # Errors
    /// [`ReportError`] if the drawing library refuses it.
    pub fn svg(&self) -> Result<String, ReportError> {
        self.drawn().finish_alone(&self.description())
    }

    /// The figure as a PDF file of one page, with text in Helvetica.
    ///
    /// # Errors
    /// [`ReportError::Letter`] for a label with a letter that the fonts of PDF do not have.
    pub fn pdf(&self) -> Result<Vec<u8>, ReportError> {
        self.drawn().finish_pdf(&self.description())
    }

    fn description(&self) -> String {
        format!("{} over {}", self.y.title, self.x.title)
    }

    /// Stretches of a series between values without a place, and between turns.
    fn stretches(&self, series: &PanelSeries) -> Vec<Vec<(f64, f64)>> {
        let mut stretches = vec![Vec::new()];
        let mut last: Option<(f64, f64)> = None;
        let jumps = |axis: &ChartAxis, from: f64, to: f64| {
            axis.scale == ChartScale::Turn && (to - from).abs() > PI
        };
        for (x, y) in &series.points {
            let point = self.x.shown(*x).zip(self.y.shown(*y));
            let is_apart = match (last, point) {
                (Some(last), Some(point)) => {
                    jumps(&self.x, last.0, point.0) || jumps(&self.y, last.1, point.1)
                }
                _ => true,
            };
            if is_apart {
                stretches.push(Vec::new());
            }
            if let (Some(point), Some(stretch)) = (point, stretches.last_mut()) {
                stretch.push(point);
            }
            last = point;
        }
        stretches.retain(|stretch| !stretch.is_empty());
        stretches
    }

    fn drawn(&self) -> Canvas {
        let series = self
            .series
            .iter()
            .filter(|series| series.stroke != Stroke::Guide);
        let curves: Vec<_> = series
            .map(|series| (series, self.stretches(series)))
            .collect();
        let all = || {
            curves
                .iter()
                .flat_map(|(_, stretches)| stretches.iter().flatten())
        };
        let mut x = self.x.over(
            all().map(|point| point.0),
            if self.is_equal { 0.04 } else { 0.0 },
        );
        let mut y = self.y.over(all().map(|point| point.1), 0.06);
        let mut height = FRAME.1;
        if self.is_equal {
            height = FRAME.0 * equal(&mut x, &mut y);
        }
        let names: Vec<&str> = match curves.len() {
            1 => Vec::new(),
            _ => curves
                .iter()
                .map(|(series, _)| series.name.as_str())
                .collect(),
        };
        let width = AROUND[0] + FRAME.0 + AROUND[2];
        let (places, lines) = legend(&names, FRAME.0);
        let body = AROUND[1] + height + AROUND[3];
        let whole = body + LINE * lines as f64 + if lines > 0 { 6.0 } else { 0.0 };
        let frame = Frame::new(width, body, x, y);
        let mut canvas = Canvas::new(width, whole);
        canvas.cell((0.0, 0.0), (width, whole), PAPER);
        frame.draw(&mut canvas, &self.x.title, &self.y.title);
        for (at, (series, stretches)) in curves.iter().enumerate() {
            let ink = SERIES[at % SERIES.len()];
            for stretch in stretches {
                let points: Vec<_> = stretch.iter().map(|&(x, y)| frame.point(x, y)).collect();
                match series.stroke {
                    Stroke::Points => points.iter().for_each(|&at| canvas.disc(at, 1.3, ink)),
                    _ => canvas.path(&points, ink, 1.4),
                }
            }
        }
        for (at, (name, (left, line))) in names.iter().zip(places).enumerate() {
            let ink = SERIES[at % SERIES.len()];
            let (x, y) = (AROUND[0] + left, body + 6.0 + LINE * line as f64);
            match curves[at].0.stroke {
                Stroke::Points => canvas.disc((x + MARK / 2.0, y), 2.6, ink),
                _ => canvas.path(&[(x, y), (x + MARK, y)], ink, 2.0),
            }
            canvas.label(name, (x + MARK + 6.0, y), Anchor::Start);
        }
        canvas
    }
}

/// Lengthens linear axes until a unit is as long along both in a frame: its height over its width.
pub(super) fn equal(x: &mut Axis, y: &mut Axis) -> f64 {
    let span = |axis: &Axis| match *axis {
        Axis::Linear { low, high } => Some((low, high)),
        Axis::Turn => Some((-PI, PI)),
        Axis::Logarithmic { .. } | Axis::Sites { .. } => None,
    };
    let (Some((left, right)), Some((low, high))) = (span(x), span(y)) else {
        return FRAME.1 / FRAME.0;
    };
    let ratio = (high - low) / (right - left);
    let lengthen = |axis: &mut Axis, (low, high): (f64, f64), length: f64| {
        let middle = f64::midpoint(low, high);
        *axis = Axis::Linear {
            low: middle - length / 2.0,
            high: middle + length / 2.0,
        };
    };
    if ratio < FLATTEST {
        lengthen(y, (low, high), FLATTEST * (right - left));
    } else if ratio > TALLEST {
        lengthen(x, (left, right), (high - low) / TALLEST);
    }
    ratio.clamp(FLATTEST, TALLEST)
}

/// Where the entries of a legend stand, from the left in which line, and how many lines there are.
fn legend(names: &[&str], width: f64) -> (Vec<(f64, usize)>, usize) {
    let (mut places, mut left, mut line) = (Vec::new(), 0.0, 0);
    for name in names {
        let own = MARK + 6.0 + width_of(name, LETTERS);
        if left > 0.0 && left + own > width {
            (left, line) = (0.0, line + 1);
        }
        places.push((left, line));
        left += own + BEHIND;
    }
    let lines = if names.is_empty() { 0 } else { line + 1 };
    (places, lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(name: &str, points: Vec<(f64, f64)>) -> PanelSeries {
        PanelSeries {
            name: name.to_owned(),
            points,
            stroke: Stroke::Line,
        }
    }

    fn axis(title: &str, scale: ChartScale) -> ChartAxis {
        ChartAxis {
            title: title.to_owned(),
            scale,
        }
    }

    /// A turning angle is cut where it wraps: each stretch rises, and none crosses the frame.
    #[test]
    fn angles_are_shown_modulo_a_turn() {
        let points = (0..400)
            .map(|k| (0.05 * f64::from(k), 0.3 * f64::from(k)))
            .collect();
        let chart = Chart {
            x: axis("t (s)", ChartScale::Linear),
            y: axis("θ", ChartScale::Turn),
            series: vec![series("one", points)],
            is_equal: false,
        };
        let stretches = chart.stretches(&chart.series[0]);
        // 119.7 rad are 19 turns and a bit, the first cut at π.
        assert_eq!(stretches.len(), 20);
        for stretch in &stretches {
            assert!(stretch.iter().all(|(_, y)| (-PI..PI).contains(y)));
            assert!(stretch.is_sorted_by(|a, b| a.1 < b.1));
        }
        let svg = chart.svg().expect("a picture");
        assert!(svg.contains("−π/2") && svg.contains("t (s)"), "{svg}");
    }

    /// A unit is as long along both axes, of round, flat and tall curves.
    #[test]
    fn equal_units_are_equal() {
        for (a, b) in [(1.0, 1.0), (3.0, 0.2), (0.1, 8.0)] {
            let circle = (0..100).map(|k| {
                let (s, c) = libm::sincos(0.0634 * f64::from(k));
                (a * c, b * s)
            });
            let values: Vec<(f64, f64)> = circle.collect();
            let mut x = Axis::linear(values.iter().map(|p| p.0), 0.04);
            let mut y = Axis::linear(values.iter().map(|p| p.1), 0.06);
            let ratio = equal(&mut x, &mut y);
            let (
                Axis::Linear {
                    low: left,
                    high: right,
                },
                Axis::Linear { low, high },
            ) = (x, y)
            else {
                panic!("linear axes");
            };
            assert!(((high - low) / (right - left) - ratio).abs() < 1e-12);
            assert!((FLATTEST..=TALLEST).contains(&ratio));
            assert!(left < -a && right > a * 0.99 && low < -b * 0.99 && high > b * 0.99);
        }
    }

    /// A PDF is one page with two fonts, its cross-references where they say; letters of no font are told.
    #[test]
    fn a_chart_is_a_pdf() {
        let mut chart = Chart {
            x: axis("ψ/ψ₀ (10⁻³ Wb)", ChartScale::Linear),
            y: axis("|ΔH|", ChartScale::Logarithmic),
            series: vec![
                series("h = 0.1", vec![(0.0, 1e-3), (1.0, 1e-5), (2.0, f64::NAN)]),
                series("h = 0.05", vec![(0.0, 1e-4), (2.0, 1e-6)]),
            ],
            is_equal: false,
        };
        let pdf = chart.pdf().expect("a file");
        assert!(pdf.starts_with(b"%PDF-1.7") && pdf.ends_with(b"%%EOF"));
        let text = String::from_utf8_lossy(&pdf);
        let table = text
            .rfind("startxref")
            .map(|at| text[at..].lines().nth(1).map(str::to_owned));
        let place: usize = table
            .flatten()
            .and_then(|line| line.parse().ok())
            .expect("a number");
        assert!(pdf[place..].starts_with(b"xref"));
        for part in ["/Helvetica", "/Symbol", "/MediaBox"] {
            assert!(text.contains(part), "{part}");
        }
        assert_eq!(chart.pdf().expect("a file"), pdf);
        chart.x.title = "漢".to_owned();
        let error = chart.pdf().expect_err("no letter").to_string();
        assert!(error.contains('漢') && error.contains("SVG"), "{error}");
    }
}
