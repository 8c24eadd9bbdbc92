//! Steps that are made at once, as often as asked for.

use leafwise_expression::kernel::apart;

use super::Block;
use super::at_once::{End, Program};
use crate::elimination::{Rows, dimension};
use crate::error::StepError;
use crate::{SolverStatistics, StepCheck, StepRecord};

/// A check of every step, and a record of where each leads.
type Onlookers<'a, 'c, 'r, 's> = (
    &'a mut Option<&'c mut dyn StepCheck>,
    &'a mut Option<&'r mut StepRecord<'s>>,
);

impl<const W: usize, const D: usize, V: Rows<W>, M: Rows<W>> Block<W, D, V, M> {
    /// Makes steps of a lane alone at once as long as they are likely to be of one or two evaluations, up to `steps`; returns
    /// how many. Behind a step that is longer, or not plain, all is as it was before it.
    pub(super) fn run_at_once(
        &mut self,
        steps: u64,
        work: &mut SolverStatistics,
        check: &mut Option<&mut dyn StepCheck>,
        record: &mut Option<&mut StepRecord<'_>>,
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
            let (more, end) = self.repeat(
                program,
                needs_two,
                steps - made,
                work,
                (check, record),
                &mut outcome,
            );
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
        let inputs = program.inputs::<W>();
        let vectors = [self.x.as_ref(), self.low.as_ref(), last];
        for (inputs, vector) in inputs.chunks_exact_mut(d).zip(vectors) {
            copy(inputs, vector);
        }
        true
    }

    /// Takes the state and what the next step depends on from the inputs of that.
    fn take_over(&mut self, program: &mut Program) {
        let d = dimension::<D>(self.dimension);
        let mut vectors = program.inputs::<W>().chunks_exact(d);
        let mut take = |own: &mut V| {
            let vector = vectors.next().expect("three vectors");
            copy(own.as_mut(), vector);
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
        (check, record): Onlookers<'_, '_, '_, '_>,
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
            let needs_other = next.convergence.foresees_two(lane.convergence.first) != needs_two;
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
            if let Some(record) = record {
                record.take(inputs[..d].as_flattened(), work.evaluations);
            }
            if needs_other {
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
                    let before = self.lanes[0].convergence.first;
                    own.needs_two = lane.convergence.foresees_two(before);
                    self.lanes[0] = lane;
                    self.outcome[0] = Ok(());
                    copy(self.increment.as_mut(), corrected.increment);
                    copy(self.y.as_mut(), corrected.solution);
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

/// Row by row.
#[inline(always)]
fn copy<const W: usize>(to: &mut [[f64; W]], from: &[[f64; W]]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
        apart::<W>();
    }
}
