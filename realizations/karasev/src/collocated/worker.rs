//! α̂ and β̂ at (x, p) and their derivatives.

use leafwise_core::{Ends, RealizationWorker, StepError};

use super::curve::Curve;
use super::tangent::CurveTangent;

/// Where the automatic choice of nodes starts.
pub(super) const FEWEST_POINTS: usize = 3;

/// One thread's evaluator.
pub(super) struct CollocatedWorker {
    curve: Curve,
    epsilon: f64,
    /// The most nodes an automatic choice takes; `None` when their number is fixed.
    most_points: Option<usize>,
    /// The last point, and the tangent there once it is known.
    z: Vec<f64>,
    tangent: CurveTangent,
}

impl CollocatedWorker {
    pub(super) fn new(curve: Curve, epsilon: f64, most_points: Option<usize>, d: usize) -> Self {
        Self {
            curve,
            epsilon,
            most_points,
            z: vec![0.0; 2 * d],
            tangent: CurveTangent::default(),
        }
    }

    /// The tangent at the last point.
    fn know_tangent(&mut self) -> Result<(), StepError> {
        if self.tangent.is_known() {
            return Ok(());
        }
        let p = &self.z[self.z.len() / 2..];
        self.tangent.solve(&mut self.curve, self.epsilon, p)
    }

    /// Solves the curve, with more nodes where its tail asks for them.
    fn solve(&mut self) -> Result<(), StepError> {
        let (x, p) = self.z.split_at(self.z.len() / 2);
        loop {
            self.curve.solve(self.epsilon, x, p)?;
            if !self.curve.refine(self.most_points)? {
                return Ok(());
            }
        }
    }
}

impl RealizationWorker for CollocatedWorker {
    fn ends(&mut self, z: &[f64], ends: &mut Ends) -> Result<(), StepError> {
        self.z.copy_from_slice(z);
        self.tangent.clear(&mut self.curve);
        self.solve()?;
        let d = z.len() / 2;
        let curve = &self.curve;
        for i in 0..d {
            ends.base[i] = z[i];
            ends.offset[i] = curve.combination(self.epsilon, &curve.rule.end, i);
            ends.increment[i] = -curve.combination(self.epsilon, &curve.rule.weights, i);
        }
        Ok(())
    }

    fn has_tangents(&self) -> bool {
        self.curve.has_slopes()
    }

    fn operations(&self) -> Option<u64> {
        self.curve.operations()
    }

    fn tangents(&mut self, target: &mut [f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.know_tangent()?;
        self.tangent
            .ends(&self.curve, self.epsilon, target, increment)
    }

    fn source_hessian(&mut self, covector: &[f64], hessian: &mut [f64]) -> Result<(), StepError> {
        self.know_tangent()?;
        let p = &self.z[covector.len()..];
        let curve = &mut self.curve;
        self.tangent
            .source_hessian(curve, self.epsilon, p, covector, hessian)
    }

    fn has_source_hessian(&self) -> bool {
        self.curve.field.has_curvatures()
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
