//! Coefficients of Ŝ/h and the points y of the pairs, in turn.

use leafwise_core::StepError;
use nalgebra::{DMatrix, DVector};

use crate::basis::Basis;
use crate::error::LearnError;
use crate::geometry::{Geometry, TensorAt};
use crate::pairs::StatePairs;
use crate::squares::{Columns, Squares};

/// The most solves for the coefficients.
const MOST_SWEEPS: usize = 16;

/// The most corrections of a point y between two of these.
const MOST_CORRECTIONS: usize = 50;

/// Changes of y that are round-off, relative to the largest coordinate.
const SMALL: f64 = 4.0 * f64::EPSILON;

/// Sweeps that changed y by less than this part of the motion have converged.
const CONVERGED: f64 = 1e-9;

/// The most numbers of the matrix of least squares.
const MOST_NUMBERS: usize = 1 << 26;

/// Failure of a function of the basis.
const OUTSIDE: StepError = StepError::NonFinite {
    what: "the basis",
};

/// Setting of a fit beside pairs and basis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FitSetting {
    /// h.
    pub h: f64,
    /// λ, relative to columns of unit length.
    pub ridge: f64,
    /// Whether both states of a pair have errors, which are corrected too.
    pub has_noise: bool,
}

/// Coefficients of Ŝ/h and what is left.
pub(crate) struct Fitted {
    /// The matrix of the last solve: rows Qᵀ(−εhΠ)∇f, r of them for each pair.
    pub matrix: Columns,
    /// Its right sides.
    pub right: Vec<f64>,
    /// The pair of every row.
    pub pair_of: Vec<usize>,
    pub squares: Squares,
    /// Mean square of what is left along leaves, over the degrees of freedom.
    pub noise: f64,
    /// Root mean square of what is left along leaves.
    pub residual: f64,
    /// Root mean square of x' − x, and of its part that no H makes, each per direction.
    pub motion: f64,
    pub off_leaf: Option<f64>,
    pub sweeps: usize,
    pub is_converged: bool,
}

/// Row of a state: Qᵀ(−εhΠ(x))∇f(x), and the same for every direction of its leaf.
pub(crate) fn rows_at(
    tensor: &TensorAt,
    slopes: &[f64],
    factor: f64,
) -> DMatrix<f64> {
    let d = tensor.matrix.nrows();
    let slopes = DMatrix::from_column_slice(d, slopes.len() / d, slopes);
    (tensor.range.transpose() * (&tensor.matrix * factor)) * slopes
}

/// Coefficients of Ŝ/h by least squares.
pub(crate) fn fit(
    geometry: &mut Geometry,
    pairs: &StatePairs,
    basis: &Basis,
    names: &[String],
    setting: FitSetting,
) -> Result<Fitted, LearnError> {
    let (count, d, n) = (pairs.len(), pairs.dimension(), basis.len());
    let means: Vec<Vec<f64>> = (0..count)
        .map(|k| {
            let ends = pairs.before(k).iter().zip(pairs.after(k));
            ends.map(|(a, b)| a / 2.0 + b / 2.0).collect()
        })
        .collect();
    let moved: Vec<Vec<f64>> = (0..count)
        .map(|k| {
            let ends = pairs.before(k).iter().zip(pairs.after(k));
            ends.map(|(a, b)| b - a).collect()
        })
        .collect();
    let largest = means.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
    let total: f64 = moved.iter().flatten().map(|b| b * b).sum();
    if total == 0.0 {
        return Err(LearnError::NoMotion);
    }
    let motion = libm::sqrt(total / (count * d) as f64);
    let mut points = means.clone();
    // What the leading part −εΠ(y)p leaves out, and corrections of noisy states.
    let mut further = vec![vec![0.0; d]; count];
    let mut shifts = vec![vec![0.0; d]; count];
    let mut sweeps = 0;
    loop {
        sweeps += 1;
        let mut rows: Vec<(usize, Vec<f64>, f64)> = Vec::new();
        let mut all_slopes = Vec::with_capacity(count);
        let (mut off, mut off_directions) = (0.0, 0);
        for k in 0..count {
            let outside = |error| LearnError::Outside { pair: k + 1, error };
            let tensor = geometry.tensor(&points[k]).map_err(outside)?;
            let slopes = values_at(basis, &points[k], names, k)?.1;
            let right: Vec<f64> = moved[k].iter().zip(&further[k]).map(|(b, f)| b - f).collect();
            let right = DVector::from_vec(right);
            let matrix = rows_at(&tensor, &slopes, setting.h);
            let along = tensor.range.transpose() * &right;
            let rest = &right - &tensor.range * &along;
            off += rest.norm_squared();
            off_directions += d - along.len();
            let weight = libm::sqrt(pairs.weight(k));
            for i in 0..along.len() {
                let row = matrix.row(i).iter().map(|a| a * weight).collect();
                rows.push((k, row, along[i] * weight));
            }
            all_slopes.push(slopes);
        }
        if rows.len() < n {
            let rank = (rows.len() as f64 / count as f64).max(1e-9);
            return Err(match rows.is_empty() {
                true => LearnError::Singular,
                false => LearnError::TooFew {
                    pairs: count,
                    equations: rows.len(),
                    functions: n,
                    needed: (n as f64 / rank).ceil() as usize,
                },
            });
        }
        if rows.len().saturating_mul(n) > MOST_NUMBERS {
            return Err(LearnError::TooLarge {
                rows: rows.len(),
                functions: n,
                most: MOST_NUMBERS,
            });
        }
        let mut matrix = Columns::zeros(rows.len(), n);
        for j in 0..n {
            for (a, row) in matrix.column_mut(j).iter_mut().zip(&rows) {
                *a = row.1[j];
            }
        }
        let right: Vec<f64> = rows.iter().map(|row| row.2).collect();
        let pair_of: Vec<usize> = rows.iter().map(|row| row.0).collect();
        drop(rows);
        let squares = Squares::solve(&matrix, &right, setting.ridge);
        if squares.rank == 0 {
            return Err(LearnError::Singular);
        }
        // Points y of the same pairs under the new coefficients.
        let mut change = 0.0_f64;
        for k in 0..count {
            let outside = |error| LearnError::Outside { pair: k + 1, error };
            let covector = |slopes: &[f64]| covector(slopes, &squares.solution, d, setting.h);
            if setting.has_noise {
                let right: Vec<f64> = moved[k].iter().zip(&further[k]).map(|(b, f)| b - f).collect();
                let shift = correction(geometry, basis, (&points[k], &shifts[k]), &right, &squares.solution, setting.h);
                if let Some(shift) = shift {
                    shifts[k].iter_mut().zip(&shift).for_each(|(all, own)| *all += own);
                }
            }
            let mut y = points[k].clone();
            let mut p = covector(&all_slopes[k]);
            for _ in 0..MOST_CORRECTIONS {
                let ends = geometry.ends(&y, &p).map_err(outside)?;
                let mut largest_change = 0.0_f64;
                for i in 0..d {
                    let by = means[k][i] + shifts[k][i] - ends.mean[i];
                    y[i] += by;
                    largest_change = largest_change.max(by.abs());
                }
                p = covector(&values_at(basis, &y, names, k)?.1);
                if largest_change <= SMALL * largest {
                    break;
                }
            }
            let ends = geometry.ends(&y, &p).map_err(outside)?;
            let leading = &geometry.tensor(&y).map_err(outside)?.matrix * DVector::from_vec(p);
            for i in 0..d {
                further[k][i] = ends.increment[i] - leading[i];
                change = change.max((y[i] - points[k][i]).abs());
            }
            if !change.is_finite() {
                return Err(outside(OUTSIDE));
            }
            points[k] = y;
        }
        let is_converged = change <= CONVERGED * motion;
        if change <= SMALL * largest || sweeps == MOST_SWEEPS {
            let found = matrix.times(&squares.solution);
            let left: f64 = found.iter().zip(&right).map(|(f, b)| (f - b) * (f - b)).sum();
            let freedom = right.len().saturating_sub(squares.rank);
            return Ok(Fitted {
                noise: left / freedom.max(1) as f64,
                residual: libm::sqrt(left / right.len() as f64),
                motion,
                off_leaf: (off_directions > 0).then(|| libm::sqrt(off / off_directions as f64)),
                matrix,
                right,
                pair_of,
                squares,
                sweeps,
                is_converged,
            });
        }
    }
}

