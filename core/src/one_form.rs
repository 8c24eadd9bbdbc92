//! Bisections that are graphs of closed one-forms, as numbers.

use leafwise_expression::{Graph, Kernel, StepSize, Term};

use crate::chart::ChartWorker;
use crate::dynamics::BisectionWorker;
use crate::error::{BuildError, StepError};
use crate::runge_kutta::{SmoothMap, SmoothMapEvaluator};

/// One thread's evaluator of a closed one-form θ_{ε,h} on M, for fixed parameters, ε and h.
pub trait OneFormWorker: Send {
    /// p = θ(y).
    ///
    /// # Errors
    /// [`StepError`] where θ has no value.
    fn value(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError>;
    /// Dθ at the point of the last call, row-major d × d.
    ///
    /// # Errors
    /// [`StepError::NoTangent`] where it is not offered.
    fn jacobian(&mut self, jacobian: &mut [f64]) -> Result<(), StepError>;
    /// Whether [`jacobian`](Self::jacobian) is offered.
    fn has_jacobian(&self) -> bool {
        true
    }
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for a part that
    /// does not count.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    fn operations(&self) -> Option<u64> {
        None
    }
}

/// y ↦ χ(y, θ(y)): the graph of a one-form, through a chart.
pub struct GraphOfOneForm {
    form: Box<dyn OneFormWorker>,
    chart: Box<dyn ChartWorker>,
    p: Vec<f64>,
    jacobian: Vec<f64>,
    of_chart: Vec<f64>,
    /// Operations of the products.
    linear: u64,
}

impl GraphOfOneForm {
    /// The graph of a one-form on M of `dimension` d in S of `space` coordinates.
    pub fn new(
        form: Box<dyn OneFormWorker>,
        chart: Box<dyn ChartWorker>,
        dimension: usize,
        space: usize,
    ) -> Self {
        Self {
            form,
            chart,
            p: vec![0.0; dimension],
            jacobian: vec![0.0; dimension * dimension],
            of_chart: vec![0.0; space * 2 * dimension],
            linear: 0,
        }
    }
}

impl BisectionWorker for GraphOfOneForm {
    fn point(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.form.value(y, &mut self.p)?;
        self.chart.point(y, &self.p, z)
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        let d = self.p.len();
        self.form.jacobian(&mut self.jacobian)?;
        self.chart.tangent(&mut self.of_chart)?;
        for (row, out) in self.of_chart.chunks(2 * d).zip(tangent.chunks_mut(d)) {
            let (of_x, of_p) = row.split_at(d);
            for (j, out) in out.iter_mut().enumerate() {
                let through_p: f64 = (0..d).map(|k| of_p[k] * self.jacobian[k * d + j]).sum();
                *out = of_x[j] + through_p;
            }
        }
        self.linear += 2 * (tangent.len() * d) as u64;
        Ok(())
    }

    fn has_tangent(&self) -> bool {
        self.form.has_jacobian() && self.chart.has_tangent()
    }

    fn operations(&self) -> Option<u64> {
        Some(self.form.operations()? + self.chart.operations()? + self.linear)
    }
}

/// A one-form given by code.
#[derive(Clone, Debug)]
pub struct CodeOneForm {
    map: SmoothMap,
}

impl CodeOneForm {
    /// What is evaluated, for reports.
    pub fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        self.map.kernels()
    }

    /// Compiles y ↦ θ(y) and its Jacobian; `write` gets ε, h and y.
    ///
    /// # Errors
    /// Those of `write`, and [`BuildError::Algebra`] where a derivative has no code.
    pub fn compile(
        dimension: usize,
        parameters: usize,
        write: impl FnOnce(&mut Graph, &Term, &Term, &[Term]) -> Result<Vec<Term>, BuildError>,
    ) -> Result<Self, BuildError> {
        let mut graph = Graph::new();
        let y: Vec<Term> = (0..dimension).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let h = graph.step_size(StepSize::H);
        let p = write(&mut graph, &epsilon, &h, &y)?;
        Ok(Self {
            map: SmoothMap::compile(&mut graph, &p, parameters, dimension)?,
        })
    }

    /// An evaluator for fixed parameters, ε and h.
    pub fn worker(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn OneFormWorker> {
        Box::new(CodeOneFormWorker {
            map: self.map.evaluator(parameters, epsilon, h),
            y: vec![0.0; self.map.inputs()],
        })
    }
}

struct CodeOneFormWorker {
    map: SmoothMapEvaluator,
    y: Vec<f64>,
}

impl OneFormWorker for CodeOneFormWorker {
    fn value(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError> {
        self.y.copy_from_slice(y);
        self.map.value(y, p)
    }

    fn jacobian(&mut self, jacobian: &mut [f64]) -> Result<(), StepError> {
        self.map.jacobian(&self.y, jacobian)
    }

    fn operations(&self) -> Option<u64> {
        self.map.operations()
    }
}
