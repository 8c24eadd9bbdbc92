//! The stage equations of one trajectory, between the evaluations that they ask for.

use super::tableau::PartitionedTableau;
use crate::error::StepError;
use leafwise_solver::judge::{Verdict, reach};
use leafwise_solver::{
    CorrectionMethod, DenseFactors, Iteration, elimination_operations, substitution_operations,
};

/// Budget of one solve by Newton's iteration.
const MOST_EVALUATIONS: usize = 50;

/// Budget of one solve without Jacobians.
const MOST_ACCELERATED: usize = 100;

/// The Jacobians are evaluated anew while a correction is above this fraction of the one before.
const SLOW: f64 = 0.01;

/// Corrections up to this size do not ask for other Jacobians where z itself is solved for.
const SMALL: f64 = 1e-6;

/// Coefficients and step τ, which all trajectories of a solver share.
pub(super) struct Coefficients {
    pub(super) tableau: PartitionedTableau,
    pub(super) time_step: f64,
}

impl Coefficients {
    /// τ Σ_j a_ij F(Z_j), a coordinate of a stage.
    fn sum(&self, slopes: &[f64], n: usize, row: usize) -> f64 {
        let (i, c) = (row / n, row % n);
        let terms = self.tableau.row(i, c).iter().zip(slopes.chunks(n));
        let sum: f64 = terms.map(|(a, slope)| a * slope[c]).sum();
        self.time_step * sum
    }

    /// 1 − τ a_ij DF(Z_j), for a part of the step.
    fn matrix(&self, part: f64, jacobians: &[f64], n: usize, matrix: &mut [f64]) {
        let size = self.tableau.stages() * n;
        let time_step = part * self.time_step;
        for (row, entries) in matrix.chunks_exact_mut(size).enumerate() {
            let (i, c) = (row / n, row % n);
            let slopes = jacobians.chunks_exact(n).skip(c).step_by(n);
            let blocks = self.tableau.row(i, c).iter().zip(slopes);
            for (entries, (a, slope)) in entries.chunks_exact_mut(n).zip(blocks) {
                let factor = time_step * a;
                for (entry, slope) in entries.iter_mut().zip(slope) {
                    *entry = 0.0 - factor * slope;
                }
            }
            entries[row] = 1.0 - time_step * self.tableau.row(i, c)[i] * jacobians[row * n + c];
        }
    }
}

/// One trajectory's Z_i = z + τ Σ_j a_ij F(Z_j).
pub(super) struct StageSolve {
    /// Z_i − z, F(Z_i) and DF(Z_i), one stage after the other.
    displacements: Vec<f64>,
    slopes: Vec<f64>,
    jacobians: Vec<f64>,
    /// Those of 1 − τ a_ij DF(Z_j); a correction of the displacements.
    factors: DenseFactors,
    pub(super) correction: Vec<f64>,
    /// z.
    start: Vec<f64>,
    stage: Vec<f64>,
    pub(super) iteration: Iteration,
    /// Newton's last correction, and whether the Jacobians are kept.
    last: f64,
    contracts: bool,
    /// Of accelerated stages: whether they are solved, and their slopes lag behind.
    lags: bool,
    /// Operations of the sums over stages and the solves.
    pub(super) linear: u64,
}

impl StageSolve {
    /// For z of n coordinates and s stages; cold.
    pub(super) fn new(n: usize, stages: usize, has_jacobian: bool) -> Self {
        let (all, size) = (stages * n, if has_jacobian { stages * n } else { 0 });
        let method = match has_jacobian {
            true => CorrectionMethod::Newton,
            false => CorrectionMethod::Acceleration,
        };
        Self {
            displacements: vec![0.0; all],
            slopes: vec![0.0; all],
            jacobians: vec![0.0; size * n],
            factors: DenseFactors::new(size),
            correction: vec![0.0; all],
            start: vec![0.0; n],
            stage: vec![0.0; n],
            iteration: Iteration::new(method, all),
            last: f64::INFINITY,
            contracts: false,
            lags: false,
            linear: 0,
        }
    }

    /// Begins a solve.
    pub(super) fn begin(&mut self, start: &[f64]) {
        self.start.copy_from_slice(start);
        self.iteration.begin_step();
        self.begin_again();
    }

    /// Goes on from another z.
    pub(super) fn move_to(&mut self, start: &[f64]) {
        self.start.copy_from_slice(start);
    }

    /// Keeps the Jacobians where corrections are small: it is z that moves then.
    pub(super) fn keep_jacobians(&mut self) {
        self.contracts |= self.last <= SMALL;
    }

