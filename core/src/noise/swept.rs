//! Split steps of a lattice by sweeps over one set of fields.

use super::increments::{Normals, SiteNoise, normal};
use crate::error::StepError;
use crate::lattice::{Fields, Swept, SweptKernels};
use crate::solver::{Setting, SolverStatistics, Stepper};

/// χ*_{t/2} ∘ flows of the noise ∘ χ_{t/2} of a lattice, all of them sweeps. The channels' flows are numbered 1 … K … 1, as
/// the families of increments behind the coordinates are.
#[derive(Clone, Debug)]
pub struct SweptNoise {
    drift: Swept,
    flows: Vec<Swept>,
}

impl SweptNoise {
    /// Of the drift and each flow of noise; `None` where they do not work on the same fields.
    pub fn new(drift: Swept, flows: Vec<Swept>) -> Option<Self> {
        let own = Self { drift, flows };
        own.fields().map(|_| own)
    }

    fn fields(&self) -> Option<Fields> {
        let maps: Vec<&Swept> = std::iter::once(&self.drift).chain(&self.flows).collect();
        Swept::fields(&maps)
    }
}

/// Numbers that a step draws.
pub(super) struct Draws {
    pub(super) groups: Vec<SiteNoise>,
    pub(super) normals: Normals,
    /// Where the increments of each pass begin behind the coordinates, and behind the last their number.
    pub(super) starts: Vec<usize>,
}

/// One trajectory's fields and kernels.
struct Trajectory {
    drift: SweptKernels,
    flows: Vec<SweptKernels>,
    fields: Fields,
}

/// Draws, and steps with what was drawn: only the flows of the pass that has time are swept.
pub(super) struct SweptNoiseSteps {
    map: SweptNoise,
    draws: Draws,
    /// The coordinates of a state, without increments.
    own: usize,
    trajectories: Vec<Trajectory>,
    members: Vec<u64>,
    sizes: (f64, f64),
    /// The number of the next step.
    step: u64,
    statistics: SolverStatistics,
}

impl SweptNoiseSteps {
    /// Steps of a map that draws so.
    ///
    /// # Panics
    /// When the map was made without [`SweptNoise::new`].
    pub(super) fn new(
        map: &SweptNoise,
        draws: Draws,
        lanes: usize,
        parameters: &[f64],
        sizes: (f64, f64),
    ) -> Self {
        let fields = map.fields().expect("its maps work on the same fields");
        let increments = draws.starts.last().copied().unwrap_or(0);
        let mut this = Self {
            map: map.clone(),
            own: fields.get(map.drift.state).len() - increments,
            draws,
            trajectories: Vec::new(),
            members: (0..lanes as u64).collect(),
            sizes,
            step: 0,
            statistics: SolverStatistics::default(),
        };
        let prepared = this.prepare(lanes, parameters);
        let trajectory = |(drift, flows)| Trajectory {
            drift,
            flows,
            fields: fields.clone(),
        };
        this.trajectories = prepared.into_iter().map(trajectory).collect();
        this
    }

    /// The kernels of every lane.
    fn prepare(&self, lanes: usize, parameters: &[f64]) -> Vec<(SweptKernels, Vec<SweptKernels>)> {
        let of_lane = |lane: usize| {
            let own: Vec<f64> = parameters
                .iter()
                .skip(lane)
                .step_by(lanes)
                .copied()
                .collect();
            let flows = self.map.flows.iter();
            (
                self.map.drift.prepare(0.5, &own, self.sizes),
                flows
                    .map(|flow| flow.prepare(1.0, &own, self.sizes))
                    .collect(),
            )
        };
        (0..lanes).map(of_lane).collect()
    }

