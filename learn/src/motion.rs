//! The learned map: its steps from the states of the pairs, and the Hamiltonian whose flow it is.
//!
//! Φʲ(x) are values of the flow of H̃ at the times jεh. Central differences of them give ẋ = −Π ∇H̃ at x, linear in the coefficients of H̃. That is the shadow
//! recursion backwards, H̃ = Ŝ/h − h² S_3 − …, with all its terms at once.

use leafwise_core::{Method, PoissonSystem, StepMap, Walk};
use nalgebra::DVector;

use crate::basis::Basis;
use crate::error::LearnError;
use crate::fit::{FitSetting, rows_at, values_at};
use crate::geometry::Geometry;
use crate::pairs::StatePairs;
use crate::squares::{ColumnMatrix, Squares};

/// The most steps to either side of a state.
const MOST: usize = 8;

/// Lanes of a walk.
const LANES: usize = 64;

/// H is recovered from at least this part of the states.
const LEAST_PART: f64 = 0.5;

/// The Hamiltonian of the learned map.
pub(crate) struct Recovered {
    /// Coefficients of H in the basis.
    pub coefficients: Vec<f64>,
    /// Root mean square of what differences of two orders and the basis leave of ẋ, relative to ẋ.
    pub error: f64,
}

/// x_{−m}, …, x_m for each state whose steps all succeed, from the states before the steps of the pairs.
pub(crate) struct Orbits {
    /// `[state][j + MOST]`.
    states: Vec<Vec<Vec<f64>>>,
    /// Root mean square of Φ(x) − x' over the pairs, `None` where no step succeeds.
    pub one_step: Option<f64>,
    /// How many pairs have a step that fails.
    pub failed: usize,
}

impl Orbits {
    /// Orbits of a map through the pairs.
    pub fn of(
        method: &Method,
        system: &PoissonSystem,
        pairs: &StatePairs,
        epsilon: f64,
        h: f64,
    ) -> Self {
        let (count, d) = (pairs.len(), pairs.dimension());
        let states: Vec<&[f64]> = (0..count).map(|k| pairs.before(k)).collect();
        let forward = walked(method, system, &states, epsilon, h);
        let backward = walked(method, system, &states, epsilon, -h);
        let (mut sum, mut made) = (0.0, 0);
        let mut found = Vec::new();
        for (k, (ahead, behind)) in forward.into_iter().zip(backward).enumerate() {
            if let Some(next) = ahead.first() {
                let errors = next.iter().zip(pairs.after(k));
                sum += errors.map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
                made += 1;
            }
            if ahead.len() == MOST && behind.len() == MOST {
                let mut orbit: Vec<Vec<f64>> = behind.into_iter().rev().collect();
                orbit.push(states[k].to_vec());
                orbit.extend(ahead);
                found.push(orbit);
            }
        }
        Self {
            states: found,
            one_step: (made > 0).then(|| libm::sqrt(sum / (made * d) as f64)),
            failed: count - made,
        }
    }

