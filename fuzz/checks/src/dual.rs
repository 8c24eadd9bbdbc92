//! Value and gradient of a tree by dual numbers, with a first-order bound on what rounding does to them.
//!
//! Nothing here is the program's but the table of functions: derivatives are written down once more.

use leafwise::expression::Function;
use leafwise::expression::special::Special;
use smallvec::{SmallVec, smallvec};

use crate::tree::Tree;

/// A number and the bound on its error, for f and for the slopes of up to six variables in place.
pub type Parts = SmallVec<[(f64, f64); 7]>;

/// f and ∇f with bounds on their errors.
#[derive(Clone, Debug)]
pub struct Dual {
    /// f and the bound on its error, then the same for each ∂f/∂xᵢ.
    pub parts: Parts,
    /// Whether a part of the formula is so large, small or ill-conditioned that first order bounds nothing.
    pub is_rough: bool,
}

/// Unit roundoff, with room for functions within an ulp.
const ROUND_OFF: f64 = f64::EPSILON;

/// Relative errors above this are not of first order.
const ROUGH: f64 = 1e-4;

/// Sizes that keep clear of overflow and underflow in whatever order products are formed.
const SIZES: std::ops::Range<f64> = 1e-70..1e70;

impl Dual {
    fn constant(value: f64, error: f64, variables: usize) -> Self {
        let mut parts: Parts = smallvec![(0.0, 0.0); variables + 1];
        parts[0] = (value, error);
        Self {
            parts,
            is_rough: false,
        }
    }

    /// f.
    pub fn value(&self) -> f64 {
        self.parts[0].0
    }

    /// ∂f/∂xᵢ.
    pub fn slope(&self, index: usize) -> f64 {
        self.parts[index + 1].0
    }

    /// Tells roughness once an operation is done.
    fn judged(mut self) -> Self {
        let (value, error) = self.parts[0];
        let fits = |x: f64| x == 0.0 || SIZES.contains(&x.abs());
        let fit = self.parts.iter().all(|(x, e)| fits(*x) && e.is_finite());
        self.is_rough |= !fit || error > ROUGH * value.abs();
        self
    }

    fn add(&self, other: &Self, sign: f64) -> Self {
        let both = self.parts.iter().zip(&other.parts);
        let parts = both.map(|((a, ea), (b, eb))| {
            let sum = a + sign * b;
            (sum, ea + eb + ROUND_OFF * (a.abs() + b.abs()))
        });
        Self {
            parts: parts.collect(),
            is_rough: self.is_rough || other.is_rough,
        }
    }

    fn multiply(&self, other: &Self) -> Self {
        let ((a, ea), (b, eb)) = (self.parts[0], other.parts[0]);
        let error = a.abs() * eb + b.abs() * ea + ROUND_OFF * (a * b).abs();
        let mut parts: Parts = smallvec![(a * b, error)];
        for ((da, eda), (db, edb)) in self.parts[1..].iter().zip(&other.parts[1..]) {
            let error = a.abs() * edb + db.abs() * ea + b.abs() * eda + da.abs() * eb;
            let size = (a * db).abs() + (b * da).abs();
            parts.push((a * db + b * da, error + 2.0 * ROUND_OFF * size));
        }
        let is_rough = self.is_rough || other.is_rough;
        Self { parts, is_rough }.judged()
    }

    /// g(f) from g, g′ and g″ at f, each right within `ulps` units.
    fn through(&self, g: [f64; 3], ulps: f64) -> Self {
        self.through_above(g, ulps, 0.0)
    }

