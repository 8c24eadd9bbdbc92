//! The linear iteration y ← y − (β̂(L(y)) − x).

use std::sync::Arc;

use super::program::{LatticeEvaluator, LatticeProgram};
use super::stages::MethodFields;
use crate::error::StepError;
use crate::solver::judge::{Verdict, is_between, largest};
use crate::solver::{CorrectionMethod, Extrapolation, Iteration, StepReport, Trajectories};

/// Budget of one step. At t‖DX‖ = 1 the iteration gains a factor of about two each time.
const MOST_EVALUATIONS: usize = 200;

/// Rows that are corrected and measured at a time.
const ROWS: usize = 64;

/// Levels of differences that the start is extrapolated from, a number a coordinate each.
const EXTRAPOLATION: usize = 7;

/// Solves β̂(L(y)) = x by the iteration whose rate is the size of D(β̂∘L) − 1 = O(t), without any
/// Jacobian: O(N) a step.
///
/// *Stop*: when what the next correction would add is below a small part of an ulp, judged by the
/// observed rate, or when the corrections stagnate at round-off.
pub(super) struct LatticeTrajectory {
    program: Arc<LatticeProgram>,
    fields: MethodFields,
    evaluator: LatticeEvaluator,
    extrapolation: Extrapolation,
    displacement: Vec<f64>,
    /// Of the residuals alone, row after row: no room for unknowns.
    iteration: Iteration,
    evaluations: u64,
}

impl LatticeTrajectory {
    pub(super) fn new(
        program: &Arc<LatticeProgram>,
        fields: MethodFields,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let evaluator = program.evaluator(parameters, epsilon, h);
        let dimension = evaluator.field(fields.y).len();
        Self {
            program: Arc::clone(program),
            fields,
            evaluator,
            extrapolation: Extrapolation::new(dimension, EXTRAPOLATION),
            displacement: vec![0.0; dimension],
            iteration: Iteration::new(CorrectionMethod::Residual, 0),
            evaluations: 0,
        }
    }
}

impl LatticeTrajectory {
    /// One solve from the extrapolated start.
    fn solve(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        let Self {
            evaluator,
            displacement,
            iteration,
            fields,
            ..
        } = self;
        self.extrapolation.predict(displacement.as_chunks_mut().0);
        iteration.begin(MOST_EVALUATIONS, largest(x) + largest(displacement));
        loop {
            let y = evaluator.field_mut(fields.y);
            for ((y, x), displacement) in y.iter_mut().zip(x).zip(&*displacement) {
                *y = x + displacement;
            }
            self.program.run(evaluator);
            *evaluations += 1;
            self.evaluations += 1;
            let (offset, change) = (
                evaluator.field(fields.offset),
                evaluator.field(fields.increment),
            );
            let y = evaluator.field(fields.y);
            let mut finite = true;
            iteration.take_change(largest(change));
            for start in (0..displacement.len()).step_by(ROWS) {
                let end = displacement.len().min(start + ROWS);
                let (x, y, low) = (&x[start..end], &y[start..end], &low[start..end]);
                let (offset, change) = (&offset[start..end], &change[start..end]);
                let displacement = &mut displacement[start..end];
                let [mut corrections, mut scales] = [[0.0; ROWS]; 2];
                for i in 0..displacement.len() {
                    // x − y is exact: they are close.
                    let correction = (x[i] - y[i]) - offset[i] + low[i];
                    displacement[i] = (y[i] - x[i]) + correction;
                    finite &= correction.is_finite() && change[i].is_finite();
                    corrections[i] = correction;
                    scales[i] = iteration.scale(x[i], change[i]);
                }
                let rows = ..displacement.len();
                iteration.take_rows(&corrections[rows], &scales[rows]);
            }
            let verdict = iteration.judge()?;
            if !finite {
                return Err(StepError::NonFinite {
                    what: "a correction of the lattice",
                });
            }
            if verdict == Verdict::Converged {
                if !is_between(x, y, change) {
                    return Err(StepError::OtherBranch { reached: 0.0 });
                }
                increment.copy_from_slice(change);
                self.extrapolation
                    .record(displacement.as_chunks_mut().0, &[true]);
                return Ok(());
            }
        }
    }
}

impl Trajectories for LatticeTrajectory {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let taken = &mut taken[0];
        let mut solved = self.solve(x, low, increment, &mut taken.evaluations);
        if solved.is_err() && !self.extrapolation.is_cold(0) {
            // The extrapolated start may have led astray.
            self.extrapolation.clear(0);
            solved = self.solve(x, low, increment, &mut taken.evaluations);
        }
        (taken.outcome, taken.is_rounded) = (solved, self.iteration.is_rounded());
    }

    fn solution(&self, _: usize) -> Option<&[f64]> {
        Some(self.evaluator.field(self.fields.y))
    }

    fn operations(&self) -> Option<u64> {
        Some(self.evaluations * self.program.work())
    }

    fn restart(&mut self, _: usize) {
        self.extrapolation.clear(0);
    }

    fn memory(&self, _: usize) -> Vec<f64> {
        let mut memory = Vec::with_capacity(self.extrapolation.memory_len());
        self.extrapolation.memory(0, &mut memory);
        memory
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.extrapolation.restore(0, memory);
    }
}
