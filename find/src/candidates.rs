//! Functions whose rational combinations are tried: monomials up to a degree, and antiderivatives of terms.

use std::collections::BTreeSet;

use leafwise_expression::algebra::{Coefficient, CoefficientRing, Generator, Monomial, Symbol};
use leafwise_expression::{AlgebraError, Arithmetic, Function, Polynomial, Rational, Ring};

use crate::error::FindError;

/// Unknown coefficients of one linear system.
pub(crate) const MOST_UNKNOWNS: usize = 3_000;

/// The monomials of total degree 1 … `degree` in these symbols.
pub(crate) fn monomials(
    ring: &mut Ring,
    symbols: &[Symbol],
    degree: usize,
) -> Result<Vec<Polynomial>, FindError> {
    // C(n + D, D) − 1.
    let unknowns = (1..=degree).fold(1.0, |count, k| {
        count * (symbols.len() + k) as f64 / k as f64
    });
    if unknowns > MOST_UNKNOWNS as f64 {
        return Err(FindError::TooMany {
            degree,
            symbols: symbols.len(),
            unknowns: unknowns as usize,
            most: MOST_UNKNOWNS,
        });
    }
    let mut all: Vec<Polynomial> = Vec::new();
    let one = ring.one();
    let mut last: Vec<(usize, Polynomial)> = vec![(0, one)];
    for _ in 0..degree {
        let mut next = Vec::new();
        for (from, monomial) in &last {
            for (at, &symbol) in symbols.iter().enumerate().skip(*from) {
                let product = ring.multiply(monomial, &Polynomial::symbol(symbol));
                // A square of a cosine is a sum of others.
                if product.terms().len() == 1 {
                    next.push((at, product));
                }
            }
        }
        all.extend(next.iter().map(|(_, monomial)| monomial.clone()));
        last = next;
    }
    Ok(all)
}

/// The variables and the functions that f is made of, with the sine beside each cosine and the reverse.
pub(crate) fn symbols_of(ring: &mut Ring, f: &[Polynomial]) -> Result<Vec<Symbol>, AlgebraError> {
    let variables = ring.variables() as u32;
    let mut symbols: BTreeSet<Symbol> = (0..variables).collect();
    symbols.extend(f.iter().flat_map(|f| f.symbols()));
    for symbol in symbols.clone() {
        if let Some(partner) = partner(ring, symbol)? {
            symbols.extend(partner.symbols());
        }
    }
    Ok(symbols.into_iter().collect())
}

/// cos u of sin u, sin u of cos u; cosh u and sinh u the same.
fn partner(ring: &mut Ring, symbol: Symbol) -> Result<Option<Polynomial>, AlgebraError> {
    let Some(Generator::Function(function, u)) = ring.generator(symbol).cloned() else {
        return Ok(None);
    };
    let other = match function {
        Function::Sin => Function::Cos,
        Function::Cos => Function::Sin,
        Function::Sinh => Function::Cosh,
        Function::Cosh => Function::Sinh,
        _ => return Ok(None),
    };
    ring.apply(other, &u).map(Some)
}

/// Functions among whose combinations an antiderivative of the monomial m by xᵢ is likely to be.
pub(crate) fn antiderivatives(
    ring: &mut Ring,
    m: &Monomial,
    i: usize,
) -> Result<Vec<Polynomial>, AlgebraError> {
    let term = |m: Monomial| Polynomial::term(m, Coefficient::from_rational(&Rational::one()));
    let symbol = i as Symbol;
    let mut found = Vec::new();
    let x = ring.variable(i);
    let raised = term(m.shifted(symbol, 1));
    if m.exponent(symbol) == -1 {
        let logarithm = ring.apply(Function::Ln, &x)?;
        found.push(ring.multiply(&raised, &logarithm));
    }
    found.push(raised);
    let generators: Vec<(Symbol, i32)> = (m.factors().iter().copied())
        .filter(|(symbol, _)| *symbol as usize >= ring.variables())
        .collect();
    if generators.is_empty() {
        return Ok(found);
    }
    let bases = [m.clone(), m.shifted(symbol, -1)];
    found.extend(bases.iter().cloned().map(term));
    for (generator_symbol, exponent) in generators {
        let Some(generator) = ring.generator(generator_symbol).cloned() else {
            continue;
        };
        let u = generator.argument().clone();
        for base in &bases {
            let base_term = term(base.clone());
            found.push(ring.multiply(&base_term, &u));
            match &generator {
                Generator::Inverse(_) => {
                    let lowered = term(base.shifted(generator_symbol, -1));
                    if exponent == 1 {
                        let logarithm = ring.apply(Function::Ln, &u)?;
                        found.push(ring.multiply(&lowered, &logarithm));
                        // The other functions may be those of u′: ∫ sin u/cos u = −ln cos u.
                        let variables = base.factors().iter();
                        let variables =
                            variables.filter(|(own, _)| (*own as usize) < ring.variables());
                        let rest = variables.fold(Monomial::one(), |rest, (own, exponent)| {
                            rest.shifted(*own, *exponent)
                        });
                        found.push(ring.multiply(&term(rest), &logarithm));
                    }
                    found.push(lowered);
                }
                // ∫ tan = ln(1 + tan²)/2, and ∫ tanh = −ln(1 − tanh²)/2.
                Generator::Function(own @ (Function::Tan | Function::Tanh), _) if exponent == 1 => {
                    let sign = if *own == Function::Tan { 1 } else { -1 };
                    let (one, own) = (ring.one(), Polynomial::symbol(generator_symbol));
                    let square = ring.multiply(&own, &own);
                    let sum = [
                        (Rational::one(), one),
                        (Rational::from_integer(sign), square),
                    ];
                    let below = ring.combine(&sum);
                    let logarithm = ring.apply(Function::Ln, &below)?;
                    let rest = term(base.shifted(generator_symbol, -1));
                    found.push(ring.multiply(&rest, &logarithm));
                }
                Generator::Function(Function::Ln, _) => {
                    found.push(term(base.shifted(generator_symbol, -1).shifted(symbol, 1)));
                    found.push(term(base.shifted(generator_symbol, 1).shifted(symbol, 1)));
                }
                _ => {}
            }
        }
        if let Some(partner) = partner(ring, generator_symbol)? {
            for base in [m.clone(), m.shifted(symbol, 1)] {
                let rest = term(base.shifted(generator_symbol, -1));
                found.push(ring.multiply(&rest, &partner));
            }
        }
    }
    Ok(found)
}
