//! A bound of the eigenvalues of W = Z²/4, and where the exponential chart ends.

use leafwise_core::StepError;
use leafwise_core::solver::judge::larger;
use nalgebra::{DMatrix, DVector, Schur};

use crate::even_part::LARGEST;

/// Iterations of the eigenvalue solver for each eigenvalue, ten times what it takes.
const MOST_ITERATIONS: usize = 30;

/// Tolerance below which the eigenvalue solver takes an entry for 0, beside the norm: 2⁻³⁶. On multiple pairs it stalls
/// at a thousand roundings, and that near the wall α has lost all digits.
const NEGLIGIBLE: f64 = 1.0 / 68_719_476_736.0;

/// Bases in which the eigenvalue solver is tried: in one out of a thousand it goes in circles.
const MOST_BASES: usize = 8;

/// After so many sweeps rows and columns of matrices of any units are alike.
const MOST_SWEEPS: usize = 16;

pub(crate) const SINGULAR: StepError = StepError::NonFinite {
    what: "the inverse of a function of the coadjoint map",
};

/// A bound of every eigenvalue of a d × d matrix, row-major, whatever the units of the coordinates. It is the norm, and
/// where that is large the norm in units that make rows and columns alike.
pub(crate) fn spectral_bound(matrix: &[f64], d: usize) -> f64 {
    use std::f64::consts::PI;
    let plain = norm(matrix, d);
    if plain < PI * PI || !plain.is_finite() {
        return plain;
    }
    plain.min(norm(&balanced(matrix, d), d))
}

/// S⁻¹AS with a diagonal S for which the off-diagonal sums of each row and of its column are about the same (E. Osborne, *On
/// pre-conditioning of matrices*, J. ACM 7 (1960)).
fn balanced(matrix: &[f64], d: usize) -> Vec<f64> {
    let mut a = matrix.to_vec();
    for _ in 0..MOST_SWEEPS {
        for i in 0..d {
            let others = (0..d).filter(|j| *j != i);
            let sums = others.map(|j| (a[i * d + j].abs(), a[j * d + i].abs()));
            let (row, column) = sums.fold((0.0, 0.0), |(r, c), (x, y)| (r + x, c + y));
            let factor = libm::sqrt(row / column);
            if factor.is_finite() && factor > 0.0 {
                a[i * d..][..d].iter_mut().for_each(|v| *v /= factor);
                let column = a[i..].iter_mut().step_by(d);
                column.for_each(|v| *v *= factor);
            }
        }
    }
    a
}

/// The smaller of the row sum and the column sum norm: a bound of every eigenvalue.
fn norm(matrix: &[f64], d: usize) -> f64 {
    let (mut rows, mut columns) = (0.0, 0.0);
    for i in 0..d {
        let (mut row, mut column) = (0.0, 0.0);
        for k in 0..d {
            row += matrix[i * d + k].abs();
            column += matrix[k * d + i].abs();
        }
        (rows, columns) = (larger(rows, row), larger(columns, column));
    }
    if rows <= columns { rows } else { columns }
}

/// Refuses Z with an eigenvalue of imaginary part 2π or more: along p ↦ τp one of them met ±2πi. The argument `bound`
/// is a norm of Z²/4, so that |λ| ≤ 2√bound.
pub(crate) fn check_chart(map: &[f64], d: usize, bound: f64) -> Result<(), StepError> {
    use std::f64::consts::PI;
    if !bound.is_finite() {
        return Err(StepError::NonFinite {
            what: "the coadjoint map",
        });
    }
    if bound > LARGEST {
        return Err(StepError::LeftChart {
            ratio: libm::sqrt(bound / LARGEST),
        });
    }
    if bound < PI * PI {
        return Ok(());
    }
    let balanced = DMatrix::from_row_slice(d, d, &balanced(map, d));
    let widest = widest_frequency(&balanced).ok_or(SINGULAR)?;
    if widest < 2.0 * PI {
        return Ok(());
    }
    Err(StepError::LeftChart {
        ratio: widest / (2.0 * PI),
    })
}

/// The largest |Im λ|, `None` where the solver fails in every basis.
fn widest_frequency(map: &DMatrix<f64>) -> Option<f64> {
    let d = map.nrows();
    // The solver compares an entry with its diagonal neighbours, which eigenvalues near 0 leave
    // without a size: a shift gives them one and moves no imaginary part.
    let mut shifted = map + DMatrix::identity(d, d) * norm(map.as_slice(), d);
    for basis in 1..=MOST_BASES {
        if let Some(schur) = Schur::try_new(shifted.clone(), NEGLIGIBLE, MOST_ITERATIONS * d) {
            let eigenvalues = schur.complex_eigenvalues();
            return Some(eigenvalues.iter().fold(0.0, |m: f64, v| m.max(v.im.abs())));
        }
        let mirror = DVector::from_fn(d, |i, _| libm::sin((1 + i) as f64 * basis as f64));
        let square = mirror.norm_squared();
        let reflection = DMatrix::identity(d, d) - &mirror * mirror.transpose() * (2.0 / square);
        shifted = &reflection * shifted * &reflection;
    }
    None
}
