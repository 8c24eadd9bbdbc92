//! How long a motion can be followed in double precision.

use std::fmt;

use leafwise_core::Walk;
use leafwise_scene::json::{double, optional};
use serde::Serialize;

use super::candidate::{Bench, Candidate};
use super::norm::{distance, norm};
use super::reference::{Judged, ROUND_OFF, Reference};

/// How long a motion can be followed in double precision, where its end cannot be known as well as
/// is wanted.
///
/// Two methods of high accuracy in double precision part by at least round-off that the motion has magnified. A more
/// accurate reference would not help, since each method that is judged by it rounds too.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// The end time.
    #[serde(skip)]
    pub time: f64,
    /// The error that is wanted of the end state.
    #[serde(serialize_with = "double")]
    pub wanted: f64,
    /// The round-off of the end state, 4·2⁻⁵²‖x‖.
    #[serde(skip)]
    pub round_off: f64,
    /// ‖δx(T)‖/‖δx(0)‖ for a small change of the initial state, in proportion to its components;
    /// `None` where it cannot be followed.
    #[serde(serialize_with = "optional")]
    pub growth: Option<f64>,
    /// The two methods of the reference and how far they are apart, where that is more than grown round-off.
    #[serde(skip)]
    pub parted: Option<(String, f64)>,
    /// The longest time, among sixteenths of the end time, to which the state is known ten times
    /// better than is wanted; `None` where there is none.
    pub known: Option<Known>,
}

/// A shorter time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Known {
    /// The time.
    #[serde(serialize_with = "double")]
    pub time: f64,
    /// The reference's own error there.
    #[serde(serialize_with = "double")]
    pub error: f64,
}

/// Times that are tried, as parts of the end time.
const PARTS: u32 = 16;

/// Pieces of the time after each of which a small change is made small again.
const SEGMENTS: u64 = 256;

/// Two methods may be so many times further apart than round-off that has grown as a small change does: each step adds its own.
const MORE: f64 = 1e4;

/// A small change, relative to the state.
const SMALL_CHANGE: f64 = 1e-8;

impl Horizon {
    /// Measures how long the scene's motion can be known to `wanted`.
    fn measure(bench: &Bench<'_>, reference: &Reference, wanted: f64) -> Self {
        let round_off = ROUND_OFF * f64::EPSILON * reference.norm();
        let can_be_held = wanted > round_off;
        let growth = growth(bench, reference);
        let grown = MORE * round_off * growth.unwrap_or(1.0).max(1.0);
        let parted = || (reference.methods.join(" and "), reference.apart);
        Self {
            time: bench.time(),
            wanted,
            round_off,
            growth,
            parted: (reference.apart > grown).then(parted),
            known: can_be_held
                .then(|| known(bench, reference.judged(), wanted))
                .flatten(),
        }
    }
}

impl Reference {
    /// How long the motion can be known to `wanted`, where its end is not: costs several references.
    pub fn horizon(&self, bench: &Bench<'_>, wanted: f64) -> Horizon {
        Horizon::measure(bench, self, wanted)
    }
}

/// Bisects over the parts of the time.
fn known(bench: &Bench<'_>, judged: Judged, wanted: f64) -> Option<Known> {
    let (mut low, mut high) = (0, PARTS);
    let mut known = None;
    while high - low > 1 {
        let middle = (low + high) / 2;
        let time = bench.time() * f64::from(middle) / f64::from(PARTS);
        let shorter = bench.over(time).ok();
        let reference = shorter.and_then(|bench| Reference::compute(&bench, judged).ok());
        match reference.filter(|reference| reference.floor() <= wanted) {
            Some(reference) => {
                let error = reference.error;
                known = Some(Known { time, error });
                low = middle;
            }
            None => high = middle,
        }
    }
    known
}

/// Follows a small change with the reference's better method.
fn growth(bench: &Bench<'_>, reference: &Reference) -> Option<f64> {
    let (method, setting) = reference.best();
    let candidate = Candidate::build(bench, method).ok()?;
    let run = candidate.run_at(bench, *setting).ok()?;
    let values = run.system.parameter_values();
    let time_step = bench.extent() / setting.steps as f64;
    let start = |x: &[f64]| Walk::new(run.method.map(), &values, 1.0, time_step, x);
    let mut near: Vec<f64> = run.plan.initial.clone();
    for (at, x) in near.iter_mut().enumerate() {
        let sign = if at % 2 == 0 { 1.0 } else { -1.0 };
        *x += sign * SMALL_CHANGE * *x;
    }
    let mut base = start(&run.plan.initial);
    let initial = distance(base.state(), &near);
    if initial == 0.0 {
        return None;
    }
    let mut growth = 1.0;
    let mut taken = 0;
    for segment in 1..=SEGMENTS {
        let end = (u128::from(setting.steps) * u128::from(segment) / u128::from(SEGMENTS)) as u64;
        if end == taken {
            continue;
        }
        let mut beside = start(&near);
        let before = distance(base.state(), &near);
        base.advance(end - taken).ok()?;
        beside.advance(end - taken).ok()?;
        taken = end;
        let after = distance(base.state(), beside.state());
        if after == 0.0 || !after.is_finite() {
            return None;
        }
        growth *= after / before;
        // In proportion to the state, so that its rounding is the same part of it.
        let size = match norm(base.state()) {
            0.0 => initial,
            norm => SMALL_CHANGE * norm,
        };
        let scale = size / after;
        let pairs = base.state().iter().zip(beside.state());
        near = pairs.map(|(x, y)| x + scale * (y - x)).collect();
    }
    growth.is_finite().then_some(growth)
}

impl fmt::Display for Horizon {
    /// Writes how long the motion is known, why no longer, and a remedy to try.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.wanted <= self.round_off {
            return write!(
                f,
                "the round-off of a double of that size is {:.0e}: raise the bound",
                self.round_off
            );
        }
        if let Some((methods, apart)) = &self.parted {
            write!(
                f,
                "{methods} are {apart:.0e} apart, more than round-off: one of them steps over something shorter than a step, as a \
                 pulse or a wall; take a smaller time-step; ",
            )?;
            return match self.known {
                Some(known) => write!(
                    f,
                    "to t = {} the state is known to {:.1e}",
                    known.time, known.error
                ),
                None => write!(f, "or give only --energy and --casimir"),
            };
        }
        match self.growth {
            Some(growth) => write!(
                f,
                "a small change of the initial state grows by a factor of {growth:.0e} until \
                 t = {}, and so does the round-off of every method; ",
                self.time
            )?,
            None => write!(
                f,
                "the round-off of every method grows until t = {}; ",
                self.time
            )?,
        }
        match self.known {
            Some(known) => write!(
                f,
                "to t = {} the state is known to {:.1e}: take --time {}, or give only --energy and \
                 --casimir",
                known.time, known.error, known.time
            ),
            None => write!(
                f,
                "even to t = {} the state is not known to {:.0e}: raise the bound, or give only \
                 --energy and --casimir",
                self.time / f64::from(PARTS),
                self.wanted
            ),
        }
    }
}
