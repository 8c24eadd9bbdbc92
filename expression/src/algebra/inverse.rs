//! Inverses: of coefficients, of monomials, and of polynomials as generators.

use super::generator::{Atom, Generator};
use super::monomial::{Monomial, Symbol};
use super::polynomial::{Coefficient, CoefficientRing, Polynomial};
use super::ring::Ring;
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::expression::Function;
use crate::rational::Rational;

impl Ring {
    /// 1/c in the field of the parameters.
    pub(super) fn coefficient_inverse(
        &mut self,
        c: &Coefficient,
    ) -> Result<Coefficient, AlgebraError> {
        match c.terms() {
            [] => Err(AlgebraError::DivisionByZero),
            [(m, r)] => Ok(Coefficient::term(m.inverse(), r.recip())),
            _ => Ok(self.atom_symbol(Atom::Inverse(c.clone()))),
        }
    }

    /// 1/f: an inverse monomial, or a Laurent monomial times an adjoined inverse of a primitive
    /// polynomial, its powers ≥ 0, with leading coefficient 1.
    pub(super) fn inverse(&mut self, f: &Polynomial) -> Result<Polynomial, AlgebraError> {
        self.unless_refused(())?;
        let content = f.content();
        let Some((leading, coefficient)) = f.leading() else {
            return Err(AlgebraError::DivisionByZero);
        };
        let unit = self.coefficient_inverse(coefficient)?;
        let outer = self.inverse_monomial(&content, unit.clone())?;
        if f.terms().len() == 1 {
            return self.unless_refused(outer);
        }
        // The leading coefficient is 1 by construction; where the parameters' inverse is an opaque
        // constant the product does not collapse by itself, so it is set.
        let below = content.inverse();
        let leading = leading.multiply(&below);
        let scaled = self.times_term(f, &below, &unit);
        let others = scaled.terms().iter().filter(|(m, _)| *m != leading);
        let primitive = Polynomial::collect(others.cloned().chain([(leading.clone(), one())]));
        let inverse = Polynomial::symbol(self.adjoin(Generator::Inverse(primitive)));
        let inverse = self.multiply(&outer, &inverse);
        self.unless_refused(inverse)
    }

    /// unit / content, where factors that are roots, inverses, cosines or hyperbolic cosines go
    /// through their relations rather than to negative exponents.
    pub(super) fn inverse_monomial(
        &mut self,
        content: &Monomial,
        unit: Coefficient,
    ) -> Result<Polynomial, AlgebraError> {
        let mut plain = Monomial::one();
        let mut factors = Vec::new();
        for &(symbol, exponent) in content.factors() {
            match self.generator(symbol).cloned() {
                Some(Generator::Root(u, q)) => {
                    // 1/g^e = g^(q−e)/u.
                    let below = self.inverse(&u)?;
                    let above =
                        Polynomial::term(Monomial::power(symbol, i32::from(q) - exponent), one());
                    factors.push(self.multiply(&above, &below));
                }
                Some(Generator::Inverse(u)) => {
                    factors.push(self.integer_power(&u, exponent.into())?);
                }
                Some(Generator::Function(Function::Cos | Function::Cosh, _)) => {
                    let base = Polynomial::symbol(symbol);
                    // A single cosine: 1/cos is adjoined as a generator of its own.
                    let inverse = Polynomial::symbol(self.adjoin(Generator::Inverse(base)));
                    factors.push(self.integer_power(&inverse, exponent.into())?);
                }
                Some(Generator::Kept(..)) => {
                    // 1/g has no value where g is 0, which it is on one side: it cancels nothing.
                    let base = Polynomial::symbol(symbol);
                    let minus = Coefficient::from_rational(&Rational::from_integer(-1));
                    let inverse = Polynomial::symbol(self.adjoin(Generator::Power(base, minus)));
                    factors.push(self.integer_power(&inverse, exponent.into())?);
                }
                _ => plain = plain.shifted(symbol, -exponent),
            }
        }
        let mut result = Polynomial::term(plain, unit);
        for factor in factors {
            result = self.multiply(&result, &factor);
        }
        Ok(result)
    }
}

/// A product as two: of the powers that have a value everywhere, and of the others.
pub(super) fn split(
    product: &Monomial,
    is_everywhere: impl Fn(Symbol) -> bool,
) -> (Monomial, Monomial) {
    let (mut outside, mut inside) = (Monomial::one(), Monomial::one());
    for &(symbol, exponent) in product.factors() {
        let part = if exponent > 0 && is_everywhere(symbol) {
            &mut outside
        } else {
            &mut inside
        };
        *part = part.shifted(symbol, exponent);
    }
    (outside, inside)
}

pub(super) fn one() -> Coefficient {
    Coefficient::from_rational(&Rational::one())
}

/// Whether the leading term's leading rational coefficient is negative: the sign that odd and even
/// functions pull out of their argument.
pub(super) fn has_negative_lead(f: &Polynomial) -> bool {
    f.terms()
        .last()
        .and_then(|(_, c)| c.terms().last())
        .is_some_and(|(_, r)| r.is_negative())
}
