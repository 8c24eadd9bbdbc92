//! The exact series of α along p(h), from its formulas.

use leafwise_core::BuildError;
use leafwise_core::realization::{SourceRecursion, SourceSeriesIn};
use leafwise_expression::series::{Tape, TapeIndex, TaylorState};
use leafwise_expression::{AlgebraError, DifferentialAlgebra, Expression, Rational};

/// [hᵏ] α_1(x, Σ_{k≥1} pₖ hᵏ).
#[derive(Clone, Debug)]
pub(super) struct FormulaSeries {
    /// α_1 over x1 … xd, p1 … pd.
    alpha: Vec<Expression>,
}

/// A momentum and an ε at which formulas are compared.
const SAMPLES: [(f64, f64); 3] = [(0.1, 0.5), (-0.07, 0.25), (0.03, 2.0)];

/// What round-off leaves of equal values of two formulas.
const ROUND_OFF: f64 = 1e-12;

impl FormulaSeries {
    /// The series of formulas over x1 … xd, p1 … pd, epsilon; `None` where α_ε(x, p) is not
    /// α_1(x, εp), the property of realization data from which coefficients at ε = 1 serve every ε.
    /// The property is sampled.
    pub(super) fn new(alpha: &[Expression]) -> Option<Self> {
        scales(alpha).then(|| Self {
            alpha: alpha
                .iter()
                .map(|formula| at_one(formula, 2 * alpha.len()))
                .collect(),
        })
    }
}

fn scales(alpha: &[Expression]) -> bool {
    let d = alpha.len();
    let mut is_seen = false;
    for (size, epsilon) in SAMPLES {
        // States that many domains contain: positive, all different.
        let x: Vec<f64> = (0..d).map(|i| 0.7 + 0.2 * i as f64).collect();
        let p: Vec<f64> = (0..d).map(|i| size / (1.0 + i as f64)).collect();
        let at = |factor: f64, epsilon: f64| -> Vec<f64> {
            let scaled = p.iter().map(|p| factor * p);
            x.iter().copied().chain(scaled).chain([epsilon]).collect()
        };
        let (scaled, own) = (at(epsilon, 1.0), at(1.0, epsilon));
        for formula in alpha {
            let (a, b) = (formula.evaluate(&own, &[]), formula.evaluate(&scaled, &[]));
            if !a.is_finite() || !b.is_finite() {
                continue;
            }
            is_seen = true;
            if (a - b).abs() > ROUND_OFF * (1.0 + a.abs()) {
                return false;
            }
        }
    }
    is_seen
}

/// The formula at ε = 1, the variable `epsilon` standing last.
fn at_one(formula: &Expression, epsilon: usize) -> Expression {
    let one = |part: &Expression| Box::new(at_one(part, epsilon));
    let all = |parts: &[Expression]| parts.iter().map(|part| at_one(part, epsilon)).collect();
    match formula {
        Expression::Variable(index) if *index == epsilon => Expression::Constant(Rational::one()),
        Expression::Constant(_)
        | Expression::Pi
        | Expression::Parameter(_)
        | Expression::Variable(_) => formula.clone(),
        Expression::Sum(terms) => Expression::Sum(all(terms)),
        Expression::Product(factors) => Expression::Product(all(factors)),
        Expression::Negate(operand) => Expression::Negate(one(operand)),
        Expression::Quotient(above, below) => Expression::Quotient(one(above), one(below)),
        Expression::Power(base, exponent) => Expression::Power(one(base), one(exponent)),
        Expression::Apply(function, argument) => Expression::Apply(*function, one(argument)),
    }
}

impl<A: DifferentialAlgebra> SourceSeriesIn<A> for FormulaSeries {
    fn start(&self, algebra: &mut A) -> Result<Box<dyn SourceRecursion<A>>, BuildError> {
        let mut tape = Tape::new();
        let alpha = self
            .alpha
            .iter()
            .map(|formula| tape.record(formula))
            .collect::<Result<Vec<_>, AlgebraError>>()?;
        let mut recursion = Recursion {
            state: TaylorState::new(&tape),
            x: (0..self.alpha.len())
                .map(|i| algebra.coordinate(i))
                .collect(),
            tape,
            alpha,
            order: 0,
        };
        let d = self.alpha.len();
        let (tape, x) = (&recursion.tape, &recursion.x);
        recursion.state.extend(tape, algebra, |algebra, index| {
            if index < d {
                x[index].clone()
            } else {
                algebra.zero()
            }
        })?;
        Ok(Box::new(recursion))
    }
}

struct Recursion<E> {
    tape: Tape,
    state: TaylorState<E>,
    x: Vec<E>,
    alpha: Vec<TapeIndex>,
    /// The last known order.
    order: usize,
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursion<A::Element> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        let d = self.x.len();
        self.state.extend(&self.tape, algebra, |algebra, index| {
            if index < d {
                algebra.zero()
            } else {
                p[index - d].clone()
            }
        })?;
        self.order += 1;
        let coefficient = |index: &TapeIndex| self.state.coefficient(*index, self.order).clone();
        Ok(self.alpha.iter().map(coefficient).collect())
    }
}
