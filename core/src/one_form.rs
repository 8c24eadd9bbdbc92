//! One-forms on M, and their graphs as numbers.

use leafwise_expression::{Graph, StepSize, Term};

use crate::error::{BuildError, StepError};
use crate::evaluator::{Evaluator, is_same};
use crate::generating_function::Generating;
use crate::runge_kutta::SmoothMap;

/// θ_{ε,h} on M.
#[derive(Clone, Debug)]
pub enum OneForm {
    /// dŜ_{ε,h}: closed, and its graph Lagrangian.
    Differential(Generating),
    /// Any other, whose graph maps along leaves.
    Code {
        /// The code; its inputs are the coordinates of M, and it may use ε and h.
        graph: Graph,
        /// d components.
        components: Vec<Term>,
    },
    /// θ as numbers: from the d coordinates y to d components.
    Numbers(SmoothMap),
}

impl OneForm {
    /// θ_{ε,h}(y) as code, or else the numbers.
    pub(crate) fn code(&self) -> Result<PointCode<'_>, &SmoothMap> {
        match self {
            Self::Differential(generating) => Ok(Box::new(|graph, epsilon, h, y| {
                generating.differential(graph, epsilon, h, y)
            })),
            Self::Code { graph, components } => Ok(Box::new(move |code, _, _, y| {
                Ok(code.import(graph, components, y)?)
            })),
            Self::Numbers(map) => Err(map),
        }
    }

    /// y ↦ θ_{ε,h}(y) and its Jacobian on M of `dimension` d, compiled where they are code.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a derivative has no code.
    pub fn map(&self, dimension: usize, parameters: usize) -> Result<SmoothMap, BuildError> {
        let code = match self.code() {
            Ok(code) => code,
            Err(numbers) => return Ok(numbers.clone()),
        };
        let mut graph = Graph::new();
        let y: Vec<Term> = (0..dimension).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let h = graph.step_size(StepSize::H);
        let p = code(&mut graph, &epsilon, &h, &y)?;
        SmoothMap::compile(graph, &p, parameters, dimension)
    }
}

/// A bisection or a one-form as straight-line code: of a graph, ε, h and y, the d_S coordinates of L_{ε,h}(y).
///
/// It fails with [`BuildError::Algebra`] where the Hamiltonian has no code.
pub type PointCode<'a> =
    Box<dyn Fn(&mut Graph, &Term, &Term, &[Term]) -> Result<Vec<Term>, BuildError> + 'a>;

/// y ↦ χ(y, θ(y)): the graph of a one-form, through a chart.
pub(crate) struct GraphOfOneForm {
    form: Box<dyn Evaluator>,
    chart: Box<dyn Evaluator>,
    dimension: usize,
    /// The points y of the last call, none where it failed, θ there, the pairs (y, θ(y)), and Dθ and Dχ.
    y: Vec<f64>,
    p: Vec<f64>,
    pairs: Vec<f64>,
    jacobian: Vec<f64>,
    of_chart: Vec<f64>,
    /// Operations of the products.
    linear: u64,
}

impl GraphOfOneForm {
    /// The graph of a one-form on M of `dimension` d in S of `space` coordinates.
    pub(crate) fn new(
        form: Box<dyn Evaluator>,
        chart: Box<dyn Evaluator>,
        dimension: usize,
        space: usize,
    ) -> Self {
        Self {
            form,
            chart,
            dimension,
            y: vec![0.0; dimension],
            p: vec![0.0; dimension],
            pairs: vec![0.0; 2 * dimension],
            jacobian: vec![0.0; dimension * dimension],
            of_chart: vec![0.0; space * 2 * dimension],
            linear: 0,
        }
    }
}

impl GraphOfOneForm {
    /// Keeps the y, their θ(y) and the pairs of both.
    fn forms(&mut self, y: &[f64]) -> Result<(), StepError> {
        let d = self.dimension;
        self.y.clear();
        self.p.resize(y.len(), 0.0);
        self.form.values(y, &mut self.p)?;
        self.y.extend_from_slice(y);
        self.pairs.resize(2 * y.len(), 0.0);
        let points = y.chunks_exact(d).zip(self.p.chunks_exact(d));
        for (pair, (y, p)) in self.pairs.chunks_exact_mut(2 * d).zip(points) {
            let (first, second) = pair.split_at_mut(d);
            first.copy_from_slice(y);
            second.copy_from_slice(p);
        }
        Ok(())
    }

    /// Writes D_x χ + D_p χ Dθ at all y that are kept.
    fn tangents(&mut self, tangents: &mut [f64]) -> Result<(), StepError> {
        let (d, y) = (self.dimension, &self.y);
        self.jacobian.resize(y.len() * d, 0.0);
        self.of_chart.resize(2 * tangents.len(), 0.0);
        self.form.jacobians(y, &mut self.jacobian)?;
        self.chart.jacobians(&self.pairs, &mut self.of_chart)?;
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

impl Evaluator for GraphOfOneForm {
    fn values(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.forms(y)?;
        self.chart.values(&self.pairs, z)
    }

    fn jacobians(&mut self, y: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        if !is_same(&self.y, y) {
            self.forms(y)?;
        }
        self.tangents(tangents)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.form.operations()? + self.chart.operations()? + self.linear)
    }

    fn restart(&mut self) {
        self.y.clear();
        self.form.restart();
        self.chart.restart();
    }

    /// That of the one-form, then that of the chart.
    fn memory(&self) -> Vec<f64> {
        [self.form.memory(), self.chart.memory()].concat()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.y.clear();
        let (form, chart) = memory.split_at(self.form.memory().len());
        self.form.restore(form);
        self.chart.restore(chart);
    }
}
