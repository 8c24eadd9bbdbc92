//! The ring as an algebra in which formulas are evaluated.

use super::generator::{Atom, Generator};
use super::inverse::{has_negative_lead, one, split};
use super::monomial::{Monomial, Symbol};
use super::packed;
use super::polynomial::{Coefficient, CoefficientRing, Polynomial};
use super::ring::Ring;
use crate::arithmetic::{AlgebraError, Arithmetic, simple_value, simple_value_of_two};
use crate::expression::{Binary, Function, Side};
use crate::function::Parity;
use crate::rational::Rational;
use crate::table::Lookup;

impl Ring {
    /// Whether a symbol has a value at every state.
    pub(super) fn is_everywhere(&self, symbol: Symbol) -> bool {
        let generator = (symbol as usize).checked_sub(self.variables);
        generator.is_none_or(|at| self.are_everywhere[at])
    }

    /// Whether a constant has a value whatever the parameters are.
    pub(super) fn is_plain(&self, atom: Symbol) -> bool {
        matches!(self.atom(atom), Atom::Parameter(_) | Atom::Pi)
    }

    /// Whether a generator has a value at every state: 1 on a side of what has one.
    pub(super) fn has_value_everywhere(&self, generator: &Generator) -> bool {
        let Generator::Kept(_, c, value) = generator else {
            return false;
        };
        let mut factors = c.terms().iter().flat_map(|(m, _)| m.factors());
        let constants = c.terms().iter().flat_map(|(_, c)| c.terms());
        let mut atoms = constants.flat_map(|(m, _)| m.factors());
        *value == Polynomial::constant(one())
            && factors.all(|&(symbol, exponent)| exponent > 0 && self.is_everywhere(symbol))
            && atoms.all(|&(atom, exponent)| exponent > 0 && self.is_plain(atom))
    }

    /// v where c is of this side, of a v that stands behind the seam as a whole.
    pub(super) fn kept_inside(&mut self, side: Side, c: &Polynomial, v: Polynomial) -> Polynomial {
        let one = Polynomial::constant(one());
        if v == one && side == Side::Below {
            // 1 − g of the other side.
            let above = self.adjoin(Generator::Kept(Side::Above, c.clone(), one.clone()));
            return self.subtract(&one, &Polynomial::symbol(above));
        }
        Polynomial::symbol(self.adjoin(Generator::Kept(side, c.clone(), v)))
    }

    pub(super) fn constant_function(
        &mut self,
        function: Function,
        c: &Coefficient,
    ) -> Result<Coefficient, AlgebraError> {
        if let Some(value) = c.as_constant() {
            let is_outside = match function {
                Function::Ln | Function::Log10 | Function::Log2 | Function::Sqrt => {
                    value.is_negative()
                }
                _ => false,
            };
            if is_outside {
                return Err(AlgebraError::OutsideDomain {
                    function: function.name(),
                    argument: value.to_string(),
                });
            }
            if let Some(simple) = simple_value(function, &value)? {
                return Ok(Coefficient::constant(simple));
            }
        }
        if function == Function::Sqrt {
            return Ok(self.atom_symbol(Atom::RationalPower(c.clone(), Rational::new(1, 2))));
        }
        Ok(self.atom_symbol(Atom::Function(function, c.clone())))
    }