    fn begin_again(&mut self) {
        (self.last, self.contracts, self.lags) = (f64::INFINITY, false, false);
        let most = match self.is_newton() {
            true => MOST_EVALUATIONS,
            false => MOST_ACCELERATED,
        };
        let (start, displacements) = (&self.start, &self.displacements);
        let size = |row: usize| start[row % start.len()].abs() + displacements[row].abs();
        self.iteration.begin(most, size);
    }

    fn is_newton(&self) -> bool {
        self.iteration.method() == CorrectionMethod::Newton
    }

    /// Writes the Z_i, at which F is wanted next.
    pub(super) fn place(&self, stages: &mut [f64]) {
        let n = self.start.len();
        let displacements = self.displacements.chunks_exact(n);
        for (stage, displacement) in stages.chunks_exact_mut(n).zip(displacements) {
            for c in 0..n {
                stage[c] = self.start[c] + displacement[c];
            }
        }
    }

    /// Whether DF is wanted there too.
    pub(super) fn wants_jacobians(&self) -> bool {
        self.is_newton() && !self.contracts
    }

    /// Takes in the DF(Z_i); `matrix` is room.
    ///
    /// # Errors
    /// [`StepError::NonFinite`] where the stage equations are singular.
    pub(super) fn take_jacobians(
        &mut self,
        coefficients: &Coefficients,
        jacobians: &[f64],
        matrix: &mut [f64],
    ) -> Result<(), StepError> {
        let size = self.slopes.len();
        self.linear += (2 * size * size) as u64 + elimination_operations(size);
        if self.factor(coefficients, jacobians, matrix) {
            self.iteration.take_factors(&self.factors);
            return Ok(());
        }
        Err(StepError::NonFinite {
            what: "a correction of the stages",
        })
    }

    /// Takes in the F(Z_i) and corrects the Z_i; tells how often the slopes were evaluated once they are
    /// solved.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`], [`StepError::NonFinite`].
    pub(super) fn take_slopes(
        &mut self,
        coefficients: &Coefficients,
        slopes: &[f64],
    ) -> Result<Option<usize>, StepError> {
        self.slopes.copy_from_slice(slopes);
        match self.is_newton() {
            true => self.newton(coefficients),
            false => self.accelerate(coefficients),
        }
    }

    fn newton(&mut self, coefficients: &Coefficients) -> Result<Option<usize>, StepError> {
        let (n, all) = (self.start.len(), self.slopes.len());
        // The residuals' sums, the substitution, the slopes' corrections.
        let sums = 2 * all * coefficients.tableau.stages() + 2 * all * n;
        self.linear += sums as u64 + substitution_operations(all);
        self.take_change(coefficients);
        self.residual(coefficients);
        self.factors.solve(&mut self.correction);
        self.correct(coefficients);
        let size = self.iteration.size().component();
        self.contracts = size <= SLOW * self.last;
        self.last = size;
        let (factors, correction) = (&self.factors, &self.correction);
        let mut solve = |residual: &mut [f64]| factors.solve(residual);
        let verdict = self.iteration.judge_newton(correction, 1.0, &mut solve)?;
        let is_solved = verdict == Verdict::Converged;
        Ok(is_solved.then(|| self.iteration.evaluations()))
    }

    fn accelerate(&mut self, coefficients: &Coefficients) -> Result<Option<usize>, StepError> {
        if self.lags {
            return Ok(Some(self.iteration.evaluations() + 1));
        }
        let n = self.start.len();
        self.linear += (2 * self.slopes.len() * coefficients.tableau.stages()) as u64;
        self.take_change(coefficients);
        self.residual(coefficients);
        let start = &self.start;
        let measure = |row: usize, displacement: f64, correction: f64| {
            (start[row % n], displacement.abs() + correction.abs(), 0.0)
        };
        let (correction, displacements) = (&mut self.correction, &mut self.displacements);
        let way = |_, displacement| displacement;
        let verdict = self
            .iteration
            .correct(correction, displacements, 1.0, measure, way, None)?;
        // The slopes lag one correction behind: they are wanted once more.
        self.lags = verdict == Verdict::Converged;
        Ok(None)
    }

    /// Takes in how far the slopes reach in a step.
    fn take_change(&mut self, coefficients: &Coefficients) {
        let slopes = &self.slopes;
        let change = |row: usize| coefficients.time_step * slopes[row];
        self.iteration.take_changes(change);
    }

