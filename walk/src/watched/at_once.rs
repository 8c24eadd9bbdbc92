//! Many steps of one lane before they are looked at, invariants at all of their states at once.

use std::cell::Cell;

use leafwise_core::walk::Checkpoint;
use leafwise_core::{BuildError, SolverStatistics, Walk};

use super::Watched;
use crate::batch::Batch;
use crate::domain::outside;
use crate::fault::Fault;
use crate::look::{Look, Steps};

/// Where a batch begins.
struct Begin {
    walk: Checkpoint,
    statistics: SolverStatistics,
}

impl Watched<'_> {
    /// The number of steps that may be made before they are looked at.
    pub(super) fn at_once(&self) -> u64 {
        let most = self.batch.as_ref().map_or(1, |batch| batch.most as u64);
        most.min(self.course.steps.saturating_sub(self.walk.steps()))
    }

    /// So many steps of the one lane, then the looks at each, as if they had been made one by one.
    pub(super) fn steps_at_once<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        count: u64,
        take: &mut F,
    ) -> Result<(), E> {
        let Some(mut batch) = self.batch.take() else {
            return self.step(take);
        };
        let outcome = self.steps_of(&mut batch, count, take);
        self.batch = Some(batch);
        outcome?;
        if self.walk.steps() == self.course.steps {
            self.arrive()?;
        }
        self.report(take)
    }

    fn steps_of<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        batch: &mut Batch,
        count: u64,
        take: &mut F,
    ) -> Result<(), E> {
        let begin = Begin {
            walk: self.walk.checkpoint(),
            statistics: self.statistics(),
        };
        let is_whole = batch
            .record(count as usize, |record| {
                self.walk.advance_with(count, record)
            })
            .is_ok();
        let made = (self.walk.steps() - begin.walk.steps) as usize;
        if made == 0 {
            self.take_failures();
            return Ok(());
        }
        batch.evaluate(made, self.earlier.evaluations);
        let mut lost = None;
        if !batch.are_finite(made) {
            let (course, before) = (self.course, begin.walk.steps);
            let is_lost = |at: &usize| {
                course.looks_at(before + *at as u64 + 1)
                    && !batch.is_finite(*at)
                    && self.is_outside(batch.state(*at))
            };
            lost = (0..made).find(is_lost);
        }
        let steps = Steps {
            before: begin.walk.steps,
            count: lost.unwrap_or(made),
            batch,
            course: self.course,
            taken: Cell::new(0),
        };
        if steps.count > 0
            && let Err(error) = take(Look::Steps(&steps))
        {
            self.go_back(&begin, steps.taken.get() as u64);
            return Err(error);
        }
        if let Some(lost) = lost {
            let at = steps.at(lost);
            self.go_back(&begin, lost as u64 + 1);
            take(Look::Made(at))?;
            take(Look::Step {
                at,
                invariants: None,
                goes_on: true,
            })?;
            self.fail(0, Fault::Outside, at.steps);
            return Ok(());
        }
        if !is_whole {
            self.take_failures();
        }
        Ok(())
    }

    /// Whether a state is outside the energy's domain.
    fn is_outside(&mut self, state: &[f64]) -> bool {
        let invariants = &mut self.invariants;
        let is_nan = |state: &[f64], is_nan: &mut Vec<bool>| {
            is_nan.push(invariants.at(state)[0].is_nan());
        };
        outside(state, 1, is_nan) == [true]
    }

    /// Steps again from the beginning of a batch, so many steps: the walk stands where the looks have come to, with the work up to there.
    fn go_back(&mut self, begin: &Begin, steps: u64) {
        let (course, parameters) = (self.course, self.alones.parameters());
        let (epsilon, h) = (course.epsilon, course.h);
        let mut walk = Walk::new(self.map, parameters, epsilon, h, &begin.walk.state);
        if !self.members.is_empty() {
            walk.follow(&self.members);
        }
        let restored = walk.restore(&begin.walk);
        debug_assert!(restored.is_ok(), "it is of the same method");
        // They were made before.
        let again = walk.advance(steps);
        debug_assert!(again.is_ok(), "the same steps have the same bits");
        self.earlier = begin.statistics;
        self.walk = walk;
    }
}
