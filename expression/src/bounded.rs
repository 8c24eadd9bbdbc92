//! Numbers with a bound on their rounding errors.

use crate::arithmetic::{AlgebraError, Arithmetic, binary_derivative, function_derivative};
use crate::expression::{Binary, Function, Side};
use crate::function::kept;
use crate::graph::{Graph, Node, Operation, Term};
use crate::rational::Rational;
use crate::table::Lookup;

/// A number as it is computed, and how far rounding may have moved it from the exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The number.
    pub value: f64,
    /// The bound, to first order in the unit roundoff; infinite or NaN where there is none.
    pub error: f64,
}

impl Bounded {
    /// A number without an error.
    pub fn exact(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    /// The number after an operation that rounds, whose operands' errors come to `error`.
    fn rounded(value: f64, error: f64) -> Self {
        Self {
            value,
            error: error + ROUND_OFF * value.abs() + f64::MIN_POSITIVE,
        }
    }
}

/// Half an ulp, with what first order leaves out.
const ROUND_OFF: f64 = 0.51 * f64::EPSILON;

/// Largest relative rounding error of `libm`: its functions are within an ulp, the power within
/// two.
const FUNCTION: f64 = 2.0 * f64::EPSILON;

/// Largest rounding error of special functions and their first derivatives, of their values or of 1.
const SPECIAL: f64 = 64.0 * f64::EPSILON;

/// Largest rounding error of a table's weights and sums, of the sum of all magnitudes.
const LOOKUP: f64 = 64.0 * f64::EPSILON;

/// Formulas in plain double arithmetic at these values of the parameters, with a running error bound
/// (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, section 3.3).
#[derive(Clone, Debug)]
pub struct BoundedNumbers {
    /// The parameters' values.
    pub parameters: Vec<f64>,
}

impl BoundedNumbers {
    /// The values of `terms` of straight-line code with the inputs `x`, for ε = h = 1.
    ///
    /// # Errors
    /// [`AlgebraError`] as of a formula.
    pub fn values(
        &mut self,
        graph: &Graph,
        terms: &[Term],
        x: &[f64],
    ) -> Result<Vec<Bounded>, AlgebraError> {
        let inputs: Vec<Bounded> = x.iter().map(|x| Bounded::exact(*x)).collect();
        self.values_at(graph, terms, &inputs)
    }

    /// [`values`](Self::values) at inputs that are known up to an error.
    ///
    /// # Errors
    /// [`AlgebraError`] as of a formula.
    pub fn values_at(
        &mut self,
        graph: &Graph,
        terms: &[Term],
        inputs: &[Bounded],
    ) -> Result<Vec<Bounded>, AlgebraError> {
        let is_read = graph.read_by(terms);
        // Operands come before their uses.
        let mut known = vec![Bounded::exact(f64::NAN); graph.len()];
        for index in (0..graph.len()).filter(|&index| is_read[index]) {
            known[index] = match graph.operation(Node(index as u32)) {
                Operation::One | Operation::StepSize(_) => Bounded::exact(1.0),
                Operation::Pi => self.pi(),
                Operation::Parameter(at) => self.parameter(*at as usize),
                Operation::Input(at) => inputs[*at as usize],
                Operation::Sum(terms) => {
                    let of = |(scale, a): &(Rational, Node)| (scale.clone(), known[a.index()]);
                    let terms: Vec<_> = terms.iter().map(of).collect();
                    self.combine(&terms)
                }
                Operation::Scale(scale, a) => self.scale(scale, &known[a.index()]),
                Operation::Product(a, b) => self.multiply(&known[a.index()], &known[b.index()]),
                Operation::Reciprocal(a) => self.divide(&Bounded::exact(1.0), &known[a.index()])?,
                Operation::Function(function, a) => self.apply(*function, &known[a.index()])?,
                Operation::Analytic(function, order, a) => {
                    let a = known[a.index()];
                    let value = function.derivative(*order, a.value);
                    let slope = function.derivative(order + 1, a.value);
                    let error = FUNCTION * value.abs() + slope.abs() * a.error;
                    Bounded::rounded(value, error)
                }
                Operation::Power(a, b) => self.power(&known[a.index()], &known[b.index()])?,
                Operation::Binary(function, a, b) => {
                    self.apply_two(*function, &known[a.index()], &known[b.index()])?
                }
                Operation::Lookup(lookup, point) => {
                    let point: Vec<_> = point.iter().map(|at| known[at.index()]).collect();
                    self.look_up(*lookup, &point)?
                }
                Operation::Kept(side, c, v) => {
                    self.kept(*side, &known[c.index()], &known[v.index()])?
                }
            };
        }
        let scaled = |term: &Term| self.scale(&term.scale, &known[term.node.index()]);
        Ok(terms.iter().map(scaled).collect())
    }
}

impl Arithmetic for BoundedNumbers {
    type Element = Bounded;

