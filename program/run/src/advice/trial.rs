//! What a step map does over a run's first steps.

use leafwise_core::{Integrator, StepMap};

use leafwise_scene::compose::ComposedRun;

/// Steps over which operations and energy are measured.
const STEPS: usize = 32;

/// What an alternative may cost of the operations of the map that it replaces.
const AS_DEAR: f64 = 1.1;

/// By how much its energy error may be larger: in another chart the generating function is another,
/// and may be a worse one.
const AS_WRONG: f64 = 2.0;

/// An energy error of this part is round-off: a few dozen operations, some steps.
const ROUND_OFF: f64 = 1e-13;

/// What a map does over its first steps.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// Operations a step.
    pub operations: f64,
    /// The largest deviation of the energy, relative to it.
    pub energy: f64,
    /// x after the last.
    pub state: Vec<f64>,
}

impl Trial {
    /// Takes the run's steps from x; `None` where one fails or operations are not counted.
    pub fn of(run: &ComposedRun, map: &dyn StepMap, x: &[f64]) -> Option<Self> {
        Self::at_most(run, map, x, f64::INFINITY)
    }

    /// The same of a map that is to replace one that does `now`; `None` too once it has taken more
    /// operations than it may.
    pub fn instead(run: &ComposedRun, map: &dyn StepMap, x: &[f64], now: &Self) -> Option<Self> {
        Self::at_most(run, map, x, AS_DEAR * now.operations * STEPS as f64)
    }

    fn at_most(run: &ComposedRun, map: &dyn StepMap, x: &[f64], most: f64) -> Option<Self> {
        let parameters = run.system.parameter_values();
        let (epsilon, h) = (run.plan.epsilon, run.plan.h);
        let mut integrator = Integrator::new(map, &parameters, epsilon, h, x);
        let mut observer = run.invariants().ok()?;
        let mut values = vec![0.0; observer.observables()];
        let mut energy_at = |state: &[f64]| {
            observer.evaluate(state, &mut values);
            values[0]
        };
        let initial = energy_at(x);
        let mut largest = 0.0_f64;
        for _ in 0..STEPS {
            integrator.step().ok()?;
            if integrator.statistics().operations? as f64 > most {
                return None;
            }
            largest = largest.max((energy_at(integrator.state()) - initial).abs());
        }
        let size = if initial == 0.0 { 1.0 } else { initial.abs() };
        Some(Self {
            operations: integrator.statistics().operations_per_step()?,
            energy: largest / size,
            state: integrator.state().to_vec(),
        })
    }

    /// Whether it costs hardly more than `now`.
    pub fn is_as_cheap(&self, now: &Self) -> bool {
        self.operations <= AS_DEAR * now.operations
    }

    /// Whether it costs hardly more than `now` and its energy errs as little.
    pub fn is_worth_it(&self, now: &Self) -> bool {
        self.is_as_cheap(now) && self.energy <= AS_WRONG * now.energy + ROUND_OFF
    }
}
