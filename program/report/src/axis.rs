//! Axes: where a value stands, and which values get a label.

use std::f64::consts::PI;

use super::canvas::{AXIS, Anchor, Canvas, GRID, TEXT};
use super::number::power_of_ten;

/// A linear or logarithmic axis over a finite, nonempty range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Axis {
    /// Equal differences, equal distances.
    Linear {
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// Equal ratios, equal distances; the ends are powers of ten.
    Logarithmic {
        /// The exponent of the lower end.
        low: i32,
        /// The exponent of the upper end.
        high: i32,
    },
    /// A turn, from −π to π.
    Turn,
    /// Cells side by side, each about its number: 0, 1, …, one less than the count.
    Sites {
        /// How many cells there are, at least one.
        count: usize,
    },
}

/// Labels of an axis and the power of ten they leave out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    /// Values with their labels.
    pub labels: Vec<(f64, String)>,
    /// Factor that all labels leave out, as "×10⁻⁹", or summand, as "19.05 +"; both, or empty where they leave out
    /// nothing.
    pub factor: String,
}

impl Axis {
    /// A linear axis over the finite values, with a margin when `padding` is positive.
    pub fn linear(values: impl IntoIterator<Item = f64>, padding: f64) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|value| value.is_finite()) {
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            return Self::Linear {
                low: 0.0,
                high: 1.0,
            };
        }
        let magnitude = low.abs().max(high.abs());
        let margin = match high - low {
            0.0 if magnitude == 0.0 => 1.0,
            span if span <= magnitude * 8.0 * f64::EPSILON => magnitude * 0.05,
            span if span.is_finite() => span * padding,
            _ => {
                return Self::Linear {
                    low: -f64::MAX / 4.0,
                    high: f64::MAX / 4.0,
                };
            }
        };
        Self::Linear {
            low: low - margin,
            high: high + margin,
        }
    }

    /// A logarithmic axis over the positive finite values, at least one decade long.
    pub fn logarithmic(values: impl IntoIterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values
            .into_iter()
            .filter(|value| value.is_finite() && *value > 0.0)
        {
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            return Self::Logarithmic {
                low: -17,
                high: -15,
            };
        }
        let low = libm::floor(libm::log10(low)) as i32;
        let high = libm::ceil(libm::log10(high)) as i32;
        Self::Logarithmic {
            low,
            high: high.max(low + 1),
        }
    }

    /// Where a value stands: 0 at the lower end, 1 at the upper; clamped to the axis.
    pub fn fraction(&self, value: f64) -> f64 {
        let fraction = match *self {
            Self::Linear { low, high } => (value - low) / (high - low),
            Self::Logarithmic { low, high } if value > 0.0 => {
                (libm::log10(value) - f64::from(low)) / f64::from(high - low)
            }
            Self::Logarithmic { .. } => 0.0,
            Self::Turn => (value + PI) / (2.0 * PI),
            Self::Sites { count } => (value + 0.5) / count.max(1) as f64,
        };
        if fraction.is_nan() {
            0.0
        } else {
            fraction.clamp(0.0, 1.0)
        }
    }

    /// About `count` labelled values.
    pub fn ticks(&self, count: usize) -> Ticks {
        match *self {
            Self::Logarithmic { low, high } => {
                let stride = ((high - low) as usize).div_ceil(count.max(1)).max(1);
                let exponents = (low..=high).step_by(stride);
                let label =
                    |exponent| (libm::pow(10.0, f64::from(exponent)), power_of_ten(exponent));
                Ticks {
                    labels: exponents.map(label).collect(),
                    factor: String::new(),
                }
            }
            Self::Linear { low, high } => linear_ticks(low, high, count),
            Self::Turn => {
                let names = ["−π", "−π/2", "0", "π/2", "π"];
                let labels = names.into_iter().zip(-2..=2);
                Ticks {
                    labels: labels
                        .map(|(name, quarter)| (f64::from(quarter) * PI / 2.0, name.to_owned()))
                        .collect(),
                    factor: String::new(),
                }
            }
            Self::Sites { count: 0 | 1 } => Ticks {
                labels: vec![(0.0, "0".to_owned())],
                factor: String::new(),
            },
            Self::Sites { count: sites } => {
                // At most one label a site, so that all are whole numbers.
                linear_ticks(0.0, (sites - 1) as f64, count.clamp(1, sites - 1))
            }
        }
    }
}

/// Steps in the largest value above which labels would have more than six digits.
const LONGEST: f64 = 2e5;

