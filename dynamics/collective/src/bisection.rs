//! Σ_h(σ(M)) as a Lagrangian bisection.

use leafwise_core::runge_kutta::{PartitionedTableau, SmoothMap, StageSolver};
use leafwise_core::solver::Extrapolation;
use leafwise_core::{ChartMaps, Correction, Evaluator, LagrangianBisection, StepError};
use nalgebra::DMatrix;

/// Levels of differences that the stages' start is extrapolated from.
const EXTRAPOLATION: usize = 12;

/// y ↦ χ(Σ_h(y, 0)) in a space of so many coordinates.
///
/// The integrator Σ_h has these coefficients, and `field` is the vector field of K = H∘α̂∘χ in the chart χ. Over exact
/// realization data β̂ is constant along the flow of H∘α, so D(β̂∘L) − 1 = O(h^{m+1}).
pub fn image_of_section(
    field: SmoothMap,
    chart: ChartMaps,
    tableau: PartitionedTableau,
    correction: Correction,
    space: usize,
) -> LagrangianBisection {
    let n = field.inputs();
    let size = tableau.stages() * n;
    let has_jacobian = field.has_jacobian() && chart.has_jacobian();
    let image = move |parameters: &[f64], epsilon: f64, h: f64| -> Box<dyn Evaluator> {
        let field = field.evaluator(parameters, epsilon, h);
        Box::new(BisectionEvaluator {
            extrapolation: Extrapolation::new(size, EXTRAPOLATION),
            recorded: vec![0.0; size],
            has_stages: false,
            stages: StageSolver::new(field, tableau.clone(), h, 1),
            chart: chart.evaluator(parameters, epsilon),
            y: Vec::with_capacity(n / 2),
            end: vec![0.0; n],
            change: vec![0.0; n],
            of_chart: vec![0.0; space * n],
        })
    };
    LagrangianBisection::Points {
        // Stages start from those of the steps before.
        map: SmoothMap::from_numbers(n / 2, space, has_jacobian, image).for_one_trajectory(),
        is_near_identity: correction == Correction::Bisection,
    }
}

struct BisectionEvaluator {
    stages: StageSolver,
    /// Of the stages' displacements from one step to the next, room for them, and whether those of the last are to be
    /// recorded.
    extrapolation: Extrapolation,
    recorded: Vec<f64>,
    has_stages: bool,
    chart: Box<dyn Evaluator>,
    /// The point of the last call; empty where it failed.
    y: Vec<f64>,
    /// Σ_h(y, 0) and its difference from (y, 0).
    end: Vec<f64>,
    change: Vec<f64>,
    of_chart: Vec<f64>,
}

impl BisectionEvaluator {
    /// (y, 0).
    fn place(&mut self, y: &[f64]) {
        self.y.clear();
        let (base, covector) = self.end.split_at_mut(y.len());
        base.copy_from_slice(y);
        covector.fill(0.0);
    }

    /// Sets the displacements from which the stages of a step start.
    fn predict(&mut self) {
        if self.has_stages {
            self.recorded.copy_from_slice(self.stages.displacements());
            self.extrapolation
                .record(self.recorded.as_chunks_mut().0, &[true]);
            self.extrapolation
                .predict(self.stages.displacements().as_chunks_mut().0);
        }
        self.has_stages = false;
    }

    /// χ(Σ_h(y, 0)) by the change.
    fn arrive(&mut self, y: &[f64], z: &mut [f64], is_solved: bool) -> Result<(), StepError> {
        for (end, change) in self.end.iter_mut().zip(&self.change) {
            *end += change;
        }
        if is_solved {
            self.y.extend_from_slice(y);
        }
        self.chart.values(&self.end, z)
    }
}

impl Evaluator for BisectionEvaluator {
    fn values(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.place(y);
        self.stages.solve(&self.end, &mut self.change)?;
        self.arrive(y, z, true)
    }

    fn approach(&mut self, begins: bool, y: &[f64], z: &mut [f64]) -> Result<bool, StepError> {
        if begins {
            self.predict();
        }
        self.place(y);
        let is_solved = self.stages.approach(begins, &self.end, &mut self.change)?;
        self.has_stages |= is_solved;
        self.arrive(y, z, is_solved)?;
        Ok(is_solved)
    }

    fn jacobians(&mut self, y: &[f64], tangent: &mut [f64]) -> Result<(), StepError> {
        if !self.stages.has_tangent() {
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

    fn operations(&self) -> Option<u64> {
        Some(self.stages.operations()? + self.chart.operations()?)
    }

    fn restart(&mut self) {
        self.y.clear();
        self.stages.clear(0);
        self.extrapolation.clear(0);
        self.has_stages = false;
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = vec![f64::from(u8::from(self.has_stages))];
        self.extrapolation.memory(0, &mut memory);
        memory.extend(self.stages.memory(0));
        memory
    }

    fn restore(&mut self, memory: &[f64]) {
        self.y.clear();
        self.has_stages = memory[0] != 0.0;
        let (history, stages) = memory[1..].split_at(self.extrapolation.memory_len());
        self.extrapolation.restore(0, history);
        self.stages.restore(0, stages);
    }
}
