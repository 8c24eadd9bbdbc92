//! The stage equations of an implicit, possibly partitioned, Runge–Kutta method.

use nalgebra::DMatrix;

use super::smooth_map::SmoothMapEvaluator;
use super::tableau::PartitionedTableau;
use crate::error::StepError;
use crate::solver::iteration::Verdict;
use crate::solver::{
    Anderson, CorrectionSize, DenseFactors, LinearIteration, elimination_operations,
    substitution_operations,
};

/// Budget of one solve by Newton's iteration.
const MOST_EVALUATIONS: usize = 50;

/// Budget of one solve without Jacobians.
const MOST_ACCELERATED: usize = 100;

/// The Jacobians are evaluated anew while a correction is above this fraction of the one before.
const SLOW: f64 = 0.01;

/// Solves Z_i = z + τ Σ_j a_ij F(Z_j) and returns τ Σ_j b_j F(Z_j), for ż = F(z) and a step τ.
///
/// Newton's iteration on the displacements Z_i − z, its Jacobian kept while it contracts fast, until
/// a further correction is negligible against |Z_i| + |τ DF(Z_i)| |Z_i|, componentwise: the effect
/// of round-off in Z. It starts from the displacements of the last solve.
///
/// Where F has no Jacobian the iteration is Z_i ← z + τ Σ_j a_ij F(Z_j) with Anderson's acceleration,
/// until corrections and residuals are negligible against |Z_i| and |Z_i − z|: a shorter step is then
/// asked for than with Newton's iteration.
pub struct StageSolver {
    field: SmoothMapEvaluator,
    tableau: PartitionedTableau,
    time_step: f64,
    /// Z_i − z, F(Z_i) and DF(Z_i), one stage after the other.
    displacements: Vec<f64>,
    slopes: Vec<f64>,
    jacobians: Vec<f64>,
    /// 1 − τ a_ij DF(Z_j) and its factors; a correction of the displacements and its scale.
    matrix: Vec<f64>,
    factors: DenseFactors,
    correction: Vec<f64>,
    scales: Vec<f64>,
    /// z of the last solve, and a stage.
    start: Vec<f64>,
    stage: Vec<f64>,
    /// For fields without a Jacobian.
    anderson: Option<Anderson>,
    /// Operations of the sums over stages and the solves.
    linear: u64,
}

impl StageSolver {
    /// For the field F, coefficients and the step τ; cold.
    ///
    /// # Panics
    /// When F has not as many components as coordinates.
    pub fn new(
        field: SmoothMapEvaluator,
        tableau: impl Into<PartitionedTableau>,
        time_step: f64,
    ) -> Self {
        let n = field.map().inputs();
        assert_eq!(field.map().outputs(), n, "a vector field");
        let tableau = tableau.into();
        let s = tableau.stages();
        let has_jacobian = field.map().has_jacobian();
        let size = if has_jacobian { s * n } else { 0 };
        Self {
            anderson: (!has_jacobian).then(|| Anderson::new(s * n)),
            matrix: vec![0.0; size * size],
            factors: DenseFactors::new(size),
            correction: vec![0.0; s * n],
            scales: vec![0.0; s * n],
            field,
            tableau,
            time_step,
            displacements: vec![0.0; s * n],
            slopes: vec![0.0; s * n],
            jacobians: vec![0.0; size * n],
            start: vec![0.0; n],
            stage: vec![0.0; n],
            linear: 0,
        }
    }

    /// The number of coordinates of z.
    pub fn dimension(&self) -> usize {
        self.start.len()
    }

    /// Writes τ Σ_j b_j F(Z_j) for the step from `start`; returns how often the stages' slopes were
    /// evaluated.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`], [`StepError::NonFinite`]; the next solve then starts cold.
    pub fn solve(&mut self, start: &[f64], change: &mut [f64]) -> Result<usize, StepError> {
        self.start.copy_from_slice(start);
        let outcome = match self.anderson.take() {
            None => self.newton(),
            Some(mut anderson) => {
                let outcome = self.accelerate(&mut anderson);
                self.anderson = Some(anderson);
                outcome
            }
        };
        if outcome.is_err() {
            self.clear();
        }
        let n = self.start.len();
        for (c, change) in change.iter_mut().enumerate() {
            let sum: f64 = self
                .tableau
                .weights()
                .iter()
                .zip(self.slopes.chunks(n))
                .map(|(b, slope)| b * slope[c])
                .sum();
            *change = self.time_step * sum;
        }
        outcome
    }

