//! Derivatives of polynomials, and of the generators adjoined to them.

use super::generator::Generator;
use super::monomial::{Monomial, Symbol};
use super::polynomial::{Coefficient, Polynomial};
use super::ring::Ring;
use crate::arithmetic::{AlgebraError, Arithmetic, binary_derivative, function_derivative};
use crate::rational::Rational;

impl Ring {
    /// ∂f/∂x_v.
    ///
    /// # Errors
    /// [`AlgebraError`] when a generator's derivative does not exist, such as that of 1/0, or past a
    /// limit of the ring.
    pub fn derivative(
        &mut self,
        f: &Polynomial,
        variable: usize,
    ) -> Result<Polynomial, AlgebraError> {
        let mut parts = Vec::new();
        let mut plain = Vec::new();
        for (monomial, coefficient) in f.terms() {
            for &(symbol, exponent) in monomial.factors() {
                let rest = || monomial.shifted(symbol, -1);
                let factor = || coefficient.scaled(&Rational::from_integer(exponent.into()));
                if symbol as usize == variable {
                    plain.push((rest(), factor()));
                } else if (symbol as usize)
                    .checked_sub(self.variables)
                    .is_some_and(|at| self.reaches[at].may_contain(variable as u32))
                {
                    let inner = self.generator_derivative(symbol, variable)?;
                    if !inner.is_zero() {
                        self.spend(inner.terms().len());
                        parts.push((Rational::one(), self.times_term(&inner, &rest(), &factor())));
                    }
                }
            }
        }
        let mut sum = Polynomial::sorted(plain);
        if !parts.is_empty() {
            parts.push((Rational::one(), sum));
            sum = self.combine(&parts);
        }
        let sum = self.normalize(sum);
        self.unless_refused(sum)
    }

    /// f·(c·m), 0 after a refusal.
    pub(super) fn times_term(
        &mut self,
        f: &Polynomial,
        m: &Monomial,
        c: &Coefficient,
    ) -> Polynomial {
        let exponent = f.largest_exponent() + m.largest_exponent().max(c.largest_exponent());
        if !self.admits(exponent) {
            return Polynomial::zero();
        }
        f.times_term(m, c)
    }

    /// ∇f.
    ///
    /// # Errors
    /// Those of [`Ring::derivative`].
    pub fn gradient(&mut self, f: &Polynomial) -> Result<Vec<Polynomial>, AlgebraError> {
        (0..self.variables).map(|v| self.derivative(f, v)).collect()
    }

    pub(super) fn generator_derivative(
        &mut self,
        symbol: Symbol,
        variable: usize,
    ) -> Result<Polynomial, AlgebraError> {
        if let Some(known) = self.derivatives.get(&(symbol, variable)) {
            return Ok(known.clone());
        }
        let generator = self.generators[symbol as usize - self.variables].clone();
        if let Generator::Kept(side, u, v) = &generator {
            let inner = self.derivative(v, variable)?;
            let result = self.kept(*side, u, &inner)?;
            self.derivatives.insert((symbol, variable), result.clone());
            return Ok(result);
        }
        if let Generator::Binary(function, u, v) = &generator {
            let mut parts = Vec::with_capacity(2);
            for (by, argument) in [u, v].into_iter().enumerate() {
                let inner = self.derivative(argument, variable)?;
                if !inner.is_zero() {
                    let outer = binary_derivative(self, *function, [u, v], by)?;
                    parts.push((Rational::one(), self.multiply(&outer, &inner)));
                }
            }
            let result = self.combine(&parts);
            self.derivatives.insert((symbol, variable), result.clone());
            return Ok(result);
        }
        if let Generator::Lookup(lookup, point) = &generator {
            let mut sum = Vec::with_capacity(point.len());
            for (axis, u) in point.iter().enumerate() {
                let inner = self.derivative(u, variable)?;
                if let Some(slope) = lookup.derivative(axis).filter(|_| !inner.is_zero()) {
                    let outer = self.look_up(slope, point)?;
                    sum.push((Rational::one(), self.multiply(&outer, &inner)));
                }
            }
            let result = self.combine(&sum);
            self.derivatives.insert((symbol, variable), result.clone());
            return Ok(result);
        }
        let inner = self.derivative(generator.argument(), variable)?;
        let result = if inner.is_zero() {
            Polynomial::zero()
        } else {
            let g = Polynomial::symbol(symbol);
            let outer = match &generator {
                Generator::Inverse(_) => {
                    let square = self.multiply(&g, &g);
                    self.negate(&square)
                }
                Generator::Root(u, q) => {
                    let quotient = self.divide(&g, u)?;
                    self.scale(&Rational::new(1, i64::from(*q)), &quotient)
                }
                Generator::Power(u, exponent) => {
                    let quotient = self.divide(&g, u)?;
                    quotient.times_term(&Monomial::one(), exponent)
                }
                Generator::Function(function, u) => function_derivative(self, *function, u, &g)?,
                // Differentiated above.
                Generator::Kept(..) | Generator::Binary(..) | Generator::Lookup(..) => {
                    Polynomial::zero()
                }
            };
            self.multiply(&outer, &inner)
        };
        self.derivatives.insert((symbol, variable), result.clone());
        Ok(result)
    }
}
