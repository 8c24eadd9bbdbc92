//! Coefficients of Ŝ/h and the points y of the pairs, in turn.

use leafwise_core::StepError;
use nalgebra::{DMatrix, DVector};

use crate::basis::Basis;
use crate::error::LearnError;
use crate::geometry::{Geometry, TensorAt};
use crate::pairs::StatePairs;
use crate::squares::{ColumnMatrix, Squares};

/// The most solves for the coefficients.
const MOST_SWEEPS: usize = 24;

/// The most corrections of a point y between two of these.
const MOST_CORRECTIONS: usize = 50;

/// Changes of y that are round-off, relative to the largest coordinate.
pub(crate) const SMALL: f64 = 4.0 * f64::EPSILON;

/// Sweeps that changed y by less than this part of the motion have converged.
const CONVERGED: f64 = 1e-9;

/// Columns count as dependent below this part of the first pivot in the first sweep. Later sweeps take the residual before them: no direction is
/// determined that moves the pairs by less.
const FIRST_TOLERANCE: f64 = 1e-6;

/// No tolerance is smaller, for the residual of exact pairs is round-off.
const LEAST_TOLERANCE: f64 = 1e-10;

/// The tolerance grows so much where a point leaves the realization, up to the largest one.
const GROWTH: f64 = 30.0;
const LARGEST_TOLERANCE: f64 = 1e-2;

/// The most numbers of the matrix of least squares.
const MOST_NUMBERS: usize = 1 << 26;

/// Failure of a function of the basis.
const OUTSIDE: StepError = StepError::NonFinite { what: "the basis" };

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
    pub matrix: ColumnMatrix,
    /// Its right sides.
    pub right: Vec<f64>,
    /// The pair of every row.
    pub pair_of: Vec<usize>,
    pub squares: Squares,
    /// Mean square of what is left along leaves, over the degrees of freedom.
    pub noise: f64,
    /// Root mean square of what is left along leaves. This and the others are means by the pairs' weights.
    pub residual: f64,
    /// Root mean square of x' − x, and of its part that no H makes, each per direction.
    pub motion: f64,
    pub off_leaf: Option<f64>,
    /// Columns that depend on others to this part do not count.
    pub tolerance: f64,
    pub sweeps: usize,
    pub has_settled: bool,
}

