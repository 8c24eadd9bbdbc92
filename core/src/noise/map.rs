//! Step maps that draw.

use std::sync::Arc;

use super::increments::{Noise, Normals, SiteNoise, normal};
use super::swept::{Draws, SweptNoise, SweptNoiseSteps};
use crate::error::StepError;
use crate::solver::Differential;
use crate::solver::{MapAbilities, MapProperties, Setting, SolverStatistics, StepMap, Stepper};

/// Where a map finds the increments.
#[derive(Clone, Debug)]
enum Entry {
    /// As its last parameters.
    Parameters,
    /// As its last coordinates.
    Coordinates,
}

/// A step map whose last parameters, or last coordinates on a lattice, are drawn before every step. Steppers take the parameters
/// and coordinates before those.
#[derive(Clone)]
pub struct NoisyMap {
    map: Arc<dyn StepMap>,
    noise: Noise,
    /// Channels that enter together, each with as many places as it has sites: one without a lattice.
    groups: Vec<SiteNoise>,
    entry: Entry,
    normals: Normals,
    /// The same map as sweeps over one set of fields.
    swept: Option<Arc<SweptNoise>>,
}

impl NoisyMap {
    /// Steps of `map`, whose last [parameters](Noise::parameters) are those of `channels` of noise.
    pub fn new(map: Arc<dyn StepMap>, noise: Noise, channels: usize, normals: Normals) -> Self {
        let alone = SiteNoise {
            sites: 1,
            apart: None,
        };
        Self {
            map,
            noise,
            groups: vec![alone; channels],
            entry: Entry::Parameters,
            normals,
            swept: None,
        }
    }

    /// Steps of the map of a lattice whose last coordinates are increments w: group after group, and site after site in each.
    /// Groups stand in the order of the [parameters](Noise::parameters) of so many channels.
    pub fn of_sites(
        map: Arc<dyn StepMap>,
        noise: Noise,
        groups: Vec<SiteNoise>,
        normals: Normals,
    ) -> Self {
        Self {
            map,
            noise,
            groups,
            entry: Entry::Coordinates,
            normals,
            swept: None,
        }
    }

    /// The same as sweeps over one set of fields.
    pub fn by_sweeps(self, swept: Option<SweptNoise>) -> Self {
        let swept = swept.map(Arc::new);
        Self { swept, ..self }
    }

    /// The same with other numbers: of paths that are given, or of a quadrature.
    pub fn with_normals(&self, normals: Normals) -> Self {
        Self {
            normals,
            ..self.clone()
        }
    }

    /// How many random numbers a step takes, the sign of a [split](Noise::Split) one apart.
    pub fn channels(&self) -> usize {
        self.groups.iter().map(SiteNoise::channels).sum()
    }

    /// Where the increments begin that a step reads of the groups 1 … K or 1 … K … 1, and behind the last their number.
    fn starts(&self) -> Vec<usize> {
        let count = self.groups.len();
        let mut starts = vec![0];
        for at in 0..self.noise.parameters(count) {
            let group = at.min(2 * count - 2 - at);
            starts.push(starts[at] + self.groups[group].sites);
        }
        starts
    }

    /// How many increments of a lane a step reads.
    fn increments(&self) -> usize {
        *self.starts().last().unwrap_or(&0)
    }
}

impl StepMap for NoisyMap {
    fn dimension(&self) -> usize {
        match self.entry {
            Entry::Parameters => self.map.dimension(),
            Entry::Coordinates => self.map.dimension() - self.increments(),
        }
    }

    /// The order is that of means.
    fn properties(&self) -> MapProperties {
        let MapProperties {
            order, structure, ..
        } = self.map.properties();
        MapProperties {
            order: order.min(self.noise.weak_order()),
            structure,
            self_adjoint: Some(false),
        }
    }

    fn describe(&self) -> String {
        let channels = match self.channels() {
            1 => "one channel".to_owned(),
            count => format!("{count} channels"),
        };
        format!("{} with noise of {channels}", self.map.describe())
    }

    fn abilities(&self) -> MapAbilities<'_> {
        self.map.abilities().kernels_alone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        if let Some(swept) = &self.swept {
            let sizes = (epsilon, h);
            let draws = Draws {
                groups: self.groups.clone(),
                normals: Arc::clone(&self.normals),
                starts: self.starts(),
            };
            return Box::new(SweptNoiseSteps::new(swept, draws, lanes, parameters, sizes));
        }
        let increments = self.increments() * lanes;
        let (mut parameters, own) = (parameters.to_vec(), parameters.len());
        if matches!(self.entry, Entry::Parameters) {
            parameters.resize(own + increments, 0.0);
        }
        Box::new(NoisyStepper {
            stepper: self.map.stepper(lanes, &parameters, epsilon, h),
            spent: SolverStatistics::default(),
            map: self.clone(),
            parameters,
            own,
            starts: self.starts(),
            increments,
            extended: Extended::default(),
            members: (0..lanes as u64).collect(),
            step: 0,
            step_sizes: (epsilon, h),
        })
    }

    fn differential(&self, _: &[f64], _: f64, _: f64) -> Box<dyn Differential> {
        Box::new(NoDifferential)
    }
}

/// Of steps that another pass over a trajectory would draw anew.
struct NoDifferential;

