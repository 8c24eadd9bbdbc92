//! The nodal values Y_j = x + ε Σ_k A_jk Π(Y_k) p at fixed (x, p).

use leafwise_core::StepError;
use leafwise_core::solver::iteration::Verdict;
use leafwise_core::solver::{
    CorrectionSize, LinearIteration, elimination_operations, substitution_operations,
};
use nalgebra::{DMatrix, DVector};

use super::field::{Field, FieldWorker};
use super::rule::CollocationRule;

/// Budget of the linear iteration, before Newton's method takes over.
const MOST_ITERATIONS: usize = 40;

/// Budget of Newton's method.
const MOST_NEWTON: usize = 30;

/// The curve at q nodes, and V there.
#[derive(Clone)]
pub(super) struct Curve {
    pub(super) rule: CollocationRule,
    pub(super) field: FieldWorker,
    dimension: usize,
    /// Y_j, q × d.
    pub(super) nodes: Vec<f64>,
    /// V(Y_j, p), q × d.
    pub(super) values: Vec<f64>,
    /// Operations of the sums over nodes and the solves.
    linear: u64,
}

impl Curve {
    pub(super) fn new(field: &Field, parameters: &[f64], q: usize) -> Self {
        let d = field.dimension;
        Self {
            rule: CollocationRule::new(q),
            field: field.worker(parameters),
            dimension: d,
            nodes: vec![0.0; q * d],
            values: vec![0.0; q * d],
            linear: 0,
        }
    }

    /// Weighted operations so far: V and its slopes, sums over nodes, solves.
    pub(super) fn operations(&self) -> u64 {
        self.field.operations + self.linear
    }

    /// Counts a solve of the linearized equations for so many right-hand sides, and the sums of
    /// their solutions.
    pub(super) fn count_tangents(&mut self, columns: usize) {
        let (q, d) = (self.rule.points(), self.dimension);
        let each = substitution_operations(q * d) + (2 * q * d * (q + d + 2)) as u64;
        self.linear += elimination_operations(q * d) + columns as u64 * each;
    }

    /// The same with another number of nodes.
    pub(super) fn set_points(&mut self, q: usize) {
        self.rule = CollocationRule::new(q);
        self.nodes = vec![0.0; q * self.dimension];
        self.values = vec![0.0; q * self.dimension];
    }

    /// V at every node; an iteration sums it over the nodes, once a node.
    pub(super) fn evaluate(&mut self, p: &[f64]) {
        let d = self.dimension;
        self.linear += (2 * d * self.rule.points() * self.rule.points()) as u64;
        for (y, v) in self
            .nodes
            .chunks_exact(d)
            .zip(self.values.chunks_exact_mut(d))
        {
            self.field.value(y, p, v);
        }
    }

    /// ε Σ_k coefficients_k V_k, component i.
    pub(super) fn combination(&self, epsilon: f64, coefficients: &[f64], i: usize) -> f64 {
        let d = self.dimension;
        let sum: f64 = coefficients
            .iter()
            .zip(self.values.chunks_exact(d))
            .map(|(a, v)| a * v[i])
            .sum();
        epsilon * sum
    }

    /// The size of the last Legendre coefficient of V over that of V itself: where its square is
    /// below round-off, more nodes change nothing.
    pub(super) fn tail(&self) -> f64 {
        let d = self.dimension;
        let size = self.values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let last = (0..d)
            .map(|i| self.combination(1.0, &self.rule.last, i).abs())
            .fold(0.0_f64, f64::max);
        if size == 0.0 { 0.0 } else { last / size }
    }

    /// Solves for the nodal values: the linear iteration from the constant curve, Newton's method
    /// where that does not contract.
    pub(super) fn solve(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        let (q, d) = (self.rule.points(), self.dimension);
        self.start(x);
        let mut iteration = LinearIteration::new(MOST_ITERATIONS);
        loop {
            self.evaluate(p);
            let mut size = CorrectionSize::default();
            for j in 0..q {
                let row = &self.rule.matrix[j * q..][..q];
                for i in 0..d {
                    let offset = self.combination(epsilon, row, i);
                    let change = (x[i] - self.nodes[j * d + i]) + offset;
                    size.take(change, x[i].abs() + offset.abs());
                    self.nodes[j * d + i] = x[i] + offset;
                }
            }
            match iteration.judge_correction(&size) {
                Ok(Verdict::Continue) => {}
                Ok(Verdict::Converged) => {
                    self.evaluate(p);
                    return Ok(());
                }
                Err(_) => return self.newton(epsilon, x, p),
            }
        }
    }

    fn start(&mut self, x: &[f64]) {
        let d = self.dimension;
        self.nodes
            .chunks_exact_mut(d)
            .for_each(|y| y.copy_from_slice(x));
    }

    fn newton(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        let (q, d) = (self.rule.points(), self.dimension);
        self.start(x);
        let mut iteration = LinearIteration::new(MOST_NEWTON);
        loop {
            self.evaluate(p);
            let (jacobian, _) = self.linearization(epsilon, p);
            let mut residual = DVector::zeros(q * d);
            for j in 0..q {
                let row = &self.rule.matrix[j * q..][..q];
                for i in 0..d {
                    residual[j * d + i] =
                        (x[i] - self.nodes[j * d + i]) + self.combination(epsilon, row, i);
                }
            }
            self.linear += elimination_operations(q * d) + substitution_operations(q * d);
            let change = jacobian.lu().solve(&residual).ok_or(StepError::NonFinite {
                what: "a Newton correction of the curve",
            })?;
            let mut size = CorrectionSize::default();
            for (index, change) in change.iter().enumerate() {
                self.nodes[index] += change;
                size.take(*change, x[index % d].abs() + self.nodes[index].abs());
            }
            if iteration.judge_correction(&size)? == Verdict::Converged {
                self.evaluate(p);
                return Ok(());
            }
        }
    }

    /// The matrix 1 − ε A⊗V_y of the linearized equations, and Π at every node (q × d × d).
    pub(super) fn linearization(&mut self, epsilon: f64, p: &[f64]) -> (DMatrix<f64>, Vec<f64>) {
        let (q, d) = (self.rule.points(), self.dimension);
        let mut by_y = vec![0.0; q * d * d];
        let mut by_p = vec![0.0; q * d * d];
        for k in 0..q {
            let y = &self.nodes[k * d..][..d];
            let own = k * d * d..(k + 1) * d * d;
            self.field
                .slopes(y, p, &mut by_y[own.clone()], &mut by_p[own]);
        }
        self.linear += 3 * (q * d * q * d) as u64;
        let jacobian = DMatrix::from_fn(q * d, q * d, |row, column| {
            let (j, i, k, l) = (row / d, row % d, column / d, column % d);
            let unit = if row == column { 1.0 } else { 0.0 };
            unit - epsilon * self.rule.matrix[j * q + k] * by_y[k * d * d + i * d + l]
        });
        (jacobian, by_p)
    }

    /// ∂V/∂y at a node after [`evaluate`](Self::evaluate).
    pub(super) fn slope_by_y(&mut self, k: usize, p: &[f64], by_y: &mut [f64], by_p: &mut [f64]) {
        let d = self.dimension;
        let y = &self.nodes[k * d..][..d];
        self.field.slopes(y, p, by_y, by_p);
    }
}
