//! The nodal values Y_j = x + ε Σ_k A_jk Π(Y_k) p at fixed (x, p).

use leafwise_core::StepError;
use leafwise_core::solver::judge::{Verdict, larger, largest, reach};
use leafwise_core::solver::{
    CorrectionMethod, DenseFactors, Iteration, LinearSolve, elimination_operations,
    substitution_operations,
};

use super::field::{Field, FieldEvaluator};
use super::rule::CollocationRule;
use super::simplified::{Fixed, Simplified};

/// Budget of the first iteration, before Newton's method with the derivatives at every node takes over.
const MOST_ITERATIONS: usize = 40;

/// Budget of that.
const MOST_NEWTON: usize = 30;

/// The trailing Legendre coefficient, relative, whose square is round-off.
const SHORT_TAIL: f64 = 1e-9;

/// Least size by which a component of V is measured. For Newton's method, |εV_i| counts as at least this part of its
/// coordinate and of the contributions of others to it. Where these are not known, |V_i| counts as at least this part
/// of the largest component of V.
const LEAST_COMPONENT: f64 = 1e-5;

/// The curve at q nodes, and V there.
pub(super) struct Curve {
    pub(super) rule: CollocationRule,
    pub(super) field: FieldEvaluator,
    dimension: usize,
    /// Y_j, q × d.
    pub(super) nodes: Vec<f64>,
    /// V(Y_j, p), q × d.
    values: Vec<f64>,
    /// Legendre coefficients of V and of Y − x, q × d.
    velocity: Vec<f64>,
    pub(super) shape: Vec<f64>,
    /// Corrections of the second, and what they lead to.
    corrections: Vec<f64>,
    goal: Vec<f64>,
    pub(super) iteration: Iteration,
    pub(super) simplified: Simplified,
    /// Room for the linearized equations, made when they are first asked for.
    linearization: Option<Linearization>,
    /// Nothing but zeros, d of them.
    nothing: Vec<f64>,
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
            velocity: vec![0.0; q * d],
            shape: vec![0.0; q * d],
            corrections: vec![0.0; q * d],
            goal: vec![0.0; q * d],
            iteration: Iteration::new(CorrectionMethod::Acceleration, q * d),
            simplified: Simplified::new(d),
            linearization: None,
            nothing: vec![0.0; d],
            linear: 0,
        }
    }

    /// Weighted operations so far: V and its slopes, sums over nodes, solves.
    pub(super) fn operations(&self) -> Option<u64> {
        let corrections = self.iteration.operations() + self.simplified.operations;
        Some(self.field.operations()? + self.linear + corrections)
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
            &mut self.velocity,
            &mut self.corrections,
            &mut self.goal,
        ];
        room.into_iter().for_each(|room| *room = vec![0.0; size]);
        self.shape.resize(size, 0.0);
        self.iteration.resize(size);
        self.linearization = None;
    }

    /// V at every node, and its Legendre coefficients.
    ///
    /// # Errors
    /// The system's [`StepError`].
    pub(super) fn evaluate(&mut self, p: &[f64]) -> Result<(), StepError> {
        let d = self.dimension;
        self.field.values(&self.nodes, p, &mut self.values)?;
        self.corrections.copy_from_slice(&self.values);
        self.rule
            .to_coefficients(&mut self.corrections, &mut self.velocity, d);
        self.linear += self.rule.operations(d);
        Ok(())
    }

    /// ε ∫ V, from one end to the other: ε v_0.
    pub(super) fn whole(&self, epsilon: f64, i: usize) -> f64 {
        epsilon * self.velocity[i]
    }

    /// From the mean to the end Y(1): (ε/2)(v_0 + v_1/3).
    pub(super) fn part(&self, epsilon: f64, i: usize) -> f64 {
        let next = self.velocity.get(self.dimension + i).unwrap_or(&0.0);
        0.5 * epsilon * (self.velocity[i] + next / 3.0)
    }

    /// ε Σ_k A_jk V_k as coefficients c_m = (ε/2)(v_{m−1}/(2m−1) − v_{m+1}/(2m+3)), c_0 = 0, into `goal`.
    fn integrate(&mut self, epsilon: f64) {
        let d = self.dimension;
        let half = 0.5 * epsilon;
        self.goal[..d].fill(0.0);
        for (at, goal) in self.goal.iter_mut().enumerate().skip(d) {
            let m = (at / d) as f64;
            let next = self.velocity.get(at + d).unwrap_or(&0.0);
            *goal = half * (self.velocity[at - d] / (2.0 * m - 1.0) - next / (2.0 * m + 3.0));
        }
        self.linear += 4 * self.goal.len() as u64;
    }

    /// The last Legendre coefficient c_{q−1} of V over V itself, the largest of a component: where its
    /// square is below round-off, more nodes change nothing.
    ///
    /// By symmetry it may vanish where the next does not: with c_m like ρᵐ, c_{q−2}^((q−1)/(q−2)) is as
    /// large. A component may be round-off of its coordinate at `x` and of others.
    fn tail(&self, epsilon: f64, x: &[f64]) -> f64 {
        let (d, q) = (self.dimension, self.rule.points());
        let size = |i: usize| {
            let own = self.values.iter().skip(i).step_by(d);
            own.fold(0.0, |m, v| larger(m, v.abs()))
        };
        let whole = largest(&self.values);
        let put_in = &self.simplified.put_in;
        let least = |i: usize| match self.method() {
            CorrectionMethod::Newton => (x[i].abs() + put_in[i]) / epsilon.abs(),
            _ => whole,
        };
        let coefficient = |m: usize| {
            let of = |i: usize| {
                let scale = larger(size(i), LEAST_COMPONENT * least(i));
                match self.velocity[m * d + i].abs() {
                    0.0 => 0.0,
                    velocity => velocity / scale,
                }
            };
            (0..d).map(of).fold(0.0, larger)
        };
        if whole == 0.0 {
            return 0.0;
        }
        let exponent = (q as f64 - 1.0) / (q as f64 - 2.0);
        larger(coefficient(q - 1), libm::pow(coefficient(q - 2), exponent))
    }

    /// Takes another node where an automatic choice of up to `most` asks for it; whether it did.
    ///
    /// # Errors
    /// [`StepError::LeftChart`] where there are no more.
    pub(super) fn refine(
        &mut self,
        epsilon: f64,
        x: &[f64],
        most: Option<usize>,
    ) -> Result<bool, StepError> {
        let Some(most) = most else { return Ok(false) };
        let (points, tail) = (self.rule.points(), self.tail(epsilon, x));
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

    /// Newton's method with the derivatives at one point; Anderson's acceleration where evaluations are so dear that
    /// fewer of them pay for it, and derivatives more so.
    pub(super) fn method(&self) -> CorrectionMethod {
        match self.field.is_foreign() {
            true => CorrectionMethod::Acceleration,
            false => CorrectionMethod::Newton,
        }
    }

    /// The straight curve with these differences from its end Y(1) = x to its mean.
    pub(super) fn straighten(&mut self, displacement: &[f64]) {
        let d = self.dimension;
        self.shape.fill(0.0);
        self.shape[..d].copy_from_slice(displacement);
        let slope = self.shape.iter_mut().skip(d).zip(displacement);
        slope.for_each(|(slope, displacement)| *slope = -displacement);
    }

    /// Begins an iteration with a budget of evaluations from the curve of the present shape.
    pub(super) fn begin(&mut self, x: &[f64], (method, most): (CorrectionMethod, usize)) {
        self.place(x);
        self.iteration.set_method(method);
        // High coefficients are round-off of the first two.
        let (mean, slope) = self.shape.split_at(x.len());
        let size = |row: usize| {
            let c = row % x.len();
            x[c].abs() + mean[c].abs() + slope.get(c).unwrap_or(&0.0).abs()
        };
        self.iteration.begin(most, size);
    }

    /// Y_j = x + Σ_m a_m P_m(ξ_j).
    fn place(&mut self, x: &[f64]) {
        let d = self.dimension;
        self.rule.to_values(&self.shape, &mut self.nodes, d);
        for (at, node) in self.nodes.iter_mut().enumerate() {
            *node += x[at % d];
        }
        self.linear += self.rule.operations(d);
    }

    /// Moves the nodes to Y_j = x + mean + ε Σ_k A_jk V_k for V as last evaluated, or as Newton's method or the
    /// acceleration say. Where that is Newton's last correction, V follows it to first order.
    ///
    /// # Errors
    /// Those of [`Iteration::judge`].
    pub(super) fn correct(
        &mut self,
        epsilon: f64,
        x: &[f64],
        mean: &[f64],
    ) -> Result<Verdict, StepError> {
        let d = self.dimension;
        self.integrate(epsilon);
        self.goal[..d].copy_from_slice(mean);
        let pairs = self.goal.iter().zip(&self.shape);
        for (correction, (goal, known)) in self.corrections.iter_mut().zip(pairs) {
            *correction = goal - known;
        }
        // High coefficients are round-off of the first two.
        let (mean, slope) = self.goal.split_at(d);
        let way = |i: usize| mean[i].abs() + slope.get(i).unwrap_or(&0.0).abs();
        self.iteration.take_changes(|row| way(row % d));
        let is_newton = self.iteration.method() == CorrectionMethod::Newton;
        if is_newton {
            self.simplified.correct(&mut self.corrections);
        }
        let put_in_each = std::mem::take(&mut self.simplified.put_in);
        let put_in = |i: usize| if is_newton { put_in_each[i] } else { 0.0 };
        let simplified = &mut self.simplified;
        let mut by_factors = |residual: &mut [f64]| simplified.correct(residual);
        let solve: Option<LinearSolve<'_>> = match is_newton {
            true => Some(&mut by_factors),
            false => None,
        };
        let verdict = self.iteration.correct(
            &mut self.corrections,
            &mut self.shape,
            1.0,
            |at, _, _| (x[at % d], way(at % d), put_in(at % d)),
            |_, coefficient| coefficient,
            solve,
        );
        self.simplified.put_in = put_in_each;
        let verdict = verdict?;
        self.place(x);
        if is_newton && verdict == Verdict::Converged {
            self.simplified
                .add_change(&self.corrections, &mut self.velocity);
        }
        Ok(verdict)
    }

    /// Takes the derivatives for Newton's method at (y, p).
    ///
    /// # Errors
    /// Those of [`Simplified::linearize`].
    pub(super) fn take_slopes(
        &mut self,
        epsilon: f64,
        at: (&[f64], &[f64]),
        fixed: Fixed<'_>,
    ) -> Result<(), StepError> {
        self.simplified
            .linearize(&mut self.field, epsilon, at, fixed)
    }

    /// Solves for the nodal values from the constant curve; where the system has slopes and the iteration does not
    /// converge, with the derivatives at every node.
    pub(super) fn solve(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        match self.iterate(epsilon, x, p) {
            Err(_) if self.field.has_slopes() => self.newton(epsilon, x, p),
            outcome => outcome,
        }
    }

    fn iterate(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        let method = self.method();
        let is_newton = method == CorrectionMethod::Newton;
        if is_newton {
            self.take_slopes(epsilon, (x, p), Fixed::Mean)?;
        }
        self.shape.fill(0.0);
        self.begin(x, (method, MOST_ITERATIONS));
        loop {
            self.evaluate(p)?;
            let nothing = std::mem::take(&mut self.nothing);
            let verdict = self.correct(epsilon, x, &nothing);
            self.nothing = nothing;
            match verdict? {
                Verdict::Continue => {}
                Verdict::Converged if is_newton => return Ok(()),
                Verdict::Converged => return self.evaluate(p),
            }
        }
    }

    fn newton(&mut self, epsilon: f64, x: &[f64], p: &[f64]) -> Result<(), StepError> {
        let (q, d) = (self.rule.points(), self.dimension);
        self.shape.fill(0.0);
        self.begin(x, (CorrectionMethod::Newton, MOST_NEWTON));
        loop {
            self.evaluate(p)?;
            self.integrate(epsilon);
            self.rule.to_values(&self.goal, &mut self.corrections, d);
            for (at, correction) in self.corrections.iter_mut().enumerate() {
                *correction += x[at % d] - self.nodes[at];
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
            let nodes = &self.nodes;
            self.iteration.take_changes(|at| nodes[at] - x[at % d]);
            let linearization = self.linearization.as_ref();
            let by_y = linearization.map_or(&[][..], |own| &own.by_y);
            let mut solve = |residual: &mut [f64]| {
                if let Some(own) = linearization {
                    own.factors.solve(residual);
                }
            };
            let put_in = |at: usize| epsilon.abs() * reach(&by_y[at * d..][..d], x);
            let verdict = self.iteration.correct(
                &mut self.corrections,
                &mut self.nodes,
                1.0,
                |at, node, correction| (x[at % d], node + correction - x[at % d], put_in(at)),
                |at, node| node - x[at % d],
                Some(&mut solve),
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
