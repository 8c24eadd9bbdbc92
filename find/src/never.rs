//! Equations that have no bracket near an equilibrium. Where it is asymptotically stable, forward or backward in time, it has a neighbourhood in
//! which a continuous integral is constant. H is one, so that f = {x, H} would vanish there.

use leafwise_expression::algebra::Elimination;
use leafwise_expression::{AlgebraError, Polynomial, Rational, Ring};

use crate::field::RingField;
use crate::matrix::{Matrix, product, zeros};

/// The equilibrium and its kind as a sentence, `None` where no such one is found.
pub(crate) fn never(
    field: &mut RingField,
    variables: &[String],
) -> Result<Option<String>, AlgebraError> {
    let d = field.dimension();
    let mut points = vec![vec![Rational::zero(); d]];
    let f = field.f.clone();
    points.extend(affine_zero(&f, d));
    if let Some(rates) = field.rates() {
        points.extend(affine_zero(&rates, d));
    }
    let mut slopes = Vec::new();
    for f in &f {
        slopes.push(field.ring.gradient(f)?);
    }
    let mut seams = Vec::new();
    for f in &f {
        seams.extend(field.ring.seams(f));
    }
    for point in points {
        let at = |f: &Polynomial| value(&field.ring, f, &point);
        let values: Option<Vec<Rational>> = f.iter().map(at).collect();
        if values.is_none_or(|values| values.iter().any(|v| !v.is_zero())) {
            continue;
        }
        // There f has no slopes.
        let is_off = |seam: &Polynomial| at(seam).is_some_and(|v| !v.is_zero());
        if !seams.iter().all(is_off) {
            continue;
        }
        let rows = slopes.iter().map(|row| row.iter().map(at).collect());
        let Some(matrix) = rows.collect::<Option<Matrix>>() else {
            continue;
        };
        let negative = matrix.iter().map(|row| row.iter().map(|v| -v).collect());
        let kind = if is_stable(&matrix) {
            "asymptotically stable"
        } else if is_stable(&negative.collect()) {
            "asymptotically stable backward in time"
        } else {
            continue;
        };
        let place = variables.iter().zip(&point);
        let place: Vec<String> = place
            .map(|(name, value)| format!("{name} = {value}"))
            .collect();
        return Ok(Some(format!(
            "the equilibrium {} is {kind}: no bracket near it has a continuous Hamiltonian, which would be constant there, so that f would vanish",
            place.join(", ")
        )));
    }
    Ok(None)
}

/// The only zero of an affine field.
fn affine_zero(f: &[Polynomial], d: usize) -> Option<Vec<Rational>> {
    let mut elimination = Elimination::new(d);
    for f in f {
        let mut row = Vec::new();
        for (monomial, coefficient) in f.terms() {
            let number = coefficient.as_constant()?;
            match monomial.factors() {
                [] => row.push((d, -number)),
                [(symbol, 1)] if (*symbol as usize) < d => row.push((*symbol as usize, number)),
                _ => return None,
            }
        }
        elimination.add(row);
    }
    let solutions = elimination.solutions()?;
    solutions
        .directions
        .is_empty()
        .then_some(solutions.particular)
}

/// The exact value at a rational point, where it is rational.
fn value(ring: &Ring, f: &Polynomial, point: &[Rational]) -> Option<Rational> {
    use leafwise_expression::Arithmetic;
    let mut numbers = Ring::new(point.len());
    let variable = &mut |numbers: &mut Ring, at: usize| Ok(numbers.constant(&point[at]));
    let value = ring.formula(f).evaluate_in(&mut numbers, variable).ok()?;
    numbers.as_rational(&value)
}

/// Whether all eigenvalues have negative real parts, by the Routh array of the characteristic polynomial.
fn is_stable(a: &Matrix) -> bool {
    let polynomial = characteristic(a);
    if polynomial.iter().any(|c| c.signum() <= 0) {
        return false;
    }
    let (mut above, mut below): (Vec<Rational>, Vec<Rational>) = (Vec::new(), Vec::new());
    for (k, c) in polynomial.into_iter().enumerate() {
        if k % 2 == 0 {
            above.push(c)
        } else {
            below.push(c)
        }
    }
    while let (Some(first), Some(second)) = (above.first().cloned(), below.first().cloned()) {
        if second.signum() <= 0 {
            return false;
        }
        let ratio = &first * &second.recip();
        let zero = Rational::zero();
        let next = (1..above.len()).map(|k| &above[k] - &(&ratio * below.get(k).unwrap_or(&zero)));
        let next = next.collect();
        above = std::mem::replace(&mut below, next);
    }
    true
}

/// det(λ − A), the highest power first, by Faddeev and LeVerrier.
fn characteristic(a: &Matrix) -> Vec<Rational> {
    let n = a.len();
    let mut coefficients = vec![Rational::one()];
    let mut m = zeros(n, n);
    for k in 1..=n {
        // M ← A M + c.
        let last = coefficients[k - 1].clone();
        m = product(a, &m);
        for (i, row) in m.iter_mut().enumerate() {
            row[i] += &last;
        }
        let am = product(a, &m);
        let trace = (0..n).fold(Rational::zero(), |sum, i| sum + &am[i][i]);
        coefficients.push(-(&trace * &Rational::new(1, k as i64)));
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[i64]]) -> Matrix {
        let row = |row: &&[i64]| row.iter().map(|v| Rational::from_integer(*v)).collect();
        rows.iter().map(row).collect()
    }

    /// (λ + 1)(λ + 2)(λ + 3) = λ³ + 6λ² + 11λ + 6, a rotation with and without damping, and a saddle.
    #[test]
    fn routh_tells_stable_matrices_from_others() {
        let triangular = matrix(&[&[-1, 5, 7], &[0, -2, 1], &[0, 0, -3]]);
        let expected = [1, 6, 11, 6].map(Rational::from_integer);
        assert_eq!(characteristic(&triangular), expected);
        assert!(is_stable(&triangular));
        assert!(is_stable(&matrix(&[&[-1, 9], &[-9, -1]])));
        assert!(!is_stable(&matrix(&[&[0, 9], &[-9, 0]])));
        assert!(!is_stable(&matrix(&[&[1, 0], &[0, -2]])));
        assert!(!is_stable(&matrix(&[&[-1, 0, 0], &[0, 1, 9], &[0, -9, 1]])));
    }
}
