//! The whole K-HJ step as one solve.
//!
//! Unknown are the nodal values of the curve with its end Y(1) = x_k fixed:
//! Y_j = x_k − ε Σ_k (W_k(1) − A_jk) Π(Y_k) p, x̂ = Σ b_j Y_j, p = dŜ(x̂). Then
//! x_{k+1} = x_k − ε Σ b_j Π(Y_j) p: no inner solve for α.

use std::sync::Arc;

use leafwise_core::solver::iteration::Verdict;
use leafwise_core::solver::{
    CorrectionSize, Extrapolation, LaneByLane, LinearIteration, Trajectory,
};
use leafwise_core::{
    BuildError, LagrangianBisection, MapProperties, RealizationData, RealizationWorker, StepError,
    StepMap, Stepper,
};
use leafwise_expression::{Graph, Kernel, StepSize, Term, Workspace};
use nalgebra::DMatrix;

use super::curve::Curve;
use super::data::CollocatedKarasev;
use super::worker::{CollocatedWorker, SHORT_TAIL};

/// Budget of one step.
const MOST_EVALUATIONS: usize = 100;

/// Levels of differences that the start is extrapolated from.
const EXTRAPOLATION: usize = 12;

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
        Box::new(LaneByLane::new(lanes, d, parameters, |parameters| {
            let mut one_form = self.one_form.workspace(1);
            self.one_form
                .prepare(&mut one_form, parameters, &[epsilon], &[h]);
            FusedTrajectory {
                epsilon,
                most_points: self.data.most_points(),
                curve: self.data.curve(parameters),
                kernel: Arc::clone(&self.one_form),
                one_form,
                work: self.one_form.step_operations().work(),
                forms: 0,
                extrapolation: Extrapolation::new(d, EXTRAPOLATION),
                displacement: vec![0.0; d],
                centre: vec![0.0; d],
                p: vec![0.0; d],
            }
        }))
    }
}

struct FusedTrajectory {
    epsilon: f64,
    most_points: Option<usize>,
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

impl FusedTrajectory {
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
    fn solve(&mut self, x: &[f64], low: &[f64], evaluations: &mut u64) -> Result<(), StepError> {
        let (d, epsilon) = (x.len(), self.epsilon);
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
            *evaluations += 1;
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
                return Ok(());
            }
        }
    }
}

impl Trajectory for FusedTrajectory {
    fn step(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        loop {
            self.solve(x, low, evaluations)?;
            let (points, tail) = (self.curve.rule.points(), self.curve.tail());
            match self.most_points {
                Some(most) if tail > SHORT_TAIL && points < most => {
                    self.curve.set_points(points + 1);
                }
                Some(_) if tail > SHORT_TAIL => return Err(StepError::LeftChart { ratio: tail }),
                _ => break,
            }
        }
        for (i, increment) in increment.iter_mut().enumerate() {
            *increment = -self
                .curve
                .combination(self.epsilon, &self.curve.rule.weights, i);
        }
        if increment.iter().all(|v| v.is_finite()) {
            self.extrapolation
                .record(self.displacement.as_chunks_mut().0, &[true]);
        }
        Ok(())
    }

    fn solution(&self) -> Option<&[f64]> {
        Some(&self.centre)
    }

    fn tangent(&mut self) -> Option<Vec<f64>> {
        let d = self.centre.len();
        // A curve of its own, so that measuring does not disturb stepping.
        let curve = self.curve.clone();
        let z: Vec<f64> = self.centre.iter().chain(&self.p).copied().collect();
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
            self.kernel.output(&self.one_form, d + i * d + j)[0]
        });
        let along = |rows: &[f64]| {
            let all = DMatrix::from_row_slice(d, 2 * d, rows);
            all.columns(0, d) + all.columns(d, d) * &slope
        };
        let map = DMatrix::identity(d, d) + along(&change) * along(&target).lu().try_inverse()?;
        Some(map.transpose().as_slice().to_vec())
    }

    fn operations(&self) -> Option<u64> {
        Some(self.curve.operations() + self.forms * self.work)
    }

    fn restart(&mut self) {
        self.extrapolation.clear(0);
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = vec![self.curve.rule.points() as f64];
        self.extrapolation.memory(0, &mut memory);
        memory
    }

    fn restore(&mut self, memory: &[f64]) {
        self.curve.set_points(memory[0].max(1.0) as usize);
        self.extrapolation.restore(0, &memory[1..]);
    }
}
