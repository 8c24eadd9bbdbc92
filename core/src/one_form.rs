//! Bisections that are graphs of closed one-forms, as numbers.

use leafwise_expression::{Graph, Kernel, StepSize, Term};

use crate::bisection::{BisectionBatch, BisectionWorker, OneFormWorker};
use crate::error::{BuildError, StepError};
use crate::realization::ChartWorker;
use crate::runge_kutta::{SmoothMap, SmoothMapEvaluator};

/// y ↦ χ(y, θ(y)): the graph of a one-form, through a chart.
pub struct GraphOfOneForm {
    form: Box<dyn OneFormWorker>,
    chart: Box<dyn ChartWorker>,
    dimension: usize,
    /// The points of the last call, none where it failed, θ there, and Dθ and Dχ.
    y: Vec<f64>,
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
            dimension,
            y: vec![0.0; dimension],
            p: vec![0.0; dimension],
            jacobian: vec![0.0; dimension * dimension],
            of_chart: vec![0.0; space * 2 * dimension],
            linear: 0,
        }
    }
}

impl GraphOfOneForm {
    /// Keeps the y and their θ(y).
    fn forms(&mut self, y: &[f64]) -> Result<(), StepError> {
        self.y.clear();
        self.y.extend_from_slice(y);
        self.p.resize(y.len(), 0.0);
        let outcome = self.form.value(y, &mut self.p);
        if outcome.is_err() {
            self.y.clear();
        }
        outcome
    }

    /// Whether these are the y that are kept.
    fn has_forms(&self, y: &[f64]) -> bool {
        let mut pairs = self.y.iter().zip(y);
        self.y.len() == y.len() && pairs.all(|(kept, y)| kept.to_bits() == y.to_bits())
    }

    /// Writes D_x χ + D_p χ Dθ at all y that are kept.
    fn tangents(&mut self, tangents: &mut [f64]) -> Result<(), StepError> {
        let (d, y) = (self.dimension, &self.y);
        if y.is_empty() {
            return Err(StepError::NoTangent);
        }
        self.jacobian.resize(y.len() * d, 0.0);
        self.of_chart.resize(2 * tangents.len(), 0.0);
        self.form.jacobian(y, &mut self.jacobian)?;
        self.chart.tangent(y, &self.p, &mut self.of_chart)?;
        let entries = tangents.len() * d / y.len();
        let jacobians = self.jacobian.chunks_exact(d * d);
        let charts = self.of_chart.chunks_exact(2 * entries);
        let points = jacobians
            .zip(charts)
            .zip(tangents.chunks_exact_mut(entries));
        for ((jacobian, of_chart), tangent) in points {
            for (row, out) in of_chart.chunks(2 * d).zip(tangent.chunks_mut(d)) {
                let (of_x, of_p) = row.split_at(d);
                for (j, out) in out.iter_mut().enumerate() {
                    let through_p: f64 = (0..d).map(|k| of_p[k] * jacobian[k * d + j]).sum();
                    *out = of_x[j] + through_p;
                }
            }
        }
        self.linear += 2 * (tangents.len() * d) as u64;
        Ok(())
    }
}

impl BisectionWorker for GraphOfOneForm {
    fn point(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.all_points(y, z)
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        self.tangents(tangent)
    }

    fn has_tangent(&self) -> bool {
        self.form.has_jacobian() && self.chart.has_tangent()
    }

    fn batch(&mut self) -> Option<&mut dyn BisectionBatch> {
        Some(self)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.form.operations()? + self.chart.operations()? + self.linear)
    }
}

impl BisectionBatch for GraphOfOneForm {
    fn all_points(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.forms(y)?;
        self.chart.point(y, &self.p, z)
    }

    fn all_tangents(&mut self, y: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        if !self.has_forms(y) {
            self.forms(y)?;
        }
        self.tangents(tangents)
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
        })
    }
}

struct CodeOneFormWorker {
    map: SmoothMapEvaluator,
}

impl OneFormWorker for CodeOneFormWorker {
    fn value(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError> {
        self.map.all_values(y, p)
    }

    fn jacobian(&mut self, y: &[f64], jacobian: &mut [f64]) -> Result<(), StepError> {
        self.map.all_jacobians(y, jacobian)
    }

    fn operations(&self) -> Option<u64> {
        self.map.operations()
    }
}
