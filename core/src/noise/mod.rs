//! Noise: steps with parameters that are drawn anew before each.
//!
//! Stratonovich's dx = {H, x} dt + Σ_k σ_k {H_k, x} ∘ dW_k moves along leaves, and its flow is a Poisson map almost
//! surely (J.-M. Bismut, *Mécanique aléatoire*, 1981; J.-A. Lázaro-Camí, J.-P. Ortega, *Stochastic Hamiltonian
//! dynamical systems*, Reports on Mathematical Physics 61 (2008)). Over a step t with increments ΔW_k it is, to first
//! order in the mean, the flow of a Hamiltonian H_w. That is H_w = H + Σ_k w_k σ_k H_k with w_k = ΔW_k/t (G. N.
//! Milstein, Yu. M. Repin, M. V. Tretyakov, *Numerical methods for stochastic systems preserving symplectic structure*,
//! SIAM Journal on Numerical Analysis 40 (2002)). Any map of systems with the parameters w_k serves, and a Poisson map
//! stays one.
//!
//! Of second order in the mean is Φ_{t/2} ∘ exp(ΔW_1 σ_1 X_1) ∘ … ∘ exp(ΔW_K σ_K X_K) ∘ Φ_{t/2}. Here Φ is a
//! self-adjoint map of H alone. Where Φ = χ*_{t/2} ∘ χ_{t/2}, χ_{t/2} stands before and χ*_{t/2} behind. The flows of the
//! channels come forwards or backwards with probability 1/2 (S. Ninomiya, N. Victoir, *Weak approximation of stochastic
//! differential equations and application to derivative pricing*, Applied Mathematical Finance 15 (2008)). Both orders stand
//! in one product, 1 … K … 1, where the flows of
//! one pass have no time.

mod swept;

use std::ops::Range;
use std::sync::Arc;

use leafwise_expression::Kernel;

use crate::error::StepError;
use crate::random::{self, Random};
use crate::solver::Differential;
use crate::solver::{MapProperties, ProductStepper, SolverStatistics, StepMap, Stepper};
pub use swept::SweptNoise;
use swept::SweptNoiseSteps;

/// Where standard normal numbers ξ come from: ΔW = √t ξ.
pub trait Normals: Send + Sync {
    /// ξ of a member's step, counted from 0, and a channel. Of a [split](Noise::Split) step the channel behind the last
    /// tells by its sign which pass the flows take.
    fn normal(&self, member: u64, channel: u32, step: u64) -> f64;
    /// The same of a channel and those behind it, as many as there are places.
    fn normals(&self, member: u64, channel: u32, step: u64, into: &mut [f64]) {
        for (channel, normal) in (channel..).zip(into) {
            *normal = self.normal(member, channel, step);
        }
    }
}

/// By Philox: what a member draws depends on the seed, its number, the channel and the step alone. |ξ| is at most
/// [`LARGEST_NORMAL`](crate::random::LARGEST_NORMAL).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seed {
    /// The key of all numbers.
    pub seed: u64,
    /// Number under which member 0 draws: the numbers of member m are those of `first` + m.
    pub first: u64,
}

impl Normals for Seed {
    fn normal(&self, member: u64, channel: u32, step: u64) -> f64 {
        Random::of_step(self.seed, self.first + member, channel, step).normal()
    }

    fn normals(&self, member: u64, channel: u32, step: u64, into: &mut [f64]) {
        random::normals_of_step(self.seed, self.first + member, channel, step, into);
    }
}

/// How increments enter a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Noise {
    /// With H, as parameters w_k of one step: weak order 1.
    #[default]
    Joint,
    /// As flows between two halves of a step of H alone: weak order 2.
    Split,
}

impl Noise {
    /// How many parameters hold the increments of `channels` of noise, behind the system's own: w_1, …, w_K, and, split,
    /// w_{K−1}, …, w_1 of the second pass.
    pub fn parameters(self, channels: usize) -> usize {
        match self {
            Self::Joint => channels,
            Self::Split => (2 * channels).saturating_sub(1),
        }
    }