    pub(super) fn rational_power(
        &mut self,
        f: &Polynomial,
        exponent: &Rational,
    ) -> Result<Polynomial, AlgebraError> {
        if let Some(integer) = exponent.to_i64() {
            return self.integer_power(f, integer);
        }
        let too_large = || AlgebraError::ExponentTooLarge {
            exponent: exponent.to_string(),
        };
        if f.is_zero() {
            return if exponent.is_negative() {
                Err(AlgebraError::DivisionByZero)
            } else {
                Ok(Polynomial::zero())
            };
        }
        if let Some(c) = f.as_constant() {
            let atom = self.atom_symbol(Atom::RationalPower(c, exponent.clone()));
            return Ok(Polynomial::constant(atom));
        }
        let q = i64::try_from(exponent.denominator()).map_err(|_| too_large())?;
        let p = i64::try_from(exponent.numerator()).map_err(|_| too_large())?;
        if q > 4096 {
            return Err(too_large());
        }
        // f^(p/q) = f^w g^r with p = w q + r, 0 ≤ r < q.
        let (whole, rest) = (p.div_euclid(q), p.rem_euclid(q));
        let root = self.adjoin(Generator::Root(f.clone(), q as u16));
        let integer = self.integer_power(f, whole)?;
        let fraction = Polynomial::term(Monomial::power(root, rest as i32), one());
        let power = self.multiply(&integer, &fraction);
        self.unless_refused(power)
    }
}

impl Arithmetic for Ring {
    type Element = Polynomial;

    fn constant(&mut self, value: &Rational) -> Polynomial {
        Polynomial::constant(Coefficient::from_rational(value))
    }

    fn pi(&mut self) -> Polynomial {
        Polynomial::constant(self.atom_symbol(Atom::Pi))
    }

    fn parameter(&mut self, index: usize) -> Polynomial {
        Polynomial::constant(self.atom_symbol(Atom::Parameter(index)))
    }

    fn is_zero(&self, element: &Polynomial) -> bool {
        element.is_zero()
    }

    fn refusal(&self) -> Option<&AlgebraError> {
        self.refusal.as_ref()
    }

    fn as_rational(&self, element: &Polynomial) -> Option<Rational> {
        element.as_constant().and_then(|c| c.as_constant())
    }

    fn is_expanded(&self) -> bool {
        true
    }

    fn combine(&mut self, terms: &[(Rational, Polynomial)]) -> Polynomial {
        let one = Polynomial::constant(one());
        let products: Vec<_> = terms.iter().map(|(c, f)| (c.clone(), f, &one)).collect();
        packed::sum_of_products(&products).unwrap_or_else(|| Polynomial::combine(terms))
    }

    fn multiply(&mut self, a: &Polynomial, b: &Polynomial) -> Polynomial {
        self.sum_of_products(&[(Rational::one(), a, b)])
    }

    fn sum_of_products(&mut self, terms: &[(Rational, &Polynomial, &Polynomial)]) -> Polynomial {
        for (_, a, b) in terms {
            let may = self.admits(a.largest_exponent() + b.largest_exponent());
            if !may || !self.spend(a.terms().len() * b.terms().len()) {
                return Polynomial::zero();
            }
        }
        let sum = packed::sum_of_products(terms).unwrap_or_else(|| {
            let products = terms.iter().map(|(c, a, b)| (c.clone(), a.product(b)));
            Polynomial::combine(&products.collect::<Vec<_>>())
        });
        self.normalize(sum)
    }

    fn divide(&mut self, a: &Polynomial, b: &Polynomial) -> Result<Polynomial, AlgebraError> {
        let inverse = self.inverse(b)?;
        let quotient = self.multiply(a, &inverse);
        self.unless_refused(quotient)
    }

    fn power(&mut self, a: &Polynomial, b: &Polynomial) -> Result<Polynomial, AlgebraError> {
        let exponent = b.as_constant().ok_or(AlgebraError::VariableExponent)?;
        if let Some(rational) = exponent.as_constant() {
            return self.rational_power(a, &rational);
        }
        // a^(c + k) = a^c a^k for the integer part k of the exponent's rational term.
        let whole = exponent
            .terms()
            .iter()
            .find(|(m, _)| m.is_one())
            .and_then(|(_, r)| if r.is_integer() { r.to_i64() } else { None })
            .unwrap_or(0);
        let fraction = Coefficient::combine(&[
            (Rational::one(), exponent),
            (Rational::from_integer(-whole), one()),
        ]);
        let integer = self.integer_power(a, whole)?;
        let power = match a.as_constant() {
            Some(c) => Polynomial::constant(self.atom_symbol(Atom::Power(c, fraction))),
            None => Polynomial::symbol(self.adjoin(Generator::Power(a.clone(), fraction))),
        };
        let power = self.multiply(&integer, &power);
        self.unless_refused(power)
    }

