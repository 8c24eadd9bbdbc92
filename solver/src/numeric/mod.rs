//! Solver for parts that compute numbers, not code. Several trajectories are solved in lockstep where both parts serve
//! that.
//!
//! The modules:
//!
//! - [`evaluation`]: both maps and their tangents at the points of all that iterate.
//! - [`solve`]: the equation of one trajectory, between the evaluations that it asks for.

mod evaluation;
mod solve;

use evaluation::{By, Evaluation};
use solve::MOST_EVALUATIONS;
pub use solve::{Progress, Solve};

use super::judge::all_finite;
use super::{Branch, CorrectionMethod, StepReport, Trajectories};
use crate::Correction;
use crate::error::StepError;
use crate::evaluator::Evaluator;

/// Solves β̂(L(y)) = x with evaluators of a realization and a bisection.
///
/// The correction is the residual itself where D(β̂∘L) is near the identity (a collective integrator over a good
/// realization), and where an evaluator offers no tangents. Elsewhere it is Newton's, with the tangents of both
/// evaluators. D(β̂∘L) = 1 + O(εh), so that residuals converge for small steps.
pub struct NumericSolver {
    evaluation: Evaluation,
    correction: Correction,
    corrections: CorrectionMethod,
    dimension: usize,
    trajectories: Vec<Solve>,
    /// Those that iterate, in the order of the evaluation's points.
    active: Vec<usize>,
    /// D(β̂∘L) and D((α̂−β̂)∘L) of one of them.
    target: Vec<f64>,
    change: Vec<f64>,
    /// Room for the path to a trajectory's solution.
    branch: Branch,
    first: Vec<f64>,
}

impl NumericSolver {
    /// For `count` trajectories in M of `dimension` d, by points of S of `space` coordinates: of several
    /// by evaluators that are pointwise.
    pub fn new(
        (realization, bisection): (Box<dyn Evaluator>, Box<dyn Evaluator>),
        (dimension, space): (usize, usize),
        (correction, corrections): (Correction, CorrectionMethod),
        count: usize,
    ) -> Self {
        let d = dimension;
        Self {
            evaluation: Evaluation::new((realization, bisection), (d, space), count),
            correction,
            corrections,
            dimension,
            trajectories: (0..count).map(|_| Solve::new(corrections, d)).collect(),
            active: Vec::with_capacity(count),
            target: vec![0.0; d * d],
            change: vec![0.0; d * d],
            branch: Branch::new(if corrections == CorrectionMethod::Newton {
                d
            } else {
                0
            }),
            first: vec![0.0; d],
        }
    }

    /// One round of evaluations, after which some no longer iterate.
    fn advance(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let d = self.dimension;
        for (place, at) in self.active.iter().enumerate() {
            self.evaluation.place(place, &self.trajectories[*at].y);
            taken[*at].evaluations += u64::from(!self.trajectories[*at].is_last);
        }
        let newton = self.corrections == CorrectionMethod::Newton;
        self.evaluation.evaluate(&mut self.active, taken, newton);
        let is_exact = self.evaluation.is_exact;
        if let By::Approach { begins } = &mut self.evaluation.by {
            *begins = false;
        }
        let mut place = 0;
        self.active.retain(|&at| {
            let (own, taken) = (&mut self.trajectories[at], &mut taken[at]);
            let (from, to) = (at * d, (at + 1) * d);
            let (x, low, increment) = (&x[from..to], &low[from..to], &mut increment[from..to]);
            let ends = self.evaluation.ends(place);
            if newton {
                let (target, change) = (&mut self.target, &mut self.change);
                own.linear += self.evaluation.tangents(place, target, change);
            }
            place += 1;
            match own.take((x, low), (ends, is_exact), &self.target) {
                Ok(Progress::Iterates) => true,
                Ok(Progress::Solved) => {
                    taken.evaluations += u64::from(own.is_last);
                    if let Err(error) = own.finish(x, ends, &self.change, increment) {
                        taken.fail(error);
                    }
                    false
                }
                Err(error) => {
                    taken.fail(error);
                    false
                }
            }
        });
    }

