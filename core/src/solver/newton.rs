//! Exact Newton on a compiled kernel, one iteration history a lane.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Rational};
use leafwise_expression::{Graph, Kernel, OperationCount, Term, Workspace};

use super::extrapolation::Extrapolation;
use super::iteration::{CorrectionSize, NORMWISE_ROUND_OFF};
use super::linear::{elimination_operations, solve_in_place, substitution_operations};
use super::{LARGEST_REMAINDER, SolverStatistics, Stepper, tangent_of_map};
use crate::error::{BuildError, StepError};
use crate::realization::SourceTarget;

/// Newton's budget for one step. Quadratic convergence takes 2 to 4; a cold start at a large step
/// a dozen.
const MOST_EVALUATIONS: usize = 50;

/// How much larger than the observed convergence constant the true one may be.
const SAFETY: f64 = 4.0;

/// The code of one Newton iteration: y ↦ base − y, β̂ − base, α̂ − β̂, their Jacobians, the guard.
#[derive(Clone, Debug)]
pub struct NewtonKernel {
    kernel: Arc<Kernel>,
    residual_operations: OperationCount,
    dimension: usize,
    has_guard: bool,
}

impl NewtonKernel {
    /// Compiles the iteration for source and target code over the inputs y_0 … y_{d−1}.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a derivative has no code.
    pub fn compile(
        graph: &mut Graph,
        ends: &SourceTarget,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let d = ends.base.len();
        let mut outputs: Vec<Term> = Vec::with_capacity(d * (3 + 2 * d) + 2 * d);
        outputs.extend_from_slice(&ends.base);
        outputs.extend_from_slice(&ends.offset);
        outputs.extend_from_slice(&ends.increment);
        let residual_operations = Kernel::compile(graph, &outputs, parameters, d).step_operations();
        for i in 0..d {
            for j in 0..d {
                let base = graph.derivative(&ends.base[i], j)?;
                let offset = graph.derivative(&ends.offset[i], j)?;
                outputs.push(graph.combine(&[(Rational::one(), base), (Rational::one(), offset)]));
            }
        }
        for i in 0..d {
            for j in 0..d {
                outputs.push(graph.derivative(&ends.increment[i], j)?);
            }
        }
        if let Some((first, last)) = &ends.guard {
            outputs.extend_from_slice(first);
            outputs.extend_from_slice(last);
        }
        let kernel = Kernel::compile(graph, &outputs, parameters, d);
        Ok(Self {
            kernel: Arc::new(kernel),
            residual_operations,
            dimension: d,
            has_guard: ends.guard.is_some(),
        })
    }

    /// Weighted operations of one Newton iteration with its linear solve.
    pub fn work(&self) -> u64 {
        let solve =
            elimination_operations(self.dimension) + substitution_operations(self.dimension);
        self.operations().work() + solve
    }

    /// The code of one Newton iteration: outputs base − y, β̂ − base, α̂ − β̂, D(β̂∘L), D(α̂ − β̂)∘L,
    /// and the guard's.
    pub fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// Operations of one Newton iteration, the linear solve apart.
    pub fn operations(&self) -> OperationCount {
        self.kernel.step_operations()
    }

    /// Operations of α̂ and β̂ along the bisection alone.
    pub fn residual_operations(&self) -> OperationCount {
        self.residual_operations
    }

    /// Operations once for each choice of parameters and step sizes.
    pub fn coefficient_operations(&self) -> OperationCount {
        self.kernel.coefficient_operations()
    }
}

/// Solves β̂(L(y)) = x by Newton's method with the exact Jacobian, `lanes` trajectories at once.
///
/// *Start*: extrapolation of earlier solutions. *Stop*: when the quadratic remainder C‖δ‖² that
/// the next correction would have is below a small part of an ulp, C being the convergence constant observed so far;
/// the last correction then enters the increment to first order, without another evaluation. A
/// lane freezes on its own test, so its result does not depend on its neighbours.
pub struct NewtonStepper {
    kernel: Arc<Kernel>,
    workspace: Workspace,
    dimension: usize,
    has_guard: bool,
    /// Operations of one iteration.
    work: u64,
    lanes: Vec<Lane>,
    statistics: SolverStatistics,
}

struct Lane {
    y: Vec<f64>,
    correction: Vec<f64>,
    jacobian: Vec<f64>,
    extrapolation: Extrapolation,
    /// The largest ‖δ_{k+1}‖/‖δ_k‖² of recent steps; infinite before any was seen.
    constant: f64,
    last: f64,
    /// How many corrections in a row did not shrink.
    stuck: usize,
    evaluations: usize,
    active: bool,
}

