//! The linear iteration y ← y − (β̂(L(y)) − x).

use std::sync::Arc;

use super::program::{LatticeEvaluator, LatticeProgram};
use super::stages::MethodFields;
use crate::error::StepError;
use crate::solver::judge::{Verdict, Watch, is_between, larger, largest, relative};
use crate::solver::{CorrectionMethod, Extrapolation, Iteration, StepReport, Trajectories};

/// Budget of one step. At t‖DX‖ = 1 the iteration gains a factor of about two each time.
const MOST_EVALUATIONS: usize = 200;

/// Rows that are corrected and measured at a time.
const ROWS: usize = 64;

/// Levels of differences that the start is extrapolated from, a number a coordinate each.
const EXTRAPOLATION: usize = 7;

/// A point of the path is solved to this part of the largest coordinate.
const NEAR: f64 = 1e-9;

/// Two points that differ by less than this part of the largest coordinate are the same solution. At a rate of 9/10
/// a correction below [`NEAR`] leaves less than a hundredth of it.
const SAME: f64 = 1e-6;

/// On the path the largest of so many corrections in a row never grows: else the way passes by a fold, to another
/// solution. More than one in a row, as fields correct each other in turns.
const IN_A_ROW: usize = 3;

/// The smallest part of the path that is tried.
const SHORTEST: f64 = 1.0 / 1024.0;

/// Solves β̂(L(y)) = x by a linear iteration without any Jacobian: O(N) a step. The rate of the iteration is the size
/// of D(β̂∘L) − 1 = O(t).
///
/// The *stop* comes when what the next correction would add is below a small part of an ulp, judged by the observed
/// rate. It also comes when the corrections stagnate at round-off.
///
/// The *branch* is followed where the iteration is slow or its start missed half of the way. Steps s times as long
/// are then solved from s = 0 on, each from the one before. Where the iteration converges, every eigenvalue of
/// D(β̂∘L) has a positive real part: none of these solutions is beyond a fold. Where corrections grow it passed one
/// by.
pub(super) struct LatticeTrajectory {
    program: Arc<LatticeProgram>,
    fields: MethodFields,
    parameters: Vec<f64>,
    epsilon: f64,
    h: f64,
    evaluator: LatticeEvaluator,
    extrapolation: Extrapolation,
    /// y − x.
    displacement: Vec<f64>,
    /// Displacement y − x that was predicted, where the solve starts.
    start: Vec<f64>,
    /// Of the residuals alone, row after row: no room for unknowns.
    iteration: Iteration,
    /// Whether the last solve ended as a whole alone.
    is_rounded: bool,
    watch: Watch,
    /// Room for the path, made when it is first asked for.
    path: Option<Box<Path>>,
    evaluations: u64,
}

/// Displacements along the path, and the solution that was found before it.
struct Path {
    before: Vec<f64>,
    at_once: Vec<f64>,
    found: Vec<f64>,
    y: Vec<f64>,
}

impl Path {
    fn new(dimension: usize) -> Self {
        let [before, at_once, found, y] = std::array::from_fn(|_| vec![0.0; dimension]);
        Self {
            before,
            at_once,
            found,
            y,
        }
    }
}

/// Purpose of a solve: the step itself, or a point of the path to its solution.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Step,
    /// A point of the path.
    Point,
}

impl LatticeTrajectory {
    pub(super) fn new(
        program: &Arc<LatticeProgram>,
        fields: MethodFields,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let evaluator = program.evaluator(parameters, epsilon, h);
        let dimension = evaluator.field(fields.y).len();
        Self {
            program: Arc::clone(program),
            fields,
            parameters: parameters.to_vec(),
            epsilon,
            h,
            evaluator,
            extrapolation: Extrapolation::new(dimension, EXTRAPOLATION),
            displacement: vec![0.0; dimension],
            start: vec![0.0; dimension],
            iteration: Iteration::new(CorrectionMethod::Residual, 0),
            is_rounded: false,
            watch: Watch::NEW,
            path: None,
            evaluations: 0,
        }
    }

