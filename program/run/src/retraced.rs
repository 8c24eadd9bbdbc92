//! The states of a run at any times, stepped again from the nearest one that is kept.

use std::collections::VecDeque;

use leafwise_core::Walk;
use leafwise_core::walk::Checkpoint;
use leafwise_scene::compose::ComposedRun;
use leafwise_walk::{LastStep, is_same_time};

use super::outcome::Failure;

/// Numbers that the kept states hold at most: 32 MiB.
const MOST_NUMBERS: usize = 1 << 22;

/// States that are kept at most, however small they are, and at least, however large.
const MOST_KEPT: usize = 1024;
const LEAST_KEPT: usize = 8;

/// States before the times that were asked for last: neighbours begin there.
const RECENT: usize = 16;

/// Steps between two looks whether to go on.
const STRIDE: u64 = 256;

/// Why there is no state.
#[derive(Clone, Debug, PartialEq)]
pub enum Retrace {
    /// It was asked to stop.
    Interrupted,
    /// A step on the way could not be taken.
    Failed(Failure),
}

/// The states of a run between and at its steps: the bits of its samples at given times.
///
/// It steps as far as it was asked for, and keeps states on the way, every 2^k steps. A time takes at most as many
/// steps as lie between two kept states, about a thousandth of the run. One near an earlier time takes a few.
pub struct Retraced {
    run: ComposedRun,
    walk: Walk,
    kept: Vec<Checkpoint>,
    every: u64,
    most: usize,
    recent: VecDeque<Checkpoint>,
    steps: u64,
}

impl Retraced {
    /// Nothing is stepped yet; `None` where steps are of another time than the states', and where events change these.
    pub fn of(run: ComposedRun) -> Option<Self> {
        if run.pace().is_some() || run.plan.events.act.is_some() {
            return None;
        }
        let walk = run.walk();
        let first = walk.checkpoint();
        let numbers = 2 * first.state.len() + first.memory.len();
        Some(Self {
            most: (MOST_NUMBERS / numbers.max(1)).clamp(LEAST_KEPT, MOST_KEPT),
            run,
            walk,
            kept: vec![first],
            every: 1,
            recent: VecDeque::new(),
            steps: 0,
        })
    }

    /// The steps that were made so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The state at a time on the way of the run, the scene's own coordinates.
    ///
    /// # Errors
    /// A step that could not be taken, and `goes_on`, where it says no.
    pub fn at(
        &mut self,
        time: f64,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<f64>, Retrace> {
        let plan = &self.run.plan;
        let step = plan.epsilon * plan.h;
        let time_of = |steps: u64| steps as f64 * step;
        let is_before = |steps: u64| (time - time_of(steps)) * step >= 0.0;
        let mut before = (time / step).max(0.0) as u64;
        while before > 0 && !is_before(before) {
            before -= 1;
        }
        while is_before(before + 1) {
            before += 1;
        }
        let is_met = |steps: u64| is_same_time(time_of(steps), time);
        if !is_met(before) && is_met(before + 1) {
            before += 1;
        }
        self.reach(before, goes_on)?;
        let walk = &self.walk;
        if is_met(before) {
            return Ok(self.run.own(walk.state()).to_vec());
        }
        let parameters = self.run.system.parameter_values();
        let (map, plan) = (self.run.method.map(), &self.run.plan);
        let mut last = LastStep::new(map, parameters, plan.epsilon, plan.h);
        last.start.keep(walk);
        self.steps += 1;
        match last.state_at(before + 1, time) {
            Ok(state) => Ok(self.run.own(&state).to_vec()),
            Err(error) => Err(self.failure(&error)),
        }
    }

    /// Brings the walk to a number of steps.
    fn reach(&mut self, steps: u64, goes_on: &mut dyn FnMut() -> bool) -> Result<(), Retrace> {
        let own = Some(self.walk.steps()).filter(|own| *own <= steps);
        let kept = (steps / self.every).min(self.kept.len() as u64 - 1) as usize;
        let all = self.recent.iter().chain(std::iter::once(&self.kept[kept]));
        let nearest = all
            .filter(|one| one.steps <= steps)
            .max_by_key(|one| one.steps);
        if let Some(nearest) = nearest.filter(|one| own.is_none_or(|own| own < one.steps)) {
            let restored = self.walk.restore(nearest);
            debug_assert!(restored.is_ok(), "it is of the same method");
        }
        while self.walk.steps() < steps {
            if !goes_on() {
                return Err(Retrace::Interrupted);
            }
            let (at, next) = (self.walk.steps(), self.kept.len() as u64 * self.every);
            let stop = if at < next { steps.min(next) } else { steps };
            let advanced = self.walk.advance((stop - at).min(STRIDE));
            self.steps += self.walk.steps() - at;
            if let Err(error) = advanced {
                return Err(self.failure(&error));
            }
            if self.walk.steps() == next {
                self.keep();
            }
        }
        if !self.recent.iter().any(|one| one.steps == steps) {
            self.recent.truncate(RECENT - 1);
            self.recent.push_front(self.walk.checkpoint());
        }
        Ok(())
    }

    /// Keeps the present state, every other one of them where there are too many.
    fn keep(&mut self) {
        self.kept.push(self.walk.checkpoint());
        if self.kept.len() > self.most {
            let mut number = 0_u64;
            self.kept.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.every *= 2;
        }
    }

    fn failure(&self, error: &leafwise_core::StepError) -> Retrace {
        let (steps, time) = (self.walk.steps(), self.walk.time());
        let state = self.run.own(self.walk.state());
        Retrace::Failed(Failure::of_step(error, &self.run, steps, time, state))
    }
}
