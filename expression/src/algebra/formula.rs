//! Elements of the ring as formulas again.

use super::generator::{Atom, Generator};
use super::monomial::Monomial;
use super::polynomial::{Coefficient, Polynomial};
use super::ring::Ring;
use crate::expression::Expression;
use crate::rational::Rational;

impl Ring {
    /// A formula of the same value, expanded: Σ c·m.
    pub fn formula(&self, f: &Polynomial) -> Expression {
        let terms = f.terms().iter();
        sum(terms.map(|(monomial, coefficient)| {
            let factors = powers(monomial, |symbol| match self.generator(symbol) {
                None => Expression::Variable(symbol as usize),
                Some(generator) => self.generator_formula(generator),
            });
            product(self.coefficient_formula(coefficient), factors)
        }))
    }

    /// A formula of the same value, of parameters alone.
    pub fn coefficient_formula(&self, c: &Coefficient) -> Expression {
        let terms = c.terms().iter();
        sum(terms.map(|(monomial, number)| {
            let factors = powers(monomial, |symbol| self.atom_formula(self.atom(symbol)));
            product(Expression::Constant(number.clone()), factors)
        }))
    }

    fn generator_formula(&self, generator: &Generator) -> Expression {
        match generator {
            Generator::Inverse(u) => inverse(self.formula(u)),
            Generator::Root(u, q) => power(
                self.formula(u),
                Expression::Constant(Rational::new(1, i64::from(*q))),
            ),
            Generator::Power(u, a) => power(self.formula(u), self.coefficient_formula(a)),
            Generator::Function(f, u) => Expression::Apply(*f, Box::new(self.formula(u))),
            Generator::Binary(f, u, v) => {
                Expression::Binary(*f, Box::new([self.formula(u), self.formula(v)]))
            }
            Generator::Lookup(lookup, point) => {
                let point = point.iter().map(|u| self.formula(u));
                Expression::Lookup(*lookup, point.collect())
            }
            Generator::Kept(side, u, v) => {
                Expression::kept(*side, self.formula(u), self.formula(v))
            }
        }
    }

    fn atom_formula(&self, atom: &Atom) -> Expression {
        match atom {
            Atom::Parameter(index) => Expression::Parameter(*index),
            Atom::Pi => Expression::Pi,
            Atom::Inverse(c) => inverse(self.coefficient_formula(c)),
            Atom::RationalPower(c, r) => {
                power(self.coefficient_formula(c), Expression::Constant(r.clone()))
            }
            Atom::Power(c, d) => power(self.coefficient_formula(c), self.coefficient_formula(d)),
            Atom::Binary(f, c, d) => {
                let pair = [c, d].map(|part| self.coefficient_formula(part));
                Expression::Binary(*f, Box::new(pair))
            }
            Atom::Lookup(lookup, point) => {
                let point = point.iter().map(|c| self.coefficient_formula(c));
                Expression::Lookup(*lookup, point.collect())
            }
            Atom::Function(f, c) => Expression::Apply(*f, Box::new(self.coefficient_formula(c))),
        }
    }
}

fn powers(monomial: &Monomial, base: impl Fn(super::Symbol) -> Expression) -> Vec<Expression> {
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
