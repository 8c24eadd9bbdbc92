//! One formula, any algebra.

use crate::arithmetic::{AlgebraError, Arithmetic, MOST_FACTORS};
use crate::expression::{Expression, Side};
use crate::rational::Rational;
use crate::shared::Known;

/// Element of an algebra that stands for the variable xᵢ, as a function of the algebra and i.
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
        self.value_in(arithmetic, variable, &mut Known::default())
    }

    fn value_in<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        variable: &mut VariableIn<'_, A>,
        known: &mut Known<Self, A::Element>,
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
                    terms.push((sign, part.value_in(arithmetic, variable, known)?));
                }
                Ok(arithmetic.combine(&terms))
            }
            Self::Product(factors) if factors.len() > MOST_FACTORS => {
                Err(AlgebraError::TooManyFactors)
            }
            Self::Product(factors) => {
                let mut product = arithmetic.one();
                for factor in factors {
                    let factor = factor.value_in(arithmetic, variable, known)?;
                    product = arithmetic.multiply(&product, &factor);
                    if let Some(refusal) = arithmetic.refusal() {
                        return Err(refusal.clone());
                    }
                }
                Ok(product)
            }
            Self::Negate(inner) => {
                let inner = inner.value_in(arithmetic, variable, known)?;
                Ok(arithmetic.negate(&inner))
            }
            Self::Quotient(above, below) => {
                let above = above.value_in(arithmetic, variable, known)?;
                let below = below.value_in(arithmetic, variable, known)?;
                arithmetic.divide(&above, &below)
            }
            Self::Power(base, exponent) => {
                let base = base.value_in(arithmetic, variable, known)?;
                let exponent = exponent.value_in(arithmetic, variable, known)?;
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
                let argument = argument.value_in(arithmetic, variable, known)?;
                arithmetic.apply(*function, &argument)
            }
            Self::Binary(function, pair) => {
                let [a, b] = &**pair;
                let a = a.value_in(arithmetic, variable, known)?;
                let b = b.value_in(arithmetic, variable, known)?;
                arithmetic.apply_two(*function, &a, &b)
            }
            Self::Lookup(lookup, point) => {
                let mut elements = Vec::with_capacity(point.len());
                for part in point {
                    elements.push(part.value_in(arithmetic, variable, known)?);
                }
                arithmetic.look_up(*lookup, &elements)
            }
            Self::Where(parts) => {
                let [c, a, b] = &**parts;
                let c = c.value_in(arithmetic, variable, known)?;
                let mut sum = Vec::with_capacity(2);
                for (side, part) in [(Side::Above, a), (Side::Below, b)] {
                    let value = part.value_in(arithmetic, variable, known)?;
                    sum.push((Rational::one(), arithmetic.kept(side, &c, &value)?));
                }
                Ok(arithmetic.combine(&sum))
            }
            Self::Shared(shared) => {
                if let Some(value) = known.get(shared) {
                    return Ok(value);
                }
                let value = shared.value_in(arithmetic, variable, known)?;
                known.insert(shared, value.clone());
                Ok(value)
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
