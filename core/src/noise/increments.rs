//! Random increments, and where they enter a step.

use std::ops::Range;
use std::sync::Arc;

use crate::random::{self, Random};

/// Standard normal numbers ξ, ΔW = √t ξ, of a member, a channel and a step, counted from 0. Each place gets one: the first that of
/// this channel, the others those of the channels behind it. Of a [split](Noise::Split) step the channel behind the last tells by
/// its sign which pass the flows take.
pub type Normals = Arc<dyn Fn(u64, u32, u64, &mut [f64]) + Send + Sync>;

/// Numbers of a function of a member, a channel and a step.
pub fn normals_of(normal: impl Fn(u64, u32, u64) -> f64 + Send + Sync + 'static) -> Normals {
    Arc::new(move |member, channel, step, into| {
        for (channel, place) in (channel..).zip(into) {
            *place = normal(member, channel, step);
        }
    })
}

/// ξ of one channel.
pub(super) fn normal(normals: &Normals, member: u64, channel: u32, step: u64) -> f64 {
    let mut one = [0.0];
    normals(member, channel, step, &mut one);
    one[0]
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

impl Seed {
    /// ξ of a member's step and a channel.
    pub fn normal(&self, member: u64, channel: u32, step: u64) -> f64 {
        Random::of_step(self.seed, self.first + member, channel, step).normal()
    }
}

impl From<Seed> for Normals {
    fn from(seed: Seed) -> Self {
        Arc::new(move |member, channel, step, into| {
            random::normals_of_step(seed.seed, seed.first + member, channel, step, into);
        })
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

/// Increments that enter a step at the sites of a lattice: coordinates behind the state's own, at rest in the step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SiteNoise {
    /// How many sites there are.
    pub sites: usize,
    /// The sites that are moved, each by a channel of its own; `None` where one channel moves all.
    pub apart: Option<Range<usize>>,
}

impl SiteNoise {
    /// How many numbers it takes.
    pub fn channels(&self) -> usize {
        self.apart.as_ref().map_or(1, Range::len)
    }
}
