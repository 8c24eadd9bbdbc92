//! The linear iteration y ← y − (β̂(L(y)) − x).

use std::sync::Arc;

use super::method::MethodFields;
use super::program::{LatticeProgram, LatticeWorker};
use crate::error::StepError;
use crate::solver::iteration::{CorrectionSize, LinearIteration, Verdict};
use crate::solver::{Extrapolation, SolverStatistics, Stepper};

/// Budget of one step. At t‖DX‖ = 1 the iteration gains a factor of about two each time.
const MOST_EVALUATIONS: usize = 200;

/// Solves β̂(L(y)) = x by the iteration whose rate is the size of D(β̂∘L) − 1 = O(t), without any
/// Jacobian: O(N) a step.
///
/// *Stop*: when what the next correction would add is below a small part of an ulp, judged by the
/// observed rate, or when the corrections stagnate at round-off.
pub struct LatticeStepper {
    program: Arc<LatticeProgram>,
    fields: MethodFields,
    /// Operations of one evaluation.
    work: u64,
    trajectories: Vec<Trajectory>,
    statistics: SolverStatistics,
}

struct Trajectory {
    worker: LatticeWorker,
    extrapolation: Extrapolation,
    displacement: Vec<f64>,
}

impl LatticeStepper {
    pub(super) fn new(
        program: Arc<LatticeProgram>,
        fields: MethodFields,
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let trajectories = (0..lanes)
            .map(|lane| {
                let own: Vec<f64> = parameters
                    .iter()
                    .skip(lane)
                    .step_by(lanes)
                    .copied()
                    .collect();
                let worker = program.worker(&own, epsilon, h);
                let dimension = worker.field(fields.y).len();
                Trajectory {
                    worker,
                    extrapolation: Extrapolation::new(dimension, 7),
                    displacement: vec![0.0; dimension],
                }
            })
            .collect();
        Self {
            work: program.work(),
            program,
            fields,
            trajectories,
            statistics: SolverStatistics::default(),
        }
    }

    fn solve(
        &mut self,
        lane: usize,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
    ) -> Result<(), StepError> {
        let lanes = self.trajectories.len();
        let Trajectory {
            worker,
            extrapolation,
            displacement,
        } = &mut self.trajectories[lane];
        extrapolation.predict(displacement.as_chunks_mut().0);
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        loop {
            let y = worker.field_mut(self.fields.y);
            for (i, y) in y.iter_mut().enumerate() {
                *y = x[i * lanes + lane] + displacement[i];
            }
            self.program.run(worker);
            let (offset, change) = (
                worker.field(self.fields.offset),
                worker.field(self.fields.increment),
            );
            let y = worker.field(self.fields.y);
            let mut size = CorrectionSize::default();
            let mut finite = true;
            for i in 0..displacement.len() {
                let here = i * lanes + lane;
                // x − y is exact: they are close.
                let correction = (x[here] - y[i]) - offset[i] + low[here];
                displacement[i] = (y[i] - x[here]) + correction;
                finite &= correction.is_finite() && change[i].is_finite();
                size.take(correction, x[here].abs() + change[i].abs());
            }
            let verdict = match iteration.judge_correction(&size) {
                Ok(verdict) if finite => verdict,
                Ok(_) => {
                    self.finish(iteration.evaluations());
                    return Err(StepError::NonFinite {
                        what: "a correction of the lattice",
                    });
                }
                Err(error) => {
                    self.finish(iteration.evaluations());
                    return Err(error);
                }
            };
            if verdict == Verdict::Converged {
                for (i, change) in change.iter().enumerate() {
                    increment[i * lanes + lane] = *change;
                }
                extrapolation.record(displacement.as_chunks_mut().0, &[true]);
                self.finish(iteration.evaluations());
                return Ok(());
            }
        }
    }

    fn finish(&mut self, evaluations: usize) {
        self.statistics.steps += 1;
        self.statistics.evaluations += evaluations as u64;
        self.statistics.most_evaluations = self.statistics.most_evaluations.max(evaluations as u64);
    }
}

impl Stepper for LatticeStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        for lane in 0..self.trajectories.len() {
            outcome[lane] = self.solve(lane, x, low, increment);
            if outcome[lane].is_err() {
                self.statistics.failures += 1;
                let lanes = self.trajectories.len();
                increment
                    .iter_mut()
                    .skip(lane)
                    .step_by(lanes)
                    .for_each(|i| *i = 0.0);
                self.trajectories[lane].extrapolation.clear(0);
            }
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.trajectories
            .get(lane)
            .map(|t| t.worker.field(self.fields.y).to_vec())
    }

    fn restart(&mut self) {
        self.trajectories
            .iter_mut()
            .for_each(|t| t.extrapolation.clear(0));
    }

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: Some(self.statistics.evaluations * self.work),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = Vec::new();
        for trajectory in &self.trajectories {
            trajectory.extrapolation.memory(0, &mut memory);
        }
        memory
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let each = self
            .trajectories
            .first()
            .map_or(0, |t| t.extrapolation.memory_len());
        if memory.len() != each * self.trajectories.len() {
            return Err(each * self.trajectories.len());
        }
        for (trajectory, part) in self.trajectories.iter_mut().zip(memory.chunks_exact(each)) {
            trajectory.extrapolation.restore(0, part);
        }
        Ok(())
    }
}
