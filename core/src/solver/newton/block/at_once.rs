//! Steps that are made at once.

use std::sync::Arc;

use leafwise_expression::{Kernel, Workspace, kernel::apart};

use super::masks::is_inside;
use super::{Block, Lane};
use crate::error::StepError;
use crate::solver::elimination::{Rows, dimension};
use crate::solver::judge::{WANDERING, larger, relative};
use crate::solver::newton::at_once::Corrected;
use crate::solver::newton::convergence::Next;
use crate::solver::newton::kernel::NewtonKernel;
use crate::solver::{SolverStatistics, StepCheck};

/// The steps of a lane alone as one kernel each.
pub(super) struct AtOnce {
    /// Those of one and of two evaluations.
    programs: [Program; 2],
    /// Whether the next step is taken to need two.
    needs_two: bool,
    /// Whether the last step was of one or two, with one Jacobian.
    is_likely: bool,
}

struct Program {
    kernel: Arc<Kernel>,
    workspace: Workspace,
}

impl AtOnce {
    /// `None` where the kernel has no such steps.
    pub(super) fn new(
        newton: &NewtonKernel,
        prepared: impl Fn(&Kernel) -> Workspace,
    ) -> Option<Box<Self>> {
        let kernels = newton.at_once.as_ref()?;
        let programs = kernels.each_ref().map(|kernel| Program {
            kernel: Arc::clone(kernel),
            workspace: prepared(kernel),
        });
        Some(Box::new(Self {
            programs,
            needs_two: false,
            is_likely: false,
        }))
    }

    /// Prepares the kernels anew by `prepare`; returns whether a coefficient has changed.
    pub(super) fn prepare(&mut self, prepare: impl Fn(&Kernel, &mut Workspace) -> bool) -> bool {
        let mut changes = false;
        for Program { kernel, workspace } in &mut self.programs {
            changes |= prepare(kernel, workspace);
        }
        changes
    }

    /// Takes in a step that was made one evaluation after the other.
    pub(super) fn learn(&mut self, lane: &Lane, is_ok: bool) {
        let evaluations = lane.convergence.evaluations;
        self.is_likely = is_ok && lane.jacobians == 1 && evaluations <= 2;
        self.needs_two = evaluations == 2;
    }
}

/// Why steps at once end.
enum End {
    /// There were as many as asked for.
    Made,
    /// The next one needs the other kernel.
    Other,
    /// The next one is longer, or not plain.
    Another,
}

impl<const W: usize, const D: usize, V: Rows<W>, M: Rows<W>> Block<W, D, V, M> {
    /// Makes steps of a lane alone at once as long as they are likely to be of one or two evaluations, up to `steps`; returns
    /// how many. Behind a step that is longer, or not plain, all is as it was before it.
    pub(super) fn run_at_once(
        &mut self,
        steps: u64,
        work: &mut SolverStatistics,
        check: &mut Option<&mut dyn StepCheck>,
    ) -> (u64, Result<(), StepError>) {
        let mut made = 0;
        let Some(mut own) = self.at_once.take() else {
            return (0, Ok(()));
        };
        let mut outcome = Ok(());
        while own.is_likely && made < steps && outcome.is_ok() {
            let needs_two = own.needs_two;
            let program = &mut own.programs[usize::from(needs_two)];
            if !self.hand_over(program) {
                break;
            }
            let (more, end) =
                self.repeat(program, needs_two, steps - made, work, check, &mut outcome);
            made += more;
            match end {
                End::Made => {}
                End::Other => own.needs_two = !needs_two,
                End::Another => own.is_likely = false,
            }
        }
        self.at_once = Some(own);
        (made, outcome)
    }

    /// Writes the inputs of a step; `false` where no solution is known before it.
    fn hand_over(&mut self, program: &mut Program) -> bool {
        let d = dimension::<D>(self.dimension);
        let Some(last) = self.start.last_known() else {
            return false;
        };
        let (inputs, _) = program.kernel.rows_mut::<W>(&mut program.workspace);
        let vectors = [self.x.as_ref(), self.low.as_ref(), last];
        for (inputs, vector) in inputs.chunks_exact_mut(d).zip(vectors) {
            inputs.copy_from_slice(vector);
        }
        true
    }

    /// Takes the state and what the next step depends on from the inputs of that.
    fn take_over(&mut self, program: &mut Program) {
        let d = dimension::<D>(self.dimension);
        let (inputs, _) = program.kernel.rows_mut::<W>(&mut program.workspace);
        let mut vectors = inputs.chunks_exact(d);
        let mut take = |own: &mut V| {
            let vector = vectors.next().expect("three vectors");
            own.as_mut().copy_from_slice(vector);
        };
        take(&mut self.x);
        take(&mut self.low);
        take(&mut self.y);
        self.start.take_solution(self.y.as_ref());
    }

