//! Hamiltonians among combinations H = Σ aₖ Iₖ of first integrals: a and the tensor together, Π(c) ∇H(a) = f and B(c, c) = 0, by least
//! squares in doubles. A system with more integrals than H and its Casimirs moves by few of these combinations: Lagrange's top has
//! m₃ and m₃² beside the energy.

use std::collections::BTreeMap;

use leafwise_expression::algebra::Monomial;
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational};

use crate::constant::pairs;
use crate::field::RingField;
use crate::identity::Identity;
use crate::jacobi::{fractions, least_squares};

/// The largest dimension: of 7 variables 168 coefficients stand beside the aₖ.
const MOST_VARIABLES: usize = 7;

/// Integrals, at most.
const MOST_INTEGRALS: usize = 12;

/// Iterations of the first solve, and of one near a solution.
const MOST_ITERATIONS: usize = 160;
const MOST_NEAR: usize = 60;

/// Starts for each integral.
const STARTS: usize = 2;

/// Part of the largest aₖ below which one is no candidate for the scale of H.
const LARGE: f64 = 0.1;

/// Π ∇H for each coefficient of Π, in their order.
pub(crate) fn columns(
    field: &mut RingField,
    hamiltonian: &Polynomial,
) -> Result<Vec<Vec<Polynomial>>, AlgebraError> {
    let d = field.dimension();
    let gradient = field.ring.gradient(hamiltonian)?;
    let mut columns = Vec::new();
    for (i, j) in pairs(d) {
        for m in 0..=d {
            let factor = match m {
                0 => field.ring.one(),
                m => field.ring.variable(m - 1),
            };
            let mut column = vec![Polynomial::zero(); d];
            column[i] = field.ring.multiply(&factor, &gradient[j]);
            let other = field.ring.multiply(&factor, &gradient[i]);
            column[j] = field.ring.negate(&other);
            columns.push(column);
        }
    }
    Ok(columns)
}

/// Equations Σ value c_n a_k = right, row by row, in doubles.
struct Bilinear {
    terms: Vec<(usize, usize, usize, f64)>,
    right: Vec<f64>,
    coefficients: usize,
    integrals: usize,
}

impl Bilinear {
    fn of(field: &mut RingField, integrals: &[Polynomial]) -> Result<Self, AlgebraError> {
        let mut rows: BTreeMap<(usize, Monomial, Monomial), usize> = BTreeMap::new();
        let (mut terms, mut count) = (Vec::new(), 0);
        let mut row = |component: usize, monomial: &Monomial, constant: &Monomial| {
            let next = rows.len();
            let key = (component, monomial.clone(), constant.clone());
            *rows.entry(key).or_insert(next)
        };
        for (k, integral) in integrals.iter().enumerate() {
            let columns = columns(field, integral)?;
            count = columns.len();
            for (n, column) in columns.iter().enumerate() {
                for (component, element) in column.iter().enumerate() {
                    for (monomial, coefficient) in element.terms() {
                        for (constant, number) in coefficient.terms() {
                            let row = row(component, monomial, constant);
                            terms.push((row, n, k, number.to_f64()));
                        }
                    }
                }
            }
        }
        let mut known = Vec::new();
        for (component, element) in field.f.iter().enumerate() {
            for (monomial, coefficient) in element.terms() {
                for (constant, number) in coefficient.terms() {
                    known.push((row(component, monomial, constant), number.to_f64()));
                }
            }
        }
        let mut right = vec![0.0; rows.len()];
        known.iter().for_each(|(row, value)| right[*row] += value);
        Ok(Self {
            terms,
            right,
            coefficients: count,
            integrals: integrals.len(),
        })
    }

    /// The values of all equations at c and a behind each other.
    fn residual(&self, identity: &Identity, t: &[f64]) -> Vec<f64> {
        let (c, a) = t.split_at(self.coefficients);
        let mut r: Vec<f64> = self.right.iter().map(|v| -v).collect();
        for (row, n, k, value) in &self.terms {
            r[*row] += value * c[*n] * a[*k];
        }
        let mut jacobi = Vec::new();
        identity.bilinear(c, c, &mut jacobi);
        r.extend(jacobi);
        r
    }