    /// Draws the increments of a lane where the flows of their pass read them; whether the second pass has the time.
    fn draw(&mut self, lane: usize) -> bool {
        let Draws {
            groups,
            normals,
            starts,
        } = &self.draws;
        let (member, last) = (self.members[lane], groups.len().saturating_sub(1));
        let all: usize = groups.iter().map(SiteNoise::channels).sum();
        let is_second = last > 0 && normal(normals, member, all as u32, self.step) < 0.0;
        let root = libm::sqrt(self.sizes.0 * self.sizes.1);
        let state = self.trajectories[lane].fields.get_mut(self.map.drift.state);
        let state = &mut state[self.own..];
        let mut channel = 0;
        for (at, group) in groups.iter().enumerate() {
            let pass = if is_second { 2 * last - at } else { at };
            let drawn = &mut state[starts[pass]..][..group.sites];
            match &group.apart {
                None => drawn.fill(normal(normals, member, channel as u32, self.step) / root),
                Some(apart) => {
                    drawn.fill(0.0);
                    let drawn = &mut drawn[apart.clone()];
                    normals(member, channel as u32, self.step, drawn);
                    drawn.iter_mut().for_each(|w| *w /= root);
                }
            }
            channel += group.channels();
        }
        is_second
    }

    /// One step of a lane from `x`; whether it is finite.
    fn advance(&mut self, lane: usize, x: impl Iterator<Item = f64>) -> bool {
        let own = self.own;
        let (state, sum) = (self.map.drift.state, self.map.drift.sum);
        let fields = &mut self.trajectories[lane].fields;
        let to = fields.get_mut(state)[..own].iter_mut();
        to.zip(x).for_each(|(to, x)| *to = x);
        fields.get_mut(sum)[..own].fill(0.0);
        let is_second = self.draw(lane);
        let Trajectory {
            drift,
            flows,
            fields,
        } = &mut self.trajectories[lane];
        self.map.drift.run(drift, fields, false);
        let last = self.draws.groups.len().saturating_sub(1);
        for at in 0..self.draws.groups.len() {
            let pass = if is_second { last + at } else { at };
            self.map.flows[pass].run(&mut flows[pass], fields, false);
        }
        self.map.drift.run(drift, fields, true);
        let is_finite = |field| {
            let numbers = &fields.get(field)[..own];
            numbers.iter().fold(true, |all, x| all & x.is_finite())
        };
        is_finite(state) && is_finite(sum)
    }
}

impl Stepper for SweptNoiseSteps {
    fn increment(
        &mut self,
        x: &[f64],
        _low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.trajectories.len();
        let own = self.own;
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            let is_finite = match lanes {
                1 => self.advance(lane, x.iter().copied()),
                _ => self.advance(lane, x.iter().skip(lane).step_by(lanes).copied()),
            };
            let to = increment.iter_mut().skip(lane).step_by(lanes);
            *outcome = match is_finite {
                true => {
                    let sum = &self.trajectories[lane].fields.get(self.map.drift.sum)[..own];
                    to.zip(sum).for_each(|(to, change)| *to = *change);
                    Ok(())
                }
                false => {
                    self.statistics.failures += 1;
                    to.for_each(|to| *to = 0.0);
                    Err(StepError::OF_INCREMENT)
                }
            };
            self.statistics.steps += 1;
            self.statistics.evaluations += 1;
            self.statistics.most_evaluations = 1;
        }
        // A step that fails has not been made.
        if outcome.iter().any(Result::is_ok) {
            self.step += 1;
        }
    }

    fn restart(&mut self) {}

    fn set(&mut self, setting: Setting<'_>) -> bool {
        match setting {
            Setting::StepSize(_) => return false,
            Setting::Members(members) => self.members.copy_from_slice(members),
            Setting::Parameters(parameters) => {
                let prepared = self.prepare(self.trajectories.len(), parameters);
                for (trajectory, (drift, flows)) in self.trajectories.iter_mut().zip(prepared) {
                    (trajectory.drift, trajectory.flows) = (drift, flows);
                }
            }
        }
        true
    }

    fn statistics(&self) -> SolverStatistics {
        let taken = self.map.flows.iter().take(self.draws.groups.len());
        let work = 2 * self.map.drift.work() + taken.map(Swept::work).sum::<u64>();
        SolverStatistics {
            operations: Some(self.statistics.steps * work),
            ..self.statistics
        }
    }

    /// The number of the next step, below 2⁵³.
    fn memory(&self) -> Vec<f64> {
        vec![self.step as f64]
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let [step] = memory else { return Err(1) };
        self.step = *step as u64;
        Ok(())
    }
}