    /// τ Σ_j b_j F(Z_j).
    pub(super) fn change(&self, coefficients: &Coefficients, change: &mut [f64]) {
        let n = self.start.len();
        for (c, change) in change.iter_mut().enumerate() {
            let weights = coefficients.tableau.weights().iter();
            let terms = weights.zip(self.slopes.chunks(n));
            let sum: f64 = terms.map(|(b, slope)| b * slope[c]).sum();
            *change = coefficients.time_step * sum;
        }
    }

    /// Keeps the Jacobians and factors 1 − τ a_ij DF(Z_j); `false` where that is singular.
    pub(super) fn factor(
        &mut self,
        coefficients: &Coefficients,
        jacobians: &[f64],
        matrix: &mut [f64],
    ) -> bool {
        self.jacobians.copy_from_slice(jacobians);
        let n = self.start.len();
        coefficients.matrix(1.0, jacobians, n, matrix);
        // Room for the sizes of the unknowns.
        for (row, size) in self.correction.iter_mut().enumerate() {
            *size = self.start[row % n].abs() + self.displacements[row].abs();
        }
        self.factors.factor_of_sizes(matrix, &self.correction)
    }

    /// A correction of the displacements for the residual in `correction`.
    pub(super) fn solve_linear(&mut self) {
        self.factors.solve(&mut self.correction);
    }

    /// τ Σ_j a_ij F(Z_j) − (Z_i − z) into `correction`.
    fn residual(&mut self, coefficients: &Coefficients) {
        let n = self.start.len();
        for (row, residual) in self.correction.iter_mut().enumerate() {
            *residual = coefficients.sum(&self.slopes, n, row) - self.displacements[row];
        }
    }

    /// Adds the correction to the stages, and to the slopes to first order; it is measured against z,
    /// what is added to it, and the effect of its round-off.
    fn correct(&mut self, coefficients: &Coefficients) {
        let n = self.start.len();
        for (displacement, change) in self.displacements.iter_mut().zip(&self.correction) {
            *displacement += change;
        }
        for i in 0..coefficients.tableau.stages() {
            for (c, stage) in self.stage.iter_mut().enumerate() {
                *stage = self.start[c] + self.displacements[i * n + c];
            }
            let correction = &self.correction[i * n..][..n];
            let jacobian = &self.jacobians[i * n * n..][..n * n];
            for (c, row) in jacobian.chunks(n).enumerate() {
                let terms = row.iter().zip(correction);
                self.slopes[i * n + c] += terms.map(|(slope, change)| slope * change).sum::<f64>();
                let left = self.factors.left(i * n + c);
                let round_off = left * coefficients.time_step * reach(row, &self.stage);
                let displacement = self.displacements[i * n + c];
                let scale =
                    (self.iteration).scale(i * n + c, self.start[c], displacement, round_off.abs());
                self.iteration.take_row(i * n + c, correction[c], scale);
                self.iteration.take_way(displacement, scale);
            }
        }
    }

    /// Sets the displacements, and begins anew from there.
    pub(super) fn begin_at(&mut self, displacements: &[f64]) {
        self.displacements.copy_from_slice(displacements);
        self.begin_again();
    }

    /// Writes τ Σ_j a_ij F(Z_j) − (Z_i − z) and 1 − τ a_ij DF(Z_j) at displacements, for slopes and
    /// Jacobians there and a part of the step τ.
    pub(super) fn equation(
        &self,
        coefficients: &Coefficients,
        part: f64,
        (displacements, slopes, jacobians): (&[f64], &[f64], &[f64]),
        residual: &mut [f64],
        matrix: &mut [f64],
    ) {
        let n = self.start.len();
        for (row, residual) in residual.iter_mut().enumerate() {
            let sum = part * coefficients.sum(slopes, n, row);
            *residual = sum - displacements[row];
        }
        coefficients.matrix(part, jacobians, n, matrix);
    }

    /// Forgets earlier solves.
    pub(super) fn clear(&mut self) {
        self.displacements.fill(0.0);
        self.iteration.restart();
    }

    /// z.
    pub(super) fn start(&self) -> &[f64] {
        &self.start
    }

    /// Displacements Z_i − z from which the next solve starts, one stage after the other.
    pub(super) fn displacements(&self) -> &[f64] {
        &self.displacements
    }

    pub(super) fn displacements_mut(&mut self) -> &mut [f64] {
        &mut self.displacements
    }

    pub(super) fn restore(&mut self, displacements: &[f64]) {
        self.displacements.copy_from_slice(displacements);
    }
}
