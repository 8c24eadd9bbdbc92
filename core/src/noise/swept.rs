//! Split steps of a lattice by sweeps over one set of fields.

use std::ops::Range;

use super::increments::{Normals, SiteNoise, normal};
use crate::error::StepError;
use crate::lattice::{Fields, Finite, Front, Swept, SweptKernels, SweptPart, add_from_field};
use crate::solver::{
    Setting, SolverStatistics, StepCheck, StepRecord, Stepper, are_finite, one_by_one,
};

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

    fn maps(&self) -> Vec<&Swept> {
        std::iter::once(&self.drift).chain(&self.flows).collect()
    }

    fn fields(&self) -> Option<Fields> {
        Swept::fields(&self.maps())
    }

    /// The sweeps of a step whose channels' flows take the first or the second pass of `groups`.
    fn schedule(&self, groups: usize, is_second: bool) -> Vec<Sweep> {
        let last = groups.saturating_sub(1);
        let of = |map: usize| {
            let own = &self.maps()[map].order;
            let sweeps = own.iter().map(move |stage| Sweep { map, stage: *stage });
            sweeps.collect::<Vec<_>>()
        };
        let flow = |at: usize| 1 + if is_second { last + at } else { at };
        let mut back = of(0);
        back.reverse();
        let mut sweeps = of(0);
        sweeps.extend((0..groups).flat_map(|at| of(flow(at))));
        sweeps.extend(back);
        sweeps
    }
}

/// A stage of the drift, the first of the maps, or of a flow.
#[derive(Clone, Copy, Debug)]
struct Sweep {
    map: usize,
    stage: usize,
}

/// Numbers that a step draws.
pub(super) struct Draws {
    pub(super) groups: Vec<SiteNoise>,
    pub(super) normals: Normals,
    /// Where the increments of each pass begin behind the coordinates, and behind the last their number.
    pub(super) starts: Vec<usize>,
}

/// Which pass the flows of the channels take in a step, and its order of parts.
struct Pass {
    sweeps: Vec<Sweep>,
    front: Option<Front>,
}

/// One trajectory's fields, and kernels of the drift and the flows.
struct Trajectory {
    kernels: Vec<SweptKernels>,
    fields: Fields,
}

/// Draws, and steps with what was drawn: only the flows of the pass that has time are swept.
pub(super) struct SweptNoiseSteps {
    map: SweptNoise,
    draws: Draws,
    /// The first pass and the second.
    passes: [Pass; 2],
    /// The coordinates of a state, without increments.
    own: usize,
    trajectories: Vec<Trajectory>,
    members: Vec<u64>,
    sizes: (f64, f64),
    /// The number of the next step.
    step: u64,
    statistics: SolverStatistics,
}

impl Draws {
    /// Whether the second pass has the time in a step.
    fn is_second(&self, member: u64, step: u64) -> bool {
        let all: usize = self.groups.iter().map(SiteNoise::channels).sum();
        self.groups.len() > 1 && normal(&self.normals, member, all as u32, step) < 0.0
    }

