//! α̂ and β̂ at (x, p) and their derivatives.

use leafwise_core::StepError;
use leafwise_core::evaluator::{Evaluator, is_same, one_by_one};

use super::curve::Curve;
use super::tangent::CurveTangent;

/// Where the automatic choice of nodes starts.
pub(super) const FEWEST_POINTS: usize = 3;

/// One thread's evaluator.
pub(super) struct CollocatedEvaluator {
    curve: Curve,
    epsilon: f64,
    /// The most nodes an automatic choice takes; `None` when their number is fixed.
    most_points: Option<usize>,
    /// The last point, not a number where its curve was not found, and the tangent there once it is known.
    z: Vec<f64>,
    tangent: CurveTangent,
}

impl CollocatedEvaluator {
    pub(super) fn new(curve: Curve, epsilon: f64, most_points: Option<usize>, d: usize) -> Self {
        Self {
            curve,
            epsilon,
            most_points,
            z: vec![f64::NAN; 2 * d],
            tangent: CurveTangent::default(),
        }
    }

    /// Solves the curve at z, with more nodes where its tail asks for them.
    fn solve(&mut self, z: &[f64]) -> Result<(), StepError> {
        self.z.fill(f64::NAN);
        self.tangent.clear(&mut self.curve);
        let (x, p) = z.split_at(z.len() / 2);
        loop {
            self.curve.solve(self.epsilon, x, p)?;
            if !self.curve.refine(self.epsilon, x, self.most_points)? {
                break;
            }
        }
        self.z.copy_from_slice(z);
        Ok(())
    }

    /// The tangent at z.
    fn know_tangent(&mut self, z: &[f64]) -> Result<(), StepError> {
        if !is_same(&self.z, z) {
            self.solve(z)?;
        }
        if self.tangent.is_known() {
            return Ok(());
        }
        let p = &z[z.len() / 2..];
        self.tangent.solve(&mut self.curve, self.epsilon, p)
    }
}

impl Evaluator for CollocatedEvaluator {
    fn values(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        one_by_one(self.z.len(), z, ends, |z, ends| {
            self.solve(z)?;
            let d = z.len() / 2;
            let curve = &self.curve;
            for i in 0..d {
                ends[i] = z[i];
                ends[d + i] = curve.part(self.epsilon, i);
                ends[2 * d + i] = -curve.whole(self.epsilon, i);
            }
            Ok(())
        })
    }

    fn jacobians(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        one_by_one(self.z.len(), z, tangents, |z, tangents| {
            self.know_tangent(z)?;
            let (target, increment) = tangents.split_at_mut(tangents.len() / 2);
            self.tangent
                .ends(&self.curve, self.epsilon, target, increment)
        })
    }

    fn hessian(
        &mut self,
        z: &[f64],
        covector: &[f64],
        hessian: &mut [f64],
    ) -> Result<(), StepError> {
        self.know_tangent(z)?;
        let p = &z[covector.len()..];
        let curve = &mut self.curve;
        self.tangent
            .source_hessian(curve, self.epsilon, p, covector, hessian)
    }

    fn operations(&self) -> Option<u64> {
        self.curve.operations()
    }

    /// With an automatic choice of nodes, it starts again from few.
    fn restart(&mut self) {
        if self.most_points.is_some() {
            self.curve.set_points(FEWEST_POINTS);
        }
    }

    fn memory(&self) -> Vec<f64> {
        vec![self.curve.rule.points() as f64]
    }

    fn restore(&mut self, memory: &[f64]) {
        self.curve.set_points(memory[0].max(1.0) as usize);
    }
}