/// Row of a state: Qᵀ(−εhΠ(x))∇f(x), and the same for every direction of its leaf.
pub(crate) fn rows_at(tensor: &TensorAt, slopes: &[f64], factor: f64) -> DMatrix<f64> {
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
    pairs.checked_units(names)?;
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
    let largest = means
        .iter()
        .flatten()
        .fold(0.0_f64, |most, x| most.max(x.abs()));
    let square = |v: &[f64]| v.iter().map(|b| b * b).sum::<f64>();
    let total: f64 = (0..count)
        .map(|k| pairs.weight(k) * square(&moved[k]))
        .sum();
    if total == 0.0 {
        return Err(LearnError::NoMotion);
    }
    let motion = libm::sqrt(total / (count * d) as f64);
    let mut points = means.clone();
    // What the leading part −εΠ(y)p leaves out, and corrections of noisy states.
    let mut further = vec![vec![0.0; d]; count];
    let mut shifts = vec![vec![0.0; d]; count];
    let mut sweeps = 0;
    let mut tolerance = FIRST_TOLERANCE;
    let mut least = LEAST_TOLERANCE;
    loop {
        sweeps += 1;
        let mut rows: Vec<(usize, Vec<f64>, f64)> = Vec::new();
        let (mut off, mut off_directions) = (0.0, 0);
        for k in 0..count {
            let outside = |error| LearnError::Outside {
                pair: pairs.number(k),
                error,
            };
            let tensor = geometry.tensor(&points[k]).map_err(outside)?;
            let slopes = values_at(basis, &points[k], names, pairs.number(k))?.1;
            let right: Vec<f64> = moved[k]
                .iter()
                .zip(&further[k])
                .map(|(b, f)| b - f)
                .collect();
            let right = DVector::from_vec(right);
            let matrix = rows_at(&tensor, &slopes, setting.h);
            let along = tensor.range.transpose() * &right;
            let rest = &right - &tensor.range * &along;
            off += pairs.weight(k) * rest.norm_squared();
            off_directions += d - along.len();
            let weight = libm::sqrt(pairs.weight(k));
            for i in 0..along.len() {
                let row = matrix.row(i).iter().map(|a| a * weight).collect();
                rows.push((k, row, along[i] * weight));
            }
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
        let mut matrix = ColumnMatrix::zeros(rows.len(), n);
        for j in 0..n {
            for (a, row) in matrix.column_mut(j).iter_mut().zip(&rows) {
                *a = row.1[j];
            }
        }
        let right: Vec<f64> = rows.iter().map(|row| row.2).collect();
        let pair_of: Vec<usize> = rows.iter().map(|row| row.0).collect();
        drop(rows);
        let squares = Squares::solve(&matrix, &right, setting.ridge, tolerance);
        if squares.rank == 0 {
            return Err(LearnError::Singular);
        }
        let found = matrix.times(&squares.solution);
        let left: f64 = found
            .iter()
            .zip(&right)
            .map(|(f, b)| (f - b) * (f - b))
            .sum();
        let residual = libm::sqrt(left / right.len() as f64);
        let before = tolerance;
        tolerance = tolerance
            .min(residual / motion / libm::sqrt(right.len() as f64))
            .max(least);
        // Points y of the same pairs under the new coefficients.
        let mut change = 0.0_f64;
        let mut outside = None;
        for k in 0..count {
            if setting.has_noise {
                let right: Vec<f64> = moved[k]
                    .iter()
                    .zip(&further[k])
                    .map(|(b, f)| b - f)
                    .collect();
                let at = (&points[k][..], &shifts[k][..]);
                if let Some(shift) =
                    correction(geometry, basis, at, &right, &squares.solution, setting.h)
                {
                    shifts[k]
                        .iter_mut()
                        .zip(&shift)
                        .for_each(|(all, own)| *all += own);
                }
            }
            let mean: Vec<f64> = means[k]
                .iter()
                .zip(&shifts[k])
                .map(|(x, s)| x + s)
                .collect();
            let moved = corrected(
                geometry,
                basis,
                (&points[k], &mean),
                &squares.solution,
                (setting.h, SMALL * largest),
            );
            match moved {
                Ok((y, rest)) => {
                    let by = y.iter().zip(&points[k]).map(|(a, b)| (a - b).abs());
                    change = by.fold(change, f64::max);
                    points[k] = y;
                    further[k] = rest;
                }
                Err(error) => {
                    outside = Some(LearnError::Outside {
                        pair: pairs.number(k),
                        error,
                    });
                    break;
                }
            }
        }
        if let Some(error) = outside {
            // Directions that the pairs hardly tell may have coefficients that lead anywhere.
            least = before * GROWTH;
            if least > LARGEST_TOLERANCE || sweeps >= MOST_SWEEPS {
                return Err(error);
            }
            tolerance = least;
            points.clone_from(&means);
            further.iter_mut().for_each(|f| f.fill(0.0));
            continue;
        }
        let has_settled = change <= CONVERGED * motion;
        // Columns that were left out may count by the smaller tolerance.
        let is_whole = squares.rank == n || tolerance >= before;
        if (change <= SMALL * largest && is_whole) || sweeps == MOST_SWEEPS {
            let freedom = right.len().saturating_sub(squares.rank);
            return Ok(Fitted {
                noise: left / freedom.max(1) as f64,
                residual,
                tolerance: before,
                motion,
                off_leaf: (off_directions > 0).then(|| libm::sqrt(off / off_directions as f64)),
                matrix,
                right,
                pair_of,
                squares,
                sweeps,
                has_settled,
            });
        }
    }
}

/// The point y with ends of this mean under p = dŜ(y), and what the leading part −εΠ(y)p leaves out of their difference.
pub(crate) fn corrected(
    geometry: &mut Geometry,
    basis: &Basis,
    (y, mean): (&[f64], &[f64]),
    coefficients: &[f64],
    (h, small): (f64, f64),
) -> Result<(Vec<f64>, Vec<f64>), StepError> {
    let mut y = y.to_vec();
    let covector_at = |y: &[f64]| {
        let slopes = basis.values(y).ok_or(OUTSIDE)?.1;
        Ok::<_, StepError>(covector(&slopes, coefficients, y.len(), h))
    };
    let mut p = covector_at(&y)?;
    for _ in 0..MOST_CORRECTIONS {
        let ends = geometry.ends(&y, &p)?;
        let mut change = 0.0_f64;
        for i in 0..y.len() {
            let by = mean[i] - ends.mean[i];
            y[i] += by;
            change = change.max(by.abs());
        }
        p = covector_at(&y)?;
        if change <= small {
            break;
        }
    }
    let ends = geometry.ends(&y, &p)?;
    let leading = &geometry.tensor(&y)?.matrix * DVector::from_vec(p);
    let rest: Vec<f64> = ends
        .increment
        .iter()
        .zip(&leading)
        .map(|(a, b)| a - b)
        .collect();
    match y.iter().chain(&rest).all(|value| value.is_finite()) {
        true => Ok((y, rest)),
        false => Err(OUTSIDE),
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

/// Values and slopes of the basis at a point of a pair, which has this place among those given.
pub(crate) fn values_at(
    basis: &Basis,
    y: &[f64],
    names: &[String],
    pair: usize,
) -> Result<(Vec<f64>, Vec<f64>), LearnError> {
    basis.values(y).ok_or_else(|| match basis.outside(y) {
        Some(i) => LearnError::Logarithm {
            pair,
            variable: names[i].clone(),
            value: y[i],
        },
        None => LearnError::Outside {
            pair,
            error: OUTSIDE,
        },
    })
}

/// The further shift s of y beside the shift δ so far. To first order it makes 4|δ + s|² + |b − F(y + s)|² least, with F(y) = −εΠ(y) dŜ(y). Of errors of one
/// size in x and x' the mean has half the variance of each, and the difference has twice of it.
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