    /// Steps by one kernel.
    #[inline(never)]
    fn repeat(
        &mut self,
        program: &mut Program,
        needs_two: bool,
        steps: u64,
        work: &mut SolverStatistics,
        check: &mut Option<&mut dyn StepCheck>,
        outcome: &mut Result<(), StepError>,
    ) -> (u64, End) {
        let d = dimension::<D>(self.dimension);
        let most_chords = self.most_chords;
        let mut lane = self.lanes[0];
        let mut made = 0;
        let end = loop {
            if made == steps {
                break End::Made;
            }
            let tried = program.step::<W>(lane, d, needs_two, most_chords);
            let (inputs, next, corrected) = match tried {
                Ok(step) => step,
                Err(end) => break end,
            };
            if let Some(check) = check {
                let (x, increment) = (inputs[..d].as_flattened(), corrected.increment);
                let outcome = std::slice::from_mut(outcome);
                check.check(x, increment.as_flattened(), outcome);
            }
            lane = next;
            work.count(lane.convergence.evaluations.into(), true);
            for i in 0..d {
                if outcome.is_ok() {
                    inputs[i] = corrected.new[0][i];
                    apart::<W>();
                    inputs[d + i] = corrected.new[1][i];
                    apart::<W>();
                }
                inputs[2 * d + i] = corrected.solution[i];
                apart::<W>();
            }
            if outcome.is_err() {
                break End::Another;
            }
            made += 1;
            if needs_two && lane.convergence.evaluations == 1 {
                break End::Other;
            }
        };
        if made > 0 || outcome.is_err() {
            self.lanes[0] = lane;
            self.take_over(program);
        }
        (made, end)
    }

    /// The increment of one step at once; `false`, and all is as it was, where that is not likely or not so.
    pub(super) fn increment_at_once(&mut self) -> bool {
        let Some(mut own) = self.at_once.take() else {
            return false;
        };
        let d = dimension::<D>(self.dimension);
        let mut is_made = false;
        while own.is_likely && !is_made {
            let needs_two = own.needs_two;
            let program = &mut own.programs[usize::from(needs_two)];
            if !self.hand_over(program) {
                break;
            }
            match program.step::<W>(self.lanes[0], d, needs_two, self.most_chords) {
                Ok((_, lane, corrected)) => {
                    own.needs_two = lane.convergence.evaluations == 2;
                    self.lanes[0] = lane;
                    self.outcome[0] = Ok(());
                    self.increment.as_mut().copy_from_slice(corrected.increment);
                    self.y.as_mut().copy_from_slice(corrected.solution);
                    self.start.take_solution(corrected.solution);
                    is_made = true;
                }
                Err(End::Other) => own.needs_two = true,
                Err(End::Made | End::Another) => own.is_likely = false,
            }
        }
        self.at_once = Some(own);
        is_made
    }
}

/// A step at once: its inputs, the lane behind it, and its last correction.
type Step<'own, const W: usize> = (&'own mut [[f64; W]], Lane, Corrected<'own, W>);

impl Program {
    /// Makes a step from the inputs as they stand, judged as those of a lane are.
    #[inline(always)]
    fn step<const W: usize>(
        &mut self,
        mut lane: Lane,
        d: usize,
        has_two: bool,
        most_chords: u32,
    ) -> Result<Step<'_, W>, End> {
        self.kernel.evaluate_own_rows::<W>(&mut self.workspace);
        let (inputs, rows) = self.kernel.rows_mut::<W>(&mut self.workspace);
        let inputs = &mut inputs[..3 * d];
        lane.watch.begin();
        lane.convergence.start(None, most_chords);
        let is_near = rows[0][0] > 0.0;
        if lane.watch.wanders() || !is_near {
            return Err(End::Another);
        }
        (lane.next, lane.jacobians, lane.is_anchor_far) = (Next::Done, 1, false);
        let mut corrected = Corrected::of(rows, 0, d);
        let mut next = judge(&mut lane, &corrected, true, most_chords);
        if next == Next::Chord {
            if !has_two {
                return Err(End::Other);
            }
            corrected = Corrected::of(rows, 1, d);
            next = judge(&mut lane, &corrected, false, most_chords);
        }
        if next != Next::Done || !is_inside(&corrected.guard, 0) {
            return Err(End::Another);
        }
        if lane.convergence.first > WANDERING {
            let mut way = 0.0;
            for i in 0..d {
                let (y, scale) = (corrected.solution[i][0], corrected.scale[i][0]);
                way = larger(way, relative(y - inputs[i][0], scale));
            }
            lane.watch.take_start(lane.convergence.first, way);
            if lane.watch.wanders() {
                return Err(End::Another);
            }
        }
        Ok((inputs, lane, corrected))
    }
}

/// What comes after a correction; an evaluation with a Jacobian where it is no number, or does not fall.
#[inline(always)]
fn judge<const W: usize>(
    lane: &mut Lane,
    corrected: &Corrected<'_, W>,
    is_newton: bool,
    most_chords: u32,
) -> Next {
    let size = corrected.size[0];
    let falls = size < 0.5 * lane.convergence.last || size <= WANDERING;
    if corrected.finite[0] != 0.0 || !falls {
        return Next::Newton;
    }
    // No correction is the third that does not shrink.
    let norm = || f64::INFINITY;
    lane.convergence.judge(size, norm, is_newton, most_chords)
}
