//! The solve for parts that compute numbers: no code, one trajectory at a time.

use std::sync::Arc;

use super::extrapolation::DEPTH;
use super::iteration::{CorrectionSize, LinearIteration, Verdict};
use super::{Anderson, Extrapolation, SolverStatistics, Stepper};
use crate::dynamics::{BisectionWorker, Correction};
use crate::error::StepError;
use crate::realization::{Ends, RealizationWorker};
use crate::solver::linear::{elimination_operations, solve_in_place, substitution_operations};

/// Budget of one step.
const MOST_EVALUATIONS: usize = 100;

/// Makes the workers of one trajectory for parameters, ε and h.
pub(crate) type MakeWorkers =
    dyn Fn(&[f64]) -> (Box<dyn RealizationWorker>, Box<dyn BisectionWorker>) + Send + Sync;

/// Solves β̂(L(y)) = x with workers of a realization and a bisection.
///
/// Where D(β̂∘L) is near the identity (a collective integrator over a good realization), and where a
/// worker offers no tangents, the correction is the residual itself; elsewhere it is Newton's, with
/// the tangents of both workers. D(β̂∘L) = 1 + O(εh), so that residuals converge for small steps.
pub(crate) struct WorkerStepper {
    trajectories: Vec<Trajectory>,
    correction: Correction,
    statistics: SolverStatistics,
}

struct Trajectory {
    /// For parts without tangents.
    anderson: Anderson,
    scales: Vec<f64>,
    realization: Box<dyn RealizationWorker>,
    bisection: Box<dyn BisectionWorker>,
    extrapolation: Extrapolation,
    displacement: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    residual: Vec<f64>,
    ends: Ends,
    /// D(β̂∘L), D((α̂−β̂)∘L), DL, and the worker's own tangents.
    target: Vec<f64>,
    change: Vec<f64>,
    point: Vec<f64>,
    target_of_z: Vec<f64>,
    change_of_z: Vec<f64>,
    /// Operations of the products and solves.
    linear: u64,
}

impl WorkerStepper {
    pub(crate) fn new(
        make: &Arc<MakeWorkers>,
        lanes: usize,
        parameters: &[f64],
        dimension: usize,
        space: usize,
        correction: Correction,
    ) -> Self {
        let d = dimension;
        let trajectories = (0..lanes)
            .map(|lane| {
                let own: Vec<f64> = parameters
                    .iter()
                    .skip(lane)
                    .step_by(lanes)
                    .copied()
                    .collect();
                let (realization, bisection) = make(&own);
                Trajectory {
                    anderson: Anderson::new(d),
                    scales: vec![0.0; d],
                    realization,
                    bisection,
                    extrapolation: Extrapolation::new(d, DEPTH),
                    displacement: vec![0.0; d],
                    y: vec![0.0; d],
                    z: vec![0.0; space],
                    residual: vec![0.0; d],
                    ends: Ends::new(d),
                    target: vec![0.0; d * d],
                    change: vec![0.0; d * d],
                    point: vec![0.0; space * d],
                    target_of_z: vec![0.0; d * space],
                    change_of_z: vec![0.0; d * space],
                    linear: 0,
                }
            })
            .collect();
        Self {
            trajectories,
            correction,
            statistics: SolverStatistics::default(),
        }
    }
}

impl Trajectory {
    /// Forgets earlier steps.
    fn restart(&mut self) {
        self.extrapolation.clear(0);
        self.bisection.restart();
        self.realization.restart();
    }

    /// Evaluates both maps at y.
    fn evaluate(&mut self) -> Result<(), StepError> {
        self.bisection.point(&self.y, &mut self.z)?;
        self.realization.ends(&self.z, &mut self.ends)
    }

    /// D(β̂∘L) and D((α̂ − β̂)∘L) at the last point.
    fn tangents(&mut self) -> Result<(), StepError> {
        let d = self.y.len();
        self.bisection.tangent(&mut self.point)?;
        self.realization
            .tangents(&mut self.target_of_z, &mut self.change_of_z)?;
        product(&self.target_of_z, &self.point, d, &mut self.target);
        product(&self.change_of_z, &self.point, d, &mut self.change);
        self.linear += 4 * (d * d * self.z.len()) as u64;
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        let own = self.linear + self.anderson.operations();
        Some(self.realization.operations()? + self.bisection.operations()? + own)
    }

