//! The corrections of one solve, whatever equation it is of.

use super::judge::{
    Allowed, CorrectionSize, LinearIteration, LinearSolve, ROUND_OFF, Reached, Verdict, Watch,
    larger, relative,
};
use super::{Anderson, DenseFactors};
use crate::error::StepError;

/// A residual that is added so often and more falls at a rate above 1/2.
const PLAIN_EVALUATIONS: usize = 60;

/// Where corrections come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CorrectionMethod {
    /// The residual and its Jacobian.
    Newton,
    /// The residual itself, where the Jacobian is near the identity.
    Residual,
    /// The residual with Anderson's acceleration, for parts without Jacobians.
    Acceleration,
}

/// u ← u + δ, until what a further correction would add is negligible.
///
/// The caller forms δ from its equation: the residual, by Newton's method with the Jacobian. Row i of δ is measured
/// against |state| + |change|. The change counts [as far as it serves](Allowed) as a scale, row by row: units of rows
/// change nothing. The measured sizes are judged by observed rates (`judge/linear.rs`). Newton's method also keeps a [`Watch`] on
/// whether its solution is plainly on the branch that begins at the state.
#[derive(Clone, Debug)]
pub struct Iteration {
    method: CorrectionMethod,
    corrections: LinearIteration,
    /// Of each row; one for all of them where there are as many as lattices have.
    allowed: Vec<Allowed>,
    watch: Watch,
    size: CorrectionSize,
    scales: Vec<f64>,
    reached: Reached,
    anderson: Option<Anderson>,
}

impl Iteration {
    /// For n unknowns that [`correct`](Self::correct) corrects.
    pub fn new(method: CorrectionMethod, n: usize) -> Self {
        Self {
            method,
            corrections: LinearIteration::new(0),
            allowed: vec![Allowed::new(0.0); n.max(1)],
            watch: Watch::NEW,
            size: CorrectionSize::default(),
            scales: vec![0.0; n],
            reached: Reached::new(n),
            anderson: (method == CorrectionMethod::Acceleration).then(|| Anderson::new(n)),
        }
    }

    /// Where the corrections come from.
    pub fn method(&self) -> CorrectionMethod {
        self.method
    }

    /// The same for n unknowns.
    pub fn resize(&mut self, n: usize) {
        self.scales = vec![0.0; n];
        self.reached = Reached::new(n);
        self.allowed = vec![Allowed::new(0.0); n.max(1)];
        if let Some(anderson) = &mut self.anderson {
            anderson.resize(n);
        }
    }

    /// Takes the corrections from elsewhere; accelerates them only if it was made for that.
    pub fn set_method(&mut self, method: CorrectionMethod) {
        self.method = method;
    }

    /// Begins a step.
    pub fn begin_step(&mut self) {
        self.watch.begin();
    }

    /// Begins a solve with a budget of evaluations; `size` is that of the state and of the change that it starts from, in a
    /// row.
    pub fn begin(&mut self, most: usize, size: impl Fn(usize) -> f64) {
        self.corrections = LinearIteration::new(most);
        for (row, allowed) in self.allowed.iter_mut().enumerate() {
            *allowed = Allowed::new(size(row));
        }
        self.size = CorrectionSize::default();
        self.watch.begin_solve();
        if let Some(anderson) = &mut self.anderson {
            anderson.clear();
        }
    }

    /// Takes in the change of the state in each row at the present iterate.
    pub fn take_changes(&mut self, change: impl Fn(usize) -> f64) {
        for (row, allowed) in self.allowed.iter_mut().enumerate() {
            allowed.take(change(row).abs());
        }
    }

    /// Takes in the factors of a new Jacobian.
    pub fn take_factors(&mut self, factors: &DenseFactors) {
        self.watch.take(!factors.is_near_identity());
    }

    /// |state| + |change| + `put_in`: the scale that a row is measured against. The last, `put_in`, is what the
    /// round-off of the others [leaves](super::judge::settled) in it.
    #[inline(always)]
    pub fn scale(&self, row: usize, state: f64, change: f64, put_in: f64) -> f64 {
        self.allowed[row].scale(state, change, put_in)
    }

    /// Takes in one row of a correction by Newton's method, to be judged [beside the others](Self::judge_newton).
    #[inline(always)]
    pub fn take_row(&mut self, row: usize, correction: f64, scale: f64) {
        self.scales[row] = scale;
        self.size.take(correction, scale);
    }

    /// Takes in one row of a correction.
    #[inline(always)]
    pub fn take(&mut self, correction: f64, scale: f64) {
        self.size.take(correction, scale);
    }

    /// [`take`](Self::take) of many rows.
    #[inline(always)]
    pub fn take_rows(&mut self, corrections: &[f64], scales: &[f64]) {
        self.size.take_rows(corrections, scales);
    }

    /// Takes in how far a row's unknown has come since the start of the step.
    #[inline(always)]
    pub fn take_way(&mut self, way: f64, scale: f64) {
        self.size.take_way(way, scale);
    }

    /// Judges the rows that were taken in, each beside its own scale.
    ///
    /// # Errors
    /// [`StepError::NonFinite`] for a correction that is not finite, [`StepError::NoConvergence`] when the budget is
    /// spent.
    pub fn judge(&mut self) -> Result<Verdict, StepError> {
        let size = std::mem::take(&mut self.size);
        match self.method {
            CorrectionMethod::Newton => self.judge_beside(&size, || f64::INFINITY),
            _ => self.corrections.judge_correction(&size),
        }
    }

