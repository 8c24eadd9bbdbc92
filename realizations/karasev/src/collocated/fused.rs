//! The whole K-HJ step as one solve.
//!
//! Unknown is the curve with its end Y(1) = x_k fixed, by its Legendre coefficients. With v_m those of Π(Y)p,
//! p = dŜ(x̂), its mean is x̂ = x_k − (ε/2)(v_0 + v_1/3). Then x_{k+1} = x_k − ε v_0: no inner solve for α.

use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::solver::judge::{Verdict, all_finite, is_between};
use leafwise_core::solver::{
    Branch, CorrectionMethod, CorrectionSize, Extrapolation, Lanes, StepReport, Trajectories,
};
use leafwise_core::{Ends, Evaluator, MapAbilities, MapProperties, StepError, StepMap, Stepper};
use nalgebra::DMatrix;

use super::collocation::Collocation;
use super::curve::Curve;
use super::evaluator::CollocatedEvaluator;
use super::simplified::Fixed;

/// Budget of one solve by Newton's method, and of one that is accelerated.
const MOST_NEWTON: usize = 40;
const MOST_ACCELERATED: usize = 100;

/// Levels of differences that the start is extrapolated from.
const EXTRAPOLATION: usize = 12;

/// A K-HJ map over collocation.
#[derive(Clone, Debug)]
pub(super) struct FusedStep {
    collocation: Collocation,
    describe: String,
    properties: MapProperties,
    /// x̂ ↦ p = θ(x̂), the one-form whose graph the bisection is.
    form: SmoothMap,
}

impl FusedStep {
    pub(super) fn new(
        collocation: Collocation,
        describe: String,
        form: SmoothMap,
        properties: MapProperties,
    ) -> Self {
        Self {
            collocation,
            describe,
            properties,
            form,
        }
    }
}

impl StepMap for FusedStep {
    fn dimension(&self) -> usize {
        self.collocation.dimension()
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.describe.clone()
    }

    fn abilities(&self) -> MapAbilities<'_> {
        let mut kernels = self.collocation.kernels();
        kernels.extend(self.form.kernels());
        MapAbilities {
            kernels,
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let d = self.dimension();
        Box::new(Lanes::apart(lanes, d, parameters, |parameters| {
            let curve = self.collocation.curve(parameters);
            let size = curve.shape.len();
            FusedTrajectory {
                epsilon,
                most_points: self.collocation.most_points(),
                curve,
                form: self.form.evaluator(parameters, epsilon, h),
                collocation: self.collocation.clone(),
                parameters: parameters.to_vec(),
                mean: vec![0.0; d],
                extrapolation: Extrapolation::new(size, EXTRAPOLATION),
                recorded: vec![0.0; size],
                displacement: vec![0.0; d],
                centre: vec![0.0; d],
                p: vec![0.0; d],
                slope: vec![0.0; d * d],
                start: vec![0.0; d],
                path: None,
            }
        }))
    }
}

struct FusedTrajectory {
    epsilon: f64,
    most_points: Option<usize>,
    curve: Curve,
    form: SmoothMapEvaluator,
    collocation: Collocation,
    parameters: Vec<f64>,
    /// Of the curve's shape, and room for that.
    extrapolation: Extrapolation,
    recorded: Vec<f64>,
    displacement: Vec<f64>,
    centre: Vec<f64>,
    p: Vec<f64>,
    /// Dθ.
    slope: Vec<f64>,
    /// x̂ − x_k by V as last evaluated.
    mean: Vec<f64>,
    /// Where the solve starts, as a displacement of the mean.
    start: Vec<f64>,
    /// Room for the path to that, made when it is first asked for.
    path: Option<Box<Path>>,
}

/// β̂(x̂, dŜ(x̂)) = x_k by evaluations of its own.
struct Path {
    branch: Branch,
    evaluator: CollocatedEvaluator,
    ends: Vec<f64>,
    z: Vec<f64>,
    /// Dβ̂ and D(α̂ − β̂).
    tangents: Vec<f64>,
    slope: Vec<f64>,
}

impl Path {
    fn new(evaluator: CollocatedEvaluator, d: usize) -> Self {
        Self {
            branch: Branch::new(d),
            evaluator,
            ends: vec![0.0; 3 * d],
            z: vec![0.0; 2 * d],
            tangents: vec![0.0; 4 * d * d],
            slope: vec![0.0; d * d],
        }
    }

