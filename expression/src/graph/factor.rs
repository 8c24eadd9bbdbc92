//! From sums of monomials to short straight-line code.

use rustc_hash::FxHashMap;

use super::node::{Graph, Term};
use crate::algebra::{Monomial, Symbol};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::rational::Rational;

/// A monomial in numbered symbols with a coefficient that is already code.
pub type FactoredTerm = (Monomial, Term);

/// Writes Σ cᵢ mᵢ for each of `polynomials` into `graph` in a multivariate Horner form. The common
/// monomial is taken out, then the symbol power that most terms share, and so on. Powers and
/// partial results are shared across all of them.
///
/// The map `symbols` gives the code of each symbol.
///
/// # Errors
/// [`AlgebraError`] for a negative power of a symbol whose code is 0.
pub fn factor_in_graph(
    graph: &mut Graph,
    polynomials: &[Vec<FactoredTerm>],
    symbols: &FxHashMap<Symbol, Term>,
) -> Result<Vec<Term>, AlgebraError> {
    polynomials
        .iter()
        .map(|terms| horner(graph, terms.clone(), symbols))
        .collect()
}

fn horner(
    graph: &mut Graph,
    mut terms: Vec<FactoredTerm>,
    symbols: &FxHashMap<Symbol, Term>,
) -> Result<Term, AlgebraError> {
    terms.retain(|(_, c)| !graph.is_zero(c));
    let Some((first, rest)) = terms.split_first() else {
        return Ok(graph.zero());
    };
    if rest.is_empty() {
        let power = monomial(graph, &first.0, symbols)?;
        return Ok(graph.multiply(&first.1, &power));
    }
    let content = rest
        .iter()
        .fold(first.0.clone(), |common, (m, _)| common.common(m));
    if !content.is_one() {
        let inverse = content.inverse();
        for term in &mut terms {
            term.0 = term.0.multiply(&inverse);
        }
        let outer = monomial(graph, &content, symbols)?;
        let inner = horner(graph, terms, symbols)?;
        return Ok(graph.multiply(&outer, &inner));
    }
    match most_shared(&terms) {
        None => sum_of_monomials(graph, &terms, symbols),
        Some(factor) => {
            let (with, without): (Vec<_>, Vec<_>) = terms
                .into_iter()
                .partition(|(m, _)| m.exponent(factor.0) >= factor.1);
            let inverse = Monomial::power(factor.0, -factor.1);
            let quotient = with
                .into_iter()
                .map(|(m, c)| (m.multiply(&inverse), c))
                .collect::<Vec<_>>();
            let outer = monomial(graph, &Monomial::power(factor.0, factor.1), symbols)?;
            let inner = horner(graph, quotient, symbols)?;
            let head = graph.multiply(&outer, &inner);
            if without.is_empty() {
                return Ok(head);
            }
            let tail = horner(graph, without, symbols)?;
            Ok(graph.add(&head, &tail))
        }
    }
}

/// The symbol that most terms contain, at least two, with the smallest power it has in them.
fn most_shared(terms: &[FactoredTerm]) -> Option<(Symbol, i32)> {
    let mut counts: FxHashMap<Symbol, (usize, i32)> = FxHashMap::default();
    for (m, _) in terms {
        for &(symbol, exponent) in m.factors() {
            let entry = counts.entry(symbol).or_insert((0, exponent));
            entry.0 += 1;
            entry.1 = entry.1.min(exponent);
        }
    }
    counts
        .into_iter()
        .filter(|(_, (count, _))| *count > 1)
        .max_by_key(|(symbol, (count, _))| (*count, std::cmp::Reverse(*symbol)))
        .map(|(symbol, (_, exponent))| (symbol, exponent))
}

fn sum_of_monomials(
    graph: &mut Graph,
    terms: &[FactoredTerm],
    symbols: &FxHashMap<Symbol, Term>,
) -> Result<Term, AlgebraError> {
    let mut sum = Vec::with_capacity(terms.len());
    for (m, c) in terms {
        let power = monomial(graph, m, symbols)?;
        sum.push((Rational::one(), graph.multiply(c, &power)));
    }
    Ok(graph.combine(&sum))
}

fn monomial(
    graph: &mut Graph,
    monomial: &Monomial,
    symbols: &FxHashMap<Symbol, Term>,
) -> Result<Term, AlgebraError> {
    let mut product = graph.one();
    for &(symbol, exponent) in monomial.factors() {
        // A negative power is the power of the reciprocal, so that all of them share it.
        let base = &symbols[&symbol];
        let power = if exponent < 0 {
            let one = graph.one();
            let reciprocal = graph.divide(&one, base)?;
            graph.integer_power(&reciprocal, i64::from(-exponent))?
        } else {
            graph.integer_power(base, exponent.into())?
        };
        product = graph.multiply(&product, &power);
    }
    Ok(product)
}