    /// Judges the rows of a correction by Newton's method, which counts `unit` times in the state. Where rows make no
    /// progress, they are compared with what the round-off of all that are settled puts into them. `solve` replaces a
    /// residual by its correction.
    ///
    /// # Errors
    /// Those of [`judge`](Self::judge).
    pub fn judge_newton(
        &mut self,
        corrections: &[f64],
        unit: f64,
        solve: LinearSolve<'_>,
    ) -> Result<Verdict, StepError> {
        let size = std::mem::take(&mut self.size);
        let (scales, mut reached) = (
            std::mem::take(&mut self.scales),
            std::mem::replace(&mut self.reached, Reached::new(0)),
        );
        let beside = || {
            for (row, own) in reached.sizes.iter_mut().enumerate() {
                let is_settled = relative(unit * corrections[row], scales[row]) <= ROUND_OFF;
                *own = if is_settled { scales[row] } else { 0.0 };
            }
            reached.add(solve);
            let rows = corrections.iter().zip(&reached.sizes);
            rows.fold(0.0, |all, (correction, size)| {
                larger(all, relative(unit * correction, *size))
            })
        };
        let verdict = self.judge_beside(&size, beside);
        (self.scales, self.reached) = (scales, reached);
        verdict
    }

    fn judge_beside(
        &mut self,
        size: &CorrectionSize,
        beside: impl FnOnce() -> f64,
    ) -> Result<Verdict, StepError> {
        self.watch.take_correction(size);
        let verdict = self.corrections.judge_beside(size.component(), beside)?;
        if verdict == Verdict::Converged {
            self.watch.take_end(size);
        }
        Ok(verdict)
    }

    /// Adds the corrections, accelerated where the method says so, to the unknowns, and judges them. The closure
    /// `measure(i, u, δ)` returns (state, change, what the others put in) of a row. How far the row has come with the
    /// unknown u is `way(i, u)`. A correction counts `unit` times in the state. Of Newton's method
    /// `solve` replaces a residual by its correction.
    ///
    /// # Errors
    /// Those of [`judge`](Self::judge).
    pub fn correct(
        &mut self,
        corrections: &mut [f64],
        unknowns: &mut [f64],
        unit: f64,
        measure: impl Fn(usize, f64, f64) -> (f64, f64, f64),
        way: impl Fn(usize, f64) -> f64,
        solve: Option<LinearSolve<'_>>,
    ) -> Result<Verdict, StepError> {
        for (i, correction) in corrections.iter().enumerate() {
            let (state, change, put_in) = measure(i, unknowns[i], *correction);
            self.scales[i] = self.scale(i, state, change, put_in);
            self.size.take(unit * correction, self.scales[i]);
        }
        if let (CorrectionMethod::Acceleration, Some(anderson)) = (self.method, &mut self.anderson)
        {
            anderson.correct(corrections, &self.scales);
            for (correction, scale) in corrections.iter().zip(&self.scales) {
                self.size.take(unit * correction, *scale);
            }
        }
        for (unknown, correction) in unknowns.iter_mut().zip(&*corrections) {
            *unknown += correction;
        }
        let Some(solve) = solve else {
            return self.judge();
        };
        for (i, unknown) in unknowns.iter().enumerate() {
            self.size.take_way(way(i, *unknown), self.scales[i]);
        }
        self.judge_newton(corrections, unit, solve)
    }

    /// The rows taken in since they were judged last.
    pub fn size(&self) -> CorrectionSize {
        self.size
    }

    /// Evaluations of this solve.
    pub fn evaluations(&self) -> usize {
        self.corrections.evaluations()
    }

    /// Whether the solve ended as a whole alone: a component still changed.
    pub fn is_rounded(&self) -> bool {
        self.corrections.is_rounded()
    }

    /// Whether the iteration without acceleration converges at a rate above 1/2, or not at all: its Jacobian is then not
    /// near the identity.
    pub fn is_slow(&self) -> bool {
        match (self.method, &self.anderson) {
            (CorrectionMethod::Acceleration, Some(anderson)) => {
                anderson.rate().is_nan() || anderson.rate() > 0.5
            }
            _ => self.evaluations() > PLAIN_EVALUATIONS,
        }
    }

    /// Whether the iteration without acceleration converges at a rate of at most 1/2, as far as that is no round-off. Its
    /// solution is then that on the branch that begins at the state.
    pub fn is_plain(&self) -> bool {
        let rate = self.anderson.as_ref().map(Anderson::rate_of_whole);
        rate.is_some_and(|rate| rate <= 0.5)
    }

    /// Watch that tells whether the solution is plainly on the branch that begins at the state. Without Newton's
    /// method the caller keeps it.
    pub fn watch(&mut self) -> &mut Watch {
        &mut self.watch
    }

    /// Whether the solution is not plainly on the branch that begins at the state.
    pub fn wanders(&self) -> bool {
        self.watch.wanders()
    }

    /// Operations of the acceleration so far, as [`SolverStatistics::operations`] counts them.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    pub fn operations(&self) -> u64 {
        self.anderson.as_ref().map_or(0, Anderson::operations)
    }

    /// Forgets earlier steps.
    pub fn restart(&mut self) {
        self.watch = Watch::NEW;
    }

    /// Memory between steps: the number of its [`Watch`], on which the next step depends.
    pub fn memory(&self) -> f64 {
        self.watch.memory()
    }

    /// Restores [`memory`](Self::memory).
    pub fn restore(&mut self, memory: f64) {
        self.watch.restore(memory);
    }
}
