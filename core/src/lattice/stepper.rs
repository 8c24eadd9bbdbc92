//! The linear iteration y ← y − (β̂(L(y)) − x).

use std::sync::Arc;

use super::program::{LatticeProgram, LatticeWorker};
use super::stages::MethodFields;
use crate::error::StepError;
use crate::solver::judge::{
    Allowed, CorrectionSize, LinearIteration, Verdict, is_between, largest,
};
use crate::solver::{Extrapolation, StepReport, Trajectories};

/// Budget of one step. At t‖DX‖ = 1 the iteration gains a factor of about two each time.
const MOST_EVALUATIONS: usize = 200;

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
    worker: LatticeWorker,
    extrapolation: Extrapolation,
    displacement: Vec<f64>,
    evaluations: u64,
    is_rounded: bool,
}

impl LatticeTrajectory {
    pub(super) fn new(
        program: &Arc<LatticeProgram>,
        fields: MethodFields,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let worker = program.worker(parameters, epsilon, h);
        let dimension = worker.field(fields.y).len();
        Self {
            program: Arc::clone(program),
            fields,
            worker,
            extrapolation: Extrapolation::new(dimension, EXTRAPOLATION),
            displacement: vec![0.0; dimension],
            evaluations: 0,
            is_rounded: false,
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
            worker,
            displacement,
            fields,
            ..
        } = self;
        self.extrapolation.predict(displacement.as_chunks_mut().0);
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        let mut allowed = Allowed::new(largest(x) + largest(displacement));
        loop {
            let y = worker.field_mut(fields.y);
            for ((y, x), displacement) in y.iter_mut().zip(x).zip(&*displacement) {
                *y = x + displacement;
            }
            self.program.run(worker);
            *evaluations += 1;
            self.evaluations += 1;
            let (offset, change) = (worker.field(fields.offset), worker.field(fields.increment));
            let y = worker.field(fields.y);
            let mut size = CorrectionSize::default();
            let mut finite = true;
            allowed.take(largest(change));
            for i in 0..displacement.len() {
                // x − y is exact: they are close.
                let correction = (x[i] - y[i]) - offset[i] + low[i];
                displacement[i] = (y[i] - x[i]) + correction;
                finite &= correction.is_finite() && change[i].is_finite();
                size.take(correction, x[i].abs() + allowed.scale(change[i]));
            }
            let verdict = iteration.judge_correction(&size)?;
            if !finite {
                return Err(StepError::NonFinite {
                    what: "a correction of the lattice",
                });
            }
            if verdict == Verdict::Converged {
                self.is_rounded = iteration.is_rounded();
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
        (taken.outcome, taken.is_rounded) = (solved, self.is_rounded);
    }

    fn solution(&self, _: usize) -> Option<&[f64]> {
        Some(self.worker.field(self.fields.y))
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
