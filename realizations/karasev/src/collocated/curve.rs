//! The nodal values Y_j = x + ε Σ_k A_jk Π(Y_k) p at fixed (x, p).

use leafwise_core::StepError;
use leafwise_core::solver::iteration::Verdict;
use leafwise_core::solver::{
    Anderson, CorrectionSize, LinearIteration, elimination_operations, substitution_operations,
};
use nalgebra::{DMatrix, DVector};

use super::field::{Field, FieldWorker};
use super::rule::CollocationRule;

/// Budget of the iteration, before Newton's method takes over.
const MOST_ITERATIONS: usize = 40;

/// Budget of Newton's method.
const MOST_NEWTON: usize = 30;

/// The curve at q nodes, and V there.
pub(super) struct Curve {
    pub(super) rule: CollocationRule,
    pub(super) field: FieldWorker,
    dimension: usize,
    /// Y_j, q × d.
    pub(super) nodes: Vec<f64>,
    /// V(Y_j, p), q × d.
    pub(super) values: Vec<f64>,
    /// Y_j − x, its corrections and what they are measured against, q × d.
    pub(super) offsets: Vec<f64>,
    corrections: Vec<f64>,
    scales: Vec<f64>,
    anderson: Anderson,
    accelerates: bool,
    /// Operations of accelerations at other numbers of nodes.
    accelerated: u64,
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
            offsets: vec![0.0; q * d],
            corrections: vec![0.0; q * d],
            scales: vec![0.0; q * d],
            anderson: Anderson::new(q * d),
            accelerates: false,
            accelerated: 0,
            linear: 0,
        }
    }

    /// Weighted operations so far: V and its slopes, sums over nodes, solves.
    pub(super) fn operations(&self) -> Option<u64> {
        Some(self.field.operations()? + self.linear + self.accelerated + self.anderson.operations())
    }

    /// Counts a solve of the linearized equations for so many right-hand sides, and the sums of
    /// their solutions.
    pub(super) fn count_tangents(&mut self, columns: usize) {
        let (q, d) = (self.rule.points(), self.dimension);
        let each = substitution_operations(q * d) + (2 * q * d * (q + d + 2)) as u64;
        self.linear += elimination_operations(q * d) + columns as u64 * each;
    }

    /// Counts an adjoint solve of the linearized equations, and the products with second derivatives
    /// at every node.
    pub(super) fn count_hessian(&mut self) {
        let (q, d) = (self.rule.points(), self.dimension);
        let adjoint = elimination_operations(q * d) + substitution_operations(q * d);
        self.linear += adjoint + (q * 12 * d * d * d + 4 * q * q * d) as u64;
    }

    /// The same with another number of nodes.
    pub(super) fn set_points(&mut self, q: usize) {
        let size = q * self.dimension;
        self.rule = CollocationRule::new(q);
        let room = [
            &mut self.nodes,
            &mut self.values,
            &mut self.offsets,
            &mut self.corrections,
            &mut self.scales,
        ];
        room.into_iter().for_each(|room| *room = vec![0.0; size]);
        self.accelerated += self.anderson.operations();
        self.anderson = Anderson::new(size);
    }

    /// V at every node; an iteration sums it over the nodes, once a node.
    ///
    /// # Errors
    /// The system's [`StepError`].
    pub(super) fn evaluate(&mut self, p: &[f64]) -> Result<(), StepError> {
        let d = self.dimension;
        self.linear += (2 * d * self.rule.points() * self.rule.points()) as u64;
        self.field.values(&self.nodes, p, &mut self.values)
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

    /// Whether evaluations are so dear that fewer of them pay for Anderson's acceleration.
    pub(super) fn is_foreign(&self) -> bool {
        self.field.is_foreign()
    }

    /// Begins an iteration, accelerated or not, from the curve at `offset(j, i)` = Y_j − x,
    /// component i.
    pub(super) fn begin(
        &mut self,
        x: &[f64],
        accelerates: bool,
        offset: impl Fn(usize, usize) -> f64,
    ) {
        let d = self.dimension;
        self.accelerates = accelerates;
        self.anderson.clear();
        for (at, node) in self.nodes.iter_mut().enumerate() {
            self.offsets[at] = offset(at / d, at % d);
            *node = x[at % d] + self.offsets[at];
        }
    }

    /// Moves the nodes to Y_j = x + shift + ε Σ_k A_jk V_k, or towards it where the iteration is
    /// accelerated; V as last evaluated.
    pub(super) fn correct(&mut self, epsilon: f64, x: &[f64], shift: &[f64]) -> CorrectionSize {
        let (q, d) = (self.rule.points(), self.dimension);
        let mut size = CorrectionSize::default();
        for j in 0..q {
            let row = &self.rule.matrix[j * q..][..q];
            for i in 0..d {
                let at = j * d + i;
                let offset = self.combination(epsilon, row, i) + shift[i];
                self.corrections[at] = offset - self.offsets[at];
                self.scales[at] = x[i].abs() + offset.abs();
                size.take(self.corrections[at], self.scales[at]);
            }
        }
        if self.accelerates {
            self.anderson.correct(&mut self.corrections, &self.scales);
        }
        for (at, correction) in self.corrections.iter().enumerate() {
            size.take(*correction, self.scales[at]);
            self.offsets[at] += correction;
            self.nodes[at] = x[at % d] + self.offsets[at];
        }
        size
    }

    /// Solves for the nodal values: the iteration from the constant curve, then, where the system has
    /// slopes, Newton's method.
    pub(super) fn solve(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        let nothing = vec![0.0; self.dimension];
        self.begin(x, self.is_foreign(), |_, _| 0.0);
        let mut iteration = LinearIteration::new(MOST_ITERATIONS);
        loop {
            self.evaluate(p)?;
            let size = self.correct(epsilon, x, &nothing);
            match iteration.judge_correction(&size) {
                Ok(Verdict::Continue) => {}
                Ok(Verdict::Converged) => return self.evaluate(p),
                Err(_) if self.field.has_slopes() => return self.newton(epsilon, x, p),
                Err(error) => return Err(error),
            }
        }
    }

    fn newton(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        let (q, d) = (self.rule.points(), self.dimension);
        self.begin(x, false, |_, _| 0.0);
        let mut iteration = LinearIteration::new(MOST_NEWTON);
        loop {
            self.evaluate(p)?;
            let jacobian = self.linearization(epsilon, p)?.matrix;
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
                return self.evaluate(p);
            }
        }
    }

    /// Whether the tangents below are offered.
    pub(super) fn has_slopes(&self) -> bool {
        self.field.has_slopes()
    }

    /// The linearized equations at the present nodes.
    pub(super) fn linearization(
        &mut self,
        epsilon: f64,
        p: &[f64],
    ) -> Result<Linearization, StepError> {
        let (q, d) = (self.rule.points(), self.dimension);
        let mut by_y = vec![0.0; q * d * d];
        let mut by_p = vec![0.0; q * d * d];
        for k in 0..q {
            let y = &self.nodes[k * d..][..d];
            let own = k * d * d..(k + 1) * d * d;
            self.field
                .slopes(y, p, &mut by_y[own.clone()], &mut by_p[own])?;
        }
        self.linear += 3 * (q * d * q * d) as u64;
        let matrix = DMatrix::from_fn(q * d, q * d, |row, column| {
            let (j, i, k, l) = (row / d, row % d, column / d, column % d);
            let unit = if row == column { 1.0 } else { 0.0 };
            unit - epsilon * self.rule.matrix[j * q + k] * by_y[k * d * d + i * d + l]
        });
        Ok(Linearization { matrix, by_y, by_p })
    }
}

/// 1 − ε A⊗V_y, and V_y and V_p = Π at every node, q × d × d.
pub(super) struct Linearization {
    pub(super) matrix: DMatrix<f64>,
    pub(super) by_y: Vec<f64>,
    pub(super) by_p: Vec<f64>,
}
