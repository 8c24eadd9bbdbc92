//! Functions that Ŝ is a sum of: products of functions of one variable.

use std::f64::consts::TAU;

use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Expression, Rational};

use crate::error::LearnError;

/// The degree of the pieces of a spline.
const PIECE: i32 = 5;

/// The most functions of a basis.
const MOST_FUNCTIONS: usize = 2000;

/// Functions of one variable x. The k-th ones have the degree k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FunctionFamily {
    /// xᵏ.
    Polynomial,
    /// uᵏ with u from −1 to 1 over the range of the data.
    Centred,
    /// u, …, u⁵, and (u − t)⁵ right of each of k − 5 knots t at equal distances: splines that are four times continuously differentiable.
    Spline,
    /// e^{kx} and e^{−kx}.
    Exponential,
    /// cos(2πkx/period) and sin(2πkx/period).
    Fourier {
        /// The period, positive.
        period: f64,
    },
}

/// Basis of one variable: its family, and whether ln x stands beside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasisAxis {
    /// Functions that products are made of.
    pub family: FunctionFamily,
    /// Whether ln x is a function too, in no product.
    pub has_logarithm: bool,
}

/// Which products of functions of one variable a basis has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BasisDegree {
    /// Those whose degrees sum to at most this one.
    Total(usize),
    /// Those whose degree in each variable is at most its own.
    Each(Vec<usize>),
}

impl BasisDegree {
    /// The largest sum of the degrees of a product.
    pub fn total(&self) -> usize {
        match self {
            Self::Total(degree) => *degree,
            Self::Each(degrees) => degrees.iter().sum(),
        }
    }

    /// The largest degree in a variable.
    pub fn of_variable(&self, i: usize) -> usize {
        match self {
            Self::Total(degree) => *degree,
            Self::Each(degrees) => degrees.get(i).copied().unwrap_or(0),
        }
    }
}

/// A function of one variable.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Member {
    Power(i32),
    Centred(i32),
    /// The number of a knot, from 0.
    Knot(i32),
    Exponential(i32),
    Cosine(i32),
    Sine(i32),
    Logarithm,
}

/// The members of one variable, and what their arguments are scaled by.
#[derive(Clone, Debug)]
struct AxisMembers {
    members: Vec<Member>,
    /// A power of 2 near the largest |x|.
    scale: f64,
    /// 2π/period.
    frequency: f64,
    /// u = rate (x − middle).
    rate: f64,
    middle: f64,
    /// u of the knots.
    knots: Vec<f64>,
}

/// A basis f_1, …, f_n on ℝᵈ: all products of these degrees but for 1, and logarithms.
#[derive(Clone, Debug)]
pub struct Basis {
    axes: Vec<AxisMembers>,
    /// The factors of every function: a variable and one of its members.
    functions: Vec<Vec<(usize, usize)>>,
}

impl Basis {
    /// The basis of a degree for states in these ranges, a pair (least, largest) for each variable.
    ///
    /// # Errors
    /// [`LearnError::TooManyFunctions`], and [`LearnError::Period`] for a period that is no positive number.
    pub fn new(
        axes: &[BasisAxis],
        ranges: &[(f64, f64)],
        degree: &BasisDegree,
    ) -> Result<Self, LearnError> {
        let mut own = Vec::with_capacity(axes.len());
        for (i, (axis, &(least, largest))) in axes.iter().zip(ranges).enumerate() {
            let most = degree.of_variable(i) as i32;
            let scale = match axis.family {
                FunctionFamily::Polynomial => size(least, largest),
                _ => 1.0,
            };
            let mut frequency = 1.0;
            let (rate, middle) = centred(least, largest);
            let mut knots = Vec::new();
            let mut members: Vec<Member> = match axis.family {
                FunctionFamily::Polynomial => (1..=most).map(Member::Power).collect(),
                FunctionFamily::Centred => (1..=most).map(Member::Centred).collect(),
                FunctionFamily::Spline => {
                    let count = (most - PIECE).max(0);
                    let at = |k: i32| 2.0 * f64::from(k + 1) / f64::from(count + 1) - 1.0;
                    knots = (0..count).map(|k| rounded(at(k))).collect();
                    let powers = (1..=most.min(PIECE)).map(Member::Centred);
                    powers.chain((0..count).map(Member::Knot)).collect()
                }
                FunctionFamily::Exponential => (1..=most)
                    .flat_map(|k| [Member::Exponential(k), Member::Exponential(-k)])
                    .collect(),
                FunctionFamily::Fourier { period } => {
                    if !(period.is_finite() && period > 0.0) {
                        return Err(LearnError::Period { period });
                    }
                    frequency = TAU / period;
                    (1..=most)
                        .flat_map(|k| [Member::Cosine(k), Member::Sine(k)])
                        .collect()
                }
            };
            if axis.has_logarithm {
                members.push(Member::Logarithm);
            }
            own.push(AxisMembers {
                members,
                scale,
                frequency,
                rate,
                middle,
                knots,
            });
        }
        let mut functions = Vec::new();
        let mut factors = Vec::new();
        products(&own, 0, degree.total() as i32, &mut factors, &mut functions)?;
        functions.sort_by_key(|factors| {
            let degrees = factors.iter().map(|&(i, at)| own[i].members[at].degree());
            degrees.sum::<i32>()
        });
        for (i, axis) in own.iter().enumerate() {
            if axis.members.last() == Some(&Member::Logarithm) {
                functions.push(vec![(i, axis.members.len() - 1)]);
            }
        }
        Ok(Self {
            axes: own,
            functions,
        })
    }