    /// Whether the mean that was `solved` is that on the branch which begins at x: of L = graph sθ, from
    /// s = 0.
    fn settle(
        &mut self,
        form: &mut dyn Evaluator,
        (x, low): (&[f64], &[f64]),
        solved: Result<&[f64], StepError>,
        evaluations: &mut u64,
    ) -> Result<bool, StepError> {
        let d = x.len();
        let Self {
            branch,
            evaluator,
            ends,
            z,
            tangents,
            slope,
        } = self;
        branch.settle(
            x,
            x,
            solved,
            evaluations,
            |part, centre, residual, jacobian| {
                let (mean, p) = z.split_at_mut(d);
                mean.copy_from_slice(centre);
                form.values(centre, p)?;
                form.jacobians(centre, slope)?;
                p.iter_mut().for_each(|p| *p *= part);
                evaluator.values(z, ends)?;
                evaluator.jacobians(z, tangents)?;
                let (ends, (target, _)) = (Ends::of(ends), tangents.split_at(2 * d * d));
                for i in 0..d {
                    residual[i] = (x[i] - ends.base[i]) - ends.offset[i] + low[i];
                    let (by_x, by_p) = target[i * 2 * d..][..2 * d].split_at(d);
                    for j in 0..d {
                        // D(β̂∘L) = ∂x + ∂p s Dθ on L = graph sθ.
                        let through: f64 = (0..d).map(|k| by_p[k] * slope[k * d + j]).sum();
                        jacobian[i * d + j] = by_x[j] + part * through;
                    }
                }
                all_finite(residual, jacobian, "a Newton correction")
            },
        )
    }
}

impl FusedTrajectory {
    /// One solve from the present shape with as many nodes as it needs.
    fn resolve(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        loop {
            self.solve(x, low, evaluations)?;
            if !self.curve.refine(self.epsilon, x, self.most_points)? {
                break;
            }
            self.forget();
        }
        for (i, increment) in increment.iter_mut().enumerate() {
            *increment = -self.curve.whole(self.epsilon, i);
        }
        if !increment.iter().all(|v| v.is_finite()) {
            return Err(StepError::OF_INCREMENT);
        }
        if is_between(x, &self.centre, increment) {
            Ok(())
        } else {
            Err(StepError::OtherBranch { reached: 0.0 })
        }
    }

    /// Forgets the curves of earlier steps.
    fn forget(&mut self) {
        let size = self.curve.shape.len();
        self.extrapolation = Extrapolation::new(size, EXTRAPOLATION);
        self.recorded = vec![0.0; size];
    }

    /// One solve at the present number of nodes: by Newton's method where it converges, else accelerated.
    fn solve(&mut self, x: &[f64], low: &[f64], evaluations: &mut u64) -> Result<(), StepError> {
        if self.curve.method() == CorrectionMethod::Newton && self.form.map().has_jacobian() {
            let newton = (CorrectionMethod::Newton, MOST_NEWTON);
            if self.iterate(x, low, evaluations, newton).is_ok() {
                return Ok(());
            }
            self.curve.iteration.watch().take(true);
            self.curve.straighten(&self.start);
        }
        let accelerated = (CorrectionMethod::Acceleration, MOST_ACCELERATED);
        self.iterate(x, low, evaluations, accelerated)
    }

    /// Makes sure that the mean is the one connected with the state, and takes that where the solve
    /// found another or none.
    #[cold]
    fn settle(
        &mut self,
        solved: Result<(), StepError>,
        (x, low): (&[f64], &[f64]),
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        let mut path = self.path.take().unwrap_or_else(|| {
            let curve = self.collocation.curve(&self.parameters);
            let evaluator = CollocatedEvaluator::new(curve, self.epsilon, None, x.len());
            Box::new(Path::new(evaluator, x.len()))
        });
        path.evaluator.restore(&[self.curve.rule.points() as f64]);
        let solved = solved.map(|()| &self.centre[..]);
        let settled = path.settle(&mut self.form, (x, low), solved, evaluations);
        let outcome = settled.and_then(|is_found| {
            if is_found {
                return Ok(());
            }
            for (i, start) in self.start.iter_mut().enumerate() {
                *start = path.branch.end()[i] - x[i];
            }
            self.curve.straighten(&self.start);
            self.resolve(x, low, increment, evaluations)?;
            path.branch.confirm_end(&self.centre)
        });
        self.path = Some(path);
        outcome
    }

    fn iterate(
        &mut self,
        x: &[f64],
        low: &[f64],
        evaluations: &mut u64,
        method: (CorrectionMethod, usize),
    ) -> Result<(), StepError> {
        let is_newton = method.0 == CorrectionMethod::Newton;
        self.curve.begin(x, method);
        self.take_mean(x);
        self.form.values(&self.centre, &mut self.p)?;
        if is_newton {
            self.form.jacobians(&self.centre, &mut self.slope)?;
            let (at, fixed) = ((&self.centre[..], &self.p[..]), Fixed::End(&self.slope));
            self.curve.take_slopes(self.epsilon, at, fixed)?;
            let factors = self.curve.simplified.factors();
            self.curve.iteration.take_factors(factors);
        }
        loop {
            *evaluations += 1;
            self.curve.evaluate(&self.p)?;
            for (i, mean) in self.mean.iter_mut().enumerate() {
                *mean = low[i] - self.curve.part(self.epsilon, i);
            }
            let verdict = self.curve.correct(self.epsilon, x, &self.mean)?;
            self.take_mean(x);
            if is_newton && verdict == Verdict::Converged {
                return Ok(());
            }
            self.form.values(&self.centre, &mut self.p)?;
            if verdict == Verdict::Converged {
                let is_slow = self.curve.iteration.is_slow();
                self.curve.iteration.watch().take(is_slow);
                // V lags one correction behind.
                *evaluations += 1;
                return self.curve.evaluate(&self.p);
            }
        }
    }

