//! Brackets of two and three variables by first integrals: f = φ ∇C × ∇H in space, f = φ (∂H/∂y, −∂H/∂x) in the plane. Jacobi's
//! identity holds for any factor φ.

use std::collections::BTreeMap;

use leafwise_expression::algebra::quotient;
use leafwise_expression::{Arithmetic, Expression, Polynomial, Rational, Ring};

use crate::error::FindError;
use crate::field::RingField;
use crate::integrals::{Integral, products};
use crate::report::{Attempt, Kind, TensorCandidate};

/// Pairs of integrals that are tried.
const MOST_PAIRS: usize = 400;

/// The degree of Darboux polynomials that are looked for.
const DARBOUX_DEGREE: usize = 3;

/// The bracket with the fewest terms among those of pairs of integrals.
pub(crate) fn low(field: &mut RingField, polynomials: &[Polynomial]) -> Result<Attempt, FindError> {
    let d = field.dimension();
    if d != 2 && d != 3 {
        return Ok(Attempt::none(format!(
            "it needs two or three variables, and there are {d}"
        )));
    }
    let mut integrals = Vec::new();
    for polynomial in polynomials {
        integrals.push(Integral::of_polynomial(&mut field.ring, polynomial)?);
    }
    integrals.extend(products(field, DARBOUX_DEGREE)?);
    let none = |count: &str| Attempt::none(format!("{count} was found"));
    if d == 2 {
        let mut best = None;
        for hamiltonian in &integrals {
            let found = in_the_plane(field, hamiltonian)?;
            TensorCandidate::keep_smaller(&mut best, found, &field.ring);
        }
        return Ok(best.map_or_else(
            || none("no first integral"),
            |b| Attempt::Found(Box::new(b)),
        ));
    }
    let mut best = None;
    let count = integrals.len();
    let pairs = (0..count).flat_map(|c| (0..count).filter(move |&h| h != c).map(move |h| (c, h)));
    for (c, h) in pairs.take(MOST_PAIRS) {
        let found = in_space(field, &integrals[c], &integrals[h])?;
        TensorCandidate::keep_smaller(&mut best, found, &field.ring);
    }
    Ok(best.map_or_else(
        || none("no pair of independent first integrals"),
        |b| Attempt::Found(Box::new(b)),
    ))
}

/// above/below, as a polynomial or one over a polynomial where it is one.
fn ratio(ring: &mut Ring, above: &Polynomial, below: &Polynomial) -> Result<Polynomial, FindError> {
    if let Some(whole) = quotient(above, below) {
        return Ok(whole);
    }
    if let Some(inverse) = quotient(below, above) {
        let one = ring.one();
        return Ok(ring.divide(&one, &inverse)?);
    }
    Ok(ring.divide(above, below)?)
}

/// {x, y} = φ with f = φ (∂_y H, −∂_x H).
fn in_the_plane(field: &mut RingField, h: &Integral) -> Result<Option<TensorCandidate>, FindError> {
    let ring = &mut field.ring;
    let slopes = [h.gradient[1].clone(), ring.negate(&h.gradient[0])];
    let Some(at) = slopes.iter().position(|slope| !slope.is_zero()) else {
        return Ok(None);
    };
    let above = ring.multiply(&field.f[at], &h.divisor);
    let phi = ratio(ring, &above, &slopes[at])?;
    let hamiltonian = element(ring, h)?;
    Ok(Some(TensorCandidate {
        kind: Kind::FirstIntegrals,
        tensor: BTreeMap::from([((0, 1), phi)]),
        hamiltonian,
        family: 1,
        energy: energy(h),
        casimirs: Vec::new(),
    }))
}

/// J v = φ g_C × v with g_C along ∇C, so that f = φ g_C × ∇H.
fn in_space(
    field: &mut RingField,
    c: &Integral,
    h: &Integral,
) -> Result<Option<TensorCandidate>, FindError> {
    let ring = &mut field.ring;
    let (a, b) = (&c.gradient, &h.gradient);
    let mut cross = Vec::with_capacity(3);
    for (i, j) in [(1, 2), (2, 0), (0, 1)] {
        let minus = -Rational::one();
        cross.push(ring.sum_of_products(&[(Rational::one(), &a[i], &b[j]), (minus, &a[j], &b[i])]));
    }
    let Some(at) = cross.iter().position(|entry| !entry.is_zero()) else {
        return Ok(None);
    };
    // Both are integrals, so f is along the product; the proof that it is stands in these normal forms.
    for other in 0..3 {
        let left = ring.multiply(&field.f[at], &cross[other]);
        let right = ring.multiply(&field.f[other], &cross[at]);
        if left != right {
            return Ok(None);
        }
    }
    let above = ring.multiply(&field.f[at], &h.divisor);
    let phi = ratio(ring, &above, &cross[at])?;
    let mut tensor = BTreeMap::new();
    for (pair, k, sign) in [((0, 1), 2, -1), ((0, 2), 1, 1), ((1, 2), 0, -1)] {
        let entry = ring.multiply(&phi, &a[k]);
        let entry = ring.scale(&Rational::from_integer(sign), &entry);
        if !entry.is_zero() {
            tensor.insert(pair, entry);
        }
    }
    Ok(Some(TensorCandidate {
        kind: Kind::FirstIntegrals,
        tensor,
        hamiltonian: element(ring, h)?,
        family: 1,
        energy: energy(h),
        casimirs: vec![c.formula.clone()],
    }))
}

/// The formula, where the ring would expand it.
fn energy(h: &Integral) -> Option<Expression> {
    let is_expanded = h.divisor.as_constant().is_some();
    (!is_expanded).then(|| h.formula.clone())
}

fn element(ring: &mut Ring, integral: &Integral) -> Result<Polynomial, FindError> {
    let variable = &mut |ring: &mut Ring, at: usize| Ok(ring.variable(at));
    Ok(integral.formula.evaluate_in(ring, variable)?)
}