    /// n.
    pub fn len(&self) -> usize {
        self.functions.len()
    }

    /// Whether there is no function.
    pub fn is_empty(&self) -> bool {
        self.functions.is_empty()
    }

    /// Values f_j(x) and slopes ∂_i f_j(x) at `[j*d + i]`; none outside of a function's domain.
    pub fn values(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let d = self.axes.len();
        let mut tables = Vec::with_capacity(d);
        for (axis, &x) in self.axes.iter().zip(x) {
            let table: Vec<(f64, f64)> = axis.members.iter().map(|m| axis.value(*m, x)).collect();
            tables.push(table);
        }
        let mut values = Vec::with_capacity(self.len());
        let mut slopes = vec![0.0; self.len() * d];
        for (factors, slopes) in self.functions.iter().zip(slopes.chunks_mut(d.max(1))) {
            values.push(factors.iter().map(|&(i, at)| tables[i][at].0).product());
            for &(i, at) in factors {
                let others = factors.iter().filter(|(other, _)| *other != i);
                let others: f64 = others.map(|&(i, at)| tables[i][at].0).product();
                slopes[i] = tables[i][at].1 * others;
            }
        }
        let is_finite = values.iter().chain(&slopes).all(|value| value.is_finite());
        is_finite.then_some((values, slopes))
    }

    /// Σ_j c_j f_j over the functions with c_j ≠ 0, as text.
    pub fn written(&self, coefficients: &[f64], names: &[String]) -> String {
        let mut text = String::new();
        for (j, coefficient) in coefficients.iter().enumerate() {
            let coefficient = self.unscaled(j, *coefficient);
            if coefficient == 0.0 {
                continue;
            }
            let sign = match (coefficient < 0.0, text.is_empty()) {
                (true, true) => "-",
                (true, false) => " - ",
                (false, true) => "",
                (false, false) => " + ",
            };
            text.push_str(sign);
            text.push_str(&format!("{:?}*{}", coefficient.abs(), self.name(j, names)));
        }
        match text.is_empty() {
            true => "0".to_owned(),
            false => text,
        }
    }

    /// f_j as text, at unit scales.
    pub fn name(&self, j: usize, names: &[String]) -> String {
        let factors = self.functions[j].iter();
        let factors = factors.map(|&(i, at)| {
            let axis = &self.axes[i];
            axis.written(axis.members[at], &names[i])
        });
        factors.collect::<Vec<_>>().join("*")
    }

    /// The factor of f_j at unit scales in place of a factor of f_j.
    pub fn unscaled(&self, j: usize, coefficient: f64) -> f64 {
        let factors = self.functions[j].iter();
        factors.fold(coefficient, |value, &(i, at)| {
            match self.axes[i].members[at] {
                Member::Power(k) => value / power(self.axes[i].scale, k),
                _ => value,
            }
        })
    }

    /// Σ_j c_j f_j as a formula.
    pub fn formula(&self, coefficients: &[f64]) -> Expression {
        let names: Vec<String> = (0..self.axes.len()).map(|i| format!("v{i}")).collect();
        let text = self.written(coefficients, &names);
        let parsed = Formula::parse(&text);
        let resolved =
            parsed.and_then(|formula| formula.resolve(&Scope::new().with_variables(&names), None));
        match resolved {
            Ok(Some(formula)) => formula,
            _ => Expression::Constant(Rational::zero()),
        }
    }

    /// The variable whose logarithm is a function and that is not positive here.
    pub fn outside(&self, x: &[f64]) -> Option<usize> {
        let logarithms = self.axes.iter().zip(x).enumerate();
        let mut outside = logarithms.filter(|(_, (axis, x))| {
            axis.members.last() == Some(&Member::Logarithm) && (**x <= 0.0 || x.is_nan())
        });
        outside.next().map(|(i, _)| i)
    }
}

impl Member {
    fn degree(self) -> i32 {
        match self {
            Self::Power(k) | Self::Centred(k) | Self::Cosine(k) | Self::Sine(k) => k,
            Self::Knot(k) => PIECE + 1 + k,
            Self::Exponential(k) => k.abs(),
            Self::Logarithm => 1,
        }
    }
}