    fn constant(&mut self, value: &Rational) -> Bounded {
        Bounded::rounded(value.to_f64(), 0.0)
    }
    fn pi(&mut self) -> Bounded {
        Bounded::rounded(std::f64::consts::PI, 0.0)
    }
    fn parameter(&mut self, index: usize) -> Bounded {
        Bounded::exact(self.parameters[index])
    }
    /// A number is not recognized: it may be a small one.
    fn is_zero(&self, _element: &Bounded) -> bool {
        false
    }
    fn as_rational(&self, _element: &Bounded) -> Option<Rational> {
        None
    }
    fn combine(&mut self, terms: &[(Rational, Bounded)]) -> Bounded {
        let mut sum = Bounded::exact(0.0);
        for (factor, term) in terms {
            let term = if factor.is_one() {
                *term
            } else {
                let factor = self.constant(factor);
                self.multiply(&factor, term)
            };
            sum = Bounded::rounded(sum.value + term.value, sum.error + term.error);
        }
        sum
    }
    fn multiply(&mut self, a: &Bounded, b: &Bounded) -> Bounded {
        let error = a.value.abs() * b.error + a.error * (b.value.abs() + b.error);
        Bounded::rounded(a.value * b.value, error)
    }
    fn divide(&mut self, a: &Bounded, b: &Bounded) -> Result<Bounded, AlgebraError> {
        let value = a.value / b.value;
        let least = b.value.abs() - b.error;
        let error = if least > 0.0 {
            (a.error + value.abs() * b.error) / least
        } else {
            f64::INFINITY
        };
        Ok(Bounded::rounded(value, error))
    }
    fn power(&mut self, a: &Bounded, b: &Bounded) -> Result<Bounded, AlgebraError> {
        let value = libm::pow(a.value, b.value);
        let least = a.value.abs() - a.error;
        let relative = if least > 0.0 {
            b.value.abs() * a.error / least + libm::log(a.value.abs()).abs() * b.error
        } else {
            f64::INFINITY
        };
        let error = value.abs() * (relative + FUNCTION);
        Ok(Bounded::rounded(value, error))
    }
    /// The errors of the arguments are taken with the slopes; without a bound where the value may jump between them.
    fn apply_two(
        &mut self,
        function: Binary,
        a: &Bounded,
        b: &Bounded,
    ) -> Result<Bounded, AlgebraError> {
        let value = function.apply(a.value, b.value);
        let mut error = FUNCTION * value.abs();
        for (by, own) in [a, b].into_iter().enumerate() {
            if own.error == 0.0 {
                continue;
            }
            let pair = [a, b].map(|part| Bounded::exact(part.value));
            let slope = binary_derivative(self, function, [&pair[0], &pair[1]], by)?.value;
            error += slope.abs() * own.error;
            for end in [own.value - own.error, own.value + own.error] {
                let at = match by {
                    0 => function.apply(end, b.value),
                    _ => function.apply(a.value, end),
                };
                // Twice the slope is more than a smooth function changes by.
                let is_jump = (at - value).abs() > 2.0 * error;
                error = if is_jump { f64::INFINITY } else { error };
            }
        }
        Ok(Bounded::rounded(value, error))
    }
    /// Rounding of the weights and of the sum, and slopes where the point is not known exactly.
    fn look_up(&mut self, lookup: Lookup, point: &[Bounded]) -> Result<Bounded, AlgebraError> {
        let at: Vec<f64> = point.iter().map(|x| x.value).collect();
        let mut error = LOOKUP * lookup.magnitude(&at);
        for (axis, x) in point.iter().enumerate().filter(|(_, x)| x.error > 0.0) {
            let slope = lookup.derivative(axis).map_or(0.0, |slope| slope.at(&at));
            error += slope.abs() * x.error;
        }
        Ok(Bounded::rounded(lookup.at(&at), error))
    }
    /// Without a bound where c may be of either side.
    fn kept(&mut self, side: Side, c: &Bounded, v: &Bounded) -> Result<Bounded, AlgebraError> {
        let value = kept(side, c.value, v.value);
        let is_sure = c.error == 0.0 || c.value.abs() > c.error;
        let error = match (is_sure, kept(side, c.value, 1.0) == 0.0) {
            (false, _) => f64::INFINITY,
            (true, true) => 0.0,
            (true, false) => v.error,
        };
        Ok(Bounded { value, error })
    }
    /// The error of the argument is taken with the slope there and at both ends of its interval.
    fn apply(&mut self, function: Function, a: &Bounded) -> Result<Bounded, AlgebraError> {
        let value = function.apply(a.value);
        let mut error = match function {
            Function::Gamma | Function::Special(..) => SPECIAL * value.abs().max(1.0),
            _ => FUNCTION * value.abs(),
        };
        if a.error > 0.0 && function.is_step() {
            let [low, high] = [a.value - a.error, a.value + a.error].map(|at| function.apply(at));
            // Without a bound where it may be either of two.
            error = if high == low { error } else { f64::INFINITY };
        } else if a.error > 0.0 {
            let mut slope = 0.0_f64;
            for at in [a.value - a.error, a.value, a.value + a.error] {
                let (u, g) = (Bounded::exact(at), Bounded::exact(function.apply(at)));
                let here = function_derivative(self, function, &u, &g)?.value.abs();
                // A maximum that keeps NaN.
                slope = if here > slope || here.is_nan() {
                    here
                } else {
                    slope
                };
            }
            error += slope * a.error;
        }
        Ok(Bounded::rounded(value, error))
    }
}
