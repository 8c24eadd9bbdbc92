//! The linearized motion within a leaf, in units of its own, and what it says about stability.

use thiserror::Error;

use super::equations::largest;
use super::linear::{Columns, Complex, SingularValues, dot, eigenvalues};
use super::units::Units;

/// Singular values of the tensor that are no zeros, over the largest.
const RANK: f64 = 1e-9;

/// Curvatures that are no zeros, over the largest.
const CURVED: f64 = 1e-9;

/// A real part above this, over the largest size of an eigenvalue, is that of an unstable motion. Two eigenvalues that meet on the
/// axis are known to the root of the round-off.
const GROWS: f64 = 1e-7;

/// Eigenvalues of several zeros are known to higher roots of it.
const ZERO: f64 = 1e-3;

/// The verdict on an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Its leaf is a point.
    Alone,
    /// The energy is a strict minimum or maximum in the leaf: neighbours stay near for all times.
    Stable,
    /// No neighbour parts exponentially; the energy is no strict extremum, and does not decide.
    SpectrallyStable,
    /// Neighbours part exponentially.
    Unstable,
    /// Zeros among the eigenvalues hide whether others are none.
    Undecided,
}

/// Columns of −Π, with which the motion is −Π∇H, and of the derivatives of the motion.
#[derive(Clone)]
pub(super) struct Linear {
    pub tensor: Columns,
    pub motion: Columns,
}

/// Eigenvalues that do not converge.
#[derive(Debug, Error)]
#[error("the eigenvalues of the linearized motion do not converge")]
pub struct NoEigenvalues;

/// The linearized motion in the leaf, in units.
pub(super) struct Leaf {
    /// Orthonormal directions.
    pub basis: Columns,
    /// The dimension of the leaf of the state to begin with.
    pub dimension_at_first: usize,
    motion: Columns,
    pub eigenvalues: Vec<Complex>,
    /// S, symmetric.
    variation: Columns,
    /// Its eigenvalues, in order.
    curvatures: Vec<f64>,
}

impl Leaf {
    pub fn of(units: &Units, here: &Linear, first: &Linear) -> Result<Self, NoEigenvalues> {
        let (own, motion) = (units.tensor(&here.tensor), units.motion(&here.motion));
        let parts = SingularValues::of(&own);
        let before = SingularValues::of(&units.tensor(&first.tensor)).values;
        let least = RANK * parts.values[0].max(before[0]);
        let rank = |values: &[f64]| values.iter().filter(|value| **value > least).count();
        let count = rank(&parts.values);
        let basis = parts.left[..count].to_vec();
        let motion = within(&basis, &motion);
        let inverse = SingularValues::of(&within(&basis, &own));
        let solved: Columns = (motion.iter())
            .map(|column| inverse.solve(column, 0.0))
            .collect();
        let variation = (0..count)
            .map(|j| {
                let entries = (0..count).map(|i| 0.5 * (solved[j][i] + solved[i][j]));
                entries.collect()
            })
            .collect();
        Ok(Self {
            eigenvalues: eigenvalues_of(&motion)?,
            curvatures: in_order(&variation)?,
            basis,
            dimension_at_first: rank(&before),
            motion,
            variation,
        })
    }

    /// The largest curvature.
    pub fn steepness(&self) -> f64 {
        largest(&self.curvatures)
    }

    /// Curvatures in an orthonormal basis of the scene's coordinates.
    pub fn curvatures_outside(&self, units: &Units) -> Result<Vec<f64>, NoEigenvalues> {
        let outside: Columns = self.basis.iter().map(|v| units.outside(v)).collect();
        let parts = SingularValues::of(&outside);
        let scaled = within(&parts.right, &self.variation);
        let factor = units.action / units.time;
        let columns = scaled.iter().zip(&parts.values).map(|(column, size)| {
            let entries = column.iter().zip(&parts.values);
            entries.map(|(s, own)| factor * s / (size * own)).collect()
        });
        in_order(&columns.collect())
    }

    pub fn verdict(&self) -> Verdict {
        let (Some(least), Some(most)) = (self.curvatures.first(), self.curvatures.last()) else {
            return Verdict::Alone;
        };
        let flat = CURVED * self.steepness();
        if *least > flat || *most < -flat {
            return Verdict::Stable;
        }
        let scale = SingularValues::of(&self.motion).values;
        let size = scale[0];
        let is_singular = scale.last().is_some_and(|least| *least <= CURVED * size);
        let mut grows = (self.eigenvalues.iter()).filter(|of| of.re > GROWS * size);
        match grows.next() {
            None => Verdict::SpectrallyStable,
            Some(first) if is_singular && first.modulus() <= ZERO * size => Verdict::Undecided,
            Some(_) => Verdict::Unstable,
        }
    }
}

fn eigenvalues_of(matrix: &Columns) -> Result<Vec<Complex>, NoEigenvalues> {
    eigenvalues(matrix).ok_or(NoEigenvalues)
}

/// The eigenvalues of a symmetric matrix.
fn in_order(symmetric: &Columns) -> Result<Vec<f64>, NoEigenvalues> {
    let mut values: Vec<f64> = eigenvalues_of(symmetric)?.iter().map(|of| of.re).collect();
    values.sort_by(f64::total_cmp);
    Ok(values)
}

/// BᵀAB of a matrix by its columns.
fn within(basis: &Columns, matrix: &Columns) -> Columns {
    let moved = basis.iter().map(|v| applied(matrix, v));
    moved
        .map(|moved| basis.iter().map(|w| dot(w, &moved)).collect())
        .collect()
}

fn applied(matrix: &Columns, v: &[f64]) -> Vec<f64> {
    let mut moved = vec![0.0; matrix.first().map_or(0, Vec::len)];
    for (part, column) in v.iter().zip(matrix) {
        moved
            .iter_mut()
            .zip(column)
            .for_each(|(m, c)| *m += part * c);
    }
    moved
}