    /// The same where these are units of `least` at least, as next to zeros of g and g′.
    fn through_above(&self, g: [f64; 3], ulps: f64, least: f64) -> Self {
        let (_, ea) = self.parts[0];
        let [value, slope, second] = g;
        let off = ulps * ROUND_OFF;
        let error = slope.abs() * ea + off * value.abs().max(least);
        let mut parts: Parts = smallvec![(value, error)];
        for (da, eda) in &self.parts[1..] {
            if (*da, *eda) == (0.0, 0.0) {
                // What does not depend on a variable has no slope, not even where g has none.
                parts.push((0.0, 0.0));
                continue;
            }
            let of_slope = second.abs() * ea + off * slope.abs().max(least);
            let product = slope * da;
            let error = slope.abs() * eda + of_slope * da.abs() + ROUND_OFF * product.abs();
            parts.push((product, error));
        }
        let is_rough = self.is_rough;
        Self { parts, is_rough }.judged()
    }

    fn power(&self, exponent: f64) -> Self {
        let x = self.value();
        if exponent == 0.0 {
            return Self::constant(1.0, 0.0, self.parts.len() - 1);
        }
        let slope = exponent * libm::pow(x, exponent - 1.0);
        let second = exponent * (exponent - 1.0) * libm::pow(x, exponent - 2.0);
        // The exponent itself is rounded, or the product is formed factor by factor.
        let logarithm = if x == 0.0 {
            0.0
        } else {
            libm::log(x.abs()).abs()
        };
        let ulps = 4.0 + exponent.abs() * (1.0 + logarithm);
        let integer = exponent == 1.0;
        let second = if integer { 0.0 } else { second };
        self.through([libm::pow(x, exponent), slope, second], ulps)
    }

    fn apply(&self, function: Function) -> Self {
        let x = self.value();
        let value = function.apply(x);
        let (slope, second) = derivatives(function, x, value);
        let (ulps, least) = match function {
            // Γ′ is Γψ, and ψ right within units of 1 next to its zero.
            Function::Gamma => (64.0, value.abs()),
            // Of the size of their amplitude.
            Function::Special(..) => (64.0, 1.0),
            _ => (4.0, 0.0),
        };
        self.through_above([value, slope, second], ulps, least)
    }
}

/// g′(x) and g″(x).
fn derivatives(function: Function, x: f64, g: f64) -> (f64, f64) {
    match function {
        Function::Exp => (g, g),
        Function::Ln => (1.0 / x, -1.0 / (x * x)),
        Function::Sqrt => (0.5 / g, -0.25 / (g * x)),
        Function::Sin => (libm::cos(x), -g),
        Function::Cos => (-libm::sin(x), -g),
        Function::Tan => {
            let c = libm::cos(x);
            (1.0 / (c * c), 2.0 * g / (c * c))
        }
        Function::Asin | Function::Acos => {
            let sign = if function == Function::Asin {
                1.0
            } else {
                -1.0
            };
            let below = (1.0 - x) * (1.0 + x);
            let slope = sign / libm::sqrt(below);
            (slope, slope * x / below)
        }
        Function::Atan => {
            let below = 1.0 + x * x;
            (1.0 / below, -2.0 * x / (below * below))
        }
        Function::Sinh => (libm::cosh(x), g),
        Function::Cosh => (libm::sinh(x), g),
        Function::Tanh => {
            let c = libm::cosh(x);
            (1.0 / (c * c), -2.0 * g / (c * c))
        }
        Function::Asinh => {
            let below = 1.0 + x * x;
            let slope = 1.0 / libm::sqrt(below);
            (slope, -x * slope / below)
        }
        Function::Acosh => {
            let below = (x - 1.0) * (x + 1.0);
            let slope = 1.0 / libm::sqrt(below);
            (slope, -x * slope / below)
        }
        Function::Atanh => {
            let below = (1.0 - x) * (1.0 + x);
            (1.0 / below, 2.0 * x / (below * below))
        }
        // Next to a seam both sides count: a slope beyond all sizes makes the formula rough.
        Function::Abs | Function::Sign | Function::Floor => {
            let seam = match function {
                Function::Floor => libm::round(x),
                _ => 0.0,
            };
            let is_next = (x - seam).abs() <= 1e-6 * x.abs().max(1e-6);
            let jump = if is_next { f64::INFINITY } else { 0.0 };
            match function {
                Function::Abs => (x.signum(), jump),
                _ => (jump, jump),
            }
        }
        Function::Erf | Function::Erfc => {
            let sign = if function == Function::Erf { 1.0 } else { -1.0 };
            let slope = sign * std::f64::consts::FRAC_2_SQRT_PI * libm::exp(-x * x);
            (slope, -2.0 * x * slope)
        }
        Function::Gamma => {
            let [first, second] = [1, 2].map(|k| Special::LnGamma.derivative(k, x));
            (g * first, g * (first * first + second))
        }
        Function::Log10 | Function::Log2 => {
            let base = if function == Function::Log10 {
                10.0
            } else {
                2.0
            };
            let slope = 1.0 / (x * libm::log(base));
            (slope, -slope / x)
        }
        Function::Special(Special::J0, 0) => (-libm::j1(x), 0.5 * (libm::jn(2, x) - g)),
        // Next to 0 both integrals are equal.
        Function::Special(Special::EllipticE, 0) if x.abs() > 0.5 => {
            let k = Special::EllipticK.derivative(0, x);
            let slope = (g - k) / (2.0 * x);
            (slope, Special::EllipticE.derivative(2, x))
        }
        Function::Special(special, order) => {
            let [slope, second] = [1, 2].map(|k| special.derivative(u32::from(order) + k, x));
            (slope, second)
        }
    }
}