    /// The order of means in t.
    pub fn weak_order(self) -> usize {
        match self {
            Self::Joint => 1,
            Self::Split => 2,
        }
    }
}

/// The product of flows of a [split](Noise::Split) step, as a map of systems that have its
/// [parameters](Noise::parameters).
#[derive(Clone)]
pub struct SplitNoise {
    /// Those of H alone.
    described: String,
    properties: MapProperties,
    stages: Vec<(Arc<dyn StepMap>, f64)>,
}

impl SplitNoise {
    /// Φ_{t/2} ∘ φ_1 ∘ … ∘ φ_K ∘ … ∘ φ_1 ∘ Φ_{t/2}: Φ of H alone, and a flow for each parameter w_j, of w_j σ_k H_k.
    /// Of a product of χ and χ* the first stands before and the second behind.
    pub fn new(drift: Arc<dyn StepMap>, flows: Vec<Arc<dyn StepMap>>) -> Self {
        let factors = drift.factored().map(|own| own.factors);
        let [before, behind] = factors.unwrap_or_else(|| [Arc::clone(&drift), Arc::clone(&drift)]);
        let mut stages = vec![(before, 0.5)];
        stages.extend(flows.into_iter().map(|flow| (flow, 1.0)));
        stages.push((behind, 0.5));
        Self {
            described: drift.describe(),
            properties: drift.properties(),
            stages,
        }
    }
}

impl StepMap for SplitNoise {
    fn dimension(&self) -> usize {
        self.stages[0].0.dimension()
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        let flows = self.stages.len() - 2;
        let noun = if flows == 1 { "flow" } else { "flows" };
        format!("halves of {} about {flows} {noun} of noise", self.described)
    }

    fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        let maps = self.stages[1..].iter();
        maps.flat_map(|(map, _)| map.kernels()).collect()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let stages = &self.stages;
        Box::new(ProductStepper::new(stages, lanes, parameters, epsilon, h))
    }
}

/// Increments that enter a step at the sites of a lattice: coordinates behind the state's own, at rest in the step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SiteNoise {
    /// How many sites there are.
    pub sites: usize,
    /// The sites that are moved, each by a channel of its own; `None` where one channel moves all.
    pub apart: Option<Range<usize>>,
}

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
    normals: Arc<dyn Normals>,
    /// The same map as sweeps over one set of fields.
    swept: Option<SweptNoise>,
}

impl NoisyMap {
    /// Steps of `map`, whose last [parameters](Noise::parameters) are those of `channels` of noise.
    pub fn new(
        map: Arc<dyn StepMap>,
        noise: Noise,
        channels: usize,
        normals: Arc<dyn Normals>,
    ) -> Self {
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
        normals: Arc<dyn Normals>,
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
        Self { swept, ..self }
    }

    /// The same with other numbers: of paths that are given, or of a quadrature.
    pub fn with_normals(&self, normals: Arc<dyn Normals>) -> Self {
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

impl SiteNoise {
    fn channels(&self) -> usize {
        self.apart.as_ref().map_or(1, Range::len)
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

    fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        self.map.kernels()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        if let Some(swept) = &self.swept {
            let sizes = (epsilon, h);
            return Box::new(SweptNoiseSteps::new(self, swept, lanes, parameters, sizes));
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
            let normal = |channel: usize| normals.normal(*member, channel as u32, self.step);
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
        if self.stepper.set_parameters(&self.parameters) {
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

    fn resize(&mut self, h: f64) -> bool {
        let is_offered = self.stepper.resize(h);
        if is_offered {
            (self.step, self.spent) = (0, SolverStatistics::default());
            self.step_sizes.1 = h;
        }
        is_offered
    }

    fn follow(&mut self, members: &[u64]) {
        self.members.copy_from_slice(members);
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> bool {
        self.parameters[..self.own].copy_from_slice(parameters);
        if matches!(self.map.entry, Entry::Coordinates) {
            self.renew();
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
