//! From the exact ring to straight-line code.

use rustc_hash::FxHashMap;

use super::factor::{FactoredTerm, factor_in_graph};
use super::node::{Graph, Term};
use crate::algebra::{Atom, Coefficient, Generator, Monomial, Polynomial, Ring, Symbol};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::rational::Rational;

/// Σⱼ cⱼ fⱼ for each output, cⱼ a factor of the coefficient tier (a power of the step size, say)
/// and fⱼ in the ring. Like monomials are merged into one coefficient, then factored and shared
/// across all outputs. The code of the state is `variables`.
///
/// # Errors
/// [`AlgebraError`] when an adjoined function has no code, such as 1/0.
pub fn lift(
    graph: &mut Graph,
    ring: &Ring,
    outputs: &[Vec<(Term, Polynomial)>],
    variables: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    if let Some(refusal) = ring.refusal() {
        return Err(refusal.clone());
    }
    let mut lifting = Lifting {
        ring,
        variables,
        symbols: FxHashMap::default(),
    };
    let mut polynomials = Vec::with_capacity(outputs.len());
    for output in outputs {
        let mut merged: Vec<(Monomial, Vec<(Rational, Term)>)> = Vec::new();
        let mut places: FxHashMap<Monomial, usize> = FxHashMap::default();
        for (factor, polynomial) in output {
            for (m, c) in polynomial.terms() {
                for &(symbol, _) in m.factors() {
                    lifting.symbol(graph, symbol)?;
                }
                let c = lifting.coefficient(graph, c)?;
                let c = graph.multiply(factor, &c);
                let at = *places.entry(m.clone()).or_insert_with(|| {
                    merged.push((m.clone(), Vec::new()));
                    merged.len() - 1
                });
                merged[at].1.push((Rational::one(), c));
            }
        }
        let terms: Vec<FactoredTerm> = merged
            .into_iter()
            .map(|(m, parts)| (m, graph.combine(&parts)))
            .collect();
        polynomials.push(terms);
    }
    factor_in_graph(graph, &polynomials, &lifting.symbols)
}

struct Lifting<'a> {
    ring: &'a Ring,
    variables: &'a [Term],
    symbols: FxHashMap<Symbol, Term>,
}

impl Lifting<'_> {
    fn symbol(&mut self, graph: &mut Graph, symbol: Symbol) -> Result<Term, AlgebraError> {
        if let Some(known) = self.symbols.get(&symbol) {
            return Ok(known.clone());
        }
        let code = match self.ring.generator(symbol) {
            None => self.variables[symbol as usize].clone(),
            Some(generator) => {
                let argument = self.polynomial(graph, generator.argument())?;
                match generator {
                    Generator::Kept(side, _, value) => {
                        let value = self.polynomial(graph, value)?;
                        graph.kept(*side, &argument, &value)?
                    }
                    Generator::Lookup(lookup, point) => {
                        let mut terms = Vec::with_capacity(point.len());
                        for at in point {
                            terms.push(self.polynomial(graph, at)?);
                        }
                        graph.look_up(*lookup, &terms)?
                    }
                    Generator::Inverse(_) => {
                        let one = graph.one();
                        graph.divide(&one, &argument)?
                    }
                    Generator::Root(_, q) => {
                        let exponent = graph.constant(&Rational::new(1, i64::from(*q)));
                        graph.power(&argument, &exponent)?
                    }
                    Generator::Power(_, exponent) => {
                        let exponent = self.coefficient(graph, exponent)?;
                        graph.power(&argument, &exponent)?
                    }
                    Generator::Binary(function, _, other) => {
                        let other = self.polynomial(graph, other)?;
                        graph.apply_two(*function, &argument, &other)?
                    }
                    Generator::Function(function, _) => graph.apply(*function, &argument)?,
                }
            }
        };
        self.symbols.insert(symbol, code.clone());
        Ok(code)
    }

    fn polynomial(&mut self, graph: &mut Graph, f: &Polynomial) -> Result<Term, AlgebraError> {
        let mut terms = Vec::with_capacity(f.terms().len());
        for (m, c) in f.terms() {
            for &(symbol, _) in m.factors() {
                self.symbol(graph, symbol)?;
            }
            terms.push((m.clone(), self.coefficient(graph, c)?));
        }
        let mut codes = factor_in_graph(graph, &[terms], &self.symbols)?;
        Ok(codes.pop().expect("one polynomial in, one term out"))
    }

    fn coefficient(&self, graph: &mut Graph, c: &Coefficient) -> Result<Term, AlgebraError> {
        let mut sum = Vec::with_capacity(c.terms().len());
        for (m, r) in c.terms() {
            let mut product = graph.one();
            for &(symbol, exponent) in m.factors() {
                let atom = self.atom(graph, symbol)?;
                let power = graph.integer_power(&atom, exponent.into())?;
                product = graph.multiply(&product, &power);
            }
            sum.push((r.clone(), product));
        }
        Ok(graph.combine(&sum))
    }

    fn atom(&self, graph: &mut Graph, symbol: Symbol) -> Result<Term, AlgebraError> {
        match self.ring.atom(symbol) {
            Atom::Parameter(index) => Ok(graph.parameter(*index)),
            Atom::Pi => Ok(graph.pi()),
            Atom::Inverse(c) => {
                let (one, c) = (graph.one(), self.coefficient(graph, c)?);
                graph.divide(&one, &c)
            }
            Atom::RationalPower(c, exponent) => {
                let c = self.coefficient(graph, c)?;
                let exponent = graph.constant(exponent);
                graph.power(&c, &exponent)
            }
            Atom::Power(c, exponent) => {
                let c = self.coefficient(graph, c)?;
                let exponent = self.coefficient(graph, exponent)?;
                graph.power(&c, &exponent)
            }
            Atom::Binary(function, c, d) => {
                let c = self.coefficient(graph, c)?;
                let d = self.coefficient(graph, d)?;
                graph.apply_two(*function, &c, &d)
            }
            Atom::Lookup(lookup, point) => {
                let mut terms = Vec::with_capacity(point.len());
                for at in point {
                    terms.push(self.coefficient(graph, at)?);
                }
                graph.look_up(*lookup, &terms)
            }
            Atom::Function(function, c) => {
                let c = self.coefficient(graph, c)?;
                graph.apply(*function, &c)
            }
        }
    }
}