    fn newton(&mut self) -> Result<usize, StepError> {
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        let mut last = f64::INFINITY;
        let mut contracts = false;
        let (n, stages) = (self.start.len(), self.tableau.stages());
        let size = stages * n;
        // The residuals' sums, the substitution, the slopes' corrections; the matrix and its factors.
        let each = (2 * size * stages + 2 * size * n) as u64 + substitution_operations(size);
        let fresh = (2 * size * size) as u64 + elimination_operations(size);
        loop {
            self.evaluate_slopes()?;
            if !contracts {
                self.evaluate_jacobians()?;
                self.linear += fresh;
                if !self.factor() {
                    return Err(StepError::NonFinite {
                        what: "a correction of the stages",
                    });
                }
            }
            self.linear += each;
            self.residual();
            self.factors.solve(&mut self.correction);
            let size = self.correct();
            if iteration.judge(size)? == Verdict::Converged {
                return Ok(iteration.evaluations());
            }
            contracts = size <= SLOW * last;
            last = size;
        }
    }

    fn accelerate(&mut self, anderson: &mut Anderson) -> Result<usize, StepError> {
        let n = self.start.len();
        let mut iteration = LinearIteration::new(MOST_ACCELERATED);
        anderson.clear();
        loop {
            self.evaluate_slopes()?;
            self.linear += (2 * self.scales.len() * self.tableau.stages()) as u64;
            self.residual();
            let mut size = CorrectionSize::default();
            for (row, scale) in self.scales.iter_mut().enumerate() {
                let displacement = self.displacements[row];
                *scale = (self.start[row % n] + displacement).abs()
                    + displacement.abs()
                    + self.correction[row].abs();
                size.take(self.correction[row], *scale);
            }
            anderson.correct(&mut self.correction, &self.scales);
            for (row, change) in self.correction.iter().enumerate() {
                size.take(*change, self.scales[row]);
                self.displacements[row] += change;
            }
            if iteration.judge_correction(&size)? == Verdict::Converged {
                // The slopes lag one correction behind.
                self.evaluate_slopes()?;
                return Ok(iteration.evaluations() + 1);
            }
        }
    }

    /// Z_i into `stage`.
    fn place(&mut self, stage: usize) {
        let n = self.start.len();
        let displacement = &self.displacements[stage * n..][..n];
        for (c, z) in self.stage.iter_mut().enumerate() {
            *z = self.start[c] + displacement[c];
        }
    }

    fn evaluate_slopes(&mut self) -> Result<(), StepError> {
        let n = self.start.len();
        for i in 0..self.tableau.stages() {
            self.place(i);
            let slopes = &mut self.slopes[i * n..][..n];
            self.field.value(&self.stage, slopes)?;
        }
        Ok(())
    }

    fn evaluate_jacobians(&mut self) -> Result<(), StepError> {
        let n = self.start.len();
        for i in 0..self.tableau.stages() {
            self.place(i);
            let jacobian = &mut self.jacobians[i * n * n..][..n * n];
            self.field.jacobian(&self.stage, jacobian)?;
        }
        Ok(())
    }

    /// Factors 1 − τ a_ij DF(Z_j); `false` where that is singular.
    fn factor(&mut self) -> bool {
        let (n, size) = (self.start.len(), self.slopes.len());
        for (row, entries) in self.matrix.chunks_exact_mut(size).enumerate() {
            let (i, c) = (row / n, row % n);
            for (column, entry) in entries.iter_mut().enumerate() {
                let (j, k) = (column / n, column % n);
                let unit = if row == column { 1.0 } else { 0.0 };
                let a = self.tableau.row(i, c)[j];
                *entry = unit - self.time_step * a * self.jacobians[(j * n + c) * n + k];
            }
        }
        self.factors.factor(&self.matrix)
    }