impl Tree {
    /// f(x).
    pub fn value(&self, x: &[f64]) -> f64 {
        self.dual_along(x, 0).value()
    }

    /// f(x) and ∇f(x).
    pub fn dual(&self, x: &[f64]) -> Dual {
        self.dual_along(x, x.len())
    }

    /// f(x) and its slopes along the first d variables.
    fn dual_along(&self, x: &[f64], d: usize) -> Dual {
        let along = |tree: &Tree| tree.dual_along(x, d);
        match self {
            Self::Number(value) => Dual::constant(*value, 0.0, d).judged(),
            Self::Pi => Dual::constant(std::f64::consts::PI, 0.5 * ROUND_OFF, d),
            Self::Variable(index) => {
                let mut dual = Dual::constant(x[*index], 0.0, d);
                if let Some(own) = dual.parts.get_mut(index + 1) {
                    own.0 = 1.0;
                }
                dual.judged()
            }
            Self::Sum(terms) => {
                let mut sum = Dual::constant(0.0, 0.0, d);
                for (is_negative, term) in terms {
                    sum = sum.add(&along(term), if *is_negative { -1.0 } else { 1.0 });
                }
                sum.judged()
            }
            Self::Product(factors) => {
                let mut product = Dual::constant(1.0, 0.0, d);
                for factor in factors {
                    product = product.multiply(&along(factor));
                }
                product
            }
            Self::Quotient(above, below) => along(above).multiply(&along(below).power(-1.0)),
            Self::Power(base, numerator, denominator) => {
                along(base).power(f64::from(*numerator) / f64::from(*denominator))
            }
            Self::General(base, exponent) => {
                let (base, exponent) = (along(base), along(exponent));
                if exponent.parts[1..].iter().all(|slope| *slope == (0.0, 0.0)) {
                    return base.power(exponent.value());
                }
                let logarithm = base.apply(Function::Ln);
                exponent.multiply(&logarithm).apply(Function::Exp)
            }
            Self::Negate(operand) => Dual::constant(0.0, 0.0, d).add(&along(operand), -1.0),
            Self::Apply(function, argument) => along(argument).apply(*function),
            Self::If(parts) => {
                let [c, a, b] = &**parts;
                let c = along(c);
                let (value, error) = c.parts[0];
                let mut kept = along(if value > 0.0 { a } else { b });
                // Next to the seam, and where c has no value, either may be taken.
                let is_sure =
                    value.abs() > 2.0 * error && value.is_finite() || value == 0.0 && error == 0.0;
                kept.is_rough |= c.is_rough || !is_sure;
                kept
            }
        }
    }
}
