//! The whole K-HJ step as one solve.
//!
//! Unknown are the nodal values of the curve with its end Y(1) = x_k fixed:
//! Y_j = x_k − ε Σ_k (W_k(1) − A_jk) Π(Y_k) p, x̂ = Σ b_j Y_j, p = dŜ(x̂). Then
//! x_{k+1} = x_k − ε Σ b_j Π(Y_j) p: no inner solve for α.

use std::sync::Arc;

use leafwise_core::solver::iteration::Verdict;
use leafwise_core::solver::{CorrectionSize, Extrapolation, LinearIteration};
use leafwise_core::{
    BuildError, LagrangianBisection, MapProperties, RealizationData, RealizationWorker,
    SolverStatistics, StepError, StepMap, Stepper,
};
use leafwise_expression::{Graph, Kernel, StepSize, Term, Workspace};
use nalgebra::DMatrix;

use super::curve::Curve;
use super::data::CollocatedKarasev;
use super::worker::{CollocatedWorker, SHORT_TAIL};

/// Budget of one step.
const MOST_EVALUATIONS: usize = 100;

/// A K-HJ map over collocation.
#[derive(Clone, Debug)]
pub(super) struct FusedStep {
    data: Arc<CollocatedKarasev>,
    describe: String,
    properties: MapProperties,
    /// x̂ ↦ (p, ∂p/∂x̂).
    one_form: Arc<Kernel>,
}

impl FusedStep {
    pub(super) fn compile(
        data: Arc<CollocatedKarasev>,
        bisection: Arc<dyn LagrangianBisection>,
        properties: MapProperties,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let d = data.dimension();
        let code = bisection.code().ok_or_else(|| BuildError::Incompatible {
            dynamics: "the bisection".to_owned(),
            realization: data.describe(),
            reason: "its one-form has no code".to_owned(),
        })?;
        let mut graph = Graph::new();
        let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let h = graph.step_size(StepSize::H);
        let mut outputs = code.point(&mut graph, &epsilon, &h, &y)?.split_off(d);
        for i in 0..d {
            let p = outputs[i].clone();
            for j in 0..d {
                outputs.push(graph.derivative(&p, j)?);
            }
        }
        let one_form = Arc::new(Kernel::compile(&graph, &outputs, parameters, d));
        let describe = format!("{} + Hamilton-Jacobi, fused", data.describe());
        Ok(Self {
            data,
            describe,
            properties,
            one_form,
        })
    }
}

impl StepMap for FusedStep {
    fn dimension(&self) -> usize {
        self.data.dimension()
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.describe.clone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let d = self.dimension();
        let trajectories = (0..lanes)
            .map(|lane| {
                let own: Vec<f64> = parameters
                    .iter()
                    .skip(lane)
                    .step_by(lanes)
                    .copied()
                    .collect();
                let work = self.one_form.step_operations().work();
                let mut one_form = self.one_form.workspace(1);
                self.one_form.prepare(&mut one_form, &own, &[epsilon], &[h]);
                Trajectory {
                    curve: self.data.curve(&own),
                    kernel: Arc::clone(&self.one_form),
                    one_form,
                    work,
                    forms: 0,
                    extrapolation: Extrapolation::new(d, 12),
                    displacement: vec![0.0; d],
                    centre: vec![0.0; d],
                    p: vec![0.0; d],
                }
            })
            .collect();
        Box::new(FusedStepper {
            trajectories,
            epsilon,
            most_points: self.data.most_points(),
            statistics: SolverStatistics::default(),
        })
    }
}

struct FusedStepper {
    trajectories: Vec<Trajectory>,
    epsilon: f64,
    most_points: Option<usize>,
    statistics: SolverStatistics,
}

struct Trajectory {
    curve: Curve,
    kernel: Arc<Kernel>,
    one_form: Workspace,
    /// Operations of one evaluation of dŜ, and how often it was evaluated.
    work: u64,
    forms: u64,
    extrapolation: Extrapolation,
    displacement: Vec<f64>,
    centre: Vec<f64>,
    p: Vec<f64>,
}

impl Trajectory {
    fn one_form(&mut self) {
        for (i, value) in self.centre.iter().enumerate() {
            self.one_form.input_mut(i)[0] = *value;
        }
        self.kernel.evaluate_in_place(&mut self.one_form);
        self.forms += 1;
        for (i, p) in self.p.iter_mut().enumerate() {
            *p = self.kernel.output(&self.one_form, i)[0];
        }
    }

