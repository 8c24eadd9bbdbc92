//! The way of drawn states onto the symplectic leaf of their center.

use leafwise_core::Evaluator;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::solver::judge::Verdict;
use leafwise_core::solver::{CorrectionMethod, DenseFactors, Iteration};
use leafwise_scene::compose::{ComposedRun, Refusal};
use leafwise_scene::document::{EnsembleSection, Located, SceneDocument};

/// Budget of the way onto a leaf.
const MOST_EVALUATIONS: usize = 50;

/// Newton's method along the Casimirs' gradients, x ← x − DCᵀ(DC DCᵀ)⁻¹(C(x) − C(c)), one member after the other.
pub(super) struct WayOntoLeaf {
    /// The energy, then the Casimirs.
    map: SmoothMapEvaluator,
    wanted: Vec<f64>,
    values: Vec<f64>,
    rows: Vec<f64>,
    gram: Vec<f64>,
    multipliers: Vec<f64>,
    factors: DenseFactors,
    /// Judged as a whole too: a coordinate may be the round-off of others.
    iteration: Iteration,
}

impl WayOntoLeaf {
    pub(super) fn new(invariants: &SmoothMap, parameters: &[f64]) -> Self {
        let (outputs, count) = (invariants.outputs(), invariants.outputs() - 1);
        Self {
            map: invariants.evaluator(parameters, 1.0, 1.0),
            wanted: vec![0.0; outputs],
            values: vec![0.0; outputs],
            rows: vec![0.0; outputs * invariants.inputs()],
            gram: vec![0.0; count * count],
            multipliers: vec![0.0; count],
            factors: DenseFactors::new(count),
            iteration: Iteration::new(CorrectionMethod::Residual, 0),
        }
    }

    /// Moves a state onto the leaf of the center at these parameters; `None` where no way leads there.
    pub(super) fn go(
        &mut self,
        parameters: &[f64],
        center: &[f64],
        state: &mut [f64],
    ) -> Option<()> {
        let (d, count) = (state.len(), self.multipliers.len());
        self.map.set_parameters(parameters);
        self.map.values(center, &mut self.wanted).ok()?;
        self.iteration.begin(MOST_EVALUATIONS, |_| 0.0);
        loop {
            self.map.values(state, &mut self.values).ok()?;
            self.map.jacobians(state, &mut self.rows).ok()?;
            let rows = &self.rows[d..];
            for (at, entry) in self.gram.iter_mut().enumerate() {
                let (a, b) = (&rows[at / count * d..][..d], &rows[at % count * d..][..d]);
                *entry = a.iter().zip(b).map(|(a, b)| a * b).sum();
            }
            let missing = self.wanted.iter().zip(&self.values).skip(1);
            for (multiplier, (wanted, value)) in self.multipliers.iter_mut().zip(missing) {
                *multiplier = wanted - value;
            }
            if !self.factors.factor(&self.gram) {
                return None;
            }
            self.factors.solve(&mut self.multipliers);
            let scale = state.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for (i, x) in state.iter_mut().enumerate() {
                let slopes = rows.iter().skip(i).step_by(d);
                let change: f64 = slopes.zip(&self.multipliers).map(|(v, m)| v * m).sum();
                self.iteration.take(change, scale);
                *x += change;
            }
            if self.iteration.judge().ok()? == Verdict::Converged {
                return state.iter().all(|x| x.is_finite()).then_some(());
            }
        }
    }
}

/// The corank of Π at a point, and how many of the declared Casimirs are independent there; `None` where
/// they have no value.
fn ranks(run: &ComposedRun, invariants: &SmoothMap, x: &[f64]) -> Option<(usize, usize)> {
    let d = x.len();
    let parameters = run.system.parameter_values();
    let numbers = run.system.numbers().ok()?;
    let mut numbers = numbers.evaluator(&parameters);
    let mut tensor = vec![0.0; d * d];
    for (k, column) in tensor.chunks_exact_mut(d).enumerate() {
        let mut unit = vec![0.0; d];
        unit[k] = 1.0;
        numbers.tensor(x, &unit, column).ok()?;
    }
    let mut map = invariants.evaluator(&parameters, 1.0, 1.0);
    let mut rows = vec![0.0; invariants.outputs() * d];
    let mut values = vec![0.0; invariants.outputs()];
    map.values(x, &mut values).ok()?;
    map.jacobians(x, &mut rows).ok()?;
    Some((d - rank(tensor, d), rank(rows.split_off(d), d)))
}

