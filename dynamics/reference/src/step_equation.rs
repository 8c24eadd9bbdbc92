//! The equation of an implicit step, solved on the branch that begins at a step of size 0.
//!
//! Many equations are first solved by fixed points, without a matrix. Where these converge plainly, at a rate of at most 1/2, the
//! solution is that of the branch. Elsewhere Newton's method takes the step.

use leafwise_core::StepError;
use leafwise_core::solver::judge::{Verdict, all_finite};
use leafwise_core::solver::{
    Branch, CorrectionMethod, DenseFactors, Iteration, LinearSolve, MANY_EQUATIONS,
    elimination_operations, substitution_operations,
};

/// Budget of one solve by Newton's method, and of one without Jacobians.
const MOST_EVALUATIONS: usize = 50;
const MOST_ACCELERATED: usize = 100;

/// Budget of one that Newton's method follows: a rate of 1/2 takes 53, fewer with acceleration, and more where waves are narrow.
const MOST_PLAIN: usize = 60;

/// r(u) = 0 for the unknowns u of a step, which are 0 for a step of size 0.
pub(crate) trait StepEquation {
    /// The step's size t.
    fn time_step(&mut self) -> &mut f64;
    /// Writes r(u) and, for Newton's method, −Dr(u), row-major; `matrix` is empty for iterations without it.
    fn linearize(
        &mut self,
        unknowns: &[f64],
        residual: &mut [f64],
        matrix: &mut [f64],
    ) -> Result<(), StepError>;
    /// The change of the state in a row, for the last u.
    fn change(&self, row: usize) -> f64;
    /// Scales against which a row of a correction is measured, for the last u: the state, its change, and what the
    /// round-off of the others puts into it.
    fn measure(&self, row: usize) -> (f64, f64, f64);
    /// How much an unknown counts in the state.
    fn unit(&self) -> f64;
}

/// The unknowns and their iteration.
pub(crate) struct StepSolve {
    pub(crate) unknowns: Vec<f64>,
    pub(crate) iteration: Iteration,
    /// r, then a correction; −Dr and its factors.
    residual: Vec<f64>,
    matrix: Vec<f64>,
    pub(crate) factors: DenseFactors,
    /// Room for the path to the solution that is connected with 0.
    branch: Branch,
    nothing: Vec<f64>,
    sizes: Vec<f64>,
    /// The iteration that is tried before Newton's, and its start.
    plain: Option<(Iteration, Vec<f64>)>,
    /// Whether the last solve was by it.
    is_plain: bool,
    /// Operations of the solves.
    linear: u64,
}

impl StepSolve {
    /// For n unknowns, of an equation with a Jacobian or without.
    pub(crate) fn new(n: usize, has_jacobian: bool) -> Self {
        let (method, linear) = match has_jacobian {
            true => (CorrectionMethod::Newton, n),
            false => (CorrectionMethod::Acceleration, 0),
        };
        Self {
            unknowns: vec![0.0; n],
            iteration: Iteration::new(method, n),
            residual: vec![0.0; n],
            matrix: vec![0.0; linear * linear],
            factors: DenseFactors::new(linear),
            branch: Branch::new(linear),
            nothing: vec![0.0; linear],
            sizes: vec![0.0; linear],
            plain: None,
            is_plain: false,
            linear: 0,
        }
    }

    /// The same, trying fixed points u ← u + r(u) first where there are [`MANY_EQUATIONS`] and a Jacobian.
    #[must_use]
    pub(crate) fn plainly_first(mut self) -> Self {
        let n = self.unknowns.len();
        if self.has_jacobian() && n >= MANY_EQUATIONS {
            let iteration = Iteration::new(CorrectionMethod::Acceleration, n);
            self.plain = Some((iteration, vec![0.0; n]));
        }
        self
    }

    /// Whether the last solve was by fixed points: the residual was added to the unknowns.
    pub(crate) fn is_by_residuals(&self) -> bool {
        self.is_plain || !self.has_jacobian()
    }

    /// u ← u + r(u), without acceleration.
    ///
    /// # Errors
    /// Those of the equation.
    pub(crate) fn add_residual(
        &mut self,
        equation: &mut impl StepEquation,
    ) -> Result<(), StepError> {
        equation.linearize(&self.unknowns, &mut self.residual, &mut [])?;
        for (unknown, residual) in self.unknowns.iter_mut().zip(&self.residual) {
            *unknown += residual;
        }
        Ok(())
    }

    /// Whether the last solve ended as a whole alone.
    pub(crate) fn is_rounded(&self) -> bool {
        match &self.plain {
            Some((plain, _)) if self.is_plain => plain.is_rounded(),
            _ => self.iteration.is_rounded(),
        }
    }

    pub(crate) fn has_jacobian(&self) -> bool {
        self.iteration.method() == CorrectionMethod::Newton
    }

    /// Solves for a step from the state x, beginning at the last solution; returns the evaluations. By Newton's
    /// method the solution is the one connected with a step of size 0.
    pub(crate) fn solve(
        &mut self,
        equation: &mut impl StepEquation,
        x: &[f64],
    ) -> Result<usize, StepError> {
        let tried = self.solve_plainly(equation, x);
        if self.is_plain {
            return Ok(tried);
        }
        self.iteration.begin_step();
        let mut solved = self.iterate(equation, x);
        if self.has_jacobian() && (solved.is_err() || self.iteration.wanders()) {
            solved = self.settle(solved, equation, x);
        }
        solved.map(|evaluations| tried + evaluations)
    }