    /// Columns of their derivatives, by c and by the aₖ that are free.
    fn slopes(&self, identity: &Identity, t: &[f64], free: &[usize]) -> Vec<Vec<f64>> {
        let (c, a) = t.split_at(self.coefficients);
        let size = self.right.len();
        let mut slopes = vec![vec![0.0; size]; self.coefficients];
        let mut by_a = vec![vec![0.0; size]; self.integrals];
        for (row, n, k, value) in &self.terms {
            slopes[*n][*row] += value * a[*k];
            by_a[*k][*row] += value * c[*n];
        }
        let (mut left, mut right) = (Vec::new(), Vec::new());
        let mut unit = vec![0.0; c.len()];
        for (n, slope) in slopes.iter_mut().enumerate() {
            unit[n] = 1.0;
            identity.bilinear(c, &unit, &mut left);
            identity.bilinear(&unit, c, &mut right);
            unit[n] = 0.0;
            slope.extend(left.iter().zip(&right).map(|(a, b)| a + b));
        }
        let of_identity = left.len();
        slopes.extend(free.iter().map(|k| {
            let mut slope = by_a[*k].clone();
            slope.resize(size + of_identity, 0.0);
            slope
        }));
        slopes
    }

    /// c and a near these, with the aₖ that are free.
    fn solved(
        &self,
        identity: &Identity,
        t: &[f64],
        free: &[usize],
        iterations: usize,
    ) -> Option<Vec<f64>> {
        let whole = |own: &[f64]| {
            let mut whole = t.to_vec();
            let (c, a) = own.split_at(self.coefficients);
            whole[..self.coefficients].copy_from_slice(c);
            for (k, value) in free.iter().zip(a) {
                whole[self.coefficients + k] = *value;
            }
            whole
        };
        let mut start = t[..self.coefficients].to_vec();
        start.extend(free.iter().map(|k| t[self.coefficients + k]));
        let residual = |own: &[f64]| self.residual(identity, &whole(own));
        let slopes = |own: &[f64]| self.slopes(identity, &whole(own), free);
        let scale = |own: &[f64]| own.iter().map(|v| v * v).sum::<f64>().max(1.0);
        let found = least_squares(start, iterations, (&residual, &slopes, &scale))?;
        Some(whole(&found))
    }
}

/// Rational a for which Π ∇H = f has a Poisson solution in doubles; `None` where none is found.
pub(crate) fn hamiltonian(
    field: &mut RingField,
    integrals: &[Polynomial],
    identity: &Identity,
) -> Result<Option<Vec<Rational>>, AlgebraError> {
    let count = integrals.len();
    if !(2..=MOST_INTEGRALS).contains(&count) || field.dimension() > MOST_VARIABLES {
        return Ok(None);
    }
    let equations = Bilinear::of(field, integrals)?;
    let all: Vec<usize> = (0..count).collect();
    let mut phase = 0.25_f64;
    let mut next = || {
        phase = (phase + 0.618_033_988_749_894_9) % 1.0;
        2.0 * phase - 1.0
    };
    // Integrals with many terms first: the energy is among them.
    for _ in 0..STARTS {
        for own in (0..count).rev() {
            let mut t: Vec<f64> = (0..equations.coefficients).map(|_| 0.3 * next()).collect();
            t.extend((0..count).map(|k| if k == own { 1.0 } else { 0.3 * next() }));
            let found = equations.solved(identity, &t, &all, MOST_ITERATIONS);
            if let Some(found) = found
                && let Some(choice) = simplest(&equations, identity, found)
            {
                return Ok(Some(choice));
            }
        }
    }
    Ok(None)
}

/// The solution with few and simple aₖ near one.
fn simplest(equations: &Bilinear, identity: &Identity, mut t: Vec<f64>) -> Option<Vec<Rational>> {
    let first = equations.coefficients;
    let largest = t[first..].iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    // The last of the large ones has the scale.
    let own = (0..equations.integrals).rfind(|k| t[first + k].abs() >= LARGE * largest)?;
    let scale = t[first + own];
    t[..first].iter_mut().for_each(|c| *c *= scale);
    t[first..].iter_mut().for_each(|a| *a /= scale);
    let mut choice = vec![Rational::zero(); equations.integrals];
    choice[own] = Rational::one();
    let mut free: Vec<usize> = (0..equations.integrals).filter(|k| *k != own).collect();
    let mut order = free.clone();
    order.sort_by(|a, b| t[first + a].abs().total_cmp(&t[first + b].abs()));
    let mut fix = |t: &mut Vec<f64>, free: &mut Vec<usize>, at: usize, value: &Rational| {
        let mut trial = t.clone();
        trial[first + at] = value.to_f64();
        let others: Vec<usize> = free.iter().copied().filter(|k| *k != at).collect();
        let solved = equations.solved(identity, &trial, &others, MOST_NEAR);
        solved.map(|solved| {
            (*t, *free) = (solved, others);
            choice[at] = value.clone();
        })
    };
    for at in order {
        let _ = fix(&mut t, &mut free, at, &Rational::zero());
    }
    while let Some(&at) = free.first() {
        let values = fractions(t[first + at]);
        let mut values = values.iter();
        values.find_map(|value| fix(&mut t, &mut free, at, value))?;
    }
    Some(choice)
}
