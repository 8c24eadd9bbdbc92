//! The curve Y(s) = Σ hᵏ Y_k(s) and its polynomial coefficients.
//!
//! With s = σ + ½ the zero-mean condition reads ∫_{−½}^{½} Y_k dσ = 0 for k ≥ 1. The parity of Y_k in σ is that of k:
//! half of its coefficients vanish identically.

use leafwise_core::SystemFormulas;
use leafwise_expression::Expression;
use leafwise_expression::arithmetic::{AlgebraError, Arithmetic};
use leafwise_expression::rational::Rational;
use leafwise_expression::series::{Tape, TapeIndex, TaylorState, Univariate};

/// The series of the curve over an algebra with elements `E`, one order at a time.
///
/// Y_{k+1} is the zero-mean antiderivative of the hᵏ-coefficient of Π(Y) q with q(h) = Σ hᵏ q_k. For q = p constant
/// this is Karasev's curve in powers of ε. For q_k = p_{k+1} it is the curve along p(h) = Σ_{k≥1} p_k hᵏ.
#[derive(Clone, Debug)]
pub struct KarasevCurve<E> {
    tape: Tape,
    rows: Vec<TapeIndex>,
    state: TaylorState<Vec<E>>,
    /// Y_k per component, coefficients of powers of σ.
    coefficients: Vec<Vec<Vec<E>>>,
}

impl<E: Clone + std::fmt::Debug> KarasevCurve<E> {
    /// The curve with Y_0 = `x`.
    ///
    /// # Errors
    /// [`AlgebraError`] when the tensor divides by zero or has a variable exponent.
    pub fn new(system: &SystemFormulas, x: &[E]) -> Result<Self, AlgebraError> {
        let d = system.dimension();
        let mut tape = Tape::new();
        let variables = (0..2 * d)
            .map(|i| tape.record(&Expression::Variable(i)))
            .collect::<Result<Vec<_>, _>>()?;
        let rows = system.apply_tensor(&mut tape, &variables[..d], &variables[d..])?;
        let state = TaylorState::new(&tape);
        let coefficients = vec![x.iter().map(|value| vec![value.clone()]).collect()];
        Ok(Self {
            tape,
            rows,
            state,
            coefficients,
        })
    }

    /// Given q_k (k = 0 at the first call), computes Y_{k+1}.
    ///
    /// # Errors
    /// [`AlgebraError`] when a function of the tensor has no value at Y_0.
    pub fn push<A: Arithmetic<Element = E>>(
        &mut self,
        arithmetic: &mut A,
        q: &[E],
    ) -> Result<(), AlgebraError> {
        let k = self.coefficients.len() - 1;
        let d = q.len();
        let mut polynomials = Univariate { inner: arithmetic };
        let current = &self.coefficients[k];
        self.state
            .extend(&self.tape, &mut polynomials, |ring, index| {
                if index < d {
                    current[index].clone()
                } else if ring.inner.is_zero(&q[index - d]) {
                    Vec::new()
                } else {
                    vec![q[index - d].clone()]
                }
            })?;
        let next = self
            .rows
            .iter()
            .map(|row| zero_mean_antiderivative(arithmetic, self.state.coefficient(*row, k)))
            .collect();
        self.coefficients.push(next);
        Ok(())
    }

    /// The order of the last known Y_k.
    pub fn order(&self) -> usize {
        self.coefficients.len() - 1
    }

    /// The last known Y_k: per component its coefficients of powers of σ.
    pub fn last(&self) -> &[Vec<E>] {
        &self.coefficients[self.order()]
    }

    /// Puts other code for the same values in place of the last known Y_k.
    pub fn replace_last(&mut self, coefficients: Vec<Vec<E>>) {
        let order = self.order();
        self.coefficients[order] = coefficients;
    }

    /// α_(k) = Y_k(s = 0), k ≤ [`order`](Self::order).
    pub fn source<A: Arithmetic<Element = E>>(&self, arithmetic: &mut A, k: usize) -> Vec<E> {
        self.coefficients[k]
            .iter()
            .map(|polynomial| {
                let terms: Vec<_> = polynomial
                    .iter()
                    .enumerate()
                    .map(|(j, c)| (Rational::new(-1, 2).powi(j as i64), c.clone()))
                    .collect();
                arithmetic.combine(&terms)
            })
            .collect()
    }
}

/// V ↦ W with W′ = V and ∫_{−½}^{½} W dσ = 0.
fn zero_mean_antiderivative<A: Arithmetic>(
    arithmetic: &mut A,
    v: &[A::Element],
) -> Vec<A::Element> {
    if v.is_empty() {
        return Vec::new();
    }
    // The mean of σᵐ over [−½, ½] is 2^{−m}/(m+1) for even m and 0 for odd m.
    let mean: Vec<_> = v
        .iter()
        .enumerate()
        .filter(|(j, c)| j % 2 == 1 && !arithmetic.is_zero(c))
        .map(|(j, c)| {
            let m = j as i64 + 1;
            (
                -(Rational::new(1, 2).powi(m) * Rational::new(1, m * (m + 1))),
                c.clone(),
            )
        })
        .collect();
    let mut w = vec![arithmetic.combine(&mean)];
    for (j, c) in v.iter().enumerate() {
        w.push(arithmetic.scale(&Rational::new(1, j as i64 + 1), c));
    }
    w
}
