//! The compensated step loop.

use crate::compensation::two_sum;
use crate::error::StepError;
use crate::solver::{Setting, SolverStatistics, StepMap, StepRecord, Stepper};
use crate::system::PoissonSystem;

/// Trajectories of one step map, x_{k+1} = x_k + Δ_k, in one lane or in several side by side: a lane has the bits that it
/// would have alone.
///
/// States are compensated: what rounding takes from x_k + Δ_k is kept in a second double and enters the next step.
/// Round-off then grows like a random walk of steps' round-off, not of states'. Arrays are structures of arrays,
/// coordinate j of lane w at `[j*lanes + w]`; of one lane they are the state itself.
///
/// Of several lanes, one whose step fails rests at its last good state and disturbs no other. Its column goes on as a
/// copy of one that lives, which nobody reads. One lane alone stays where it is, and may try again.
pub struct Walk {
    stepper: Box<dyn Stepper>,
    lanes: usize,
    state: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    outcome: Vec<Result<(), StepError>>,
    rests: Vec<Option<Rest>>,
    living: usize,
    steps: u64,
    /// ε and h.
    step_sizes: (f64, f64),
    failed: Vec<(usize, StepError)>,
    /// The last states of lanes that rest; none before one does.
    last: Vec<f64>,
}

/// How a lane has come to rest.
struct Rest {
    steps: u64,
    error: Option<StepError>,
}

impl Walk {
    /// Starts one trajectory at `initial` with `parameters` and the step sizes ε and h.
    ///
    /// # Panics
    /// When `initial` does not have the map's dimension.
    pub fn new(
        map: &dyn StepMap,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
        initial: &[f64],
    ) -> Self {
        Self::side_by_side(map, 1, (parameters, initial), epsilon, h)
    }

    /// Starts `lanes` trajectories with parameters and initial states of their own. Both are structures of arrays.
    ///
    /// # Panics
    /// Without a lane, and when an initial state does not have the map's dimension.
    pub fn side_by_side(
        map: &dyn StepMap,
        lanes: usize,
        (parameters, initial): (&[f64], &[f64]),
        epsilon: f64,
        h: f64,
    ) -> Self {
        assert!(
            lanes > 0 && initial.len() == map.dimension() * lanes,
            "every initial state has the map's dimension"
        );
        Self {
            stepper: map.stepper(lanes, parameters, epsilon, h),
            lanes,
            state: initial.to_vec(),
            low: vec![0.0; initial.len()],
            increment: vec![0.0; initial.len()],
            outcome: vec![Ok(()); lanes],
            rests: (0..lanes).map(|_| None).collect(),
            living: lanes,
            steps: 0,
            step_sizes: (epsilon, h),
            failed: Vec::new(),
            last: Vec::new(),
        }
    }

    /// Starts again by the same map with other parameters and initial states, in as many lanes: a new walk, to the bit.
    /// Where the stepper takes other parameters, nothing is allocated.
    ///
    /// # Panics
    /// When an initial state does not have the map's dimension.
    pub fn start_again(&mut self, map: &dyn StepMap, (parameters, initial): (&[f64], &[f64])) {
        let (epsilon, h) = self.step_sizes;
        let stepper = &mut self.stepper;
        if !(stepper.set(Setting::Parameters(parameters)) && stepper.set(Setting::StepSize(h))) {
            *stepper = map.stepper(self.lanes, parameters, epsilon, h);
        }
        self.state.copy_from_slice(initial);
        self.low.fill(0.0);
        self.outcome.fill(Ok(()));
        self.go_on_from(0);
    }

    /// Lets every lane go on, after so many steps.
    fn go_on_from(&mut self, steps: u64) {
        self.steps = steps;
        self.rests.fill_with(|| None);
        self.living = self.lanes;
        self.failed.clear();
    }

    /// Starts at x_0 with the system's own values of parameters, ε = 1 and h the `time_step`.
    ///
    /// # Panics
    /// When `initial` does not have the map's dimension.
    pub fn of(map: &dyn StepMap, system: &PoissonSystem, initial: &[f64], time_step: f64) -> Self {
        Self::new(map, &system.parameter_values(), 1.0, time_step, initial)
    }

    /// The same from each of these states, side by side.
    ///
    /// # Panics
    /// When there is none, or one does not have the map's dimension.
    pub fn of_each(
        map: &dyn StepMap,
        system: &PoissonSystem,
        initial: &[Vec<f64>],
        time_step: f64,
    ) -> Self {
        assert!(
            initial.iter().all(|state| state.len() == map.dimension()),
            "every initial state has the map's dimension"
        );
        let values = vec![system.parameter_values(); initial.len()];
        let own = (side_by_side(&values), side_by_side(initial));
        Self::side_by_side(map, initial.len(), (&own.0, &own.1), 1.0, time_step)
    }

