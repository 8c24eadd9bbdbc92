//! Invariants and cost along an orbit.

use leafwise_core::solver::judge::larger;
use std::time::Instant;

use leafwise_core::diagnostics::{InvariantDrift, casimir_round_off, casimir_sizes, measure_drift};
use leafwise_core::system::SystemInvariants;
use leafwise_core::{StepError, StepMap, Walk};

use super::problem::Problem;

/// Drift of invariants over a thousand steps, of many coordinates over a hundred, and the cost of a step.
pub(super) struct Drift {
    /// The largest relative deviation of the energy.
    pub energy: f64,
    /// That of the last tenth over that of the first.
    pub growth: Option<f64>,
    /// The largest relative deviation of a Casimir.
    pub casimirs: f64,
    /// Whether every Casimir stays within the round-off of its terms; `None` where there is none.
    pub keeps_casimirs: Option<bool>,
    /// States along the orbit.
    pub states: Vec<Vec<f64>>,
    /// Solver evaluations a step.
    pub evaluations: f64,
    /// Nanoseconds a step, observers apart.
    pub nanoseconds: f64,
}

/// The number of steps over which drift is measured, and over which time is.
const STEPS: usize = 1000;
const TIMED_STEPS: usize = 200;
/// A problem of many coordinates takes so many times fewer.
const FEWER: usize = 10;

/// States of them that are looked at.
const STATES: usize = 16;
const FEW_STATES: usize = 4;

impl Drift {
    /// Runs `map` with steps of `t`.
    ///
    /// # Errors
    /// The map's [`StepError`].
    pub fn measure(problem: &Problem, map: &dyn StepMap, t: f64) -> Result<Self, StepError> {
        let values = problem.system.parameter_values();
        let fewer = if problem.is_sampled() { FEWER } else { 1 };
        let (steps, timed_steps) = (STEPS / fewer, TIMED_STEPS / fewer);
        let looked_at = if problem.is_sampled() {
            FEW_STATES
        } else {
            STATES
        };
        let start = || Walk::new(map, &values, 1.0, t, &problem.initial);
        let mut timed = start();
        let started = Instant::now();
        timed.advance(timed_steps as u64)?;
        let nanoseconds = started.elapsed().as_secs_f64() * 1e9 / timed_steps as f64;
        let mut walk = start();
        let invariants = match SystemInvariants::new(&problem.system, &values) {
            Ok(observer) => measure_drift(&mut walk, observer, steps)?,
            Err(_) => Vec::new(),
        };
        let mut states = vec![problem.initial.clone()];
        let mut orbit = start();
        for _ in 0..looked_at {
            orbit.advance((steps / looked_at) as u64)?;
            states.push(orbit.state().to_vec());
        }
        let sizes = casimir_sizes(&problem.system, &values, &states).unwrap_or_default();
        let (energy, casimirs) = match invariants.split_first() {
            Some((energy, casimirs)) => (Some(energy), casimirs),
            None => (None, invariants.as_slice()),
        };
        Ok(Self {
            energy: energy.map_or(f64::NAN, InvariantDrift::relative),
            growth: energy.and_then(|energy| energy.growth),
            keeps_casimirs: (!casimirs.is_empty()).then(|| {
                let mut drifts = casimirs
                    .iter()
                    .zip(sizes.iter().chain(std::iter::repeat(&0.0)));
                drifts.all(|(casimir, size)| {
                    let size = size.max(casimir.initial.abs());
                    casimir.largest <= casimir_round_off(size, steps as u64)
                })
            }),
            states,
            casimirs: casimirs
                .iter()
                .map(InvariantDrift::relative)
                .fold(0.0, larger),
            evaluations: walk.statistics().evaluations_per_step(),
            nanoseconds,
        })
    }
}