    /// x̂, and its difference from x.
    fn take_mean(&mut self, x: &[f64]) {
        let mean = &self.curve.shape[..x.len()];
        self.displacement.copy_from_slice(mean);
        for (centre, (x, displacement)) in self.centre.iter_mut().zip(x.iter().zip(mean)) {
            *centre = x + displacement;
        }
    }
}

impl FusedTrajectory {
    fn advance(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        self.curve.iteration.begin_step();
        self.extrapolation
            .predict(self.curve.shape.as_chunks_mut().0);
        self.take_mean(x);
        self.start.copy_from_slice(&self.displacement);
        let mut solved = self.resolve(x, low, increment, evaluations);
        let mut miss = CorrectionSize::default();
        for (i, displacement) in self.displacement.iter().enumerate() {
            let scale = x[i].abs() + increment[i].abs();
            miss.take(displacement - self.start[i], scale);
            miss.take_way(*displacement, scale);
        }
        let watch = self.curve.iteration.watch();
        watch.take_start(miss.component(), miss.way());
        if solved.is_err() || watch.wanders() {
            if self.curve.has_slopes() && self.form.map().has_jacobian() {
                solved = self.settle(solved, (x, low), increment, evaluations);
            } else if solved.is_err() && !self.extrapolation.is_cold(0) {
                // The extrapolated start may have led astray.
                self.start.fill(0.0);
                self.curve.shape.fill(0.0);
                solved = self.resolve(x, low, increment, evaluations);
            }
        }
        solved?;
        self.recorded.copy_from_slice(&self.curve.shape);
        self.extrapolation
            .record(self.recorded.as_chunks_mut().0, &[true]);
        Ok(())
    }
}

impl Trajectories for FusedTrajectory {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let taken = &mut taken[0];
        taken.outcome = self.advance(x, low, increment, &mut taken.evaluations);
        taken.is_rounded = self.curve.iteration.is_rounded();
    }

    fn solution(&self, _: usize) -> Option<&[f64]> {
        Some(&self.centre)
    }

    fn tangent(&mut self, _: usize) -> Option<Vec<f64>> {
        let d = self.centre.len();
        // A curve of its own, so that measuring does not disturb stepping.
        let mut curve = self.collocation.curve(&self.parameters);
        curve.set_points(self.curve.rule.points());
        self.form.values(&self.centre, &mut self.p).ok()?;
        let z: Vec<f64> = self.centre.iter().chain(&self.p).copied().collect();
        let mut evaluator = CollocatedEvaluator::new(curve, self.epsilon, None, d);
        let mut tangents = vec![0.0; 4 * d * d];
        evaluator.jacobians(&z, &mut tangents).ok()?;
        let (target, change) = tangents.split_at(2 * d * d);
        // D(·∘L) = ∂x + ∂p Dθ on L = graph θ.
        let mut slope = vec![0.0; d * d];
        self.form.jacobians(&self.centre, &mut slope).ok()?;
        let slope = DMatrix::from_row_slice(d, d, &slope);
        let along = |rows: &[f64]| {
            let all = DMatrix::from_row_slice(d, 2 * d, rows);
            all.columns(0, d) + all.columns(d, d) * &slope
        };
        let map = DMatrix::identity(d, d) + along(change) * along(target).lu().try_inverse()?;
        Some(map.transpose().as_slice().to_vec())
    }

    fn operations(&self) -> Option<u64> {
        Some(self.curve.operations()? + self.form.operations()?)
    }

    fn restart(&mut self, _: usize) {
        self.extrapolation.clear(0);
        self.curve.iteration.restart();
    }

    /// Of the same length with any number of nodes.
    fn memory(&self, _: usize) -> Vec<f64> {
        let points = self.curve.rule.points();
        let mut memory = vec![points as f64, self.curve.iteration.memory()];
        self.extrapolation.memory(0, &mut memory);
        let missing = self.most_points.unwrap_or(points) - points;
        memory.resize(
            memory.len() + missing * self.centre.len() * EXTRAPOLATION,
            0.0,
        );
        memory
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.curve.set_points(memory[0].max(1.0) as usize);
        self.curve.iteration.restore(memory[1]);
        self.forget();
        self.extrapolation.restore(0, &memory[2..]);
    }
}
