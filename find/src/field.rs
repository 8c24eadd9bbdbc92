//! The field f in the exact ring.

use leafwise_expression::algebra::Generator;
use leafwise_expression::{AlgebraError, Arithmetic, Function, Polynomial, Rational, Ring};

use crate::equations::Equations;
use crate::error::FindError;

/// Products of terms that one search may form.
const MOST_PRODUCTS: u64 = 1 << 26;

/// f, with the ring that it is in.
#[derive(Clone, Debug)]
pub(crate) struct RingField {
    pub ring: Ring,
    pub f: Vec<Polynomial>,
}

impl RingField {
    pub fn of(equations: &Equations) -> Result<Self, FindError> {
        let mut ring = Ring::limited(equations.variables().len(), MOST_PRODUCTS);
        let formulas = equations.field().iter().zip(equations.variables());
        let f = formulas
            .map(|(formula, variable)| {
                formula
                    .evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))
                    .map_err(|error| FindError::Equation {
                        variable: variable.clone(),
                        error,
                    })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { ring, f })
    }

    pub fn dimension(&self) -> usize {
        self.f.len()
    }

    /// ∇I · f.
    pub fn along(&mut self, integral: &Polynomial) -> Result<Polynomial, AlgebraError> {
        let gradient = self.ring.gradient(integral)?;
        Ok(dot(&mut self.ring, &gradient, &self.f))
    }

    /// The degree of f where f is a polynomial, or its largest degree in variables and functions.
    pub fn degree(&self) -> usize {
        let terms = self.f.iter().flat_map(Polynomial::terms);
        let degrees = terms.map(|(monomial, _)| {
            let factors = monomial.factors().iter();
            factors
                .map(|(_, exponent)| exponent.unsigned_abs() as usize)
                .sum()
        });
        degrees.max().unwrap_or(0)
    }

    /// Whether f_i has the factor x_i.
    pub fn has_factor(&self, i: usize) -> bool {
        let terms = self.f[i].terms().iter();
        terms.map(|(m, _)| m.exponent(i as u32)).all(|e| e >= 1)
    }

    /// f_i/x_i, where every f_i has the factor x_i.
    pub fn rates(&mut self) -> Option<Vec<Polynomial>> {
        if !(0..self.f.len()).all(|i| self.has_factor(i)) {
            return None;
        }
        let rates = self.f.iter().enumerate().map(|(i, f)| over(f, i));
        Some(rates.collect())
    }

    /// Whether products of the functions in f are linearly independent. These are at most one of exp u, ln u, or sin u and cos u, of a
    /// polynomial u. A linear system without a solution then proves that there is none.
    pub fn is_decided(&self) -> bool {
        let mut argument = None;
        let symbols = self.f.iter().flat_map(|f| f.symbols());
        for symbol in symbols {
            let Some(generator) = self.ring.generator(symbol) else {
                continue;
            };
            let is_simple = matches!(
                generator,
                Generator::Function(
                    Function::Exp | Function::Ln | Function::Sin | Function::Cos,
                    _
                )
            );
            let u = generator.argument();
            let is_polynomial = u.terms().iter().all(|(m, _)| {
                let mut factors = m.factors().iter();
                factors.all(|&(s, e)| e > 0 && (s as usize) < self.f.len())
            });
            let kind = match generator {
                Generator::Function(Function::Sin | Function::Cos, _) => 0,
                Generator::Function(Function::Exp, _) => 1,
                _ => 2,
            };
            if !is_simple || !is_polynomial {
                return false;
            }
            if *argument.get_or_insert((kind, u)) != (kind, u) {
                return false;
            }
        }
        let mut coefficients = self.f.iter().flat_map(Polynomial::terms).map(|(_, c)| c);
        coefficients.all(|c| c.as_constant().is_some())
    }
}

/// Σ aᵢ bᵢ.
pub(crate) fn dot(ring: &mut Ring, a: &[Polynomial], b: &[Polynomial]) -> Polynomial {
    let products: Vec<_> = (a.iter().zip(b))
        .map(|(a, b)| (Rational::one(), a, b))
        .collect();
    ring.sum_of_products(&products)
}

/// f/x_i.
pub(crate) fn over(f: &Polynomial, i: usize) -> Polynomial {
    use leafwise_expression::algebra::{Coefficient, CoefficientRing, Monomial};
    let one = Coefficient::from_rational(&Rational::one());
    f.times_term(&Monomial::power(i as u32, -1), &one)
}
