//! The step loop: one step of all lanes, and the looks at it in their order.

mod acts;
mod at_once;
mod corners;
mod crossed;
mod deviations;
mod lanes;
mod looks;
pub(crate) mod memory;

use leafwise_core::{BuildError, SolverStatistics, StepMap, Walk};

use self::lanes::{EventLanes, StopLanes};
use crate::alone::Alones;
use crate::batch::Batch;
use crate::course::Course;
use crate::fault::{Ended, Fault, Why};
use crate::functions::FunctionValues;
use crate::indicators::Deviations;
use crate::look::{At, Look};
use crate::pace::PacedSteps;
use crate::step::StepStart;

/// A [`Walk`] of one or of several lanes on its [`Course`]: a lane comes to what it would come to alone.
pub struct Watched<'a> {
    course: &'a Course,
    walk: Walk,
    /// Where the last step begins, in all lanes; nothing where no state between is asked for.
    start: StepStart,
    invariants: FunctionValues,
    stop: Option<StopLanes<'a>>,
    events: Vec<EventLanes<'a>>,
    paced: Vec<PacedSteps>,
    /// The number of the next sample at a time, for each lane.
    next: Vec<u64>,
    ends: Vec<Option<Ended>>,
    /// Room for the states of ends: that of earlier ones.
    room: Vec<Vec<f64>>,
    /// The lanes that have made the last step, and go on from there by their pace.
    moved: Vec<bool>,
    /// Lanes that have ended, and that nobody has heard of.
    fresh: Vec<usize>,
    alones: Alones<'a>,
    map: &'a dyn StepMap,
    /// The members that lanes are, where they are told.
    members: Vec<u64>,
    /// Where many steps are made before they are looked at.
    batch: Option<Batch>,
    /// The work of a stepper that was given up.
    earlier: SolverStatistics,
    /// Vectors that indicators of chaos follow.
    deviations: Option<Deviations<'a>>,
    /// Lanes whose leaf has too few dimensions for them.
    flat: Vec<usize>,
}

impl<'a> Watched<'a> {
    /// `lanes` at their initial states with their parameters, both structures of arrays.
    ///
    /// # Errors
    /// Returns [`BuildError`] where a function of the course has no evaluator.
    ///
    /// # Panics
    /// Panics where there is no lane. Panics too where a state has another dimension than the map.
    pub fn new(
        course: &'a Course,
        map: &'a dyn StepMap,
        lanes: usize,
        (parameters, initial): (&[f64], &[f64]),
    ) -> Result<Self, BuildError> {
        let own = (parameters, initial);
        let walk = Walk::side_by_side(map, lanes, own, course.epsilon, course.h);
        let mut watched = Self {
            course,
            start: StepStart::default(),
            invariants: course.invariants.values(lanes, parameters)?,
            stop: StopLanes::of(course, lanes, parameters)?,
            events: EventLanes::of(course, lanes, parameters)?,
            paced: vec![PacedSteps::default(); lanes],
            next: vec![1; lanes],
            ends: vec![None; lanes],
            room: Vec::new(),
            moved: vec![false; lanes],
            fresh: Vec::new(),
            batch: Batch::of(course, map.dimension(), (lanes, parameters))?,
            alones: Alones::new(course, map, (lanes, parameters)),
            walk,
            map,
            members: Vec::new(),
            earlier: SolverStatistics::default(),
            deviations: (course.indicators.as_ref())
                .map(|of| Deviations::new(of, map.dimension(), (lanes, parameters)))
                .transpose()?,
            flat: Vec::new(),
        };
        watched.stand();
        Ok(watched)
    }

    /// Starts again with other parameters and initial states, in as many lanes: a new walk, to the bit. What steps and looks are made
    /// with stays.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Panics
    /// As [`new`](Self::new).
    pub fn start_again(
        &mut self,
        (parameters, initial): (&[f64], &[f64]),
    ) -> Result<(), BuildError> {
        self.walk.start_again(self.map, (parameters, initial));
        self.invariants.set_parameters(parameters)?;
        if let Some(stop) = &mut self.stop {
            stop.values.set_parameters(parameters)?;
        }
        for event in &mut self.events {
            event.values.set_parameters(parameters)?;
            event.counts.fill(0);
        }
        if let Some(batch) = &mut self.batch {
            batch.set_parameters(parameters)?;
        }
        if let Some(deviations) = &mut self.deviations {
            deviations.set_parameters(parameters)?;
        }
        self.alones.set_parameters(parameters);
        self.paced.fill(PacedSteps::default());
        self.next.fill(1);
        let ends = self.ends.iter_mut().filter_map(Option::take);
        self.room.extend(ends.map(|ended| ended.state));
        self.fresh.clear();
        self.members.clear();
        self.earlier = SolverStatistics::default();
        self.stand();
        Ok(())
    }