/// p = h ∇(Ŝ/h).
fn covector(slopes: &[f64], coefficients: &[f64], d: usize, h: f64) -> Vec<f64> {
    let mut p = vec![0.0; d];
    for (slopes, c) in slopes.chunks(d).zip(coefficients) {
        for (p, slope) in p.iter_mut().zip(slopes) {
            *p += h * c * slope;
        }
    }
    p
}

/// Values and slopes of the basis at a point of a pair.
pub(crate) fn values_at(
    basis: &Basis,
    y: &[f64],
    names: &[String],
    pair: usize,
) -> Result<(Vec<f64>, Vec<f64>), LearnError> {
    basis.values(y).ok_or_else(|| match basis.outside(y) {
        Some(i) => LearnError::Logarithm {
            pair: pair + 1,
            variable: names[i].clone(),
            value: y[i],
        },
        None => LearnError::Outside {
            pair: pair + 1,
            error: OUTSIDE,
        },
    })
}

/// The further shift s of y that makes 4|δ + s|² + |b − F(y + s)|² least to first order, F(y) = −εΠ(y) dŜ(y), beside the shift δ so far. Of
/// errors of one size in x and x' the mean has half the variance of each, and the difference has twice of it.
fn correction(
    geometry: &mut Geometry,
    basis: &Basis,
    (y, shift): (&[f64], &[f64]),
    right: &[f64],
    coefficients: &[f64],
    h: f64,
) -> Option<Vec<f64>> {
    let d = y.len();
    let mut field = |y: &[f64]| -> Option<DVector<f64>> {
        let slopes = basis.values(y)?.1;
        let p = covector(&slopes, coefficients, d, h);
        Some(&geometry.tensor(y).ok()?.matrix * DVector::from_vec(p))
    };
    let left = DVector::from_column_slice(right) - field(y)?;
    let mut slope = DMatrix::zeros(d, d);
    for j in 0..d {
        // Central differences: their error of 1e-10 is far below that of the noise.
        let by = 1e-5 * y[j].abs().max(1e-2);
        let (mut up, mut down) = (y.to_vec(), y.to_vec());
        up[j] += by;
        down[j] -= by;
        slope.set_column(j, &((field(&up)? - field(&down)?) / (2.0 * by)));
    }
    let normal = DMatrix::identity(d, d) * 4.0 + slope.transpose() * &slope;
    let right = slope.transpose() * left - DVector::from_column_slice(shift) * 4.0;
    let shift = normal.lu().solve(&right)?;
    Some(shift.iter().copied().collect())
}
