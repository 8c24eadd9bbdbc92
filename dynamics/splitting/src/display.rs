//! Elements of the ring as formulas.

use leafwise_core::SystemFormulas;
use leafwise_expression::algebra::{Atom, Coefficient, Generator, Monomial, Polynomial, Symbol};
use leafwise_expression::{Rational, Ring, Side};

/// The names of a system's variables and parameters.
pub(crate) struct Names<'a> {
    pub(crate) system: &'a SystemFormulas,
    pub(crate) ring: &'a Ring,
}

impl Names<'_> {
    /// A polynomial of the state.
    pub(crate) fn polynomial(&self, f: &Polynomial) -> String {
        sum(f.terms().iter().map(|(monomial, coefficient)| {
            let (mut above, mut below) = self.factors(monomial, &|s| self.symbol(s));
            let number = match coefficient.terms() {
                [(constants, number)] => {
                    let (more_above, more_below) = self.factors(constants, &|s| self.constant(s));
                    above.splice(0..0, more_above);
                    below.splice(0..0, more_below);
                    number.clone()
                }
                _ => {
                    above.insert(0, format!("({})", self.coefficient(coefficient)));
                    Rational::one()
                }
            };
            product(&number, above, below)
        }))
    }

    fn coefficient(&self, c: &Coefficient) -> String {
        sum(c.terms().iter().map(|(monomial, number)| {
            let (above, below) = self.factors(monomial, &|s| self.constant(s));
            product(number, above, below)
        }))
    }

    fn factors(
        &self,
        monomial: &Monomial,
        name: &dyn Fn(Symbol) -> String,
    ) -> (Vec<String>, Vec<String>) {
        let (mut above, mut below) = (Vec::new(), Vec::new());
        for &(symbol, exponent) in monomial.factors() {
            let side = if exponent > 0 { &mut above } else { &mut below };
            side.push(match exponent.unsigned_abs() {
                1 => name(symbol),
                power => format!("{}^{power}", name(symbol)),
            });
        }
        (above, below)
    }

    fn symbol(&self, symbol: Symbol) -> String {
        match self.ring.generator(symbol) {
            None => self.system.variables()[symbol as usize].clone(),
            Some(Generator::Inverse(u)) => format!("(1/({}))", self.polynomial(u)),
            Some(Generator::Root(u, q)) => format!("({})^(1/{q})", self.polynomial(u)),
            Some(Generator::Power(u, exponent)) => {
                format!("({})^({})", self.polynomial(u), self.coefficient(exponent))
            }
            Some(Generator::Function(function, u)) => function.called(&self.polynomial(u)),
            Some(Generator::Binary(function, u, v)) => {
                let [u, v] = [u, v].map(|part| self.polynomial(part));
                format!("{}({u}, {v})", function.name())
            }
            Some(Generator::Lookup(lookup, point)) => {
                lookup.called(point.iter().map(|u| self.polynomial(u)))
            }
            Some(Generator::Kept(side, u, v)) => {
                let sign = match side {
                    Side::Above => ">",
                    Side::Below => "<=",
                };
                let [u, v] = [u, v].map(|part| self.polynomial(part));
                format!("if({u} {sign} 0, {v}, 0)")
            }
        }
    }

    fn constant(&self, symbol: Symbol) -> String {
        match self.ring.atom(symbol) {
            Atom::Parameter(index) => self.system.parameters()[*index].name.clone(),
            Atom::Pi => "pi".to_owned(),
            Atom::Inverse(c) => format!("(1/({}))", self.coefficient(c)),
            Atom::RationalPower(c, exponent) => format!("({})^({exponent})", self.coefficient(c)),
            Atom::Power(c, exponent) => {
                format!("({})^({})", self.coefficient(c), self.coefficient(exponent))
            }
            Atom::Binary(function, c, d) => {
                let [c, d] = [c, d].map(|part| self.coefficient(part));
                format!("{}({c}, {d})", function.name())
            }
            Atom::Lookup(lookup, point) => lookup.called(point.iter().map(|c| self.coefficient(c))),
            Atom::Function(function, c) => format!("{function}({})", self.coefficient(c)),
        }
    }
}

/// number·Π above/Π below.
fn product(number: &Rational, mut above: Vec<String>, mut below: Vec<String>) -> String {
    let size = number.abs();
    let (numerator, denominator) = (size.numerator().to_string(), size.denominator().to_string());
    if numerator != "1" || above.is_empty() {
        above.insert(0, numerator);
    }
    if denominator != "1" {
        below.insert(0, denominator);
    }
    let sign = if number.is_negative() { "-" } else { "" };
    let above = above.join("*");
    match below.as_slice() {
        [] => format!("{sign}{above}"),
        [single] => format!("{sign}{above}/{single}"),
        several => format!("{sign}{above}/({})", several.join("*")),
    }
}

fn sum(terms: impl Iterator<Item = String>) -> String {
    let text = terms.collect::<Vec<_>>().join(" + ").replace("+ -", "- ");
    if text.is_empty() {
        "0".to_owned()
    } else {
        text
    }
}