    /// Makes sure that a solution is the one connected with the state, and takes that where the solve
    /// found another or none. Without tangents the solve begins once more at the state itself.
    #[cold]
    fn settle(
        &mut self,
        at: usize,
        (x, low): (&[f64], &[f64]),
        increment: &mut [f64],
        taken: &mut [StepReport],
    ) {
        let d = self.dimension;
        let own = &mut self.trajectories[at];
        let state = &x[at * d..][..d];
        let solved = std::mem::replace(&mut taken[at].outcome, Ok(()));
        if self.corrections == CorrectionMethod::Newton {
            let (evaluation, active) = (&mut self.evaluation, &mut self.active);
            let (low, change) = (&low[at * d..][..d], &mut self.change);
            // −F at the state, of which less and less is left.
            let first = &mut self.first;
            let mut has_begun = false;
            let evaluate =
                |part: f64, point: &[f64], residual: &mut [f64], jacobian: &mut [f64]| {
                    evaluation.place(0, point);
                    active.clear();
                    active.push(0);
                    let mut alone = [StepReport::NOTHING];
                    evaluation.evaluate(active, &mut alone, true);
                    let [StepReport { outcome, .. }] = alone;
                    outcome?;
                    let ends = evaluation.ends(0);
                    for i in 0..d {
                        residual[i] = state[i] - ends[i] - ends[d + i] + low[i];
                    }
                    if !has_begun {
                        first.copy_from_slice(residual);
                        has_begun = true;
                    }
                    for (residual, first) in residual.iter_mut().zip(first.iter()) {
                        *residual -= (1.0 - part) * first;
                    }
                    evaluation.tangents(0, jacobian, change);
                    all_finite(residual, jacobian, "a Newton correction")
                };
            let spent = &mut taken[at].evaluations;
            let solved = solved.map(|()| &own.y[..]);
            match self.branch.settle(state, state, solved, spent, evaluate) {
                Ok(true) => return,
                Ok(false) => own.begin_at(state, self.branch.end(), MOST_EVALUATIONS),
                Err(error) => {
                    taken[at].outcome = Err(error);
                    return;
                }
            }
        } else if own.extrapolation.is_cold(0) {
            taken[at].outcome = solved;
            return;
        } else {
            own.begin_at(state, state, MOST_EVALUATIONS);
        }
        self.active.clear();
        self.active.push(at);
        while !self.active.is_empty() {
            self.advance(x, low, increment, taken);
        }
        if self.corrections == CorrectionMethod::Newton && taken[at].outcome.is_ok() {
            taken[at].outcome = self.branch.confirm_end(&self.trajectories[at].y);
        }
    }

    /// α̂(L(x)) − x.
    fn uncorrected(&mut self, x: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let d = self.dimension;
        for (place, at) in self.active.iter().enumerate() {
            taken[*at].evaluations = 1;
            let own = &mut self.trajectories[*at];
            own.y.copy_from_slice(&x[at * d..][..d]);
            self.evaluation.place(place, &own.y);
        }
        self.evaluation.evaluate(&mut self.active, taken, false);
        for (place, at) in self.active.iter().enumerate() {
            let ends = self.evaluation.ends(place);
            for i in 0..d {
                let place = at * d + i;
                increment[place] = (ends[i] - x[place]) + ends[d + i] + ends[2 * d + i];
            }
        }
    }
}

impl Trajectories for NumericSolver {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        self.active.clear();
        self.active.extend(0..self.trajectories.len());
        if self.correction == Correction::None {
            return self.uncorrected(x, increment, taken);
        }
        for (own, x) in self.trajectories.iter_mut().zip(x.chunks(self.dimension)) {
            own.begin(x);
        }
        // With residuals, the solve behind L goes on with that for y.
        if self.corrections == CorrectionMethod::Residual {
            self.evaluation.by = By::Approach { begins: true };
        }
        while !self.active.is_empty() {
            self.advance(x, low, increment, taken);
        }
        self.evaluation.by = By::Values;
        for at in 0..self.trajectories.len() {
            let is_open = match &taken[at].outcome {
                Ok(()) => {
                    self.corrections == CorrectionMethod::Newton
                        && self.trajectories[at].iteration.wanders()
                }
                Err(error) => {
                    error.is_of_a_solve() || matches!(error, StepError::OtherBranch { .. })
                }
            };
            if is_open {
                self.settle(at, (x, low), increment, taken);
            }
            taken[at].is_rounded = self.trajectories[at].iteration.is_rounded();
            if taken[at].outcome.is_ok() {
                self.trajectories[at].record();
            }
        }
    }

    fn solution(&self, at: usize) -> Option<&[f64]> {
        Some(&self.trajectories[at].y)
    }

    fn tangent(&mut self, at: usize) -> Option<Vec<f64>> {
        self.evaluation.place(0, &self.trajectories[at].y);
        let (mut active, mut taken) = (vec![0], [StepReport::NOTHING]);
        self.evaluation.evaluate(&mut active, &mut taken, true);
        if active.is_empty() {
            return None;
        }
        let (target, change) = (&mut self.target, &mut self.change);
        self.trajectories[at].linear += self.evaluation.tangents(0, target, change);
        if self.correction == Correction::None {
            let sum = self.target.iter().zip(&self.change);
            return Some(sum.map(|(t, c)| t + c).collect());
        }
        super::tangent_of_map(&self.target, &self.change, self.dimension)
    }

    fn operations(&self) -> Option<u64> {
        let own: u64 = self.trajectories.iter().map(Solve::operations).sum();
        Some(self.evaluation.operations()? + own)
    }

    fn restart(&mut self, at: usize) {
        self.trajectories[at].extrapolation.clear(0);
        self.trajectories[at].iteration.restart();
        self.evaluation.restart();
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        let mut memory = vec![self.trajectories[at].iteration.memory()];
        self.trajectories[at].extrapolation.memory(0, &mut memory);
        memory.extend(self.evaluation.memory());
        memory
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        self.trajectories[at].iteration.restore(memory[0]);
        let extrapolation = &mut self.trajectories[at].extrapolation;
        let (history, parts) = memory[1..].split_at(extrapolation.memory_len());
        extrapolation.restore(0, history);
        self.evaluation.restore(parts);
    }
}