    /// τ Σ_j a_ij F(Z_j) − (Z_i − z) into `correction`.
    fn residual(&mut self) {
        let n = self.start.len();
        for (row, residual) in self.correction.iter_mut().enumerate() {
            let (i, c) = (row / n, row % n);
            let sum: f64 = self
                .tableau
                .row(i, c)
                .iter()
                .zip(self.slopes.chunks(n))
                .map(|(a, slope)| a * slope[c])
                .sum();
            *residual = self.time_step * sum - self.displacements[row];
        }
    }

    /// Adds the correction to the stages, and to the slopes to first order; returns its relative
    /// size.
    fn correct(&mut self) -> f64 {
        let n = self.start.len();
        let mut size = 0.0_f64;
        for (displacement, change) in self.displacements.iter_mut().zip(&self.correction) {
            *displacement += change;
        }
        for i in 0..self.tableau.stages() {
            self.place(i);
            let correction = &self.correction[i * n..][..n];
            let jacobian = &self.jacobians[i * n * n..][..n * n];
            for (c, row) in jacobian.chunks(n).enumerate() {
                let (mut change, mut reach) = (0.0, 0.0);
                for k in 0..n {
                    change += row[k] * correction[k];
                    reach += (row[k] * self.stage[k]).abs();
                }
                self.slopes[i * n + c] += change;
                let scale = self.stage[c].abs() + (self.time_step * reach).abs();
                // A coordinate that came to 0 by this very correction has no scale yet.
                let relative = if scale == 0.0 {
                    1.0
                } else {
                    correction[c].abs() / scale
                };
                if correction[c] != 0.0 && (relative > size || relative.is_nan()) {
                    size = relative;
                }
            }
        }
        size
    }

    /// Whether [`tangent`](Self::tangent) is offered: F has a Jacobian.
    pub fn has_tangent(&self) -> bool {
        self.anderson.is_none()
    }

    /// D(z + τ Σ b_j F(Z_j)) · V at the last solve, for V of as many rows as coordinates: exact
    /// through the stage equations. `None` where they are singular or F has no Jacobian.
    pub fn tangent(&mut self, seeds: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let n = self.start.len();
        if !self.has_tangent() {
            return None;
        }
        self.evaluate_jacobians().ok()?;
        if !self.factor() {
            return None;
        }
        let mut stages = DMatrix::zeros(self.slopes.len(), seeds.ncols());
        for (column, seed) in seeds.column_iter().enumerate() {
            for row in 0..self.correction.len() {
                self.correction[row] = seed[row % n];
            }
            self.factors.solve(&mut self.correction);
            stages.column_mut(column).copy_from_slice(&self.correction);
        }
        let mut tangent = seeds.clone();
        for (j, b) in self.tableau.weights().iter().enumerate() {
            let jacobian = DMatrix::from_row_slice(n, n, &self.jacobians[j * n * n..][..n * n]);
            tangent += jacobian * stages.rows(j * n, n) * (self.time_step * b);
        }
        tangent.iter().all(|v| v.is_finite()).then_some(tangent)
    }

    /// Weighted operations of all solves so far; `None` for a field that does not count.
    pub fn operations(&self) -> Option<u64> {
        Some(self.field.operations()? + self.linear)
    }

    /// Forgets earlier solves.
    pub fn clear(&mut self) {
        self.displacements.fill(0.0);
        self.field.restart();
    }

    /// What the next solve depends on: the displacements of the last one, and the field's memory.
    pub fn memory(&self) -> Vec<f64> {
        [self.displacements.clone(), self.field.memory()].concat()
    }

    /// Restores [`memory`](Self::memory).
    ///
    /// # Panics
    /// When `memory` has another length.
    pub fn restore(&mut self, memory: &[f64]) {
        let (displacements, field) = memory.split_at(self.displacements.len());
        self.displacements.copy_from_slice(displacements);
        self.field.restore(field);
    }
}
