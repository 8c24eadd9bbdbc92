//! Normal forms: the generators' relations as rewriting rules.

use super::generator::Generator;
use super::monomial::Monomial;
use super::polynomial::{Coefficient, CoefficientRing, Polynomial};
use super::ring::Ring;
use crate::expression::Function;
use crate::rational::Rational;

impl Ring {
    /// The normal form under the generators' relations.
    pub(super) fn normalize(&mut self, mut f: Polynomial) -> Polynomial {
        if !self.has_relations {
            return f;
        }
        loop {
            let mut settled = Vec::new();
            let mut rewritten = Vec::new();
            for (monomial, coefficient) in f.terms() {
                match self.rewrite(monomial) {
                    None => settled.push((monomial.clone(), coefficient.clone())),
                    Some(replacement) => {
                        let one = Monomial::one();
                        rewritten.push(self.times_term(&replacement, &one, coefficient));
                    }
                }
            }
            if rewritten.is_empty() {
                return f;
            }
            if !self.spend(rewritten.iter().map(|r| r.terms().len()).sum()) {
                return Polynomial::zero();
            }
            f = Polynomial::collect(
                settled
                    .into_iter()
                    .chain(rewritten.iter().flat_map(|r| r.terms().to_vec())),
            );
            if !self.admits(f.largest_exponent()) {
                return Polynomial::zero();
            }
        }
    }

    /// One application of a relation to a monomial, `None` when it is in normal form.
    fn rewrite(&self, monomial: &Monomial) -> Option<Polynomial> {
        let one = || Coefficient::from_rational(&Rational::one());
        for &(symbol, exponent) in monomial.factors() {
            let Some(generator) = self.generator(symbol) else {
                continue;
            };
            match generator {
                Generator::Inverse(u) => {
                    let (leading, _) = u.leading().expect("an inverse has terms");
                    if exponent > 0 && monomial.is_multiple_of(leading) {
                        let rest = monomial.multiply(&leading.inverse());
                        let others = u.terms().iter().filter(|(m, _)| m != leading);
                        let tail =
                            others.map(|(m, c)| (rest.multiply(m), c.scaled(&-Rational::one())));
                        return Some(Polynomial::collect(
                            tail.chain(std::iter::once((rest.shifted(symbol, -1), one()))),
                        ));
                    }
                    if exponent < 0 {
                        let rest = monomial.shifted(symbol, 1);
                        return Some(u.times_term(&rest, &one()));
                    }
                }
                Generator::Root(u, q) if exponent >= i32::from(*q) => {
                    return Some(u.times_term(&monomial.shifted(symbol, -i32::from(*q)), &one()));
                }
                Generator::Kept(_, _, value)
                    if exponent >= 2 && *value == Polynomial::constant(one()) =>
                {
                    let rest = monomial.shifted(symbol, 1 - exponent);
                    return Some(Polynomial::collect([(rest, one())]));
                }
                Generator::Function(function @ (Function::Cos | Function::Cosh), u)
                    if exponent >= 2 =>
                {
                    let (partner, sign) = if *function == Function::Cos {
                        (Function::Sin, -Rational::one())
                    } else {
                        (Function::Sinh, Rational::one())
                    };
                    let partner = self.symbols[&Generator::Function(partner, u.clone())];
                    let rest = monomial.shifted(symbol, -2);
                    return Some(Polynomial::collect([
                        (rest.clone(), one()),
                        (rest.shifted(partner, 2), one().scaled(&sign)),
                    ]));
                }
                _ => {}
            }
        }
        None
    }
}