    /// Says which member of an ensemble each lane is: [`Setting::Members`].
    pub fn follow(&mut self, members: &[u64]) {
        self.stepper.set(Setting::Members(members));
    }

    /// x_k of the lanes that live.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// The part of x_k beyond a double, laid out as [`state`](Self::state).
    pub fn compensation(&self) -> &[f64] {
        &self.low
    }

    /// The number of lanes.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// k.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// t = k ε h.
    pub fn time(&self) -> f64 {
        // Of no step backwards in time −0 is 0.
        let (epsilon, h) = self.step_sizes;
        self.steps as f64 * (epsilon * h) + 0.0
    }

    /// The solver's work so far, over all lanes.
    pub fn statistics(&self) -> SolverStatistics {
        self.stepper.statistics()
    }

    /// Evaluations so far, those of [`statistics`](Self::statistics).
    pub fn evaluations(&self) -> u64 {
        self.stepper.statistics().evaluations
    }

    /// DΦ of the last step of a lane that goes on, row-major d × d; `None` where the map offers none.
    pub fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        self.stepper.tangent(lane)
    }

    /// Whether a lane goes on.
    pub fn lives(&self, lane: usize) -> bool {
        self.rests[lane].is_none()
    }

    /// The number of lanes that go on.
    pub fn living(&self) -> usize {
        self.living
    }

    /// The last state of a lane, and the number of steps to it.
    pub fn last(&self, lane: usize) -> (u64, Vec<f64>) {
        match &self.rests[lane] {
            Some(rest) => (rest.steps, column(&self.last, lane, self.lanes)),
            None => (self.steps, column(&self.state, lane, self.lanes)),
        }
    }

    /// Sets a lane that lives to another state, from which it goes on.
    ///
    /// # Panics
    /// When the state does not have the map's dimension.
    pub fn put(&mut self, lane: usize, state: &[f64]) {
        assert_eq!(state.len() * self.lanes, self.state.len());
        for (at, value) in (lane..self.state.len()).step_by(self.lanes).zip(state) {
            (self.state[at], self.low[at]) = (*value, 0.0);
        }
    }

    /// Ends a lane at its present state.
    pub fn rest(&mut self, lane: usize) {
        self.end(lane, None);
    }

    /// The lanes that failed in the last [`step`](Self::step) or [`advance`](Self::advance), each with its error.
    pub fn failed(&self) -> &[(usize, StepError)] {
        &self.failed
    }

    /// One step of every lane that lives: x_k ↦ x_{k+1}.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub fn step(&mut self) -> Result<(), StepError> {
        self.advance(1)
    }

    /// x_k ↦ x_{k+n}, to the same bits as n steps one by one. One lane of straight-line code stays in one loop.
    ///
    /// # Errors
    /// The [`StepError`] of the first lane that fails. The others of that step are in [`failed`](Self::failed), and no
    /// further step is made behind it. Of several lanes those that fail rest at the state before it, the others have
    /// made it; one lane alone tries the step again at the next call. Where every lane rests, no step is made, and the
    /// error is that of the first that failed at some time.
    pub fn advance(&mut self, steps: u64) -> Result<(), StepError> {
        self.failed.clear();
        if self.living == 0 {
            let mut errors = self.rests.iter().flatten();
            let first = errors.find_map(|rest| rest.error.clone());
            return first.map_or(Ok(()), Err);
        }
        if self.lanes == 1 {
            return self.advance_alone(steps, None);
        }
        for _ in 0..steps {
            self.step_side_by_side();
            if let Some((_, error)) = self.failed.first() {
                return Err(error.clone());
            }
        }
        Ok(())
    }

    /// The same of one lane, with a record of the state after each step.
    ///
    /// # Errors
    /// As [`advance`](Self::advance): the record holds the steps that were made.
    ///
    /// # Panics
    /// Of several lanes, and when the record has no room for so many steps.
    pub fn advance_with(
        &mut self,
        steps: u64,
        record: &mut StepRecord<'_>,
    ) -> Result<(), StepError> {
        assert_eq!(self.lanes, 1, "a record is of one lane");
        self.failed.clear();
        match &self.rests[0] {
            Some(rest) => rest.error.clone().map_or(Ok(()), Err),
            None => self.advance_alone(steps, Some(record)),
        }
    }

    fn advance_alone(
        &mut self,
        steps: u64,
        record: Option<&mut StepRecord<'_>>,
    ) -> Result<(), StepError> {
        let (state, low) = (&mut self.state, &mut self.low);
        let increment = &mut self.increment;
        let (made, outcome) = self
            .stepper
            .advance(steps, state, low, increment, None, record);
        self.steps += made;
        outcome.inspect_err(|error| self.failed.push((0, error.clone())))
    }

    /// n steps, each followed by a look at where it has led to.
    ///
    /// # Errors
    /// As [`advance`](Self::advance); a step that fails is not looked at.
    pub fn watch(&mut self, steps: u64, mut look: impl FnMut(&Self)) -> Result<(), StepError> {
        let never = self.watch_until(steps, |walk| {
            look(walk);
            None::<std::convert::Infallible>
        });
        never.map(|_| ())
    }

    /// At most n steps, each followed by a look, until one finds something: that is returned.
    ///
    /// # Errors
    /// As [`watch`](Self::watch).
    pub fn watch_until<T>(
        &mut self,
        steps: u64,
        mut look: impl FnMut(&Self) -> Option<T>,
    ) -> Result<Option<T>, StepError> {
        for _ in 0..steps {
            self.step()?;
            if let Some(found) = look(self) {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    fn step_side_by_side(&mut self) {
        self.fill_resting();
        self.stepper.increment(
            &self.state,
            &self.low,
            &mut self.increment,
            &mut self.outcome,
        );
        let sums = self.state.iter().zip(&self.increment);
        let are_finite = sums.fold(true, |all, (x, i)| all & (x + i).is_finite());
        if !are_finite || self.outcome.iter().any(Result::is_err) {
            for lane in 0..self.lanes {
                if let Err(error) = self.judge(lane) {
                    self.fail(lane, error);
                    (lane..self.state.len())
                        .step_by(self.lanes)
                        .for_each(|at| self.increment[at] = 0.0);
                }
            }
        }
        let places = self.state.iter_mut().zip(&mut self.low);
        for ((x, low), increment) in places.zip(&self.increment) {
            (*x, *low) = two_sum(*x, increment + *low);
        }
        self.steps += 1;
    }

    fn judge(&mut self, lane: usize) -> Result<(), StepError> {
        std::mem::replace(&mut self.outcome[lane], Ok(()))?;
        let mut places = (lane..self.state.len()).step_by(self.lanes);
        if places.all(|at| (self.state[at] + self.increment[at]).is_finite()) {
            return Ok(());
        }
        Err(StepError::OF_STATE)
    }

    /// Ends a lane that lives, and remembers why.
    fn fail(&mut self, lane: usize, error: StepError) {
        if self.lives(lane) {
            self.failed.push((lane, error.clone()));
            self.end(lane, Some(error));
        }
    }

    fn end(&mut self, lane: usize, error: Option<StepError>) {
        if self.lives(lane) {
            let steps = self.steps;
            self.last.resize(self.state.len(), 0.0);
            for at in (lane..self.state.len()).step_by(self.lanes) {
                self.last[at] = self.state[at];
            }
            self.rests[lane] = Some(Rest { steps, error });
            self.living -= 1;
        }
    }

    /// Copies a lane that lives into those that rest.
    fn fill_resting(&mut self) {
        if self.living == self.lanes {
            return;
        }
        let Some(from) = (0..self.lanes).find(|lane| self.lives(*lane)) else {
            return;
        };
        for lane in 0..self.lanes {
            if self.lives(lane) {
                continue;
            }
            for row in (0..self.state.len()).step_by(self.lanes) {
                self.state[row + lane] = self.state[row + from];
                self.low[row + lane] = self.low[row + from];
            }
        }
    }

    /// Everything that later steps depend on: x_k, its compensation and the solver's memory.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            steps: self.steps,
            state: self.state.clone(),
            compensation: self.low.clone(),
            memory: self.stepper.memory(),
        }
    }

    /// Continues from a checkpoint, to the same bits as without interruption; every lane goes on.
    ///
    /// # Errors
    /// Returns the expected length when the checkpoint belongs to another method.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), usize> {
        if checkpoint.state.len() != self.state.len() {
            return Err(self.state.len());
        }
        self.stepper.restore(&checkpoint.memory)?;
        self.state.copy_from_slice(&checkpoint.state);
        self.low.copy_from_slice(&checkpoint.compensation);
        self.go_on_from(checkpoint.steps);
        Ok(())
    }
}

/// The state of a [`Walk`] between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// k.
    pub steps: u64,
    /// x_k.
    pub state: Vec<f64>,
    /// The part of x_k beyond a double.
    pub compensation: Vec<f64>,
    /// The solver's memory.
    pub memory: Vec<f64>,
}

/// One lane of a structure of arrays.
pub fn column(all: &[f64], lane: usize, lanes: usize) -> Vec<f64> {
    all.iter().skip(lane).step_by(lanes).copied().collect()
}

/// A structure of arrays of lists of one length: entry i of list w at `[i*lanes + w]`.
pub fn side_by_side(lists: &[Vec<f64>]) -> Vec<f64> {
    let rows = lists.first().map_or(0, Vec::len);
    let row = |i: usize| lists.iter().map(move |list| list[i]);
    (0..rows).flat_map(row).collect()
}