    /// H in the functions of the basis that are kept; `None` where too few orbits succeed.
    pub fn hamiltonian(
        &self,
        geometry: &mut Geometry,
        basis: &Basis,
        names: &[String],
        (kept, pairs, tolerance): (&[usize], usize, f64),
        epsilon: f64,
        setting: FitSetting,
    ) -> Result<Option<Recovered>, LearnError> {
        if (self.states.len() as f64) < LEAST_PART * pairs as f64 {
            return Ok(None);
        }
        let velocities: Vec<Vec<Vec<f64>>> = (1..=MOST)
            .map(|m| {
                let orbits = self.states.iter();
                orbits
                    .map(|orbit| slope(orbit, m, epsilon * setting.h))
                    .collect()
            })
            .collect();
        let distance = |a: &[Vec<f64>], b: &[Vec<f64>]| {
            let pairs = a.iter().flatten().zip(b.iter().flatten());
            let sum: f64 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
            libm::sqrt(sum)
        };
        // Orbits that leave the pairs' states, or fast motions, make differences of high orders worse.
        let best = (1..MOST)
            .map(|m| (m, distance(&velocities[m], &velocities[m - 1])))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((order, differences)) = best else {
            return Ok(None);
        };
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut right = Vec::new();
        for (k, (orbit, velocity)) in self.states.iter().zip(&velocities[order]).enumerate() {
            let x = &orbit[MOST];
            let outside = |error| LearnError::Outside { pair: k + 1, error };
            let tensor = geometry.tensor(x).map_err(outside)?;
            let slopes = values_at(basis, x, names, k)?.1;
            let matrix = rows_at(&tensor, &slopes, 1.0);
            let along = tensor.range.transpose() * DVector::from_column_slice(velocity) * epsilon;
            for i in 0..along.len() {
                rows.push(matrix.row(i).iter().copied().collect());
                right.push(along[i]);
            }
        }
        if rows.len() < kept.len() {
            return Ok(None);
        }
        let mut matrix = ColumnMatrix::zeros(rows.len(), kept.len());
        for (at, &j) in kept.iter().enumerate() {
            for (a, row) in matrix.column_mut(at).iter_mut().zip(&rows) {
                *a = row[j];
            }
        }
        let squares = Squares::solve(&matrix, &right, setting.ridge, tolerance);
        let found = matrix.times(&squares.solution);
        let left: f64 = found
            .iter()
            .zip(&right)
            .map(|(f, b)| (f - b) * (f - b))
            .sum();
        let total: f64 = right.iter().map(|b| b * b).sum();
        let mut coefficients = vec![0.0; basis.len()];
        for (&j, c) in kept.iter().zip(&squares.solution) {
            coefficients[j] = *c;
        }
        let error = (libm::sqrt(left) + epsilon * differences) / libm::sqrt(total);
        Ok(error.is_finite().then_some(Recovered {
            coefficients,
            error,
        }))
    }
}

/// Up to `MOST` states after each of these; fewer where a step fails.
fn walked(
    method: &Method,
    system: &PoissonSystem,
    states: &[&[f64]],
    epsilon: f64,
    h: f64,
) -> Vec<Vec<Vec<f64>>> {
    let d = method.dimension();
    let parameters = system.parameter_values();
    let mut found = Vec::with_capacity(states.len());
    for chunk in states.chunks(LANES) {
        let lanes = chunk.len();
        let values = parameters.iter().flat_map(|value| vec![*value; lanes]);
        let initial = (0..d).flat_map(|i| chunk.iter().map(move |state| state[i]));
        let (values, initial): (Vec<f64>, Vec<f64>) = (values.collect(), initial.collect());
        let mut walk = Walk::side_by_side(method, lanes, (&values, &initial), epsilon, h);
        let mut orbits: Vec<Vec<Vec<f64>>> = vec![Vec::new(); lanes];
        for step in 1..=MOST as u64 {
            // A failed lane rests, and its orbit is shorter.
            let _ = walk.step();
            for (lane, orbit) in orbits.iter_mut().enumerate() {
                let (made, state) = walk.last(lane);
                if made == step {
                    orbit.push(state);
                }
            }
        }
        found.extend(orbits);
    }
    found
}

/// The derivative at the middle of an orbit by central differences over m steps to either side, Σ_j w_j (x_j − x_{−j})/t. The weights are
/// w_j = (−1)^{j+1} m!²/(j (m − j)! (m + j)!) (B. Fornberg, *Math. Comp.* 51, 1988).
fn slope(orbit: &[Vec<f64>], m: usize, t: f64) -> Vec<f64> {
    let mut slope = vec![0.0; orbit[MOST].len()];
    let mut weight = 1.0;
    for j in 1..=m {
        // m!²/((m − j)! (m + j)!) = Π_{i ≤ j} (m − i + 1)/(m + i).
        weight *= (m - j + 1) as f64 / (m + j) as f64;
        let sign = if j % 2 == 1 { 1.0 } else { -1.0 };
        let factor = sign * weight / (j as f64 * t);
        let ends = orbit[MOST + j].iter().zip(&orbit[MOST - j]);
        for (slope, (ahead, behind)) in slope.iter_mut().zip(ends) {
            *slope += factor * (ahead - behind);
        }
    }
    slope
}