    /// Tries fixed points where they come first; returns the evaluations. The unknowns are the solution where `is_plain` says
    /// so, and those of before elsewhere.
    fn solve_plainly(&mut self, equation: &mut impl StepEquation, x: &[f64]) -> usize {
        self.is_plain = false;
        let Some((plain, start)) = &mut self.plain else {
            return 0;
        };
        start.copy_from_slice(&self.unknowns);
        let unit = equation.unit();
        let size = |row: usize| x[row % x.len()].abs() + unit * start[row].abs();
        plain.begin(MOST_PLAIN, size);
        let verdict = loop {
            if let Err(error) = equation.linearize(&self.unknowns, &mut self.residual, &mut []) {
                break Err(error);
            }
            plain.take_changes(|row| equation.change(row));
            let verdict = plain.correct(
                &mut self.residual,
                &mut self.unknowns,
                unit,
                |row, _, _| equation.measure(row),
                |_, unknown| unit * unknown,
                None,
            );
            if !matches!(verdict, Ok(Verdict::Continue)) {
                break verdict;
            }
        };
        self.is_plain = verdict.is_ok() && plain.is_plain();
        if !self.is_plain {
            self.unknowns.copy_from_slice(start);
        }
        plain.evaluations()
    }

    fn iterate(&mut self, equation: &mut impl StepEquation, x: &[f64]) -> Result<usize, StepError> {
        let (n, unit) = (self.unknowns.len(), equation.unit());
        let most = match self.has_jacobian() {
            true => MOST_EVALUATIONS,
            false => MOST_ACCELERATED,
        };
        let unknowns = &self.unknowns;
        let size = |row: usize| x[row % x.len()].abs() + unit * unknowns[row].abs();
        self.iteration.begin(most, size);
        loop {
            equation.linearize(&self.unknowns, &mut self.residual, &mut self.matrix)?;
            self.iteration.take_changes(|row| equation.change(row));
            if self.has_jacobian() {
                self.linear += elimination_operations(n) + substitution_operations(n);
                self.take_sizes(equation);
                if !(self.factors).factor_of_sizes(&self.matrix, &self.sizes) {
                    return Err(StepError::NonFinite {
                        what: "a correction of the step's equation",
                    });
                }
                self.iteration.take_factors(&self.factors);
                self.factors.solve(&mut self.residual);
            }
            let factors = match self.iteration.method() {
                CorrectionMethod::Newton => Some(&self.factors),
                _ => None,
            };
            let mut by_factors = |residual: &mut [f64]| self.factors.solve(residual);
            let solve: Option<LinearSolve<'_>> = match factors {
                Some(_) => Some(&mut by_factors),
                None => None,
            };
            let verdict = self.iteration.correct(
                &mut self.residual,
                &mut self.unknowns,
                unit,
                |row, _, _| {
                    let (state, change, put_in) = equation.measure(row);
                    let left = factors.map_or(1.0, |factors| factors.left(row));
                    (state, change, left * put_in)
                },
                |_, unknown| unit * unknown,
                solve,
            )?;
            if verdict == Verdict::Converged {
                return Ok(self.iteration.evaluations());
            }
        }
    }

    /// The state in units of the unknowns.
    fn take_sizes(&mut self, equation: &impl StepEquation) {
        let unit = equation.unit();
        for (row, size) in self.sizes.iter_mut().enumerate() {
            *size = equation.measure(row).0.abs() / unit;
        }
    }

    /// Makes sure that what was `solved` is the solution that begins at 0, and takes that where another or none was
    /// found.
    #[cold]
    fn settle(
        &mut self,
        solved: Result<usize, StepError>,
        equation: &mut impl StepEquation,
        x: &[f64],
    ) -> Result<usize, StepError> {
        self.take_sizes(equation);
        let whole = *equation.time_step();
        let mut spent = 0;
        let settled = self.branch.settle(
            &self.nothing,
            &self.sizes,
            solved.clone().map(|_| &self.unknowns[..]),
            &mut spent,
            |part, point, residual, matrix| {
                *equation.time_step() = part * whole;
                equation.linearize(point, residual, matrix)?;
                all_finite(residual, matrix, "a correction of the step's equation")
            },
        );
        *equation.time_step() = whole;
        let spent = spent as usize;
        if settled? {
            return solved.map(|evaluations| evaluations + spent);
        }
        self.unknowns.copy_from_slice(self.branch.end());
        let evaluations = self.iterate(equation, x)?;
        self.branch.confirm_end(&self.unknowns)?;
        Ok(evaluations + spent)
    }

    /// Factors −Dr at the solution; `false` where it is singular or there is none.
    pub(crate) fn factor(&mut self, equation: &mut impl StepEquation) -> bool {
        let (residual, matrix) = (&mut self.residual, &mut self.matrix);
        let is_defined = equation.linearize(&self.unknowns, residual, matrix);
        if is_defined.is_err() || !self.has_jacobian() {
            return false;
        }
        self.take_sizes(equation);
        (self.factors).factor_of_sizes(&self.matrix, &self.sizes)
    }

    pub(crate) fn operations(&self) -> u64 {
        let plain = self.plain.as_ref().map_or(0, |own| own.0.operations());
        self.linear + self.iteration.operations() + plain
    }

    /// Forgets earlier solves.
    pub(crate) fn restart(&mut self) {
        self.unknowns.fill(0.0);
        self.iteration.restart();
    }

    /// Memory that the next solve depends on: one number of the iteration, then the unknowns.
    pub(crate) fn memory(&self) -> Vec<f64> {
        [&[self.iteration.memory()], self.unknowns.as_slice()].concat()
    }

    /// Restores [`memory`](Self::memory).
    pub(crate) fn restore(&mut self, memory: &[f64]) {
        self.iteration.restore(memory[0]);
        self.unknowns.copy_from_slice(&memory[1..]);
    }
}
