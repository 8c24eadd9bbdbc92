//! The whole K-HJ step as one solve.
//!
//! Unknown are the nodal values of the curve with its end Y(1) = x_k fixed:
//! Y_j = x_k − ε Σ_k (W_k(1) − A_jk) Π(Y_k) p, x̂ = Σ b_j Y_j, p = dŜ(x̂). Then
//! x_{k+1} = x_k − ε Σ b_j Π(Y_j) p: no inner solve for α.

use std::sync::Arc;

use leafwise_core::solver::iteration::Verdict;
use leafwise_core::solver::{Extrapolation, LinearIteration};
use leafwise_core::{
    BuildError, CodeOneForm, LagrangianBisection, MapProperties, OneFormWorker, PoissonSystem,
    RealizationData, RealizationWorker, SolverStatistics, StepError, StepMap, Stepper,
};
use nalgebra::DMatrix;

use super::curve::Curve;
use super::data::CollocatedKarasev;
use super::worker::{CollocatedWorker, SHORT_TAIL};

/// Budget of one step.
const MOST_EVALUATIONS: usize = 100;

/// x̂ ↦ p where the bisection is the graph of a one-form.
#[derive(Clone, Debug)]
pub(super) enum OneForm {
    Code(CodeOneForm),
    Numbers(Arc<dyn LagrangianBisection>),
}

impl OneForm {
    /// The one-form of a bisection over pairs (x, p), `None` where it has none.
    pub(super) fn of(
        system: &PoissonSystem,
        bisection: &Arc<dyn LagrangianBisection>,
    ) -> Option<Result<Self, BuildError>> {
        let (d, parameters) = (system.dimension(), system.parameters().len());
        if let (Some(_), Some(code)) = (bisection.generating_function(), bisection.code()) {
            let form = CodeOneForm::compile(d, parameters, |graph, epsilon, h, y| {
                Ok(code.point(graph, epsilon, h, y)?.split_off(d))
            });
            return Some(form.map(Self::Code));
        }
        bisection.one_form(&system.parameter_values(), 1.0, 1.0)?;
        Some(Ok(Self::Numbers(Arc::clone(bisection))))
    }

    fn worker(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn OneFormWorker> {
        match self {
            Self::Code(form) => form.worker(parameters, epsilon, h),
            Self::Numbers(bisection) => bisection
                .one_form(parameters, epsilon, h)
                .expect("a one-form was offered when the method was composed"),
        }
    }
}

/// A K-HJ map over collocation.
#[derive(Clone, Debug)]
pub(super) struct FusedStep {
    data: Arc<CollocatedKarasev>,
    describe: String,
    properties: MapProperties,
    form: OneForm,
}

impl FusedStep {
    pub(super) fn new(
        data: Arc<CollocatedKarasev>,
        form: OneForm,
        properties: MapProperties,
    ) -> Self {
        let describe = format!("{} + Hamilton-Jacobi, fused", data.describe());
        Self {
            data,
            describe,
            properties,
            form,
        }
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

    fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        let mut kernels = vec![("one-form", self.one_form.as_ref())];
        kernels.extend(self.data.kernels());
        kernels
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
                Trajectory {
                    curve: self.data.curve(&own),
                    form: self.form.worker(&own, epsilon, h),
                    data: Arc::clone(&self.data),
                    parameters: own,
                    linear: 0,
                    shift: vec![0.0; d],
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
    form: Box<dyn OneFormWorker>,
    data: Arc<CollocatedKarasev>,
    parameters: Vec<f64>,
    /// Operations of the mean.
    linear: u64,
    extrapolation: Extrapolation,
    displacement: Vec<f64>,
    centre: Vec<f64>,
    p: Vec<f64>,
    /// x_k − Y(1), but for the state's own offset.
    shift: Vec<f64>,
}

impl Trajectory {
    fn operations(&self) -> Option<u64> {
        Some(self.curve.operations()? + self.form.operations()? + self.linear)
    }

    /// One solve at the present number of nodes: by the plain iteration where it contracts, else
    /// accelerated.
    fn solve(&mut self, epsilon: f64, x: &[f64], low: &[f64]) -> Result<usize, StepError> {
        if !self.curve.is_foreign()
            && let Ok(evaluations) = self.iterate(epsilon, x, low, false)
        {
            return Ok(evaluations);
        }
        self.iterate(epsilon, x, low, true)
    }

    fn iterate(
        &mut self,
        epsilon: f64,
        x: &[f64],
        low: &[f64],
        accelerates: bool,
    ) -> Result<usize, StepError> {
        let d = x.len();
        let q = self.curve.rule.points();
        self.extrapolation
            .predict(self.displacement.as_chunks_mut().0);
        for i in 0..d {
            self.centre[i] = x[i] + self.displacement[i];
        }
        // The straight curve through the predicted mean and the fixed end.
        let rows = self.curve.rule.matrix.chunks_exact(q);
        let left: Vec<f64> = rows.map(|row| 0.5 - row.iter().sum::<f64>()).collect();
        let displacement = &self.displacement;
        self.curve
            .begin(x, accelerates, |j, i| 2.0 * left[j] * displacement[i]);
        self.form.value(&self.centre, &mut self.p)?;
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        loop {
            self.curve.evaluate(&self.p)?;
            for i in 0..d {
                let end = self.curve.combination(epsilon, &self.curve.rule.end, i);
                self.shift[i] = low[i] - end;
            }
            let size = self.curve.correct(epsilon, x, &self.shift);
            for i in 0..d {
                let offsets = self.curve.offsets.iter().skip(i).step_by(d);
                let weights = self.curve.rule.weights.iter();
                self.displacement[i] = weights.zip(offsets).map(|(b, offset)| b * offset).sum();
                self.centre[i] = x[i] + self.displacement[i];
            }
            self.linear += (2 * q * d) as u64;
            self.form.value(&self.centre, &mut self.p)?;
            if iteration.judge_correction(&size)? == Verdict::Converged {
                // V lags one correction behind.
                self.curve.evaluate(&self.p)?;
                return Ok(iteration.evaluations() + 1);
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
        let mut curve = trajectory.data.curve(&trajectory.parameters);
        curve.set_points(trajectory.curve.rule.points());
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
        let mut slope = vec![0.0; d * d];
        trajectory.form.jacobian(&mut slope).ok()?;
        let slope = DMatrix::from_row_slice(d, d, &slope);
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
        SolverStatistics {
            operations: self.trajectories.iter().map(Trajectory::operations).sum(),
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
