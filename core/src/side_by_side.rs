//! The compensated step loop of many trajectories side by side.

use crate::compensation::two_sum;
use crate::error::StepError;
use crate::solver::{SolverStatistics, StepMap, Stepper};

/// W trajectories of one map, each as an [`Integrator`](crate::Integrator) would step it, to the same
/// bits.
///
/// A trajectory whose step fails stays at its last good state and disturbs no other: its lane goes on
/// as a copy of one that lives, which nobody reads.
pub struct SideBySide {
    stepper: Box<dyn Stepper>,
    lanes: usize,
    state: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    outcome: Vec<Result<(), StepError>>,
    rests: Vec<Option<Rest>>,
    living: usize,
    steps: u64,
}

/// Where a trajectory stays.
struct Rest {
    steps: u64,
    state: Vec<f64>,
}

impl SideBySide {
    /// Starts `lanes` trajectories at `initial` with their `parameters`, both structures of arrays:
    /// coordinate j of lane w at `[j*lanes + w]`.
    ///
    /// # Panics
    /// When `initial` does not have the map's dimension for every lane.
    pub fn new(
        map: &dyn StepMap,
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
        initial: &[f64],
    ) -> Self {
        assert_eq!(
            initial.len(),
            map.dimension() * lanes,
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
        }
    }

    /// Tells which member of an ensemble each lane is: [`Stepper::follow`].
    pub fn follow(&mut self, members: &[u64]) {
        self.stepper.follow(members);
    }

    /// The states of the living lanes, a structure of arrays.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// What the states hold beyond a double, as [`state`](Self::state).
    pub fn compensation(&self) -> &[f64] {
        &self.low
    }

    /// Whether a lane's trajectory goes on.
    pub fn lives(&self, lane: usize) -> bool {
        self.rests[lane].is_none()
    }

    /// How many go on.
    pub fn living(&self) -> usize {
        self.living
    }

    /// The last state of a lane's trajectory, and after how many steps.
    pub fn last(&self, lane: usize) -> (u64, Vec<f64>) {
        match &self.rests[lane] {
            Some(rest) => (rest.steps, rest.state.clone()),
            None => (self.steps, self.column(lane)),
        }
    }

    /// The solver's work so far, over all lanes.
    pub fn statistics(&self) -> SolverStatistics {
        self.stepper.statistics()
    }

    /// Ends a lane's trajectory at its present state.
    pub fn rest(&mut self, lane: usize) {
        if self.lives(lane) {
            let (steps, state) = self.last(lane);
            self.rests[lane] = Some(Rest { steps, state });
            self.living -= 1;
        }
    }

    /// One step of every living lane; hands over the lanes that fail, which then rest.
    pub fn step(&mut self, mut failed: impl FnMut(usize, StepError)) {
        if self.living == 0 {
            return;
        }
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
                    if self.lives(lane) {
                        self.rest(lane);
                        failed(lane, error);
                    }
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
        Err(StepError::NonFinite {
            what: "the new state",
        })
    }

    /// Copies a living lane into those that rest.
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

    fn column(&self, lane: usize) -> Vec<f64> {
        let column = self.state.iter().skip(lane).step_by(self.lanes);
        column.copied().collect()
    }
}
