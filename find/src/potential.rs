//! Integration of closed one-forms by undetermined coefficients.

use std::collections::HashSet;

use leafwise_expression::algebra::{Coefficient, Monomial, relations};
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational, Ring};

use crate::candidates::{MOST_UNKNOWNS, antiderivatives};

/// Rounds of further candidates, from the derivatives of earlier ones.
const MOST_ROUNDS: usize = 6;

/// Derivatives of a function along some directions.
pub(crate) type Derivations<'a> =
    dyn Fn(&mut Ring, &Polynomial) -> Result<Vec<Polynomial>, AlgebraError> + 'a;

/// H with D_a H = u_a for all derivations D_a, each by a variable `by[a]` and perhaps others; `None` where none is found.
pub(crate) fn potential(
    ring: &mut Ring,
    derivations: &Derivations<'_>,
    by: &[usize],
    u: &[Polynomial],
) -> Result<Option<Polynomial>, AlgebraError> {
    let mut functions: Vec<Polynomial> = Vec::new();
    let mut columns: Vec<Vec<Polynomial>> = Vec::new();
    let mut known: HashSet<Polynomial> = HashSet::new();
    let mut seen: HashSet<(usize, Monomial, Monomial)> = HashSet::new();
    let mut new: Vec<Vec<Polynomial>> = vec![u.to_vec()];
    for _ in 0..MOST_ROUNDS {
        let mut terms: Vec<(usize, Monomial, Monomial)> = Vec::new();
        for vector in &new {
            for (component, element) in vector.iter().enumerate() {
                for (monomial, coefficient) in element.terms() {
                    let constants = coefficient.terms().iter();
                    let found = constants.map(|(k, _)| (component, monomial.clone(), k.clone()));
                    terms.extend(found.filter(|term| seen.insert(term.clone())));
                }
            }
        }
        let before = columns.len();
        for (component, monomial, constant) in terms {
            let factor = Coefficient::term(constant, Rational::one());
            for candidate in antiderivatives(ring, &monomial, by[component])? {
                let candidate = candidate.times_term(&Monomial::one(), &factor);
                if candidate.is_zero() || !known.insert(candidate.clone()) {
                    continue;
                }
                let column = derivations(ring, &candidate)?;
                if column.iter().any(|c| !c.is_zero()) {
                    columns.push(column);
                    functions.push(candidate);
                }
            }
        }
        if let Some(solutions) = relations(&columns, u).solutions() {
            return Ok(Some(combination(ring, &solutions.particular, &functions)));
        }
        if columns.len() == before || columns.len() > MOST_UNKNOWNS {
            break;
        }
        new = columns[before..].to_vec();
    }
    Ok(None)
}

/// Σ cₖ fₖ.
pub(crate) fn combination(
    ring: &mut Ring,
    coefficients: &[Rational],
    functions: &[Polynomial],
) -> Polynomial {
    let terms: Vec<(Rational, Polynomial)> = (coefficients.iter().zip(functions))
        .filter(|(c, _)| !c.is_zero())
        .map(|(c, f)| (c.clone(), f.clone()))
        .collect();
    ring.combine(&terms)
}