    fn solve(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        correction: Correction,
    ) -> Result<usize, StepError> {
        let d = x.len();
        if correction == Correction::None {
            self.y.copy_from_slice(x);
            self.evaluate()?;
            for i in 0..d {
                increment[i] =
                    (self.ends.base[i] - x[i]) + self.ends.offset[i] + self.ends.increment[i];
            }
            return finite(increment).map(|()| 1);
        }
        self.extrapolation
            .predict(self.displacement.as_chunks_mut().0);
        for i in 0..d {
            self.y[i] = x[i] + self.displacement[i];
        }
        let has_tangents = self.realization.has_tangents() && self.bisection.has_tangent();
        let is_near = self.bisection.is_near_identity();
        let newton = has_tangents && !is_near;
        self.anderson.clear();
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        loop {
            self.evaluate()?;
            for i in 0..d {
                self.residual[i] = x[i] - self.ends.base[i] - self.ends.offset[i] + low[i];
            }
            if newton {
                self.tangents()?;
                self.linear += elimination_operations(d) + substitution_operations(d);
                if !solve_in_place(&mut self.target, &mut self.residual) {
                    return Err(StepError::NonFinite {
                        what: "a Newton correction",
                    });
                }
            }
            let mut correction = CorrectionSize::default();
            for i in 0..d {
                self.scales[i] = x[i].abs() + self.ends.increment[i].abs();
                correction.take(self.residual[i], self.scales[i]);
            }
            if !has_tangents && !is_near {
                self.anderson.correct(&mut self.residual, &self.scales);
            }
            for i in 0..d {
                correction.take(self.residual[i], self.scales[i]);
                self.y[i] += self.residual[i];
            }
            if iteration.judge_correction(&correction)? == Verdict::Converged {
                break;
            }
        }
        let mut evaluations = iteration.evaluations();
        if !newton && self.residual.iter().any(|r| *r != 0.0) {
            // The increment varies with y far more than the residual does: without its tangent the
            // last correction enters by one more evaluation.
            self.evaluate()?;
            evaluations += 1;
        }
        for i in 0..d {
            let row = &self.change[i * d..][..d];
            let first_order: f64 = if newton {
                row.iter().zip(&self.residual).map(|(k, r)| k * r).sum()
            } else {
                0.0
            };
            increment[i] = self.ends.increment[i] + first_order;
        }
        finite(increment)?;
        for i in 0..d {
            self.displacement[i] = self.y[i] - x[i];
        }
        self.extrapolation
            .record(self.displacement.as_chunks_mut().0, &[true]);
        Ok(evaluations)
    }
}

fn finite(increment: &[f64]) -> Result<(), StepError> {
    if increment.iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    Err(StepError::NonFinite {
        what: "the increment",
    })
}

/// The d × d product of a d × s and an s × d matrix, row-major.
fn product(a: &[f64], b: &[f64], d: usize, out: &mut [f64]) {
    let s = a.len() / d;
    for i in 0..d {
        for j in 0..d {
            out[i * d + j] = (0..s).map(|k| a[i * s + k] * b[k * d + j]).sum();
        }
    }
}

impl Stepper for WorkerStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.trajectories.len();
        for (lane, trajectory) in self.trajectories.iter_mut().enumerate() {
            let own = |values: &[f64]| -> Vec<f64> {
                values.iter().skip(lane).step_by(lanes).copied().collect()
            };
            let mut own_increment = vec![0.0; x.len() / lanes];
            let result = trajectory.solve(&own(x), &own(low), &mut own_increment, self.correction);
            self.statistics.steps += 1;
            outcome[lane] = match result {
                Ok(evaluations) => {
                    let evaluations = evaluations as u64;
                    self.statistics.evaluations += evaluations;
                    self.statistics.most_evaluations =
                        self.statistics.most_evaluations.max(evaluations);
                    Ok(())
                }
                Err(error) => {
                    self.statistics.failures += 1;
                    trajectory.restart();
                    own_increment.fill(0.0);
                    Err(error)
                }
            };
            let places = increment.iter_mut().skip(lane).step_by(lanes);
            places
                .zip(&own_increment)
                .for_each(|(place, value)| *place = *value);
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.trajectories
            .get(lane)
            .map(|trajectory| trajectory.y.clone())
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let trajectory = self.trajectories.get_mut(lane)?;
        let d = trajectory.y.len();
        trajectory.evaluate().ok()?;
        trajectory.tangents().ok()?;
        if self.correction == Correction::None {
            let sum = trajectory.target.iter().zip(&trajectory.change);
            return Some(sum.map(|(t, c)| t + c).collect());
        }
        super::tangent_of_map(&trajectory.target, &trajectory.change, d)
    }

    fn restart(&mut self) {
        for trajectory in &mut self.trajectories {
            trajectory.restart();
        }
    }

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: self.trajectories.iter().map(Trajectory::operations).sum(),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = Vec::new();
        for trajectory in &self.trajectories {
            trajectory.extrapolation.memory(0, &mut memory);
            memory.extend(trajectory.bisection.memory());
            memory.extend(trajectory.realization.memory());
        }
        memory
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let each = |t: &Trajectory| {
            let parts = t.bisection.memory().len() + t.realization.memory().len();
            t.extrapolation.memory_len() + parts
        };
        let expected = self.trajectories.iter().map(each).sum();
        if memory.len() != expected {
            return Err(expected);
        }
        let mut rest = memory;
        for trajectory in &mut self.trajectories {
            let (history, others) = rest.split_at(trajectory.extrapolation.memory_len());
            trajectory.extrapolation.restore(0, history);
            let (own, others) = others.split_at(trajectory.bisection.memory().len());
            trajectory.bisection.restore(own);
            let (own, others) = others.split_at(trajectory.realization.memory().len());
            trajectory.realization.restore(own);
            rest = others;
        }
        Ok(())
    }
}