    /// Draws the increments of some sites where the flows of their pass read them.
    fn draw(
        &self,
        (member, step, is_second): (u64, u64, bool),
        root: f64,
        sites: Range<usize>,
        increments: &mut [f64],
    ) {
        let last = self.groups.len().saturating_sub(1);
        let mut channel = 0;
        for (at, group) in self.groups.iter().enumerate() {
            let pass = if is_second { 2 * last - at } else { at };
            let end = sites.end.min(group.sites);
            let sites = sites.start.min(end)..end;
            let drawn = &mut increments[self.starts[pass]..][sites.clone()];
            match &group.apart {
                None => drawn.fill(normal(&self.normals, member, channel as u32, step) / root),
                Some(apart) => {
                    drawn.fill(0.0);
                    let from = apart.start.clamp(sites.start, sites.end);
                    let to = apart.end.clamp(from, sites.end);
                    let drawn = &mut drawn[from - sites.start..to - sites.start];
                    let first = channel + from.saturating_sub(apart.start);
                    (self.normals)(member, first as u32, step, drawn);
                    drawn.iter_mut().for_each(|w| *w /= root);
                }
            }
            channel += group.channels();
        }
    }
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
        let own = fields.get(map.drift.state).len() - increments;
        let geometry = map.drift.program.geometry();
        let families = geometry.offsets().partition_point(|start| *start < own);
        let pass = |is_second| {
            let sweeps = map.schedule(draws.groups.len(), is_second);
            let maps = map.maps();
            let parts = sweeps.iter();
            let parts = parts.map(|Sweep { map, stage }| maps[*map].program.parts(*stage));
            let front = match lanes {
                1 => Front::of(geometry, families, parts),
                _ => None,
            };
            Pass { sweeps, front }
        };
        let mut this = Self {
            passes: [false, true].map(pass),
            map: map.clone(),
            own,
            draws,
            trajectories: Vec::new(),
            members: (0..lanes as u64).collect(),
            sizes,
            step: 0,
            statistics: SolverStatistics::default(),
        };
        let prepared = this.prepare(lanes, parameters).into_iter();
        let trajectories = prepared.map(|kernels| Trajectory {
            kernels,
            fields: fields.clone(),
        });
        this.trajectories = trajectories.collect();
        this
    }

    /// The kernels of every lane.
    fn prepare(&self, lanes: usize, parameters: &[f64]) -> Vec<Vec<SweptKernels>> {
        let of_lane = |lane: usize| {
            let own = parameters.iter().skip(lane).step_by(lanes).copied();
            let own: Vec<f64> = own.collect();
            let flows = self.map.flows.iter();
            let flows = flows.map(|flow| flow.prepare(1.0, &own, self.sizes));
            let drift = self.map.drift.prepare(0.5, &own, self.sizes);
            std::iter::once(drift).chain(flows).collect()
        };
        (0..lanes).map(of_lane).collect()
    }

    /// The sweeps of a lane's step from x. Its increments are then in the field of sums.
    fn sweep(&mut self, lane: usize, x: &[f64]) -> Finite {
        self.statistics.steps += 1;
        self.statistics.evaluations += 1;
        self.statistics.most_evaluations = 1;
        let (own, step, member) = (self.own, self.step, self.members[lane]);
        let (state, sum) = (self.map.drift.state, self.map.drift.sum);
        let root = libm::sqrt(self.sizes.0 * self.sizes.1);
        let is_second = self.draws.is_second(member, step);
        let (draws, maps) = (&self.draws, self.map.maps());
        let read = |sites: Range<usize>, fields: &mut Fields| {
            let increments = &mut fields.get_mut(state)[own..];
            draws.draw((member, step, is_second), root, sites, increments);
        };
        let Pass { sweeps, front } = &self.passes[usize::from(is_second)];
        let lanes = self.trajectories.len();
        let Trajectory { kernels, fields } = &mut self.trajectories[lane];
        if let Some(front) = front {
            return front.run(
                fields,
                [state, sum],
                x,
                read,
                |SweptPart { sweep, part }, fields| {
                    let Sweep { map, stage } = sweeps[sweep];
                    maps[map].run_part((stage, part), &mut kernels[map], fields);
                },
            );
        }
        let to = fields.get_mut(state)[..own].iter_mut();
        let from = x.iter().skip(lane).step_by(lanes);
        to.zip(from).for_each(|(to, x)| *to = *x);
        fields.get_mut(sum)[..own].fill(0.0);
        read(0..usize::MAX, fields);
        for Sweep { map, stage } in sweeps {
            maps[*map].run_stage(*stage, &mut kernels[*map], fields);
        }
        let is_finite = |field| {
            let numbers = fields.get(field)[..own].iter();
            numbers.fold(true, |all, x| all & x.is_finite())
        };
        let flows = is_finite(state) && is_finite(sum);
        let sums = &fields.get(sum)[..own];
        let step = flows && (lanes > 1 || are_finite(x, sums));
        Finite { flows, step }
    }
}

impl SweptNoiseSteps {
    /// The increment of the first lane's last sweeps.
    fn sums(&self) -> &[f64] {
        &self.trajectories[0].fields.get(self.map.drift.sum)[..self.own]
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
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            let is_finite = self.sweep(lane, x).flows;
            let to = increment.iter_mut().skip(lane).step_by(lanes);
            *outcome = match is_finite {
                true => {
                    let sum = &self.trajectories[lane].fields.get(self.map.drift.sum)[..self.own];
                    to.zip(sum).for_each(|(to, change)| *to = *change);
                    Ok(())
                }
                false => {
                    self.statistics.failures += 1;
                    to.for_each(|to| *to = 0.0);
                    Err(StepError::OF_INCREMENT)
                }
            };
        }
        // A step that fails has not been made.
        if outcome.iter().any(Result::is_ok) {
            self.step += 1;
        }
    }

    fn advance(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        increment: &mut [f64],
        check: Option<&mut dyn StepCheck>,
        record: Option<&mut StepRecord<'_>>,
    ) -> (u64, Result<(), StepError>) {
        if self.trajectories.len() > 1 || check.is_some() {
            return one_by_one(self, steps, [state, low, increment], check, record);
        }
        // A step that fails has not been made.
        let step = |own: &mut Self, x: &[f64]| {
            let finite = own.sweep(0, x);
            own.statistics.failures += u64::from(!finite.flows);
            let made = finite.step();
            own.step += u64::from(made.is_ok());
            made
        };
        add_from_field(self, steps, [state, low], record, step, Self::sums)
    }

    fn restart(&mut self) {}

    fn set(&mut self, setting: Setting<'_>) -> bool {
        match setting {
            Setting::StepSize(_) => return false,
            Setting::Members(members) => self.members.copy_from_slice(members),
            Setting::Parameters(parameters) => {
                let prepared = self.prepare(self.trajectories.len(), parameters);
                for (trajectory, kernels) in self.trajectories.iter_mut().zip(prepared) {
                    trajectory.kernels = kernels;
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
