//! g(w) = (√w coth √w − 1)/w as straight-line code on ℝ\[u\]/(u² − δ).
//!
//! At w/4⁶ a convergent of Lambert's continued fraction gives g. Then six times the argument is doubled. With F =
//! 1 + w g = √w coth √w, F(4w) = F(w) + w/F(w), that is g(4w) = ¼ (g(w) + 1/(1 + w g(w))). Near 0 and on the positive
//! axis a doubling shrinks errors. Towards the pole at −π² they grow as the condition of g does: at most 8 ulps of it
//! for one root, 64 for a pair.

use leafwise_core::BuildError;
use leafwise_expression::{Arithmetic, Graph, Rational, Term};

/// How often the argument is doubled.
const DOUBLINGS: i64 = 6;

/// Levels of the continued fraction w g = w/(3 + w/(5 + w/(7 + …))). The remainder of the convergent is
/// w⁸/(3·5²⋯17²·19) of it, 1.3e-16 at the largest |w|/4⁶ served, 1.
const LEVELS: i64 = 8;

/// a + b u.
#[derive(Clone, Debug)]
pub struct Pair {
    /// a.
    pub constant: Term,
    /// b; structurally 0 where there is one simple root.
    pub slope: Term,
}

/// ℝ\[u\]/(u² − δ).
struct Pairs<'a> {
    graph: &'a mut Graph,
    split: &'a Term,
}

impl Pairs<'_> {
    fn combine(&mut self, terms: &[(Rational, &Pair)]) -> Pair {
        let part = |of: fn(&Pair) -> &Term| -> Vec<(Rational, Term)> {
            let terms = terms.iter();
            terms
                .map(|(c, pair)| (c.clone(), of(pair).clone()))
                .collect()
        };
        Pair {
            constant: self.graph.combine(&part(|pair| &pair.constant)),
            slope: self.graph.combine(&part(|pair| &pair.slope)),
        }
    }

    fn number(&mut self, value: Rational) -> Pair {
        Pair {
            constant: self.graph.constant(&value),
            slope: self.graph.zero(),
        }
    }

    fn multiply(&mut self, left: &Pair, right: &Pair) -> Pair {
        let graph = &mut *self.graph;
        let plain = graph.multiply(&left.constant, &right.constant);
        let both = graph.multiply(&left.slope, &right.slope);
        let both = graph.multiply(&both, self.split);
        let first = graph.multiply(&left.slope, &right.constant);
        let second = graph.multiply(&left.constant, &right.slope);
        Pair {
            constant: graph.add(&plain, &both),
            slope: graph.add(&first, &second),
        }
    }

    /// 1/(a + b u) = (a − b u)/(a² − δ b²), that is 1/a − b u/a² where δ = 0.
    fn invert(&mut self, pair: &Pair) -> Result<Pair, BuildError> {
        let graph = &mut *self.graph;
        let one = graph.one();
        let (constant, inverse) = if graph.is_zero(self.split) || graph.is_zero(&pair.slope) {
            let constant = graph.divide(&one, &pair.constant)?;
            (constant.clone(), graph.multiply(&constant, &constant))
        } else {
            let square = graph.multiply(&pair.constant, &pair.constant);
            let other = graph.multiply(&pair.slope, &pair.slope);
            let other = graph.multiply(&other, self.split);
            let norm = graph.subtract(&square, &other);
            let inverse = graph.divide(&one, &norm)?;
            (graph.multiply(&pair.constant, &inverse), inverse)
        };
        let slope = graph.multiply(&pair.slope, &inverse);
        Ok(Pair {
            constant,
            slope: graph.negate(&slope),
        })
    }
}

/// N_2 and N_1 of N_k = (2k+1) N_{k+1} + w N_{k+2}, N_{LEVELS+1} = 1, by ascending powers of w:
/// N_2/N_1 is the convergent of g.
fn convergent() -> (Vec<i64>, Vec<i64>) {
    let mut numerator = vec![1];
    let mut denominator = vec![2 * LEVELS + 1];
    for k in (1..LEVELS).rev() {
        let mut next: Vec<i64> = denominator.iter().map(|c| (2 * k + 1) * c).collect();
        next.resize(numerator.len() + 1, 0);
        next[1..]
            .iter_mut()
            .zip(&numerator)
            .for_each(|(sum, c)| *sum += c);
        numerator = std::mem::replace(&mut denominator, next);
    }
    (numerator, denominator)
}

/// g(w) in ℝ\[u\]/(u² − `split`).
///
/// # Errors
/// [`BuildError::Algebra`] for a divisor that is identically zero, which none is.
pub fn even_factor(graph: &mut Graph, w: &Pair, split: &Term) -> Result<Pair, BuildError> {
    let mut pairs = Pairs { graph, split };
    let (numerator, denominator) = convergent();
    let mut powers = vec![pairs.number(Rational::one()), w.clone()];
    while powers.len() < denominator.len() {
        let half = powers.len() / 2;
        let next = pairs.multiply(&powers[half].clone(), &powers[powers.len() - half].clone());
        powers.push(next);
    }
    let [above, below] = [numerator, denominator].map(|coefficients| {
        let scaled = coefficients.iter().zip(&powers).zip(0..);
        let terms: Vec<_> = scaled
            .map(|((c, power), k)| {
                (
                    &Rational::from_integer(*c) * &four_to(-DOUBLINGS * k),
                    power,
                )
            })
            .collect();
        pairs.combine(&terms)
    });
    let below = pairs.invert(&below)?;
    let mut value = pairs.multiply(&above, &below);
    let one = pairs.number(Rational::one());
    let quarter = four_to(-1);
    for j in 0..DOUBLINGS {
        let product = pairs.multiply(w, &value);
        let whole = pairs.combine(&[(Rational::one(), &one), (four_to(j - DOUBLINGS), &product)]);
        let inverse = pairs.invert(&whole)?;
        value = pairs.combine(&[(quarter.clone(), &value), (quarter.clone(), &inverse)]);
    }
    Ok(value)
}