impl Differential for NoDifferential {
    fn step(&mut self, _: &[f64], _: &[f64], _: &mut [f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn push(&mut self, _: &mut [f64], _: &[f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn pull(&mut self, _: &mut [f64], _: &mut [f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn pull_inverse(&mut self, _: &mut [f64], _: &mut [f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn knows_parameters(&self) -> bool {
        false
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

/// Draws, and steps with what was drawn.
struct NoisyStepper {
    stepper: Box<dyn Stepper>,
    /// Work of steppers that take no other parameters: each served one step.
    spent: SolverStatistics,
    map: NoisyMap,
    parameters: Vec<f64>,
    /// Where those that are drawn begin.
    own: usize,
    /// Where the increments of each pass begin.
    starts: Vec<usize>,
    /// How many increments there are, all lanes together.
    increments: usize,
    extended: Extended,
    members: Vec<u64>,
    /// The number of the next step.
    step: u64,
    step_sizes: (f64, f64),
}

/// States with increments behind their own coordinates.
#[derive(Default)]
struct Extended {
    state: Vec<f64>,
    low: Vec<f64>,
    moved: Vec<f64>,
}

impl NoisyStepper {
    /// Draws the increments of a step, where the map finds them.
    fn draw(&mut self) {
        let NoisyMap {
            noise,
            groups,
            normals,
            entry,
            ..
        } = &self.map;
        let lanes = self.members.len();
        let (epsilon, h) = self.step_sizes;
        let root = libm::sqrt(epsilon * h);
        let drawn = match entry {
            Entry::Parameters => &mut self.parameters[self.own..],
            Entry::Coordinates => {
                let own = self.extended.state.len() - self.increments;
                &mut self.extended.state[own..]
            }
        };
        let (all, last) = (self.map.channels(), groups.len().saturating_sub(1));
        for (lane, member) in self.members.iter().enumerate() {
            let normal = |channel: usize| normal(normals, *member, channel as u32, self.step);
            let is_second = *noise == Noise::Split && groups.len() > 1 && normal(all) < 0.0;
            let mut channel = 0;
            for (at, group) in groups.iter().enumerate() {
                // The last group stands in the middle of both passes.
                let other = (*noise == Noise::Split && at < last).then(|| 2 * last - at);
                let (takes, rests) = match other {
                    Some(other) if is_second => (other, Some(at)),
                    _ => (at, other),
                };
                let first = channel;
                channel += group.channels();
                let shared = match group.apart {
                    None => normal(first) / root,
                    Some(_) => 0.0,
                };
                for site in 0..group.sites {
                    let w = match &group.apart {
                        Some(apart) if apart.contains(&site) => {
                            normal(first + site - apart.start) / root
                        }
                        _ => shared,
                    };
                    let place = |pass: usize| (self.starts[pass] + site) * lanes + lane;
                    drawn[place(takes)] = w;
                    if let Some(rests) = rests {
                        drawn[place(rests)] = 0.0;
                    }
                }
            }
        }
    }

    /// The stepper with these parameters; a new one where it takes no other ones.
    fn renew(&mut self) {
        if self.stepper.set(Setting::Parameters(&self.parameters)) {
            return;
        }
        self.spent = self.spent.and(self.stepper.statistics());
        let (epsilon, h) = self.step_sizes;
        let map = &self.map.map;
        self.stepper = map.stepper(self.members.len(), &self.parameters, epsilon, h);
    }
}

impl Stepper for NoisyStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        match self.map.entry {
            Entry::Parameters => {
                self.draw();
                self.renew();
                self.stepper.increment(x, low, increment, outcome);
            }
            Entry::Coordinates => {
                let length = x.len() + self.increments;
                let Extended {
                    state,
                    low: own_low,
                    moved,
                } = &mut self.extended;
                for (extended, own) in [(state, x), (own_low, low)] {
                    extended.clear();
                    extended.extend_from_slice(own);
                    extended.resize(length, 0.0);
                }
                moved.resize(length, 0.0);
                self.draw();
                let Extended { state, low, moved } = &mut self.extended;
                self.stepper.increment(state, low, moved, outcome);
                increment.copy_from_slice(&moved[..x.len()]);
            }
        }
        // A step that fails has not been made.
        if outcome.iter().any(Result::is_ok) {
            self.step += 1;
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        match self.map.entry {
            Entry::Parameters => self.stepper.solution(lane),
            Entry::Coordinates => None,
        }
    }

    /// At what was drawn for the last step.
    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        match self.map.entry {
            Entry::Parameters => self.stepper.tangent(lane),
            Entry::Coordinates => None,
        }
    }

    fn restart(&mut self) {
        self.stepper.restart();
    }

    fn set(&mut self, setting: Setting<'_>) -> bool {
        match setting {
            Setting::StepSize(h) => {
                if !self.stepper.set(setting) {
                    return false;
                }
                (self.step, self.spent) = (0, SolverStatistics::default());
                self.step_sizes.1 = h;
            }
            Setting::Members(members) => self.members.copy_from_slice(members),
            Setting::Parameters(parameters) => {
                self.parameters[..self.own].copy_from_slice(parameters);
                if matches!(self.map.entry, Entry::Coordinates) {
                    self.renew();
                }
            }
        }
        true
    }

    fn statistics(&self) -> SolverStatistics {
        self.spent.and(self.stepper.statistics())
    }

    /// The number of the next step, below 2⁵³, then what the stepper keeps.
    fn memory(&self) -> Vec<f64> {
        let mut memory = vec![self.step as f64];
        memory.extend(self.stepper.memory());
        memory
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let expected = 1 + self.stepper.memory().len();
        let Some((step, memory)) = memory
            .split_first()
            .filter(|(_, own)| own.len() + 1 == expected)
        else {
            return Err(expected);
        };
        self.step = *step as u64;
        self.stepper.restore(memory).map_err(|length| length + 1)
    }
}
