//! The way of a state onto a level set of functions.

use leafwise_core::Evaluator;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::solver::judge::Verdict;
use leafwise_core::solver::{CorrectionMethod, DenseFactors, Iteration};

/// Budget of the way.
const MOST_EVALUATIONS: usize = 50;

/// Newton's method along gradients, x ← x − DFᵀ(DF DFᵀ)⁻¹(F(x) − c), one state after the other.
pub(crate) struct WayOntoLevel {
    map: SmoothMapEvaluator,
    /// The outputs of the map that are F.
    which: Vec<usize>,
    /// c, in the order of `which`.
    wanted: Vec<f64>,
    values: Vec<f64>,
    jacobians: Vec<f64>,
    /// DF.
    rows: Vec<f64>,
    gram: Vec<f64>,
    multipliers: Vec<f64>,
    factors: DenseFactors,
    /// Judged as a whole too: a coordinate may be the round-off of others.
    iteration: Iteration,
}

impl WayOntoLevel {
    /// Onto level sets of some outputs of a map, that of 0 at first.
    pub(crate) fn new(map: &SmoothMap, which: Vec<usize>, parameters: &[f64]) -> Self {
        let (outputs, d, count) = (map.outputs(), map.inputs(), which.len());
        Self {
            map: map.evaluator(parameters, 1.0, 1.0),
            which,
            wanted: vec![0.0; count],
            values: vec![0.0; outputs],
            jacobians: vec![0.0; outputs * d],
            rows: vec![0.0; count * d],
            gram: vec![0.0; count * count],
            multipliers: vec![0.0; count],
            factors: DenseFactors::new(count),
            iteration: Iteration::new(CorrectionMethod::Residual, 0),
        }
    }

    /// Takes the level set through a state, at these parameters; `None` where it has none.
    pub(crate) fn take_level(&mut self, parameters: &[f64], state: &[f64]) -> Option<()> {
        self.map.set_parameters(parameters);
        self.map.values(state, &mut self.values).ok()?;
        for (wanted, at) in self.wanted.iter_mut().zip(&self.which) {
            *wanted = self.values[*at];
        }
        Some(())
    }

    /// Moves a state onto the level set; `None` where no way leads there.
    pub(crate) fn go(&mut self, state: &mut [f64]) -> Option<()> {
        let (d, count) = (state.len(), self.which.len());
        self.iteration.begin(MOST_EVALUATIONS, |_| 0.0);
        loop {
            self.map.values(state, &mut self.values).ok()?;
            self.map.jacobians(state, &mut self.jacobians).ok()?;
            for (row, at) in self.rows.chunks_exact_mut(d).zip(&self.which) {
                row.copy_from_slice(&self.jacobians[at * d..][..d]);
            }
            let rows = &self.rows;
            for (at, entry) in self.gram.iter_mut().enumerate() {
                let (a, b) = (&rows[at / count * d..][..d], &rows[at % count * d..][..d]);
                *entry = a.iter().zip(b).map(|(a, b)| a * b).sum();
            }
            let missing = self.wanted.iter().zip(&self.which);
            for (multiplier, (wanted, at)) in self.multipliers.iter_mut().zip(missing) {
                *multiplier = wanted - self.values[*at];
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