/// 4ᵏ.
fn four_to(exponent: i64) -> Rational {
    Rational::from_integer(4).powi(exponent)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use leafwise_expression::{Arithmetic, Graph, Kernel};

    use super::{Pair, even_factor};
    use crate::even_part::LARGEST;

    /// G₀ + G₁ u = g(c + u) modulo u² = δ at (c, δ).
    fn factor(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut graph = Graph::new();
        let [centre, split] = [0, 1].map(|i| graph.input(i));
        let w = Pair {
            constant: centre,
            slope: graph.one(),
        };
        let value = even_factor(&mut graph, &w, &split).expect("code");
        let kernel = Kernel::compile(&graph, &[value.constant, value.slope], 0, 2);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
        let values = points.iter().map(|point| {
            let mut value = [0.0; 2];
            kernel.evaluate(&mut workspace, point, &mut value);
            value
        });
        values.collect()
    }

    /// g(w) = Σ_{n≥1} 2/(π²n² + w), by Mittag-Leffler: 2000 terms and, for the others, their
    /// expansion in w with the sums of 1/n² and 1/n⁴ by Euler and Maclaurin; far from 0 as it
    /// stands.
    fn reference(w: f64) -> f64 {
        const TERMS: u32 = 2000;
        if w > PI * PI {
            let y = libm::sqrt(w);
            return (y / libm::tanh(y) - 1.0) / w;
        }
        let m = 1.0 / f64::from(TERMS);
        let squares = m - m * m / 2.0 + m * m * m / 6.0;
        let fourths = m * m * m / 3.0 - m * m * m * m / 2.0;
        let rest = 2.0 / (PI * PI) * (squares - w / (PI * PI) * fourths);
        (1..=TERMS).rev().fold(rest, |sum, n| {
            let pole = PI * PI * f64::from(n) * f64::from(n);
            sum + 2.0 / (pole + w)
        })
    }

    /// One simple root, within the condition w/(w + π²) that the pole gives and a few ulp, four of
    /// them the reference's: π² is rounded once for all its poles, each term three times.
    #[test]
    fn it_is_accurate_from_the_pole_to_the_largest_argument() {
        let negative = (1..400).map(|i| -PI * PI * f64::from(i) / 400.0);
        let positive = (0..=400).map(|i| LARGEST * libm::pow(f64::from(i) / 400.0, 4.0));
        let points: Vec<[f64; 2]> = negative.chain(positive).map(|w| [w, 0.0]).collect();
        for (point, value) in points.iter().zip(factor(&points)) {
            let [w, expected] = [point[0], reference(point[0])];
            let pole = 1.0 + (w / (w + PI * PI)).abs();
            let error = (value[0] / expected - 1.0).abs() / f64::EPSILON;
            assert!(error <= 8.0 * pole, "w = {w}: {error} ulp");
        }
    }

    /// Two real roots c ± s: G₀ ± G₁ s are the values there.
    #[test]
    fn two_real_roots_have_their_own_values() {
        for (low, high) in [(-9.0, -0.5), (-8.0, 30.0), (0.5, 900.0), (-0.01, 0.02)] {
            let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
            let [constant, slope] = factor(&[[centre, half * half]])[0];
            for (found, w) in [
                (constant - slope * half, low),
                (constant + slope * half, high),
            ] {
                let size = reference(low).max(reference(high));
                let bound = 16.0 * f64::EPSILON * size * (1.0 + (low / (low + PI * PI)).abs());
                assert!((found - reference(w)).abs() <= bound, "{w}: {found}");
            }
        }
    }

    /// A conjugate pair c ± is: G₀ + i G₁ s = g(c + is), y coth y from its real and imaginary parts.
    #[test]
    fn a_conjugate_pair_has_a_complex_value() {
        for (re, im) in [(0.3, 2.0), (2.0, 3.0), (7.0, 1.0), (20.0, 2.5)] {
            // y = re + i im, w = y².
            let (centre, s) = (re * re - im * im, 2.0 * re * im);
            let below = libm::cosh(2.0 * re) - libm::cos(2.0 * im);
            let (a, b) = (libm::sinh(2.0 * re) / below, -libm::sin(2.0 * im) / below);
            let (a, b) = (re * a - im * b - 1.0, re * b + im * a);
            let square = centre * centre + s * s;
            let expected = [
                (a * centre + b * s) / square,
                (b * centre - a * s) / square / s,
            ];
            let found = factor(&[[centre, -s * s]])[0];
            for ((found, expected), scale) in found.iter().zip(expected).zip([1.0, 1.0 / s]) {
                let size = scale * libm::sqrt(a * a + b * b) / libm::sqrt(square);
                let error = (found - expected).abs() / size / f64::EPSILON;
                // The nearest pole is −π²; all roots here keep a tenth of that away from it.
                assert!(error <= 64.0, "y = {re} + {im} i: {error} ulp");
            }
        }
    }
}
