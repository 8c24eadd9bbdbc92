//! Σ_h(σ(M)) as a Lagrangian bisection.

use leafwise_core::runge_kutta::{PartitionedTableau, SmoothMap, StageSolver};
use leafwise_core::{ChartMaps, Correction, Evaluator, LagrangianBisection, StepError};
use nalgebra::DMatrix;

/// y ↦ χ(Σ_h(y, 0)), Σ_h the integrator of K = H∘α̂∘χ in the chart χ.
#[derive(Clone, Debug)]
pub struct ImageOfSection {
    field: SmoothMap,
    chart: ChartMaps,
    tableau: PartitionedTableau,
    correction: Correction,
    /// The number of coordinates of a point of S.
    space: usize,
}

impl ImageOfSection {
    /// The bisection of an integrator with these coefficients of the `field` of K, in a space of so
    /// many coordinates.
    pub fn new(
        field: SmoothMap,
        chart: ChartMaps,
        tableau: PartitionedTableau,
        correction: Correction,
        space: usize,
    ) -> Self {
        Self {
            field,
            chart,
            tableau,
            correction,
            space,
        }
    }
}

impl LagrangianBisection for ImageOfSection {
    fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        let field = self.field.evaluator(parameters, epsilon, h);
        let n = field.map().inputs();
        Some(Box::new(BisectionEvaluator {
            stages: StageSolver::new(field, self.tableau.clone(), h, 1),
            chart: self.chart.evaluator(parameters, epsilon),
            y: Vec::with_capacity(n / 2),
            end: vec![0.0; n],
            change: vec![0.0; n],
            of_chart: vec![0.0; self.space * n],
        }))
    }

    /// β̂ is constant along the flow of H∘α over exact realization data, so D(β̂∘L) − 1 = O(h^{m+1}).
    fn is_near_identity(&self) -> bool {
        self.correction == Correction::Bisection
    }
}

struct BisectionEvaluator {
    stages: StageSolver,
    chart: Box<dyn Evaluator>,
    /// The point of the last call; empty where it failed.
    y: Vec<f64>,
    /// Σ_h(y, 0) and its difference from (y, 0).
    end: Vec<f64>,
    change: Vec<f64>,
    of_chart: Vec<f64>,
}

impl Evaluator for BisectionEvaluator {
    fn values(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.y.clear();
        let (base, covector) = self.end.split_at_mut(y.len());
        base.copy_from_slice(y);
        covector.fill(0.0);
        self.stages.solve(&self.end, &mut self.change)?;
        for (end, change) in self.end.iter_mut().zip(&self.change) {
            *end += change;
        }
        self.y.extend_from_slice(y);
        self.chart.values(&self.end, z)
    }

    fn jacobians(&mut self, y: &[f64], tangent: &mut [f64]) -> Result<(), StepError> {
        if !self.has_jacobian() {
            return Err(StepError::NoTangent);
        }
        let n = self.end.len();
        if self.y != y {
            let mut z = vec![0.0; self.of_chart.len() / n];
            self.values(y, &mut z)?;
        }
        let section = DMatrix::identity(n, n / 2);
        let singular = || StepError::NonFinite {
            what: "the tangent of the stage equations",
        };
        let image = self.stages.tangent(0, &section).ok_or_else(singular)?;
        self.chart.jacobians(&self.end, &mut self.of_chart)?;
        let image = DMatrix::from_row_slice(self.of_chart.len() / n, n, &self.of_chart) * image;
        tangent.copy_from_slice(image.transpose().as_slice());
        Ok(())
    }

    fn has_jacobian(&self) -> bool {
        self.stages.has_tangent() && self.chart.has_jacobian()
    }

    /// Stages start from those of the steps before.
    fn is_pointwise(&self) -> bool {
        false
    }

    fn operations(&self) -> Option<u64> {
        Some(self.stages.operations()? + self.chart.operations()?)
    }

    fn restart(&mut self) {
        self.y.clear();
        self.stages.clear(0);
    }

    fn memory(&self) -> Vec<f64> {
        self.stages.memory(0)
    }

    fn restore(&mut self, memory: &[f64]) {
        self.y.clear();
        self.stages.restore(0, memory);
    }
}
