//! Tensors that are affine in x: Π(x) ∇H = f is linear in the coefficients for a given H, Jacobi's identity quadratic.

use std::collections::BTreeMap;

use leafwise_expression::algebra::relations;
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational};

use crate::constant::{members, pairs};
use crate::energy::{columns, hamiltonian};
use crate::error::FindError;
use crate::field::RingField;
use crate::identity::Identity;
use crate::jacobi::{Space, sparse_solution};
use crate::potential::combination;
use crate::report::{Attempt, Kind, TensorCandidate};

/// Hamiltonians among the integrals that are tried.
const MOST_HAMILTONIANS: usize = 24;

/// Starts of the solve for Jacobi's identity.
const STARTS: usize = 6;

/// The largest dimension: of 12 variables the coefficients are 858.
const MOST_VARIABLES: usize = 12;

/// A tensor of this kind with one of the integrals' combinations for H.
pub(crate) fn affine(
    field: &mut RingField,
    integrals: &[Polynomial],
) -> Result<Attempt, FindError> {
    let d = field.dimension();
    if d > MOST_VARIABLES {
        return Ok(Attempt::none(format!(
            "it is looked for in at most {MOST_VARIABLES} variables"
        )));
    }
    if integrals.is_empty() {
        return Ok(Attempt::none(
            "H must be among the first integrals, and there is none",
        ));
    }
    let unit = |k: usize| -> Vec<Rational> {
        let entries = 0..integrals.len();
        entries
            .map(|l| Rational::from_integer(i64::from(k == l)))
            .collect()
    };
    let units: Vec<Vec<Rational>> = (0..integrals.len()).map(unit).collect();
    let identity = Identity::of(d);
    let mut solvable = 0;
    let simple = members(&units).into_iter().take(MOST_HAMILTONIANS);
    for choice in simple {
        match of_combination(field, (integrals, &choice), &identity)? {
            Some(Attempt::Found(found)) => return Ok(Attempt::Found(found)),
            Some(_) => solvable += 1,
            None => {}
        }
    }
    if let Some(choice) = hamiltonian(field, integrals, &identity)?
        && let Some(Attempt::Found(found)) = of_combination(field, (integrals, &choice), &identity)?
    {
        return Ok(Attempt::Found(found));
    }
    Ok(Attempt::none(match solvable {
        0 => "no combination of the first integrals that was tried has an affine Π with Π ∇H = f",
        _ => "Π ∇H = f has affine solutions Π, and for none of them Jacobi's identity was solved",
    }))
}

/// A tensor with a combination of integrals for H; `None` where Π ∇H = f has no affine solution.
fn of_combination(
    field: &mut RingField,
    (integrals, choice): (&[Polynomial], &[Rational]),
    identity: &Identity,
) -> Result<Option<Attempt>, FindError> {
    let hamiltonian = combination(&mut field.ring, choice, integrals);
    let Some(space) = tensors(field, &hamiltonian)? else {
        return Ok(None);
    };
    let Some(c) = sparse_solution(identity, &space, STARTS) else {
        return Ok(Some(Attempt::none("Jacobi's identity was not solved")));
    };
    Ok(Some(Attempt::Found(Box::new(TensorCandidate {
        kind: Kind::Affine,
        tensor: entries(field, &c),
        hamiltonian,
        family: space.directions.len() + 1,
        energy: None,
        casimirs: Vec::new(),
    }))))
}

/// All affine Π with Π ∇H = f.
fn tensors(field: &mut RingField, hamiltonian: &Polynomial) -> Result<Option<Space>, AlgebraError> {
    let columns = columns(field, hamiltonian)?;
    let solutions = relations(&columns, &field.f).solutions();
    Ok(solutions.map(|solutions| Space {
        origin: solutions.particular,
        directions: solutions.directions,
    }))
}

fn entries(field: &mut RingField, c: &[Rational]) -> BTreeMap<(usize, usize), Polynomial> {
    let d = field.dimension();
    let ring = &mut field.ring;
    let mut entries = BTreeMap::new();
    for (pair, coefficients) in pairs(d).into_iter().zip(c.chunks(d + 1)) {
        let mut terms = Vec::new();
        for (m, coefficient) in coefficients.iter().enumerate() {
            if !coefficient.is_zero() {
                let function = match m {
                    0 => ring.one(),
                    m => ring.variable(m - 1),
                };
                terms.push((coefficient.clone(), function));
            }
        }
        let entry = ring.combine(&terms);
        if !entry.is_zero() {
            entries.insert(pair, entry);
        }
    }
    entries
}
