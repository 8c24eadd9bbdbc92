//! The residual of a step's equation, by a kernel apart from the solver's.

use leafwise_core::{Method, PoissonSystem};
use leafwise_expression::{Arithmetic, Graph, Kernel, StepSize, Term};

use super::case::StressError;
use super::setup::{distance, largest};

/// β̂∘L of a method, compiled apart from its solver.
pub(super) struct Target {
    kernel: Kernel,
}

impl Target {
    /// Of a method whose parts are code; `None` for others.
    pub fn new(system: &PoissonSystem, method: &Method) -> Result<Option<Self>, StressError> {
        let d = system.dimension();
        let (Some(bisection), Some(realization)) =
            (method.bisection().code(), method.realization().code())
        else {
            return Ok(None);
        };
        let mut graph = Graph::new();
        let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let h = graph.step_size(StepSize::H);
        let z = bisection.point(&mut graph, &epsilon, &h, &y)?;
        let ends = realization.source_and_target(&mut graph, &epsilon, &z)?;
        let target: Vec<Term> = (0..d)
            .map(|i| graph.add(&ends.base[i], &ends.offset[i]))
            .collect();
        let outputs = [target, ends.offset].concat();
        Ok(Some(Self {
            kernel: Kernel::compile(&graph, &outputs, system.parameters().len(), d),
        }))
    }

    /// |β̂(L(y)) − x| relative to |x| + |y| + |β̂ − base|.
    pub fn residual(
        &self,
        parameters: &[f64],
        (epsilon, h): (f64, f64),
        x: &[f64],
        y: &[f64],
    ) -> f64 {
        let mut workspace = self.kernel.workspace(1);
        self.kernel
            .prepare(&mut workspace, parameters, &[epsilon], &[h]);
        let mut values = vec![0.0; 2 * x.len()];
        self.kernel.evaluate(&mut workspace, y, &mut values);
        let (target, offset) = values.split_at(x.len());
        distance(target, x) / (largest(x) + largest(y) + largest(offset))
    }
}