fn linear_ticks(low: f64, high: f64, count: usize) -> Ticks {
    let rough = (high - low) / count.max(1) as f64;
    let decade = libm::floor(libm::log10(rough));
    let unit = libm::pow(10.0, decade);
    let ends = |step: f64| {
        (
            libm::ceil(low / step - 1e-9),
            libm::floor(high / step + 1e-9),
        )
    };
    let steps = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0].map(|nice| nice * unit);
    let mut chosen = steps.len() - 1;
    if let Some(at) = (2..steps.len()).find(|at| steps[*at] >= rough * 0.999) {
        chosen = at;
    }
    // One label alone is no scale.
    while chosen > 0 && ends(steps[chosen]).1 - ends(steps[chosen]).0 < 1.0 {
        chosen -= 1;
    }
    let step = steps[chosen];
    let (first, last) = ends(step);
    let magnitude = low.abs().max(high.abs());
    if step.is_normal() && magnitude > LONGEST * step {
        return ticks_about(step, (low, high, count));
    }
    let exponent = libm::floor(libm::log10(magnitude)) as i32;
    let shift = if (-3..5).contains(&exponent) {
        0
    } else {
        exponent
    };
    let scale = libm::pow(10.0, f64::from(-shift));
    let decimals = (libm::floor(libm::log10(step * scale) + 1e-9) as i32)
        .min(0)
        .unsigned_abs();
    let labels = (0..=(last - first).clamp(0.0, 50.0) as usize)
        .map(|index| {
            let value = (first + index as f64) * step;
            let text = format!("{:.*}", decimals.min(15) as usize, value * scale);
            let is_zero = text.chars().all(|digit| matches!(digit, '-' | '0' | '.'));
            let text = if is_zero {
                "0".to_owned()
            } else {
                text.replace('-', "−")
            };
            (value, text)
        })
        .collect();
    let factor = if shift == 0 {
        String::new()
    } else {
        format!("×{}", power_of_ten(shift))
    };
    Ticks { labels, factor }
}

/// Labels of the differences from a round value within a range that is narrow beside it.
fn ticks_about(step: f64, (low, high, count): (f64, f64, usize)) -> Ticks {
    let nearest = |unit: f64| libm::round(0.5 * (low / unit + high / unit)) * unit;
    let rounder = nearest(10.0 * step);
    let middle = match (low..=high).contains(&rounder) {
        true => rounder,
        false => nearest(step),
    };
    let mut ticks = linear_ticks(low - middle, high - middle, count);
    for (value, _) in &mut ticks.labels {
        *value += middle;
    }
    let digits = |size: f64| libm::floor(libm::log10(size)) as i32;
    let decimals = |last: i32| last.clamp(0, 17) as usize;
    let text = match digits(middle.abs()) {
        -4..16 => format!("{middle:.*}", decimals(digits(step).saturating_neg())),
        exponent => format!("{middle:.*e}", decimals(exponent - digits(step))),
    };
    let summand = format!("{} +", text.replace('-', "−"));
    ticks.factor = match ticks.factor.as_str() {
        "" => summand,
        factor => format!("{summand} {factor}"),
    };
    ticks
}

/// A rectangle with two axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Left, top, right and bottom edge.
    pub edges: [f64; 4],
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
}

impl Frame {
    /// The standard frame of a picture of this size.
    pub fn new(width: f64, height: f64, x: Axis, y: Axis) -> Self {
        Self {
            edges: [62.0, 34.0, width - 18.0, height - 44.0],
            x,
            y,
        }
    }

    /// The point of the picture where (x, y) stands.
    pub fn point(&self, x: f64, y: f64) -> (f64, f64) {
        let [left, top, right, bottom] = self.edges;
        (
            left + self.x.fraction(x) * (right - left),
            bottom - self.y.fraction(y) * (bottom - top),
        )
    }

    /// The width of the frame in pixels, as a count of bins.
    pub fn columns(&self) -> usize {
        (self.edges[2] - self.edges[0]).max(1.0) as usize
    }

    /// Grid, frame, labels and the two titles; the vertical one stands above its axis.
    pub fn draw(&self, canvas: &mut Canvas, x_title: &str, y_title: &str) {
        let [left, top, right, bottom] = self.edges;
        // Numbers of sites are short.
        let label = match self.x {
            Axis::Sites { count } if count < 1000 => 48.0,
            _ => 90.0,
        };
        let horizontal = self.x.ticks(((right - left) / label) as usize);
        let vertical = self.y.ticks(((bottom - top) / 42.0) as usize);
        for (value, label) in &horizontal.labels {
            let (x, _) = self.point(*value, 0.0);
            canvas.path(&[(x, top), (x, bottom)], GRID, 1.0);
            canvas.label_within(label, (x, bottom + 15.0), Anchor::Middle);
        }
        for (value, label) in &vertical.labels {
            let (_, y) = self.point(0.0, *value);
            canvas.path(&[(left, y), (right, y)], GRID, 1.0);
            canvas.label_within(label, (left - 8.0, y), Anchor::End);
        }
        canvas.path(&[(left, top), (left, bottom), (right, bottom)], AXIS, 1.0);
        let titled = |title: &str, factor: &str| match factor {
            "" => title.to_owned(),
            _ => format!("{title}  ({factor})"),
        };
        let x_title = titled(x_title, &horizontal.factor);
        let y_title = titled(y_title, &vertical.factor);
        canvas.label(
            &x_title,
            ((left + right) / 2.0, bottom + 34.0),
            Anchor::Middle,
        );
        canvas.label_in(&y_title, (left, top - 17.0), Anchor::Start, TEXT, 13.0);
    }
}