    /// Takes in where the lanes begin.
    fn stand(&mut self) {
        let (course, state) = (self.course, self.walk.state());
        if let Some(pace) = &course.pace {
            // H + e is measured from e at the beginning.
            let lanes = self.walk.lanes();
            let origins = &state[pace.clock.energy * lanes..][..lanes];
            self.invariants.measure_from(origins);
        }
        if course.looks_between() {
            self.start.keep(&self.walk);
        }
        for event in &mut self.events {
            event.begin(state);
        }
        if let Some(stop) = &mut self.stop {
            stop.begin(state);
        }
        if let Some(deviations) = &mut self.deviations {
            self.flat = deviations.begin(state);
        }
        self.mark_moved();
    }

    /// Says which member of an ensemble each lane is: steps with noise draw that member's numbers.
    pub fn follow(&mut self, members: &[u64]) {
        self.walk.follow(members);
        self.members.clear();
        self.members.extend_from_slice(members);
    }

    /// Leaves a lane out.
    pub fn leave_out(&mut self, lane: usize) {
        self.walk.rest(lane);
    }

    /// The states that are stepped.
    pub fn walk(&self) -> &Walk {
        &self.walk
    }

    /// The course.
    pub fn course(&self) -> &'a Course {
        self.course
    }

    /// The invariants after the last step: invariant i of lane w at `[i*lanes + w]`.
    pub fn invariants(&mut self) -> &[f64] {
        self.invariants.at(self.walk.state())
    }

    /// The time after the last step, in one lane.
    pub fn time(&self, lane: usize) -> f64 {
        match &self.course.pace {
            None => self.walk.time(),
            Some(pace) => self.walk.state()[pace.clock.time * self.walk.lanes() + lane],
        }
    }

    /// Whether every lane has ended, or come to the end of the course.
    pub fn is_at_end(&self) -> bool {
        let mut lanes = 0..self.walk.lanes();
        lanes.all(|lane| !self.walk.lives(lane) || self.is_there(lane))
    }

    /// Whether a lane has come to the end of the course.
    fn is_there(&self, lane: usize) -> bool {
        match (&self.course.pace, self.course.until) {
            (Some(_), Some(until)) => !self.course.is_before(self.time(lane), until),
            _ => self.walk.steps() >= self.course.steps,
        }
    }

    /// Where and why a lane has ended.
    pub fn ended(&self, lane: usize) -> Option<&Ended> {
        self.ends[lane].as_ref()
    }

    /// The least and the largest time of a step in one lane, where they differ by a pace.
    pub fn step_times(&self, lane: usize) -> Option<[f64; 2]> {
        let PacedSteps { least, most, .. } = self.paced[lane];
        (most > 0.0).then_some([least, most])
    }

    /// The solver's work so far, over all lanes.
    pub fn statistics(&self) -> SolverStatistics {
        self.earlier.and(self.walk.statistics())
    }

    /// Looks whether the condition holds after the last step, unless it has ended the walk: the first thing behind
    /// [`restore`](Self::restore).
    ///
    /// # Errors
    /// [`BuildError`] where a function has no evaluator.
    pub fn look_again(&mut self) -> Result<(), BuildError> {
        match self.walk.steps() {
            0 => Ok(()),
            _ if self.ends[0].is_some() => Ok(()),
            _ => self.look_for_stops(),
        }
    }

    /// Looks at the states where a session begins: the lanes that end at their initial states. After
    /// [`restore`](Self::restore), looks at the last step for events and times behind the end of a shorter walk.
    ///
    /// # Errors
    /// Those of `take`. Returns [`BuildError`] where a function has no evaluator.
    pub fn begin<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        take: &mut F,
    ) -> Result<(), E> {
        let steps = self.walk.steps();
        if !self.invariants().iter().all(|value| value.is_finite()) {
            for (lane, is_outside) in self.outside().into_iter().enumerate() {
                if is_outside && self.walk.lives(lane) {
                    self.fail(lane, Fault::Outside, steps);
                }
            }
        }
        if steps == 0 {
            self.end_flat();
            self.look_at_initial_states();
        } else {
            self.look_for_events(take)?;
            self.take_times(take)?;
        }
        self.arrive()?;
        self.report(take)
    }

    /// Up to `steps` steps of every lane that goes on, and the looks at each.
    ///
    /// # Errors
    /// Those of `take`, and [`BuildError`] where a function has no evaluator.
    pub fn advance<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        steps: u64,
        take: &mut F,
    ) -> Result<(), E> {
        let mut left = steps;
        while left > 0 && self.walk.living() > 0 {
            let many = self.at_once().min(left);
            match many {
                0 | 1 => self.step(take)?,
                _ => self.steps_at_once(many, take)?,
            }
            left -= many.max(1);
        }
        Ok(())
    }

    /// One step of every lane that goes on, and the looks at it.
    ///
    /// # Errors
    /// Those of `take`, and [`BuildError`] where a function has no evaluator.
    pub fn step<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        take: &mut F,
    ) -> Result<(), E> {
        let looks_between = self.course.looks_between();
        if looks_between {
            self.start.keep(&self.walk);
        }
        if let Some(deviations) = &mut self.deviations {
            deviations.keep(&self.walk);
        }
        if self.walk.step().is_err() {
            self.look_for_stops_on_the_way()?;
            self.take_failures();
        }
        self.follow_deviations();
        if self.walk.living() > 0 {
            take(Look::Made(self.here()))?;
            self.look(looks_between, take)?;
        }
        self.report(take)
    }

    /// The looks at the last step, in their order.
    fn look<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        looks_between: bool,
        take: &mut F,
    ) -> Result<(), E> {
        let steps = self.walk.steps();
        if looks_between {
            self.look_at_paces()?;
            self.mark_moved();
            self.act(take)?;
            self.look_for_stops()?;
            self.look_for_events(take)?;
        }
        let is_last = self.course.pace.is_none() && steps == self.course.steps;
        let (is_some_inside, lost) = match self.course.looks_at(steps) {
            true => self.look_at_invariants(),
            false => (false, Vec::new()),
        };
        take(Look::Step {
            at: self.here(),
            invariants: is_some_inside.then(|| self.invariants.last()),
            goes_on: self.walk.living() > 0,
        })?;
        if looks_between {
            self.take_times(take)?;
        }
        for lane in lost {
            self.fail(lane, Fault::Outside, steps);
        }
        if is_last || self.course.pace.is_some() {
            self.arrive()?;
        }
        Ok(())
    }

    /// The states after the last step.
    fn here(&self) -> At<'_> {
        At {
            steps: self.walk.steps(),
            time: self.time(0),
            state: self.walk.state(),
            evaluations: self.earlier.evaluations + self.walk.evaluations(),
            indicators: self.indicators(),
        }
    }

    /// Hands over the lanes that have ended.
    fn report<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        take: &mut F,
    ) -> Result<(), E> {
        for lane in self.fresh.drain(..) {
            if let Some(ended) = &self.ends[lane] {
                take(Look::Ended { lane, ended })?;
            }
        }
        Ok(())
    }

    fn mark_moved(&mut self) {
        for lane in 0..self.moved.len() {
            self.moved[lane] = self.walk.lives(lane);
        }
    }

    /// The state of a lane after the last step, while that goes on or has just ended.
    fn present(&mut self, lane: usize) -> Vec<f64> {
        let mut own = self.room.pop().unwrap_or_default();
        let all = self.walk.state().iter();
        own.clear();
        own.extend(all.skip(lane).step_by(self.walk.lanes()));
        own
    }

    fn end(&mut self, lane: usize, ended: Ended) {
        self.walk.rest(lane);
        if self.ends[lane].replace(ended).is_none() {
            self.fresh.push(lane);
        }
    }

    /// Ends a lane that cannot go on from its present state, which so many steps have led to.
    fn fail(&mut self, lane: usize, fault: Fault, steps: u64) {
        let state = self.present(lane);
        let ended = Ended {
            why: Why::Failed(fault),
            steps,
            time: self.course.time(steps, &state),
            state,
            is_between: false,
        };
        self.end(lane, ended);
    }

    fn take_failures(&mut self) {
        for (lane, error) in self.walk.failed().to_vec() {
            if self.ends[lane].is_some() {
                continue;
            }
            let (steps, state) = self.walk.last(lane);
            let ended = Ended {
                why: Why::Failed(error.into()),
                steps,
                time: self.course.time(steps, &state),
                state,
                is_between: false,
            };
            self.end(lane, ended);
        }
    }
}
