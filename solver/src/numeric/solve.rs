//! β̂(L(y)) = x of one trajectory, between the evaluations that it asks for.

use crate::error::StepError;
use crate::extrapolation::DEPTH;
use crate::judge::{Verdict, is_between};
use crate::linear::{DenseFactors, elimination_operations, substitution_operations};
use crate::{CorrectionMethod, Extrapolation, Iteration, LinearSolve};

/// Budget of one step.
pub(super) const MOST_EVALUATIONS: usize = 100;

/// Where a solve stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Both maps are wanted at y once more.
    Iterates,
    /// y is found.
    Solved,
}

/// The solve of β̂(L(y)) = x for one state, by corrections that [`Iteration`] judges; the caller evaluates both maps.
pub struct Solve {
    /// The iterate, at the end the solution.
    pub y: Vec<f64>,
    /// Whether y is found, and the ends there are wanted.
    pub(super) is_last: bool,
    pub(super) extrapolation: Extrapolation,
    displacement: Vec<f64>,
    residual: Vec<f64>,
    factors: DenseFactors,
    /// Round-off of all coordinates that is left in each.
    put_in: Vec<f64>,
    pub(super) iteration: Iteration,
    /// Operations of the products and solves.
    pub(super) linear: u64,
}

impl Solve {
    /// Of `dimension` coordinates.
    pub fn new(method: CorrectionMethod, dimension: usize) -> Self {
        let d = dimension;
        Self {
            y: vec![0.0; d],
            is_last: false,
            extrapolation: Extrapolation::new(d, DEPTH),
            displacement: vec![0.0; d],
            residual: vec![0.0; d],
            factors: DenseFactors::new(d),
            put_in: vec![0.0; d],
            iteration: Iteration::new(method, d),
            linear: 0,
        }
    }

    /// Begins a step.
    pub(super) fn begin(&mut self, x: &[f64]) {
        self.iteration.begin_step();
        self.extrapolation
            .predict(self.displacement.as_chunks_mut().0);
        self.begin_at_displacement(x, MOST_EVALUATIONS);
    }

    /// Begins anew at a point, with a budget of evaluations.
    pub fn begin_at(&mut self, x: &[f64], y: &[f64], most: usize) {
        for (i, displacement) in self.displacement.iter_mut().enumerate() {
            *displacement = y[i] - x[i];
        }
        self.begin_at_displacement(x, most);
    }

    fn begin_at_displacement(&mut self, x: &[f64], most: usize) {
        for (i, y) in self.y.iter_mut().enumerate() {
            *y = x[i] + self.displacement[i];
        }
        let displacement = &self.displacement;
        let size = |row: usize| x[row].abs() + displacement[row].abs();
        self.iteration.begin(most, size);
        self.is_last = false;
    }

    fn is_newton(&self) -> bool {
        self.iteration.method() == CorrectionMethod::Newton
    }

    /// Takes in the ends at y, base, offset and increment, whether L is exact there, and for Newton's method D(β̂∘L), and corrects
    /// y.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`], [`StepError::NonFinite`].
    pub fn take(
        &mut self,
        (x, low): (&[f64], &[f64]),
        (ends, is_exact): (&[f64], bool),
        target: &[f64],
    ) -> Result<Progress, StepError> {
        if self.is_last {
            return Ok(Progress::Solved);
        }
        let d = x.len();
        for i in 0..d {
            self.residual[i] = x[i] - ends[i] - ends[d + i] + low[i];
        }
        if self.is_newton() {
            self.linear += elimination_operations(d) + substitution_operations(d);
            if !self.factors.factor_of_sizes(target, &self.y) {
                return Err(StepError::NonFinite {
                    what: "a Newton correction",
                });
            }
            self.iteration.take_factors(&self.factors);
            self.factors.solve(&mut self.residual);
            for (i, row) in target.chunks_exact(d).enumerate() {
                let unit = |j: usize| if i == j { 1.0 } else { 0.0 };
                let terms = row.iter().zip(&self.y).enumerate();
                let put_in: f64 = terms
                    .map(|(j, (entry, y))| ((entry - unit(j)) * y).abs())
                    .sum();
                self.put_in[i] = put_in * self.factors.left(i);
            }
        }
        let change = &ends[2 * d..];
        self.iteration.take_changes(|row| change[row]);
        let put_in = &self.put_in;
        let measure = |i: usize, _, _| (x[i], change[i], put_in[i]);
        let way = |i: usize, y: f64| y - x[i];
        let (residual, y) = (&mut self.residual, &mut self.y);
        let (factors, is_newton) = (
            &self.factors,
            self.iteration.method() == CorrectionMethod::Newton,
        );
        let mut by_factors = |r: &mut [f64]| factors.solve(r);
        let solve: Option<LinearSolve<'_>> = match is_newton {
            true => Some(&mut by_factors),
            false => None,
        };
        let verdict = self
            .iteration
            .correct(residual, y, 1.0, measure, way, solve)?;
        if verdict != Verdict::Converged || !is_exact {
            return Ok(Progress::Iterates);
        }
        // The increment varies with y far more than the residual does: without its tangent the last
        // correction enters by one more evaluation.
        self.is_last = !self.is_newton() && self.residual.iter().any(|r| *r != 0.0);
        Ok(if self.is_last {
            Progress::Iterates
        } else {
            Progress::Solved
        })
    }

    /// Writes the increment α̂ − β̂ at the solution, and keeps y − x. By `change` = D((α̂−β̂)∘L) the increment holds
    /// Newton's last correction to first order.
    ///
    /// # Errors
    /// [`StepError::OtherBranch`] where y is not of a step from x with this increment.
    pub(super) fn finish(
        &mut self,
        x: &[f64],
        ends: &[f64],
        change: &[f64],
        increment: &mut [f64],
    ) -> Result<(), StepError> {
        let d = x.len();
        for i in 0..d {
            let first_order: f64 = if self.is_newton() {
                let row = &change[i * d..][..d];
                row.iter().zip(&self.residual).map(|(k, r)| k * r).sum()
            } else {
                0.0
            };
            increment[i] = ends[2 * d + i] + first_order;
            self.displacement[i] = self.y[i] - x[i];
        }
        if !increment.iter().all(|v| v.is_finite()) {
            return Err(StepError::OF_INCREMENT);
        }
        if !is_between(x, &self.y, increment) {
            return Err(StepError::OtherBranch { reached: 0.0 });
        }
        Ok(())
    }

    /// Remembers y − x for the steps to come.
    pub(super) fn record(&mut self) {
        self.extrapolation
            .record(self.displacement.as_chunks_mut().0, &[true]);
    }

    pub(super) fn operations(&self) -> u64 {
        self.linear + self.iteration.operations()
    }
}