impl AxisMembers {
    /// A member's value and slope.
    fn value(&self, member: Member, x: f64) -> (f64, f64) {
        match member {
            Member::Power(k) => {
                let u = x / self.scale;
                let below = power(u, k - 1);
                (below * u, f64::from(k) * below / self.scale)
            }
            Member::Centred(k) => {
                let u = self.rate * (x - self.middle);
                let below = power(u, k - 1);
                (below * u, f64::from(k) * below * self.rate)
            }
            Member::Knot(k) => {
                let u = (self.rate * (x - self.middle) - self.knots[k as usize]).max(0.0);
                let below = power(u, PIECE - 1);
                (below * u, f64::from(PIECE) * below * self.rate)
            }
            Member::Exponential(k) => {
                let k = f64::from(k);
                let value = libm::exp(k * x);
                (value, k * value)
            }
            Member::Cosine(k) => {
                let k = f64::from(k) * self.frequency;
                (libm::cos(k * x), -k * libm::sin(k * x))
            }
            Member::Sine(k) => {
                let k = f64::from(k) * self.frequency;
                (libm::sin(k * x), k * libm::cos(k * x))
            }
            Member::Logarithm => (libm::log(x), 1.0 / x),
        }
    }

    fn written(&self, member: Member, name: &str) -> String {
        let times = |factor: f64| match factor == 1.0 {
            true => name.to_owned(),
            false => format!("{factor:?}*{name}"),
        };
        let centred = || match (self.middle, self.rate) {
            (0.0, rate) => times(rate),
            (middle, 1.0) => format!("{name}{}", less(middle)),
            (middle, rate) => format!("{rate:?}*({name}{})", less(middle)),
        };
        match member {
            Member::Power(1) => name.to_owned(),
            Member::Power(k) => format!("{name}^{k}"),
            Member::Centred(k) => {
                let power = if k == 1 {
                    String::new()
                } else {
                    format!("^{k}")
                };
                format!("({}){power}", centred())
            }
            Member::Knot(k) => {
                let knot = less(self.knots[k as usize]);
                format!("max({}{knot}, 0)^{PIECE}", centred())
            }
            Member::Exponential(k) => format!("exp({})", times(f64::from(k))),
            Member::Cosine(k) => format!("cos({})", times(f64::from(k) * self.frequency)),
            Member::Sine(k) => format!("sin({})", times(f64::from(k) * self.frequency)),
            Member::Logarithm => format!("ln({name})"),
        }
    }
}

/// Products of members from the variable `next` on whose degrees sum to at most `left`.
fn products(
    axes: &[AxisMembers],
    next: usize,
    left: i32,
    factors: &mut Vec<(usize, usize)>,
    functions: &mut Vec<Vec<(usize, usize)>>,
) -> Result<(), LearnError> {
    let Some(axis) = axes.get(next) else {
        if !factors.is_empty() {
            functions.push(factors.clone());
        }
        return match functions.len() > MOST_FUNCTIONS {
            true => Err(LearnError::TooManyFunctions {
                most: MOST_FUNCTIONS,
            }),
            false => Ok(()),
        };
    };
    products(axes, next + 1, left, factors, functions)?;
    for (at, member) in axis.members.iter().enumerate() {
        if *member == Member::Logarithm || member.degree() > left {
            continue;
        }
        factors.push((next, at));
        products(axes, next + 1, left - member.degree(), factors, functions)?;
        factors.pop();
    }
    Ok(())
}

/// A power of 2 near the largest |x| of a range.
fn size(least: f64, largest: f64) -> f64 {
    let size = least.abs().max(largest.abs());
    match size > 0.0 && size.is_finite() {
        true => libm::exp2(libm::round(libm::log2(size))),
        false => 1.0,
    }
}

/// The numbers of u = rate (x − middle), which leads from a range to −1 … 1. They are rounded so that formulas are short: the rate to
/// six digits, the middle to a millionth of half the range.
fn centred(least: f64, largest: f64) -> (f64, f64) {
    let half = largest / 2.0 - least / 2.0;
    let rate = rounded(1.0 / half);
    match rate > 0.0 && f64::is_finite(rate) {
        true => (rate, middle_of(largest / 2.0 + least / 2.0, half)),
        false => (1.0, least),
    }
}

/// The middle of a range to a millionth of half of it.
fn middle_of(middle: f64, half: f64) -> f64 {
    let digits = libm::ceil(libm::log10(middle.abs() / half)) + 6.0;
    match digits > 0.0 {
        true => format!("{middle:.*e}", digits.min(17.0) as usize)
            .parse()
            .unwrap_or(middle),
        false => 0.0,
    }
}

/// Six digits of a number.
fn rounded(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// Less a number, as text behind a term.
fn less(shift: f64) -> String {
    match shift {
        0.0 => String::new(),
        shift if shift < 0.0 => format!(" + {:?}", -shift),
        shift => format!(" - {shift:?}"),
    }
}

fn power(x: f64, k: i32) -> f64 {
    (0..k).fold(1.0, |value, _| value * x)
}