    /// Iterates from the displacement that is there.
    fn iterate(&mut self, x: &[f64], low: &[f64], purpose: Purpose) -> Result<(), StepError> {
        let Self {
            evaluator,
            displacement,
            iteration,
            fields,
            ..
        } = self;
        let size = largest(x) + largest(displacement);
        iteration.begin(MOST_EVALUATIONS, |_| size);
        let (mut last, mut smallest) = ([f64::INFINITY; IN_A_ROW], f64::INFINITY);
        loop {
            let y = evaluator.field_mut(fields.y);
            for ((y, x), displacement) in y.iter_mut().zip(x).zip(&*displacement) {
                *y = x + displacement;
            }
            self.program.run(evaluator);
            self.evaluations += 1;
            let (offset, change) = (
                evaluator.field(fields.offset),
                evaluator.field(fields.increment),
            );
            let y = evaluator.field(fields.y);
            let mut finite = true;
            let largest_change = largest(change);
            iteration.take_changes(|_| largest_change);
            for start in (0..displacement.len()).step_by(ROWS) {
                let end = displacement.len().min(start + ROWS);
                let (x, y, low) = (&x[start..end], &y[start..end], &low[start..end]);
                let (offset, change) = (&offset[start..end], &change[start..end]);
                let displacement = &mut displacement[start..end];
                let [mut corrections, mut scales] = [[0.0; ROWS]; 2];
                for i in 0..displacement.len() {
                    // x − y is exact: they are close.
                    let correction = (x[i] - y[i]) - offset[i] + low[i];
                    displacement[i] = (y[i] - x[i]) + correction;
                    finite &= correction.is_finite() && change[i].is_finite();
                    corrections[i] = correction;
                    scales[i] = iteration.scale(0, x[i], change[i], 0.0);
                }
                let rows = ..displacement.len();
                iteration.take_rows(&corrections[rows], &scales[rows]);
            }
            let size = iteration.size().norm();
            let verdict = iteration.judge()?;
            if !finite {
                return Err(StepError::NonFinite {
                    what: "a correction of the lattice",
                });
            }
            let is_near = purpose == Purpose::Point && size <= NEAR;
            if is_near || verdict == Verdict::Converged {
                self.is_rounded = iteration.is_rounded();
                return Ok(());
            }
            if purpose == Purpose::Point && size > smallest {
                return Err(StepError::NoConvergence {
                    evaluations: iteration.evaluations(),
                    correction: size,
                });
            }
            last.rotate_left(1);
            last[IN_A_ROW - 1] = size;
            smallest = smallest.min(largest(&last));
        }
    }

    /// One solve of the step from the displacement that is there.
    fn solve(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.iterate(x, low, Purpose::Step)?;
        if let Some(reach) = self.fields.reach {
            let ratio = largest(self.evaluator.field(reach));
            if ratio.is_nan() || ratio >= 1.0 {
                return Err(StepError::LeftChart { ratio });
            }
        }
        let change = self.evaluator.field(self.fields.increment);
        if !is_between(x, self.evaluator.field(self.fields.y), change) {
            return Err(StepError::OtherBranch { reached: 0.0 });
        }
        increment.copy_from_slice(change);
        Ok(())
    }

    /// One step: from the extrapolated start, and where that leaves open to which solution it leads, along the path.
    fn advance(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.watch.begin();
        self.extrapolation.predict(self.start.as_chunks_mut().0);
        self.displacement.copy_from_slice(&self.start);
        let mut solved = self.solve(x, low, increment);
        self.watch.take(self.iteration.is_slow());
        // As a whole: small coordinates behind a front are never foreseen.
        let state = largest(x);
        let off = relative(apart(&self.displacement, &self.start), state);
        self.watch
            .take_start(off, relative(largest(&self.displacement), state));
        if solved.is_err() || self.watch.wanders() {
            solved = self.settle(solved, x, low, increment);
        }
        solved?;
        self.extrapolation
            .record(self.displacement.as_chunks_mut().0, &[true]);
        Ok(())
    }

