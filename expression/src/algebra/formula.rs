//! Elements of the ring as formulas again.

use rustc_hash::FxHashMap;

use super::Symbol;
use super::generator::{Atom, Generator};
use super::monomial::Monomial;
use super::polynomial::{Coefficient, Polynomial};
use super::ring::Ring;
use crate::expression::Expression;
use crate::rational::Rational;

impl Ring {
    /// A formula of the same value, expanded: Σ c·m. Each function, inverse or root in it is one [`Expression::Shared`].
    pub fn formula(&self, f: &Polynomial) -> Expression {
        FormulaWriter::of(self).polynomial(f)
    }

    /// A formula of the same value, of parameters alone.
    pub fn coefficient_formula(&self, c: &Coefficient) -> Expression {
        FormulaWriter::of(self).coefficient(c)
    }
}

/// Formulas of generators and atoms that are written already: a derivative names the same root in each of its terms.
struct FormulaWriter<'a> {
    ring: &'a Ring,
    generators: FxHashMap<Symbol, Expression>,
    atoms: FxHashMap<Symbol, Expression>,
}

impl<'a> FormulaWriter<'a> {
    fn of(ring: &'a Ring) -> Self {
        Self {
            ring,
            generators: FxHashMap::default(),
            atoms: FxHashMap::default(),
        }
    }

    fn polynomial(&mut self, f: &Polynomial) -> Expression {
        let terms = f.terms().iter();
        sum(terms.map(|(monomial, coefficient)| {
            let factors = powers(monomial, |symbol| self.factor(symbol));
            product(self.coefficient(coefficient), factors)
        }))
    }

    fn coefficient(&mut self, c: &Coefficient) -> Expression {
        let terms = c.terms().iter();
        sum(terms.map(|(monomial, number)| {
            let factors = powers(monomial, |symbol| self.atom(symbol));
            product(Expression::Constant(number.clone()), factors)
        }))
    }

    /// A variable, or the generator of this symbol.
    fn factor(&mut self, symbol: Symbol) -> Expression {
        if let Some(written) = self.generators.get(&symbol) {
            return written.clone();
        }
        let written = match self.ring.generator(symbol) {
            None => Expression::Variable(symbol as usize),
            Some(generator) => self.generator(generator).shared(),
        };
        self.generators.insert(symbol, written.clone());
        written
    }

    fn generator(&mut self, generator: &Generator) -> Expression {
        match generator {
            Generator::Inverse(u) => inverse(self.polynomial(u)),
            Generator::Root(u, q) => power(
                self.polynomial(u),
                Expression::Constant(Rational::new(1, i64::from(*q))),
            ),
            Generator::Power(u, a) => power(self.polynomial(u), self.coefficient(a)),
            Generator::Function(f, u) => Expression::Apply(*f, Box::new(self.polynomial(u))),
            Generator::Binary(f, u, v) => {
                Expression::Binary(*f, Box::new([u, v].map(|part| self.polynomial(part))))
            }
            Generator::Lookup(lookup, point) => {
                let point = point.iter().map(|u| self.polynomial(u));
                Expression::Lookup(*lookup, point.collect())
            }
            Generator::Kept(side, u, v) => {
                let [u, v] = [u, v].map(|part| self.polynomial(part));
                Expression::kept(*side, u, v)
            }
        }
    }

    fn atom(&mut self, symbol: Symbol) -> Expression {
        if let Some(written) = self.atoms.get(&symbol) {
            return written.clone();
        }
        let written = match self.ring.atom(symbol) {
            Atom::Parameter(index) => Expression::Parameter(*index),
            Atom::Pi => Expression::Pi,
            Atom::Inverse(c) => inverse(self.coefficient(c)),
            Atom::RationalPower(c, r) => {
                power(self.coefficient(c), Expression::Constant(r.clone()))
            }
            Atom::Power(c, d) => power(self.coefficient(c), self.coefficient(d)),
            Atom::Binary(f, c, d) => {
                let pair = [c, d].map(|part| self.coefficient(part));
                Expression::Binary(*f, Box::new(pair))
            }
            Atom::Lookup(lookup, point) => {
                let point = point.iter().map(|c| self.coefficient(c));
                Expression::Lookup(*lookup, point.collect())
            }
            Atom::Function(f, c) => Expression::Apply(*f, Box::new(self.coefficient(c))),
        };
        let written = written.shared();
        self.atoms.insert(symbol, written.clone());
        written
    }
}

fn powers(monomial: &Monomial, mut base: impl FnMut(Symbol) -> Expression) -> Vec<Expression> {
    let factors = monomial.factors().iter();
    factors
        .map(|&(symbol, exponent)| match exponent {
            1 => base(symbol),
            _ => power(
                base(symbol),
                Expression::Constant(Rational::from_integer(i64::from(exponent))),
            ),
        })
        .collect()
}

fn power(base: Expression, exponent: Expression) -> Expression {
    Expression::Power(Box::new(base), Box::new(exponent))
}

fn inverse(below: Expression) -> Expression {
    Expression::Quotient(
        Box::new(Expression::Constant(Rational::one())),
        Box::new(below),
    )
}

/// A single term stands for itself.
fn sum(terms: impl Iterator<Item = Expression>) -> Expression {
    let mut terms: Vec<Expression> = terms.collect();
    match terms.len() {
        1 => terms.remove(0),
        _ => Expression::Sum(terms),
    }
}

fn product(coefficient: Expression, mut factors: Vec<Expression>) -> Expression {
    if coefficient != Expression::Constant(Rational::one()) || factors.is_empty() {
        factors.insert(0, coefficient);
    }
    match factors.len() {
        1 => factors.remove(0),
        _ => Expression::Product(factors),
    }
}

#[cfg(test)]
mod tests {
    use crate::algebra::Ring;
    use crate::syntax::{Formula, Scope};

    /// An element's formula is read back as the element, and has the value of the text it came from.
    #[test]
    fn elements_come_back() {
        let scope = Scope::new()
            .with_variables(&["x", "y"])
            .with_parameters(&["a", "b"]);
        for text in [
            "0",
            "a",
            "x",
            "x^2/(2*a) - 3*x*y^(-2) + pi",
            "ln(x)*sin(a*y) + sqrt(x + y)/(a + b)",
            "(x + y)^b/(1 + x^2) + a^b*exp(x/b) - a^(1/3)",
        ] {
            let parsed = Formula::parse(text).expect(text);
            let written = parsed.resolve(&scope, None).expect(text).expect(text);
            let mut ring = Ring::new(2);
            let mut read = |formula: &crate::Expression| {
                let element =
                    formula.evaluate_in(&mut ring, &mut |ring: &mut Ring, i| Ok(ring.variable(i)));
                let element = element.expect("in the algebra");
                let back = ring.formula(&element);
                (element, back)
            };
            let (element, back) = read(&written);
            assert_eq!(read(&back).0, element, "{text}");
            let (x, parameters) = ([0.7, 1.9], [1.3, 0.6]);
            let (value, expected) = (
                back.evaluate(&x, &parameters),
                written.evaluate(&x, &parameters),
            );
            // A dozen roundings of terms below 10.
            assert!(
                (value - expected).abs() < 120.0 * f64::EPSILON,
                "{text}: {value}"
            );
        }
    }
}