    /// One solve at the present number of nodes.
    fn solve(&mut self, epsilon: f64, x: &[f64], low: &[f64]) -> Result<usize, StepError> {
        let d = x.len();
        let q = self.curve.rule.points();
        self.extrapolation
            .predict(self.displacement.as_chunks_mut().0);
        for i in 0..d {
            self.centre[i] = x[i] + self.displacement[i];
        }
        // The straight curve through the predicted mean and the fixed end.
        for (j, y) in self.curve.nodes.chunks_exact_mut(d).enumerate() {
            let s: f64 = 0.5 + self.curve.rule.matrix[j * q..][..q].iter().sum::<f64>();
            for i in 0..d {
                y[i] = x[i] + 2.0 * (1.0 - s) * self.displacement[i];
            }
        }
        self.one_form();
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        loop {
            self.curve.evaluate(&self.p);
            let mut size = CorrectionSize::default();
            for i in 0..d {
                let end = self.curve.combination(epsilon, &self.curve.rule.end, i);
                let mut mean = 0.0;
                for j in 0..q {
                    let row = &self.curve.rule.matrix[j * q..][..q];
                    let offset = self.curve.combination(epsilon, row, i) - end + low[i];
                    let change = (x[i] - self.curve.nodes[j * d + i]) + offset;
                    size.take(change, x[i].abs() + offset.abs());
                    self.curve.nodes[j * d + i] = x[i] + offset;
                    mean += self.curve.rule.weights[j] * offset;
                }
                self.displacement[i] = mean;
                self.centre[i] = x[i] + mean;
            }
            self.one_form();
            if iteration.judge_correction(&size)? == Verdict::Converged {
                return Ok(iteration.evaluations());
            }
        }
    }

    fn step(
        &mut self,
        epsilon: f64,
        most_points: Option<usize>,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
    ) -> Result<usize, StepError> {
        let mut evaluations = 0;
        loop {
            evaluations += self.solve(epsilon, x, low)?;
            let (points, tail) = (self.curve.rule.points(), self.curve.tail());
            match most_points {
                Some(most) if tail > SHORT_TAIL && points < most => {
                    self.curve.set_points(points + 1);
                }
                Some(_) if tail > SHORT_TAIL => return Err(StepError::LeftChart { ratio: tail }),
                _ => break,
            }
        }
        for (i, increment) in increment.iter_mut().enumerate() {
            *increment = -self.curve.combination(epsilon, &self.curve.rule.weights, i);
        }
        if increment.iter().any(|v| !v.is_finite()) {
            return Err(StepError::NonFinite {
                what: "the increment",
            });
        }
        self.extrapolation
            .record(self.displacement.as_chunks_mut().0, &[true]);
        Ok(evaluations)
    }
}

impl Stepper for FusedStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.trajectories.len();
        let d = x.len() / lanes;
        let mut own = vec![0.0; d];
        for (lane, trajectory) in self.trajectories.iter_mut().enumerate() {
            let of = |values: &[f64]| -> Vec<f64> {
                values.iter().skip(lane).step_by(lanes).copied().collect()
            };
            let result =
                trajectory.step(self.epsilon, self.most_points, &of(x), &of(low), &mut own);
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
                    trajectory.extrapolation.clear(0);
                    own.fill(0.0);
                    Err(error)
                }
            };
            let places = increment.iter_mut().skip(lane).step_by(lanes);
            places.zip(&own).for_each(|(place, value)| *place = *value);
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.trajectories
            .get(lane)
            .map(|trajectory| trajectory.centre.clone())
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let trajectory = self.trajectories.get_mut(lane)?;
        let d = trajectory.centre.len();
        // A curve of its own, so that measuring does not disturb stepping.
        let curve = trajectory.curve.clone();
        let z: Vec<f64> = trajectory
            .centre
            .iter()
            .chain(&trajectory.p)
            .copied()
            .collect();
        let mut worker = CollocatedWorker {
            curve,
            epsilon: self.epsilon,
            most_points: None,
            z: z.clone(),
        };
        let mut ends = leafwise_core::Ends::new(d);
        worker.ends(&z, &mut ends).ok()?;
        let mut target = vec![0.0; 2 * d * d];
        let mut change = vec![0.0; 2 * d * d];
        worker.tangents(&mut target, &mut change).ok()?;
        // D(·∘L) = ∂x + ∂p Dθ on L = graph θ.
        let slope = DMatrix::from_fn(d, d, |i, j| {
            trajectory
                .kernel
                .output(&trajectory.one_form, d + i * d + j)[0]
        });
        let along = |rows: &[f64]| {
            let all = DMatrix::from_row_slice(d, 2 * d, rows);
            all.columns(0, d) + all.columns(d, d) * &slope
        };
        let map = DMatrix::identity(d, d) + along(&change) * along(&target).lu().try_inverse()?;
        Some(map.transpose().as_slice().to_vec())
    }

    fn restart(&mut self) {
        self.trajectories
            .iter_mut()
            .for_each(|t| t.extrapolation.clear(0));
    }

    fn statistics(&self) -> SolverStatistics {
        let of = |t: &Trajectory| t.curve.operations() + t.forms * t.work;
        SolverStatistics {
            operations: Some(self.trajectories.iter().map(of).sum()),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = Vec::new();
        for trajectory in &self.trajectories {
            memory.push(trajectory.curve.rule.points() as f64);
            trajectory.extrapolation.memory(0, &mut memory);
        }
        memory
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let each = 1 + self
            .trajectories
            .first()
            .map_or(0, |t| t.extrapolation.memory_len());
        if memory.len() != each * self.trajectories.len() {
            return Err(each * self.trajectories.len());
        }
        for (trajectory, part) in self.trajectories.iter_mut().zip(memory.chunks_exact(each)) {
            trajectory.curve.set_points(part[0].max(1.0) as usize);
            trajectory.extrapolation.restore(0, &part[1..]);
        }
        Ok(())
    }
}
