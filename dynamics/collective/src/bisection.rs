//! Σ_h(σ(M)) as a Lagrangian bisection.

use leafwise_core::runge_kutta::{PartitionedTableau, SmoothMap, StageSolver};
use leafwise_core::{
    BisectionWorker, ChartMaps, ChartWorker, Correction, LagrangianBisection, StepError,
};
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
    fn worker(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn BisectionWorker>> {
        let field = self.field.evaluator(parameters, epsilon, h);
        let n = field.map().inputs();
        Some(Box::new(Worker {
            stages: StageSolver::new(field, self.tableau.clone(), h, 1),
            chart: self.chart.worker(parameters, epsilon),
            near_identity: self.correction == Correction::Bisection,
            end: vec![0.0; n],
            change: vec![0.0; n],
            of_chart: vec![0.0; self.space * n],
        }))
    }
}

struct Worker {
    stages: StageSolver,
    chart: Box<dyn ChartWorker>,
    near_identity: bool,
    /// Σ_h(y, 0) and its difference from (y, 0).
    end: Vec<f64>,
    change: Vec<f64>,
    of_chart: Vec<f64>,
}

impl BisectionWorker for Worker {
    fn point(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        let d = y.len();
        self.end[..d].copy_from_slice(y);
        self.end[d..].fill(0.0);
        self.stages.solve(&self.end, &mut self.change)?;
        for (end, change) in self.end.iter_mut().zip(&self.change) {
            *end += change;
        }
        let (x, p) = self.end.split_at(d);
        self.chart.point(x, p, z)
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        if !self.has_tangent() {
            return Err(StepError::NoTangent);
        }
        let n = self.end.len();
        let section = DMatrix::identity(n, n / 2);
        let singular = || StepError::NonFinite {
            what: "the tangent of the stage equations",
        };
        let image = self.stages.tangent(0, &section).ok_or_else(singular)?;
        let (x, p) = self.end.split_at(n / 2);
        self.chart.tangent(x, p, &mut self.of_chart)?;
        let image = DMatrix::from_row_slice(self.of_chart.len() / n, n, &self.of_chart) * image;
        tangent.copy_from_slice(image.transpose().as_slice());
        Ok(())
    }

    fn has_tangent(&self) -> bool {
        self.stages.has_tangent() && self.chart.has_tangent()
    }

    /// β̂ is constant along the flow of H∘α over exact realization data, so D(β̂∘L) − 1 = O(h^{m+1}).
    fn is_near_identity(&self) -> bool {
        self.near_identity
    }

    fn operations(&self) -> Option<u64> {
        Some(self.stages.operations()? + self.chart.operations()?)
    }

    fn restart(&mut self) {
        self.stages.clear(0);
    }

    fn memory(&self) -> Vec<f64> {
        self.stages.memory(0)
    }

    fn restore(&mut self, memory: &[f64]) {
        self.stages.restore(0, memory);
    }
}
