//! One formula, any algebra.

use crate::arithmetic::{AlgebraError, Arithmetic, MOST_FACTORS};
use crate::expression::Expression;
use crate::rational::Rational;

/// What stands for the variable xᵢ in an algebra.
pub type VariableIn<'a, A> =
    dyn FnMut(&mut A, usize) -> Result<<A as Arithmetic>::Element, AlgebraError> + 'a;

impl Expression {
    /// The formula's value in `arithmetic`, with `variable(arithmetic, i)` for the variable xᵢ.
    ///
    /// # Errors
    /// [`AlgebraError`] where an operation has no result.
    pub fn evaluate_in<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        variable: &mut VariableIn<'_, A>,
    ) -> Result<A::Element, AlgebraError> {
        match self {
            Self::Constant(value) => Ok(arithmetic.constant(value)),
            Self::Pi => Ok(arithmetic.pi()),
            Self::Variable(index) => variable(arithmetic, *index),
            Self::Parameter(index) => Ok(arithmetic.parameter(*index)),
            Self::Sum(parts) => {
                let mut terms = Vec::with_capacity(parts.len());
                for part in parts {
                    let (sign, part) = part.split_sign();
                    terms.push((sign, part.evaluate_in(arithmetic, variable)?));
                }
                Ok(arithmetic.combine(&terms))
            }
            Self::Product(factors) if factors.len() > MOST_FACTORS => {
                Err(AlgebraError::TooManyFactors)
            }
            Self::Product(factors) => {
                let mut product = arithmetic.one();
                for factor in factors {
                    let factor = factor.evaluate_in(arithmetic, variable)?;
                    product = arithmetic.multiply(&product, &factor);
                    if let Some(refusal) = arithmetic.refusal() {
                        return Err(refusal.clone());
                    }
                }
                Ok(product)
            }
            Self::Negate(inner) => {
                let inner = inner.evaluate_in(arithmetic, variable)?;
                Ok(arithmetic.negate(&inner))
            }
            Self::Quotient(above, below) => {
                let above = above.evaluate_in(arithmetic, variable)?;
                let below = below.evaluate_in(arithmetic, variable)?;
                arithmetic.divide(&above, &below)
            }
            Self::Power(base, exponent) => {
                let base = base.evaluate_in(arithmetic, variable)?;
                let exponent = exponent.evaluate_in(arithmetic, variable)?;
                match arithmetic.as_rational(&exponent) {
                    Some(constant) if constant.is_integer() => {
                        let integer =
                            constant
                                .to_i64()
                                .ok_or_else(|| AlgebraError::ExponentTooLarge {
                                    exponent: constant.to_string(),
                                })?;
                        arithmetic.integer_power(&base, integer)
                    }
                    _ => arithmetic.power(&base, &exponent),
                }
            }
            Self::Apply(function, argument) => {
                let argument = argument.evaluate_in(arithmetic, variable)?;
                arithmetic.apply(*function, &argument)
            }
        }
    }

    fn split_sign(&self) -> (Rational, &Self) {
        match self {
            Self::Negate(inner) => (-Rational::one(), inner),
            other => (Rational::one(), other),
        }
    }
}