/// Entries below this part of what they were formed from are round-off.
const ROUND_OFF: f64 = 1e-11;

/// Rank of a matrix with rows of `width` numbers, whatever the units of its rows and columns. Both are scaled to 1,
/// then eliminated with the largest entry that is left as pivot.
fn rank(mut matrix: Vec<f64>, width: usize) -> usize {
    let height = matrix.len() / width;
    for _ in 0..4 {
        for row in matrix.chunks_exact_mut(width) {
            let most = row.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            if most > 0.0 {
                row.iter_mut().for_each(|value| *value /= most);
            }
        }
        for column in 0..width {
            let entries = (0..height).map(|row| matrix[row * width + column].abs());
            let most = entries.fold(0.0, f64::max);
            if most > 0.0 {
                (0..height).for_each(|row| matrix[row * width + column] /= most);
            }
        }
    }
    let mut rows: Vec<Vec<f64>> = matrix.chunks_exact(width).map(<[f64]>::to_vec).collect();
    let mut rank = 0;
    while !rows.is_empty() {
        let entries = rows.iter().enumerate().flat_map(|(i, row)| {
            let entries = row.iter().enumerate();
            entries.map(move |(j, value)| (value.abs(), i, j))
        });
        let largest = entries.fold(
            (0.0, 0, 0),
            |most, entry| if entry.0 > most.0 { entry } else { most },
        );
        let (size, i, j) = largest;
        if size <= ROUND_OFF {
            break;
        }
        let pivot = rows.swap_remove(i);
        for row in &mut rows {
            let factor = row[j] / pivot[j];
            row.iter_mut()
                .zip(&pivot)
                .for_each(|(value, p)| *value -= factor * p);
            row[j] = 0.0;
        }
        rank += 1;
    }
    rank
}

/// Energy and Casimirs of a system whose members are drawn on leaves.
///
/// # Errors
/// Casimirs that do not fix the leaf through `center`; a system or lattice without their gradients.
pub(super) fn leaves(
    document: &SceneDocument,
    ensemble: &EnsembleSection,
    run: &ComposedRun,
    center: &[f64],
) -> Result<SmoothMap, Refusal> {
    let place = ensemble.initial.as_ref().map(Located::place);
    let refuse = |message: String| {
        let place = place.as_ref().unwrap_or(&ensemble.place);
        let help =
            "declare the missing Casimirs, draw from a ball, or start on another leaf".to_owned();
        Box::new(document.diagnostic(place, message, "here", Some(help)))
    };
    if run.method.lattice().is_some() {
        let place = place.as_ref().unwrap_or(&ensemble.place);
        return Err(Box::new(document.diagnostic(
            place,
            "on a lattice of this length every site has a leaf of its own, and the way onto them is not known: Newton's \
             method along the Casimirs' gradients solves for a few Casimirs",
            "on the leaf",
            Some("draw from a ball, or give the members' states by a file".to_owned()),
        )));
    }
    let map = run
        .system
        .invariants_map()
        .map_err(|error| refuse(error.to_string()))?;
    if map.has_jacobian() && map.outputs() > 1 {
        let ranks = ranks(run, &map, center);
        if let Some((corank, independent)) = ranks.filter(|(corank, own)| corank > own) {
            return Err(refuse(format!(
                "the leaf through the center has {corank} equations, the corank of the tensor there, and \
                 {independent} independent Casimirs are declared: what they fix is more than the leaf"
            )));
        }
        return Ok(map);
    }
    Err(refuse(
        "the way onto a leaf needs the Casimirs' gradients, and this system offers none".to_owned(),
    ))
}
