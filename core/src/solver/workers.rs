//! The solve for parts that compute numbers: no code, one trajectory at a time.

use super::extrapolation::DEPTH;
use super::iteration::{CorrectionSize, LinearIteration, Verdict};
use super::{Anderson, Extrapolation, Trajectory};
use crate::dynamics::{BisectionWorker, Correction};
use crate::error::StepError;
use crate::realization::{Ends, RealizationWorker};
use crate::solver::linear::{DenseFactors, elimination_operations, substitution_operations};

/// Budget of one step.
const MOST_EVALUATIONS: usize = 100;

/// Solves β̂(L(y)) = x with workers of a realization and a bisection.
///
/// Where D(β̂∘L) is near the identity (a collective integrator over a good realization), and where a
/// worker offers no tangents, the correction is the residual itself; elsewhere it is Newton's, with
/// the tangents of both workers. D(β̂∘L) = 1 + O(εh), so that residuals converge for small steps.
pub(crate) struct Workers {
    /// For parts without tangents.
    anderson: Anderson,
    scales: Vec<f64>,
    realization: Box<dyn RealizationWorker>,
    bisection: Box<dyn BisectionWorker>,
    correction: Correction,
    extrapolation: Extrapolation,
    displacement: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    residual: Vec<f64>,
    ends: Ends,
    /// D(β̂∘L), its factors, D((α̂−β̂)∘L), DL, and the worker's own tangents.
    target: Vec<f64>,
    factors: DenseFactors,
    change: Vec<f64>,
    point: Vec<f64>,
    target_of_z: Vec<f64>,
    change_of_z: Vec<f64>,
    /// Operations of the products and solves.
    linear: u64,
}

impl Workers {
    /// For points of S of as many coordinates as `space`.
    pub(crate) fn new(
        (realization, bisection): (Box<dyn RealizationWorker>, Box<dyn BisectionWorker>),
        dimension: usize,
        space: usize,
        correction: Correction,
    ) -> Self {
        let d = dimension;
        Self {
            anderson: Anderson::new(d),
            scales: vec![0.0; d],
            realization,
            bisection,
            correction,
            extrapolation: Extrapolation::new(d, DEPTH),
            displacement: vec![0.0; d],
            y: vec![0.0; d],
            z: vec![0.0; space],
            residual: vec![0.0; d],
            ends: Ends::new(d),
            target: vec![0.0; d * d],
            factors: DenseFactors::new(d),
            change: vec![0.0; d * d],
            point: vec![0.0; space * d],
            target_of_z: vec![0.0; d * space],
            change_of_z: vec![0.0; d * space],
            linear: 0,
        }
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

    /// α̂(L(x)) − x.
    fn uncorrected(&mut self, x: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.y.copy_from_slice(x);
        self.evaluate()?;
        let Ends {
            base,
            offset,
            increment: change,
        } = &self.ends;
        for i in 0..x.len() {
            increment[i] = (base[i] - x[i]) + offset[i] + change[i];
        }
        Ok(())
    }

    /// Solves for y; returns whether the last correction is Newton's.
    fn solve(&mut self, x: &[f64], low: &[f64], evaluations: &mut u64) -> Result<bool, StepError> {
        let d = x.len();
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
            *evaluations += 1;
            self.evaluate()?;
            for i in 0..d {
                self.residual[i] = x[i] - self.ends.base[i] - self.ends.offset[i] + low[i];
            }
            if newton {
                self.tangents()?;
                self.linear += elimination_operations(d) + substitution_operations(d);
                if !self.factors.factor(&self.target) {
                    return Err(StepError::NonFinite {
                        what: "a Newton correction",
                    });
                }
                self.factors.solve(&mut self.residual);
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
                return Ok(newton);
            }
        }
    }
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

impl Trajectory for Workers {
    fn step(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        if self.correction == Correction::None {
            *evaluations = 1;
            return self.uncorrected(x, increment);
        }
        let newton = self.solve(x, low, evaluations)?;
        if !newton && self.residual.iter().any(|r| *r != 0.0) {
            // The increment varies with y far more than the residual does: without its tangent the
            // last correction enters by one more evaluation.
            self.evaluate()?;
            *evaluations += 1;
        }
        let d = x.len();
        for i in 0..d {
            let row = &self.change[i * d..][..d];
            let first_order: f64 = if newton {
                row.iter().zip(&self.residual).map(|(k, r)| k * r).sum()
            } else {
                0.0
            };
            increment[i] = self.ends.increment[i] + first_order;
            self.displacement[i] = self.y[i] - x[i];
        }
        if increment.iter().all(|v| v.is_finite()) {
            self.extrapolation
                .record(self.displacement.as_chunks_mut().0, &[true]);
        }
        Ok(())
    }

    fn solution(&self) -> Option<&[f64]> {
        Some(&self.y)
    }

    fn tangent(&mut self) -> Option<Vec<f64>> {
        self.evaluate().ok()?;
        self.tangents().ok()?;
        if self.correction == Correction::None {
            let sum = self.target.iter().zip(&self.change);
            return Some(sum.map(|(t, c)| t + c).collect());
        }
        super::tangent_of_map(&self.target, &self.change, self.y.len())
    }

    fn operations(&self) -> Option<u64> {
        let own = self.linear + self.anderson.operations();
        Some(self.realization.operations()? + self.bisection.operations()? + own)
    }

    fn restart(&mut self) {
        self.extrapolation.clear(0);
        self.bisection.restart();
        self.realization.restart();
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = Vec::with_capacity(self.extrapolation.memory_len());
        self.extrapolation.memory(0, &mut memory);
        memory.extend(self.bisection.memory());
        memory.extend(self.realization.memory());
        memory
    }

    fn restore(&mut self, memory: &[f64]) {
        let (history, parts) = memory.split_at(self.extrapolation.memory_len());
        self.extrapolation.restore(0, history);
        let (bisection, realization) = parts.split_at(self.bisection.memory().len());
        self.bisection.restore(bisection);
        self.realization.restore(realization);
    }
}
