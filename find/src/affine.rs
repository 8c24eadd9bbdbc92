//! Tensors that are affine in x: those that the motion preserves, of them the ones with Jacobi's identity, H among the first integrals.

use std::collections::BTreeMap;

use leafwise_expression::algebra::relations;
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational};

use crate::constant::{members, pairs};
use crate::error::FindError;
use crate::field::{RingField, dot};
use crate::identity::Identity;
use crate::invariant::invariant_tensors;
use crate::potential::combination;
use crate::report::{Attempt, Kind, TensorCandidate};

/// The largest dimension: of 12 variables the coefficients are 858.
const MOST_VARIABLES: usize = 12;

type Tensor = BTreeMap<(usize, usize), Polynomial>;

/// A tensor of this kind with a combination of the integrals for H, the sparsest of those that are tried.
pub(crate) fn affine(
    field: &mut RingField,
    integrals: &[Polynomial],
) -> Result<Attempt, FindError> {
    let d = field.dimension();
    if d > MOST_VARIABLES {
        return Ok(Attempt::none(format!(
            "the search takes at most {MOST_VARIABLES} variables"
        )));
    }
    let Some(mut family) = invariant_tensors(field)? else {
        return Ok(Attempt::none(
            "the affine J that the motion preserves have longer fractions than are tried",
        ));
    };
    if family.is_empty() {
        let reason =
            "the motion preserves no affine J ≠ 0, and it would preserve every J with {x, H} = f";
        return Ok(match field.is_decided() {
            true => Attempt::proved(reason),
            false => Attempt::none(reason),
        });
    }
    // The first of equals is taken: of three variables this one has the entries of one cycle.
    family.reverse();
    let identity = Identity::of(d);
    let poisson: Vec<Vec<Rational>> = (members(&family).into_iter())
        .filter(|member| identity.holds(member))
        .collect();
    if poisson.is_empty() && family.len() == 1 && field.is_decided() {
        return Ok(Attempt::proved(
            "the motion preserves only one affine J, which violates Jacobi's identity",
        ));
    }
    if integrals.is_empty() {
        return Ok(Attempt::none(
            "H must be among the first integrals, and there is none",
        ));
    }
    let mut best = None;
    for coefficients in &poisson {
        let tensor = entries(field, coefficients);
        for hamiltonian in hamiltonians(field, &tensor, integrals)? {
            let found = TensorCandidate {
                kind: Kind::Affine,
                tensor: tensor.clone(),
                hamiltonian,
                family: family.len(),
                energy: None,
                casimirs: Vec::new(),
            };
            TensorCandidate::keep_smaller(&mut best, Some(found), &field.ring);
        }
    }
    Ok(match best {
        Some(found) => Attempt::Found(Box::new(found)),
        None if poisson.is_empty() => {
            Attempt::none("none of the affine J that the motion preserves was found to be Poisson")
        }
        None => Attempt::none(
            "the motion preserves affine Poisson tensors, but no combination of the first integrals moves it by them",
        ),
    })
}

/// H among the combinations of the integrals with J ∇H = f. Beside it stands the same less multiples of Casimirs: they take away products of two
/// variables or more, for a sum of squares is wanted.
fn hamiltonians(
    field: &mut RingField,
    tensor: &Tensor,
    integrals: &[Polynomial],
) -> Result<Vec<Polynomial>, AlgebraError> {
    let mut columns = Vec::with_capacity(integrals.len());
    for integral in integrals {
        columns.push(motion(field, tensor, integral)?);
    }
    let Some(solutions) = relations(&columns, &field.f).solutions() else {
        return Ok(Vec::new());
    };
    let ring = &mut field.ring;
    let first = combination(ring, &solutions.particular, integrals);
    let mut all = vec![first.clone()];
    for direction in &solutions.directions {
        let casimir = combination(ring, direction, integrals);
        let others: BTreeMap<_, _> = (casimir.terms().iter())
            .filter(|(monomial, _)| monomial.factors().len() > 1)
            .map(|(monomial, coefficient)| (monomial, coefficient))
            .collect();
        let ratio = first.terms().iter().find_map(|(monomial, coefficient)| {
            let other = others.get(monomial)?.as_constant()?;
            Some(&coefficient.as_constant()? * &other.recip())
        });
        if let Some(ratio) = ratio {
            let part = ring.scale(&ratio, &casimir);
            all.push(ring.subtract(&first, &part));
        }
    }
    Ok(all)
}

/// J ∇H.
fn motion(
    field: &mut RingField,
    tensor: &Tensor,
    hamiltonian: &Polynomial,
) -> Result<Vec<Polynomial>, AlgebraError> {
    let d = field.dimension();
    let ring = &mut field.ring;
    let gradient = ring.gradient(hamiltonian)?;
    let mut rows: Vec<(Vec<Polynomial>, Vec<Polynomial>)> = vec![Default::default(); d];
    for (&(i, j), entry) in tensor {
        rows[i].0.push(entry.clone());
        rows[i].1.push(gradient[j].clone());
        rows[j].0.push(ring.negate(entry));
        rows[j].1.push(gradient[i].clone());
    }
    Ok(rows
        .iter()
        .map(|(left, right)| dot(ring, left, right))
        .collect())
}

fn entries(field: &mut RingField, c: &[Rational]) -> Tensor {
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