#[cfg(test)]
mod tests {
    use super::super::canvas::{Piece, SCALE};
    use super::*;

    fn texts(axis: Axis, count: usize) -> Vec<String> {
        axis.ticks(count)
            .labels
            .into_iter()
            .map(|(_, text)| text)
            .collect()
    }

    #[test]
    fn an_axis_has_more_than_one_label() {
        for half in [0.31, 1.9, 2.4, 3.9, 4.9, 9.7] {
            let labels = texts(Axis::linear([-half, half], 0.0), 3);
            assert!(labels.len() >= 2, "{half}: {labels:?}");
        }
    }

    #[test]
    fn linear_labels_are_round_numbers() {
        assert_eq!(
            texts(Axis::linear([0.0, 100.0], 0.0), 5),
            ["0", "20", "40", "60", "80", "100"]
        );
        assert_eq!(
            texts(Axis::linear([-0.1, 0.1], 0.0), 4),
            ["−0.10", "−0.05", "0", "0.05", "0.10"]
        );
    }

    #[test]
    fn small_numbers_share_one_factor() {
        let ticks = Axis::linear([0.0, 4e-9], 0.0).ticks(4);
        assert_eq!(ticks.factor, "×10⁻⁹");
        assert_eq!(ticks.labels[1].1, "1");
    }

    /// Labels of cells are whole numbers, two at least where there are two cells, each in the middle of its cell.
    #[test]
    fn sites_are_labelled_in_the_middle_of_their_cells() {
        for count in [1, 2, 3, 4, 5, 8, 30, 64, 200, 5000] {
            let axis = Axis::Sites { count };
            for most in [0, 1, 2, 3, 5, 9] {
                let labels = axis.ticks(most).labels;
                assert!(labels.len() >= count.min(2), "{count}: {labels:?}");
                for (site, text) in labels {
                    assert_eq!(text, format!("{site}"));
                    assert!(site >= 0.0 && site < count as f64 && site.fract() == 0.0);
                    let [low, high] = [site, site + 1.0].map(|edge| edge / count as f64);
                    // Sums and quotients of few numbers below 1.
                    let middle = f64::midpoint(low, high);
                    assert!((axis.fraction(site) - middle).abs() < 4.0 * f64::EPSILON);
                }
            }
        }
    }

    #[test]
    fn narrow_ranges_are_labelled_from_a_value_within() {
        let ticks = Axis::linear([18.999_999_75, 19.000_000_25], 0.0).ticks(4);
        assert_eq!(ticks.factor, "19.0000000 + ×10⁻⁷");
        let texts: Vec<&str> = ticks.labels.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(texts, ["−2", "0", "2"]);
        let far = Axis::linear([1e20, 1e20 + 1e9], 0.0).ticks(4);
        assert!(far.factor.starts_with("1.00000000"), "{}", far.factor);
    }

    #[test]
    fn logarithmic_labels_skip_decades_when_there_are_many() {
        assert_eq!(texts(Axis::logarithmic([1e-16, 1e-4]), 6).len(), 7);
        assert_eq!(texts(Axis::logarithmic([2e-3, 3e-3]), 6), ["10⁻³", "10⁻²"]);
    }

    /// The label of the last tick lies within the picture, however many digits it has.
    #[test]
    fn labels_end_with_the_picture() {
        for last in [20.0, 20_000.0, 200_000.0, 1_999_999.0] {
            let axis = Axis::linear([0.0, last], 0.0);
            let mut canvas = Canvas::new(480.0, 300.0);
            Frame::new(480.0, 300.0, axis, axis).draw(&mut canvas, "t", "x");
            for piece in &canvas.pieces {
                let Piece::Label {
                    text, at, anchor, ..
                } = piece
                else {
                    continue;
                };
                // Digits of sans-serif fonts are at most 0.64 of their size wide (DejaVu Sans).
                let width = 0.64 * 12.5 * text.chars().count() as f64;
                let at = f64::from(at.0) / SCALE;
                let [from, to] = match anchor {
                    Anchor::Start => [at, at + width],
                    Anchor::Middle => [at - width / 2.0, at + width / 2.0],
                    Anchor::End => [at - width, at],
                };
                assert!(from >= -0.5 && to <= 480.5, "{text}: {from} to {to}");
            }
        }
    }

    #[test]
    fn degenerate_ranges_still_give_an_axis() {
        for values in [
            vec![],
            vec![f64::NAN],
            vec![3.0; 4],
            vec![-f64::MAX, f64::MAX],
            vec![0.0],
        ] {
            let axis = Axis::linear(values.clone(), 0.05);
            assert!(!axis.ticks(4).labels.is_empty(), "{values:?}");
            assert!((0.0..=1.0).contains(&axis.fraction(3.0)), "{values:?}");
        }
    }
}
