//! The nodal values Y_j = x + ε Σ_k A_jk Π(Y_k) p at fixed (x, p).

use leafwise_core::StepError;
use leafwise_core::solver::judge::{Verdict, larger, largest};
use leafwise_core::solver::{
    CorrectionMethod, DenseFactors, Iteration, elimination_operations, substitution_operations,
};

use super::field::{Field, FieldEvaluator};
use super::rule::CollocationRule;

/// Budget of the iteration, before Newton's method takes over.
const MOST_ITERATIONS: usize = 40;

/// Budget of Newton's method.
const MOST_NEWTON: usize = 30;

/// The trailing Legendre coefficient, relative, whose square is round-off.
const SHORT_TAIL: f64 = 1e-9;

/// A component of V smaller than this part of the largest is measured as if it were as large.
const LEAST_COMPONENT: f64 = 1e-5;

/// The curve at q nodes, and V there.
pub(super) struct Curve {
    pub(super) rule: CollocationRule,
    pub(super) field: FieldEvaluator,
    dimension: usize,
    /// Y_j, q × d.
    pub(super) nodes: Vec<f64>,
    /// V(Y_j, p), q × d.
    pub(super) values: Vec<f64>,
    /// Y_j − x, its corrections, and ε Σ_k A_jk V_k, q × d.
    pub(super) offsets: Vec<f64>,
    corrections: Vec<f64>,
    sums: Vec<f64>,
    pub(super) iteration: Iteration,
    /// Room for the linearized equations, made when they are first asked for.
    linearization: Option<Linearization>,
    /// Nothing but zeros, d of them.
    nothing: Vec<f64>,
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
            field: field.evaluator(parameters),
            dimension: d,
            nodes: vec![0.0; q * d],
            values: vec![0.0; q * d],
            offsets: vec![0.0; q * d],
            corrections: vec![0.0; q * d],
            sums: vec![0.0; q * d],
            iteration: Iteration::new(CorrectionMethod::Acceleration, q * d),
            linearization: None,
            nothing: vec![0.0; d],
            accelerated: 0,
            linear: 0,
        }
    }

    /// Weighted operations so far: V and its slopes, sums over nodes, solves.
    pub(super) fn operations(&self) -> Option<u64> {
        Some(
            self.field.operations()? + self.linear + self.accelerated + self.iteration.operations(),
        )
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
            &mut self.sums,
        ];
        room.into_iter().for_each(|room| *room = vec![0.0; size]);
        self.accelerated += self.iteration.operations();
        self.iteration = Iteration::new(CorrectionMethod::Acceleration, size);
        self.linearization = None;
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

    /// ε Σ_k A_jk V_k of every node, [`combination`](Self::combination) of each row, into `sums`.
    fn sum_over_nodes(&mut self, epsilon: f64) {
        let (q, d) = (self.rule.points(), self.dimension);
        let rows = self.rule.matrix.chunks_exact(q);
        for (sums, row) in self.sums.chunks_exact_mut(d).zip(rows) {
            sums.fill(-0.0);
            for (a, value) in row.iter().zip(self.values.chunks_exact(d)) {
                for (sum, v) in sums.iter_mut().zip(value) {
                    *sum += a * v;
                }
            }
            sums.iter_mut().for_each(|sum| *sum *= epsilon);
        }
    }

    /// The last Legendre coefficient c_{q−1} of V over V itself, the largest of a component: where its
    /// square is below round-off, more nodes change nothing.
    ///
    /// By symmetry it may vanish where the next does not: with c_m like ρᵐ, c_{q−2}^((q−1)/(q−2)) is as
    /// large. A component counts at least as a part of the largest, whose round-off it may be.
    fn tail(&self) -> f64 {
        let (d, q) = (self.dimension, self.rule.points());
        let size = |i: usize| {
            let own = self.values.iter().skip(i).step_by(d);
            own.fold(0.0, |m, v| larger(m, v.abs()))
        };
        let whole = largest(&self.values);
        let coefficient = |which: usize| {
            let of = |i: usize| {
                let scale = larger(size(i), LEAST_COMPONENT * whole);
                self.combination(1.0, &self.rule.last[which], i).abs() / scale
            };
            (0..d).map(of).fold(0.0, larger)
        };
        if whole == 0.0 {
            return 0.0;
        }
        let (q, before) = (q as f64, coefficient(0));
        larger(coefficient(1), libm::pow(before, (q - 1.0) / (q - 2.0)))
    }

    /// Takes another node where an automatic choice of up to `most` asks for it; whether it did.
    ///
    /// # Errors
    /// [`StepError::LeftChart`] where there are no more.
    pub(super) fn refine(&mut self, most: Option<usize>) -> Result<bool, StepError> {
        let Some(most) = most else { return Ok(false) };
        let (points, tail) = (self.rule.points(), self.tail());
        // A tail that is no number is not short.
        if tail <= SHORT_TAIL {
            return Ok(false);
        }
        if points >= most {
            return Err(StepError::LeftChart { ratio: tail });
        }
        self.set_points(points + 1);
        Ok(true)
    }

    /// Anderson's acceleration where evaluations are so dear that fewer of them pay for it.
    pub(super) fn method(&self) -> CorrectionMethod {
        match self.field.is_foreign() {
            true => CorrectionMethod::Acceleration,
            false => CorrectionMethod::Residual,
        }
    }

    /// Begins an iteration with a budget of evaluations from the curve at `offset(rule, j, i)` = Y_j − x,
    /// component i.
    pub(super) fn begin(
        &mut self,
        x: &[f64],
        (method, most): (CorrectionMethod, usize),
        offset: impl Fn(&CollocationRule, usize, usize) -> f64,
    ) {
        let d = self.dimension;
        for (at, node) in self.nodes.iter_mut().enumerate() {
            self.offsets[at] = offset(&self.rule, at / d, at % d);
            *node = x[at % d] + self.offsets[at];
        }
        self.iteration.set_method(method);
        self.iteration
            .begin(most, largest(x) + largest(&self.offsets));
    }

    /// Moves the nodes to Y_j = x + shift + ε Σ_k A_jk V_k, or towards it where the iteration is
    /// accelerated; V as last evaluated.
    ///
    /// # Errors
    /// Those of [`Iteration::judge`].
    pub(super) fn correct(
        &mut self,
        epsilon: f64,
        x: &[f64],
        shift: &[f64],
    ) -> Result<Verdict, StepError> {
        let d = self.dimension;
        self.sum_over_nodes(epsilon);
        let corrections = self.corrections.chunks_exact_mut(d);
        let known = corrections.zip(self.offsets.chunks_exact(d));
        for (offsets, (corrections, known)) in self.sums.chunks_exact_mut(d).zip(known) {
            for i in 0..d {
                offsets[i] += shift[i];
                corrections[i] = offsets[i] - known[i];
            }
        }
        self.iteration.take_change(largest(&self.sums));
        let (corrections, sums) = (&mut self.corrections, &self.sums);
        let verdict = self.iteration.correct(
            corrections,
            &mut self.offsets,
            1.0,
            |at, _, _| (x[at % d], sums[at]),
            |_, offset| offset,
        );
        let offsets = self.offsets.chunks_exact(d);
        for (nodes, offsets) in self.nodes.chunks_exact_mut(d).zip(offsets) {
            for (node, (x, offset)) in nodes.iter_mut().zip(x.iter().zip(offsets)) {
                *node = x + offset;
            }
        }
        verdict
    }

    /// Solves for the nodal values: the iteration from the constant curve, then, where the system has
    /// slopes, Newton's method.
    pub(super) fn solve(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        self.begin(x, (self.method(), MOST_ITERATIONS), |_, _, _| 0.0);
        loop {
            self.evaluate(p)?;
            let nothing = std::mem::take(&mut self.nothing);
            let verdict = self.correct(epsilon, x, &nothing);
            self.nothing = nothing;
            match verdict {
                Ok(Verdict::Continue) => {}
                Ok(Verdict::Converged) => return self.evaluate(p),
                Err(_) if self.field.has_slopes() => return self.newton(epsilon, x, p),
                Err(error) => return Err(error),
            }
        }
    }

    fn newton(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        let (q, d) = (self.rule.points(), self.dimension);
        self.begin(x, (CorrectionMethod::Newton, MOST_NEWTON), |_, _, _| 0.0);
        loop {
            self.evaluate(p)?;
            self.sum_over_nodes(epsilon);
            for (at, correction) in self.corrections.iter_mut().enumerate() {
                *correction = (x[at % d] - self.nodes[at]) + self.sums[at];
            }
            let mut linearization = self.linearize(epsilon, p)?;
            self.linear += elimination_operations(q * d) + substitution_operations(q * d);
            let is_regular = linearization.factor();
            linearization.factors.solve(&mut self.corrections);
            self.linearization = Some(linearization);
            if !is_regular {
                return Err(StepError::NonFinite {
                    what: "a Newton correction of the curve",
                });
            }
            let offsets = self.nodes.iter().enumerate();
            let reached = offsets.fold(0.0, |m, (at, y)| larger(m, (y - x[at % d]).abs()));
            self.iteration.take_change(reached);
            let verdict = self.iteration.correct(
                &mut self.corrections,
                &mut self.nodes,
                1.0,
                |at, node, correction| (x[at % d], node + correction - x[at % d]),
                |at, node| node - x[at % d],
            )?;
            if verdict == Verdict::Converged {
                return self.evaluate(p);
            }
        }
    }

    /// Whether the tangents below are offered.
    pub(super) fn has_slopes(&self) -> bool {
        self.field.has_slopes()
    }

    /// The linearized equations at the present nodes, in the room that
    /// [`give_back`](Self::give_back) gave.
    pub(super) fn linearize(
        &mut self,
        epsilon: f64,
        p: &[f64],
    ) -> Result<Linearization, StepError> {
        let (q, d) = (self.rule.points(), self.dimension);
        let room = self.linearization.take();
        let mut room = room.unwrap_or_else(|| Linearization::new(q, d));
        let slopes = room.by_y.chunks_exact_mut(d * d);
        let slopes = slopes.zip(room.by_p.chunks_exact_mut(d * d));
        for (y, (by_y, by_p)) in self.nodes.chunks_exact(d).zip(slopes) {
            self.field.slopes(y, p, by_y, by_p)?;
        }
        self.linear += 3 * (q * d * q * d) as u64;
        for (row, entries) in room.matrix.chunks_exact_mut(q * d).enumerate() {
            let (j, i) = (row / d, row % d);
            let slopes = room.by_y.chunks_exact(d).skip(i).step_by(d);
            let blocks = self.rule.matrix[j * q..][..q].iter().zip(slopes);
            for (entries, (a, slope)) in entries.chunks_exact_mut(d).zip(blocks) {
                let factor = epsilon * a;
                for (entry, slope) in entries.iter_mut().zip(slope) {
                    *entry = 0.0 - factor * slope;
                }
            }
            let slope = room.by_y[row * d + i];
            entries[row] = 1.0 - epsilon * self.rule.matrix[j * q + j] * slope;
        }
        Ok(room)
    }

    /// Keeps the room of a linearization for the next one.
    pub(super) fn give_back(&mut self, room: Linearization) {
        let size = self.nodes.len();
        self.linearization = Some(room).filter(|room| room.matrix.len() == size * size);
    }
}

/// 1 − ε A⊗V_y, its factors, and V_y and V_p = Π at every node, q × d × d, row-major.
pub(super) struct Linearization {
    pub(super) matrix: Vec<f64>,
    pub(super) factors: DenseFactors,
    pub(super) by_y: Vec<f64>,
    pub(super) by_p: Vec<f64>,
}

impl Linearization {
    fn new(q: usize, d: usize) -> Self {
        let size = q * d;
        Self {
            matrix: vec![0.0; size * size],
            factors: DenseFactors::new(size),
            by_y: vec![0.0; size * d],
            by_p: vec![0.0; size * d],
        }
    }

    /// Factors the matrix; `false` where it is singular.
    pub(super) fn factor(&mut self) -> bool {
        self.factors.factor(&self.matrix)
    }

    /// Factors the transpose instead; `false` where it is singular.
    pub(super) fn factor_transpose(&mut self, size: usize) -> bool {
        for row in 0..size {
            for column in 0..row {
                self.matrix.swap(row * size + column, column * size + row);
            }
        }
        let is_regular = self.factor();
        for row in 0..size {
            for column in 0..row {
                self.matrix.swap(row * size + column, column * size + row);
            }
        }
        is_regular
    }
}
