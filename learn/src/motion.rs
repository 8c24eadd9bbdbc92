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

/// No larger s² is taken, for differences may be round-off: the rest of a series is at most 1000 times its last term.
const LARGEST_RATIO: f64 = 0.999;

/// H is recovered from at least this part of the states.
const LEAST_PART: f64 = 0.5;

/// The Hamiltonian of the learned map.
pub(crate) struct Recovered {
    /// Coefficients of H in the basis.
    pub coefficients: Vec<f64>,
    /// Bounds of what differences of all orders would change of them, and the ridge's part.
    pub uncertainty: Vec<f64>,
    /// The same of ẋ, root mean square and relative to ẋ.
    pub unresolved: f64,
    /// Root mean square of this and of what the basis leaves of ẋ, relative to ẋ.
    pub error: f64,
}

/// x_{−m}, …, x_m for each state whose steps all succeed, from the states before the steps of the pairs.
pub(crate) struct Orbits {
    /// `[state][j + MOST]`.
    states: Vec<Vec<Vec<f64>>>,
    /// The place of each state's pair among those given.
    numbers: Vec<usize>,
    /// Root mean square of Φ(x) − x' over the pairs, `None` where no step succeeds.
    pub one_step: Option<f64>,
    /// How many pairs have a step that fails.
    pub failed: usize,
}

impl Orbits {
    /// Orbits of a map through the pairs; one step alone where they are not to be long.
    pub fn of(
        method: &Method,
        system: &PoissonSystem,
        pairs: &StatePairs,
        (epsilon, h): (f64, f64),
        is_long: bool,
    ) -> Self {
        let (count, d) = (pairs.len(), pairs.dimension());
        let parameters = system.parameter_values();
        let states: Vec<&[f64]> = (0..count).map(|k| pairs.before(k)).collect();
        let orbits = |h: f64, steps: usize| -> Vec<Vec<Vec<f64>>> {
            walked(method, &parameters, &states, (epsilon, h), (steps, 1))
        };
        let forward = orbits(h, if is_long { MOST } else { 1 });
        let backward = orbits(-h, if is_long { MOST } else { 0 });
        let (mut sum, mut made, mut weights) = (0.0, 0, 0.0);
        let (mut found, mut numbers) = (Vec::new(), Vec::new());
        for (k, (ahead, behind)) in forward.into_iter().zip(backward).enumerate() {
            if let Some(next) = ahead.first() {
                let errors = next.iter().zip(pairs.after(k));
                let square: f64 = errors.map(|(a, b)| (a - b) * (a - b)).sum();
                sum += pairs.weight(k) * square;
                weights += pairs.weight(k);
                made += 1;
            }
            if ahead.len() == MOST && behind.len() == MOST {
                let mut orbit: Vec<Vec<f64>> = behind.into_iter().rev().collect();
                orbit.push(states[k].to_vec());
                orbit.extend(ahead);
                found.push(orbit);
                numbers.push(pairs.number(k));
            }
        }
        Self {
            states: found,
            numbers,
            one_step: (made > 0).then(|| libm::sqrt(sum / (weights * d as f64))),
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
        let distances: Vec<f64> = (1..MOST)
            .map(|m| distance(&velocities[m], &velocities[m - 1]))
            .collect();
        let best = (distances.iter().enumerate()).min_by(|a, b| a.1.total_cmp(b.1));
        let Some((at, &least)) = best else {
            return Ok(None);
        };
        let factor = rest_of_series(&distances, at);
        let differences = factor * least;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let (mut right, mut below) = (Vec::<f64>::new(), Vec::<f64>::new());
        for (k, orbit) in self.states.iter().enumerate() {
            let x = &orbit[MOST];
            let pair = self.numbers[k];
            let outside = |error| LearnError::Outside { pair, error };
            let tensor = geometry.tensor(x).map_err(outside)?;
            let slopes = values_at(basis, x, names, pair)?.1;
            let matrix = rows_at(&tensor, &slopes, 1.0);
            let along = |velocity: &[f64]| {
                tensor.range.transpose() * DVector::from_column_slice(velocity) * epsilon
            };
            right.extend(&along(&velocities[at + 1][k]));
            below.extend(&along(&velocities[at][k]));
            for row in matrix.row_iter() {
                rows.push(row.iter().copied().collect());
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
        let changes: Vec<f64> = right.iter().zip(&below).map(|(a, b)| a - b).collect();
        let change = Squares::solve(&matrix, &changes, setting.ridge, tolerance).solution;
        let bias = squares.ridge_bias();
        let (mut coefficients, mut uncertainty) = (vec![0.0; basis.len()], vec![0.0; basis.len()]);
        for (at, &j) in kept.iter().enumerate() {
            coefficients[j] = squares.solution[at];
            uncertainty[j] = factor * change[at] + bias[at];
        }
        let unresolved = epsilon * differences / libm::sqrt(total);
        let error = libm::sqrt(left / total) + unresolved;
        Ok(error.is_finite().then_some(Recovered {
            coefficients,
            uncertainty,
            unresolved,
            error,
        }))
    }
}

/// The sum of all further differences between orders, in units of the one at `at`, and 1 at least.
///
/// Of a motion e^{iωt} central differences over m steps are the first m terms of θ = sin θ Σ_k 4ᵏ k!²/(2k + 1)! s²ᵏ. Here θ = ωh
/// and s = sin(θ/2). Term k + 1 is s² (2k + 2)/(2k + 3) times term k. Hence two differences give s², and all later ones sum to less than s²/(1 − s²) of the last. Where
/// differences grow again beyond the least, that one is as near as they come.
fn rest_of_series(distances: &[f64], at: usize) -> f64 {
    if at + 1 < distances.len() || at == 0 || distances[at - 1] == 0.0 {
        return 1.0;
    }
    // The difference at `at` is term k + 1 = `at` + 1.
    let k = at as f64;
    let ratio = distances[at] / distances[at - 1] * (2.0 * k + 3.0) / (2.0 * k + 2.0);
    let ratio = ratio.min(LARGEST_RATIO);
    (ratio / (1.0 - ratio)).max(1.0)
}

/// States after each of these, `count` of them `every` so many steps; fewer where a step fails.
pub(crate) fn walked(
    map: &dyn StepMap,
    parameters: &[f64],
    states: &[&[f64]],
    (epsilon, h): (f64, f64),
    (count, every): (usize, u64),
) -> Vec<Vec<Vec<f64>>> {
    let d = map.dimension();
    let mut found = Vec::with_capacity(states.len());
    for chunk in states.chunks(LANES) {
        let lanes = chunk.len();
        let values = parameters.iter().flat_map(|value| vec![*value; lanes]);
        let initial = (0..d).flat_map(|i| chunk.iter().map(move |state| state[i]));
        let (values, initial): (Vec<f64>, Vec<f64>) = (values.collect(), initial.collect());
        let mut walk = Walk::side_by_side(map, lanes, (&values, &initial), epsilon, h);
        let mut orbits: Vec<Vec<Vec<f64>>> = vec![Vec::new(); lanes];
        for at in 1..=count as u64 {
            // A failed lane rests, and its orbit is shorter.
            for _ in 0..every {
                let _ = walk.step();
            }
            for (lane, orbit) in orbits.iter_mut().enumerate() {
                let (made, state) = walk.last(lane);
                if made == at * every {
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