    fn apply_two(
        &mut self,
        function: Binary,
        a: &Polynomial,
        b: &Polynomial,
    ) -> Result<Polynomial, AlgebraError> {
        if let (Some(x), Some(y)) = (self.as_rational(a), self.as_rational(b))
            && let Some(simple) = simple_value_of_two(function, &x, &y)?
        {
            return Ok(self.constant(&simple));
        }
        if let (Some(c), Some(d)) = (a.as_constant(), b.as_constant()) {
            return Ok(Polynomial::constant(
                self.atom_symbol(Atom::Binary(function, c, d)),
            ));
        }
        let generator = Generator::Binary(function, a.clone(), b.clone());
        Ok(Polynomial::symbol(self.adjoin(generator)))
    }
    fn look_up(
        &mut self,
        lookup: Lookup,
        point: &[Polynomial],
    ) -> Result<Polynomial, AlgebraError> {
        let constants: Option<Vec<_>> = point.iter().map(Polynomial::as_constant).collect();
        Ok(match constants {
            Some(point) => Polynomial::constant(self.atom_symbol(Atom::Lookup(lookup, point))),
            None => Polynomial::symbol(self.adjoin(Generator::Lookup(lookup, point.to_vec()))),
        })
    }

    /// Linear in v, whose factors that have a value everywhere stand outside.
    fn kept(
        &mut self,
        side: Side,
        c: &Polynomial,
        v: &Polynomial,
    ) -> Result<Polynomial, AlgebraError> {
        if let Some(number) = self.as_rational(c) {
            return Ok(match side.has(&number) {
                true => v.clone(),
                false => Polynomial::zero(),
            });
        }
        let mut parts = Vec::with_capacity(v.terms().len());
        for (monomial, coefficient) in v.terms() {
            let (outside, inside) = split(monomial, |symbol| self.is_everywhere(symbol));
            for (constants, number) in coefficient.terms() {
                let (known, unsure) = split(constants, |symbol| self.is_plain(symbol));
                let outside =
                    Polynomial::term(outside.clone(), Coefficient::term(known, number.clone()));
                let inside =
                    Polynomial::term(inside.clone(), Coefficient::term(unsure, Rational::one()));
                let part = self.kept_inside(side, c, inside);
                parts.push((Rational::one(), self.multiply(&outside, &part)));
            }
        }
        let sum = self.combine(&parts);
        self.unless_refused(sum)
    }

    fn apply(&mut self, function: Function, a: &Polynomial) -> Result<Polynomial, AlgebraError> {
        if let Some(c) = a.as_constant() {
            return Ok(Polynomial::constant(self.constant_function(function, &c)?));
        }
        if function == Function::Sqrt {
            return self.rational_power(a, &Rational::new(1, 2));
        }
        let parity = function.parity();
        if (parity.is_some() || function == Function::Exp) && has_negative_lead(a) {
            let positive = a.scaled(&-Rational::one());
            let value = self.apply(function, &positive)?;
            return match parity {
                Some(Parity::Even) => Ok(value),
                Some(Parity::Odd) => Ok(self.negate(&value)),
                None => self.inverse(&value),
            };
        }
        // The partner of a cosine stands in its relation.
        match function {
            Function::Cos => drop(self.adjoin(Generator::Function(Function::Sin, a.clone()))),
            Function::Cosh => drop(self.adjoin(Generator::Function(Function::Sinh, a.clone()))),
            _ => {}
        }
        Ok(Polynomial::symbol(
            self.adjoin(Generator::Function(function, a.clone())),
        ))
    }
}
