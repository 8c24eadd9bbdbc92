//! Solves of a step, in runs with gradients, by an extrapolated Jacobian.
//!
//! A gradient needs the Jacobian at every solution. Extrapolated from those of the steps before, as the solutions are, a
//! Jacobian is as good as one taken where the solve starts. One or two corrections with it reach the solution, and
//! the Jacobian that the gradient takes there is the only one of the step.

use leafwise_expression::Workspace;

use crate::judge::inside_chart;
use crate::{DenseFactors, Extrapolation, NewtonKernel};

/// Differences that are kept of solutions and Jacobians.
const LEVELS: usize = 10;

/// Steps before anything is extrapolated.
const WARM: u32 = 12;

/// A first correction larger than this, relative to the state, is not that of a smooth solution.
const FAR: f64 = 1e-3;

/// Corrections without a Jacobian before a solve is left to the stepper.
const MOST: u32 = 4;

/// Largest error of the solution, in parts of the state, that is let pass: Jacobians there are right to round-off.
const NEGLIGIBLE: f64 = f64::EPSILON;

/// How much larger than the last one seen the next rate may be.
const SAFETY: f64 = 8.0;

/// The solutions and Jacobians of the steps before, and one solve by them.
pub(super) struct Foreseen {
    displacements: Extrapolation,
    slopes: Extrapolation,
    /// y − x and D(β̂∘L) − 1, foreseen.
    displacement: Vec<[f64; 1]>,
    slope: Vec<[f64; 1]>,
    residual: Workspace,
    outputs: Vec<f64>,
    matrix: Vec<f64>,
    factors: DenseFactors,
    y: Vec<f64>,
    correction: Vec<f64>,
    /// The last correction, relative to the state, and what corrections are multiplied by.
    last: f64,
    rate: f64,
    seen: u32,
    /// Corrections so far.
    evaluations: u64,
    factorizations: u64,
}

impl Foreseen {
    /// Nothing seen; a workspace of the residual kernel.
    pub(super) fn new(newton: &NewtonKernel, residual: Workspace) -> Self {
        let d = newton.kernel().inputs();
        Self {
            displacements: Extrapolation::new(d, LEVELS),
            slopes: Extrapolation::new(d * d, LEVELS),
            displacement: vec![[0.0]; d],
            slope: vec![[0.0]; d * d],
            residual,
            outputs: vec![0.0; newton.residual_kernel().outputs()],
            matrix: vec![0.0; d * d],
            factors: DenseFactors::new(d),
            y: vec![0.0; d],
            correction: vec![0.0; d],
            last: f64::INFINITY,
            rate: f64::INFINITY,
            seen: 0,
            evaluations: 0,
            factorizations: 0,
        }
    }

    /// The solution found.
    pub(super) fn solution(&self) -> &[f64] {
        &self.y
    }

    /// Evaluations of the residual kernel, and factorizations: a substitution each time it is evaluated, and one more each time
    /// a solve is finished.
    pub(super) fn work(&self) -> [u64; 2] {
        [self.evaluations, self.factorizations]
    }

    /// Solves β̂(L(y)) = x + low to what is [`NEGLIGIBLE`]; `false` where the corrections do not say so.
    pub(super) fn solve(&mut self, newton: &NewtonKernel, [x, low]: [&[f64]; 2]) -> bool {
        if self.seen < WARM {
            return false;
        }
        let d = x.len();
        self.displacements.predict(&mut self.displacement);
        self.slopes.predict(&mut self.slope);
        self.matrix.copy_from_slice(self.slope.as_flattened());
        for i in 0..d {
            self.matrix[i * d + i] += 1.0;
            self.y[i] = x[i] + self.displacement[i][0];
        }
        self.factorizations += 1;
        if !self.factors.factor(&self.matrix) {
            return false;
        }
        self.last = f64::INFINITY;
        for _ in 0..MOST {
            let kernel = newton.residual_kernel();
            kernel.evaluate(&mut self.residual, &self.y, &mut self.outputs);
            self.evaluations += 1;
            let size = correct(
                newton,
                &self.factors,
                &self.outputs,
                [x, low],
                &self.y,
                &mut self.correction,
            );
            for (y, correction) in self.y.iter_mut().zip(&self.correction) {
                *y += correction;
            }
            let rate = if self.last.is_finite() {
                size / self.last
            } else {
                self.rate
            };
            self.last = size;
            if size.is_nan() || size > FAR {
                return false;
            }
            if size <= NEGLIGIBLE || SAFETY * rate * size <= NEGLIGIBLE {
                return true;
            }
        }
        false
    }

    /// The last correction, to first order in `increment`, from what the full kernel returned at the solution; `false` where
    /// that was none.
    pub(super) fn finish(
        &mut self,
        newton: &NewtonKernel,
        outputs: &[f64],
        [x, low]: [&[f64]; 2],
        increment: &mut [f64],
    ) -> bool {
        let d = x.len();
        let size = correct(
            newton,
            &self.factors,
            outputs,
            [x, low],
            &self.y,
            &mut self.correction,
        );
        // A correction of round-off says nothing of the rate but that it is no larger.
        self.rate = size.max(f64::EPSILON) / self.last.max(f64::EPSILON);
        let bases = if newton.base_is_point() { 0 } else { d };
        let (ends, rest) = outputs[bases + d..].split_at(d);
        let (change, guard) = rest[d * d..].split_at(d * d);
        for i in 0..d {
            let row = change[i * d..][..d].iter().zip(&self.correction);
            increment[i] = ends[i]
                + row
                    .map(|(entry, correction)| entry * correction)
                    .sum::<f64>();
        }
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let (first, last) = guard.split_at(guard.len() / 2);
        let is_inside =
            largest(last) == 0.0 || inside_chart(largest(last) / largest(first)).is_ok();
        size <= 64.0 * NEGLIGIBLE && is_inside && increment.iter().all(|value| value.is_finite())
    }

    /// Takes in the solution and D(β̂∘L) of a step from x.
    pub(super) fn record(&mut self, x: &[f64], y: &[f64], target: &[f64]) {
        let d = x.len();
        for ((displacement, y), x) in self.displacement.iter_mut().zip(y).zip(x) {
            displacement[0] = y - x;
        }
        for (at, (slope, entry)) in self.slope.iter_mut().zip(target).enumerate() {
            slope[0] = if at % (d + 1) == 0 {
                entry - 1.0
            } else {
                *entry
            };
        }
        self.displacements.record(&mut self.displacement, &[true]);
        self.slopes.record(&mut self.slope, &[true]);
        self.seen = self.seen.saturating_add(1);
    }
}

/// Writes the correction from what a kernel returned at y; its size relative to the state.
fn correct(
    newton: &NewtonKernel,
    factors: &DenseFactors,
    outputs: &[f64],
    [x, low]: [&[f64]; 2],
    y: &[f64],
    correction: &mut [f64],
) -> f64 {
    let d = x.len();
    let (base, offset) = if newton.base_is_point() {
        (y, outputs)
    } else {
        outputs.split_at(d)
    };
    for i in 0..d {
        correction[i] = x[i] - base[i] - offset[i] + low[i];
    }
    factors.solve(correction);
    let sizes = correction.iter().zip(x.iter().zip(y));
    sizes.fold(0.0, |most: f64, (correction, (x, y))| {
        let size = correction.abs() / (x.abs() + (y - x).abs()).max(f64::MIN_POSITIVE);
        if size > most || size.is_nan() {
            size
        } else {
            most
        }
    })
}