impl NewtonStepper {
    /// A worker for `lanes` trajectories.
    pub fn new(map: &NewtonKernel, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Self {
        let d = map.dimension;
        let mut workspace = map.kernel.workspace(lanes);
        map.kernel.prepare(
            &mut workspace,
            parameters,
            &vec![epsilon; lanes],
            &vec![h; lanes],
        );
        let lane = || Lane {
            y: vec![0.0; d],
            correction: vec![0.0; d],
            jacobian: vec![0.0; d * d],
            extrapolation: Extrapolation::new(d),
            constant: f64::INFINITY,
            last: f64::INFINITY,
            stuck: 0,
            evaluations: 0,
            active: false,
        };
        Self {
            kernel: Arc::clone(&map.kernel),
            workspace,
            dimension: d,
            has_guard: map.has_guard,
            work: map.work(),
            lanes: (0..lanes).map(|_| lane()).collect(),
            statistics: SolverStatistics::default(),
        }
    }

    fn output(&self, index: usize, lane: usize) -> f64 {
        self.kernel.output(&self.workspace, index)[lane]
    }

    /// One Newton correction of a lane from the kernel's outputs. `Ok(true)`: the step is done.
    fn iterate(
        &mut self,
        at: usize,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
    ) -> Result<bool, StepError> {
        let (d, lanes) = (self.dimension, self.lanes.len());
        let mut lane = std::mem::take(&mut self.lanes[at].correction);
        let mut matrix = std::mem::take(&mut self.lanes[at].jacobian);
        for i in 0..d {
            // (base − x) + (β̂ − base) − low: base and x are close, their difference is exact.
            let here = i * lanes + at;
            lane[i] = x[here] - self.output(i, at) - self.output(d + i, at) + low[here];
            for j in 0..d {
                matrix[i * d + j] = self.output(3 * d + i * d + j, at);
            }
        }
        let solvable = lane.iter().all(|r| r.is_finite()) && solve_in_place(&mut matrix, &mut lane);
        let own = |i: usize| x[i * lanes + at].abs() + self.output(2 * d + i, at).abs();
        let state_size = (0..d).map(own).fold(0.0, f64::max);
        let mut correction = CorrectionSize::default();
        for i in 0..d {
            // A component may be the round-off of what the others put into it, Σ_j |D − 1|_ij |y_j|;
            // never that of more than the state, however large a step is tried.
            let reach: f64 = (0..d)
                .map(|j| {
                    let unit = if i == j { 1.0 } else { 0.0 };
                    let slope = (self.output(3 * d + i * d + j, at) - unit).abs();
                    slope * (self.lanes[at].y[j].abs() + lane[j].abs())
                })
                .sum();
            correction.take(lane[i], own(i) + reach.min(state_size));
        }
        let size = correction.component();
        let state = &mut self.lanes[at];
        state.jacobian = matrix;
        state.correction = lane;
        state.evaluations += 1;
        if !solvable || !size.is_finite() {
            // An iterate outside the chart has no value: the guard tells the cause.
            return Err(match self.check_chart(at) {
                Err(StepError::LeftChart { ratio }) if ratio.is_finite() => {
                    StepError::LeftChart { ratio }
                }
                _ => StepError::NonFinite {
                    what: "a Newton correction",
                },
            });
        }
        if state.last.is_finite() && state.last > 0.0 && size > 16.0 * f64::EPSILON {
            let observed = size / (state.last * state.last);
            // Only a fresh observation may lower the constant, and slowly.
            state.constant = if state.constant.is_finite() {
                observed.max(0.9 * state.constant)
            } else {
                observed
            };
        }
        let remainder = if size <= f64::EPSILON {
            0.0
        } else {
            SAFETY * state.constant * size * size
        };
        let is_stuck = size >= 0.5 * state.last;
        state.stuck = if is_stuck { state.stuck + 1 } else { 0 };
        let stagnates = is_stuck && size <= 64.0 * f64::EPSILON;
        let is_round_off = state.stuck >= 2 && correction.norm() <= NORMWISE_ROUND_OFF;
        let done = remainder <= LARGEST_REMAINDER || stagnates || is_round_off;
        for i in 0..d {
            state.y[i] += state.correction[i];
        }
        state.last = size;
        if done {
            for i in 0..d {
                let mut first_order = 0.0;
                for j in 0..d {
                    first_order +=
                        self.output(3 * d + d * d + i * d + j, at) * self.lanes[at].correction[j];
                }
                increment[i * lanes + at] = self.output(2 * d + i, at) + first_order;
            }
            self.check_chart(at)?;
        } else if self.lanes[at].evaluations >= MOST_EVALUATIONS {
            return Err(StepError::NoConvergence {
                evaluations: MOST_EVALUATIONS,
                correction: size,
            });
        }
        Ok(done)
    }

    fn check_chart(&self, at: usize) -> Result<(), StepError> {
        if !self.has_guard {
            return Ok(());
        }
        let d = self.dimension;
        let start = 3 * d + 2 * d * d;
        let size = |from: usize| {
            (from..from + d).fold(0.0_f64, |m, index| m.max(self.output(index, at).abs()))
        };
        let (first, last) = (size(start), size(start + d));
        if last >= first && last > 0.0 {
            return Err(StepError::LeftChart {
                ratio: last / first,
            });
        }
        Ok(())
    }
}

impl Stepper for NewtonStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let (d, lanes) = (self.dimension, self.lanes.len());
        for (at, lane) in self.lanes.iter_mut().enumerate() {
            outcome[at] = Ok(());
            lane.extrapolation.predict(&mut lane.correction);
            for i in 0..d {
                lane.y[i] = x[i * lanes + at] + lane.correction[i];
            }
            lane.last = f64::INFINITY;
            lane.stuck = 0;
            lane.evaluations = 0;
            lane.active = true;
        }
        while self.lanes.iter().any(|lane| lane.active) {
            for i in 0..d {
                let slots = self.workspace.input_mut(i);
                for (slot, lane) in slots.iter_mut().zip(&self.lanes) {
                    *slot = lane.y[i];
                }
            }
            self.kernel.evaluate_in_place(&mut self.workspace);
            for at in 0..lanes {
                if !self.lanes[at].active {
                    continue;
                }
                match self.iterate(at, x, low, increment) {
                    Ok(done) => self.lanes[at].active = !done,
                    Err(error) => {
                        outcome[at] = Err(error);
                        self.lanes[at].active = false;
                    }
                }
            }
        }
        for (at, lane) in self.lanes.iter_mut().enumerate() {
            self.statistics.steps += 1;
            self.statistics.evaluations += lane.evaluations as u64;
            self.statistics.most_evaluations = self
                .statistics
                .most_evaluations
                .max(lane.evaluations as u64);
            let finite = (0..d).all(|i| increment[i * lanes + at].is_finite());
            if outcome[at].is_ok() && !finite {
                outcome[at] = Err(StepError::NonFinite {
                    what: "the increment",
                });
            }
            if outcome[at].is_ok() {
                for i in 0..d {
                    lane.correction[i] = lane.y[i] - x[i * lanes + at];
                }
                lane.extrapolation.record(&lane.correction);
            } else {
                self.statistics.failures += 1;
                (0..d).for_each(|i| increment[i * lanes + at] = 0.0);
                lane.extrapolation.clear();
            }
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.lanes.get(lane).map(|lane| lane.y.clone())
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let d = self.dimension;
        for i in 0..d {
            self.workspace.input_mut(i)[lane] = self.lanes[lane].y[i];
        }
        self.kernel.evaluate_in_place(&mut self.workspace);
        let matrix = |from: usize| -> Vec<f64> {
            (from..from + d * d)
                .map(|at| self.output(at, lane))
                .collect()
        };
        tangent_of_map(&matrix(3 * d), &matrix(3 * d + d * d), d)
    }

    fn restart(&mut self) {
        for lane in &mut self.lanes {
            lane.extrapolation.clear();
            lane.constant = f64::INFINITY;
        }
    }

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: Some(self.statistics.evaluations * self.work),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = Vec::new();
        for lane in &self.lanes {
            memory.push(lane.constant);
            lane.extrapolation.memory(&mut memory);
        }
        memory
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let each = 1 + self
            .lanes
            .first()
            .map_or(0, |lane| lane.extrapolation.memory_len());
        if memory.len() != each * self.lanes.len() {
            return Err(each * self.lanes.len());
        }
        for (lane, part) in self.lanes.iter_mut().zip(memory.chunks_exact(each)) {
            lane.constant = part[0];
            lane.extrapolation.restore(&part[1..]);
        }
        Ok(())
    }
}