    /// Makes sure that the solution is the one connected with the state, and takes that where the solve found another
    /// or none.
    #[cold]
    fn settle(
        &mut self,
        solved: Result<(), StepError>,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
    ) -> Result<(), StepError> {
        let dimension = x.len();
        let mut path = self
            .path
            .take()
            .unwrap_or_else(|| Box::new(Path::new(dimension)));
        path.found.copy_from_slice(&self.displacement);
        path.y.copy_from_slice(self.evaluator.field(self.fields.y));
        let is_rounded = self.is_rounded;
        let followed = self.follow(&mut path, x, low);
        self.prepare(1.0);
        let outcome = match (followed, solved) {
            (Ok(()), Ok(())) if is_same(&self.displacement, &path.found, x) => {
                self.displacement.copy_from_slice(&path.found);
                self.evaluator
                    .field_mut(self.fields.y)
                    .copy_from_slice(&path.y);
                self.is_rounded = is_rounded;
                Ok(())
            }
            (Ok(()), _) => {
                // The extrapolated start led astray.
                self.extrapolation.clear(0);
                path.before.copy_from_slice(&self.displacement);
                self.solve(x, low, increment).and_then(|()| {
                    match is_same(&self.displacement, &path.before, x) {
                        true => Ok(()),
                        false => Err(StepError::OtherBranch { reached: 1.0 }),
                    }
                })
            }
            (Err(reached), Ok(())) => Err(StepError::OtherBranch { reached }),
            (Err(_), Err(error)) => Err(error),
        };
        self.path = Some(path);
        outcome
    }

    /// Goes the path from y = x to the solution of the whole step, which then is the displacement; else tells the part
    /// of the step that was reached.
    fn follow(&mut self, path: &mut Path, x: &[f64], low: &[f64]) -> Result<(), f64> {
        self.displacement.fill(0.0);
        let (mut reached, mut part) = (0.0, 1.0);
        loop {
            let goal = reached + part;
            if self.go(path, x, low, (reached, goal)) {
                if goal >= 1.0 {
                    return Ok(());
                }
                reached = goal;
                part = (2.0 * part).min(1.0 - reached);
            } else if part > SHORTEST {
                part *= 0.5;
            } else {
                return Err(reached);
            }
        }
    }

    /// From the solution at `reached` to that at `goal`, at once and by way of the middle: both ways hardly lead to the
    /// same wrong solution. Stays where they do not meet.
    fn go(&mut self, path: &mut Path, x: &[f64], low: &[f64], (reached, goal): (f64, f64)) -> bool {
        path.before.copy_from_slice(&self.displacement);
        let mut is_met = self.approach(goal, x, low);
        if is_met {
            path.at_once.copy_from_slice(&self.displacement);
            self.displacement.copy_from_slice(&path.before);
            is_met = self.approach(0.5 * (reached + goal), x, low)
                && self.approach(goal, x, low)
                && is_same(&self.displacement, &path.at_once, x);
        }
        if !is_met {
            self.displacement.copy_from_slice(&path.before);
        }
        is_met
    }

    /// The solution of a step s times as long, from the displacement that is there; whether there is one.
    fn approach(&mut self, s: f64, x: &[f64], low: &[f64]) -> bool {
        self.prepare(s);
        self.iterate(x, low, Purpose::Point).is_ok()
    }

    /// Makes the evaluator that of steps s times as long.
    fn prepare(&mut self, s: f64) {
        let Self {
            parameters,
            epsilon,
            h,
            ..
        } = self;
        self.program
            .prepare_again(&mut self.evaluator, parameters, *epsilon, s * *h);
    }
}

/// max |aᵢ − bᵢ|.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |m, (a, b)| larger(m, (a - b).abs()))
}

/// Whether two displacements from x are of one solution.
fn is_same(a: &[f64], b: &[f64], x: &[f64]) -> bool {
    apart(a, b) <= SAME * (largest(x) + largest(a))
}

impl Trajectories for LatticeTrajectory {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let taken = &mut taken[0];
        let before = self.evaluations;
        taken.outcome = self.advance(x, low, increment);
        taken.evaluations += self.evaluations - before;
        taken.is_rounded = self.is_rounded;
    }

    fn solution(&self, _: usize) -> Option<&[f64]> {
        Some(self.evaluator.field(self.fields.y))
    }

    fn operations(&self) -> Option<u64> {
        Some(self.evaluations * self.program.work())
    }

    fn restart(&mut self, _: usize) {
        self.extrapolation.clear(0);
        self.watch = Watch::NEW;
    }

    fn memory(&self, _: usize) -> Vec<f64> {
        let mut memory = Vec::with_capacity(1 + self.extrapolation.memory_len());
        memory.push(self.watch.memory());
        self.extrapolation.memory(0, &mut memory);
        memory
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.watch.restore(memory[0]);
        self.extrapolation.restore(0, &memory[1..]);
    }
}
