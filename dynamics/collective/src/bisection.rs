//! Σ_h(σ(M)) as a Lagrangian bisection.

use leafwise_core::runge_kutta::{PartitionedTableau, SmoothMapEvaluator, StageSolver};
use leafwise_core::{BisectionWorker, Correction, LagrangianBisection, StepError};
use nalgebra::DMatrix;

use crate::hamiltonian::CollectiveField;

/// y ↦ χ(Σ_h(y, 0)), Σ_h the integrator of K = H∘α̂∘χ in the chart χ.
#[derive(Clone, Debug)]
pub struct ImageOfSection {
    field: CollectiveField,
    tableau: PartitionedTableau,
    correction: Correction,
}

impl ImageOfSection {
    /// The bisection of an integrator with these coefficients.
    pub fn new(
        field: CollectiveField,
        tableau: PartitionedTableau,
        correction: Correction,
    ) -> Self {
        Self {
            field,
            tableau,
            correction,
        }
    }
}

impl LagrangianBisection for ImageOfSection {
    fn worker(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn BisectionWorker>> {
        let field = self.field.field.evaluator(parameters, epsilon, h);
        let n = field.map().inputs();
        Some(Box::new(Worker {
            stages: StageSolver::new(field, self.tableau.clone(), h),
            chart: self
                .field
                .chart
                .as_ref()
                .map(|chart| chart.evaluator(parameters, epsilon, h)),
            near_identity: self.correction == Correction::Bisection,
            end: vec![0.0; n],
            change: vec![0.0; n],
        }))
    }
}

struct Worker {
    stages: StageSolver,
    chart: Option<SmoothMapEvaluator>,
    near_identity: bool,
    /// Σ_h(y, 0) and its difference from (y, 0).
    end: Vec<f64>,
    change: Vec<f64>,
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
        match &mut self.chart {
            None => z.copy_from_slice(&self.end),
            Some(chart) => chart.value(&self.end, z)?,
        }
        Ok(())
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        let n = self.end.len();
        let section = DMatrix::identity(n, n / 2);
        let singular = || StepError::NonFinite {
            what: "the tangent of the stage equations",
        };
        let mut image = self.stages.tangent(&section).ok_or_else(singular)?;
        if let Some(chart) = &mut self.chart {
            let rows = chart.map().outputs();
            let mut entries = vec![0.0; rows * n];
            chart.jacobian(&self.end, &mut entries)?;
            image = DMatrix::from_row_slice(rows, n, &entries) * image;
        }
        tangent.copy_from_slice(image.transpose().as_slice());
        Ok(())
    }

    /// β̂ is constant along the flow of H∘α over exact realization data, so D(β̂∘L) − 1 = O(h^{m+1}).
    fn is_near_identity(&self) -> bool {
        self.near_identity
    }

    fn operations(&self) -> Option<u64> {
        let chart = self
            .chart
            .as_ref()
            .map_or(Some(0), SmoothMapEvaluator::operations);
        Some(self.stages.operations()? + chart?)
    }

    fn restart(&mut self) {
        self.stages.clear();
    }

    fn memory(&self) -> Vec<f64> {
        self.stages.memory().to_vec()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.stages.restore(memory);
    }
}
