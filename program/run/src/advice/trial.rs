//! Trial of a step map along a run: its operations and its energy error.

use leafwise_core::{StepMap, Walk};

use leafwise_scene::compose::ComposedRun;

/// Steps from a state over which operations and energy are measured, the first ones with them.
const STEPS: usize = 32;

/// The first of them, which prepare a kernel and confirm solutions: a run pays for them once.
const FIRST: usize = 8;

/// States from which operations are counted, of the run's.
const STATES: usize = 4;

/// Most operations that the trial of an alternative may take, as a multiple of those of the map that it replaces.
const AS_LONG: u64 = 2;

/// By how much its energy error may be larger: in another chart the generating function is another,
/// and may be a worse one.
const AS_WRONG: f64 = 2.0;

/// An energy error of this part is round-off: a few dozen operations, some steps.
const ROUND_OFF: f64 = 1e-13;

/// Operations, energy error and state of a map over its first steps.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// Operations a step, over as many steps as the run has.
    pub operations: f64,
    /// The largest deviation of the energy over the first steps, relative to it.
    pub energy: f64,
    /// x after the last of these.
    pub state: Vec<f64>,
    /// Operations of the trial itself.
    spent: u64,
}

impl Trial {
    /// Takes the run's steps from some of its states; `None` where one fails or operations are not counted.
    pub fn of<'a>(
        run: &ComposedRun,
        map: &dyn StepMap,
        states: impl IntoIterator<Item = &'a [f64]>,
    ) -> Option<Self> {
        Self::at_most(run, map, states, u64::MAX)
    }

    /// The same of a map that is to replace one that does `now`; `None` too once it has taken many more operations.
    pub fn instead<'a>(
        run: &ComposedRun,
        map: &dyn StepMap,
        states: impl IntoIterator<Item = &'a [f64]>,
        now: &Self,
    ) -> Option<Self> {
        Self::at_most(run, map, states, AS_LONG.saturating_mul(now.spent))
    }

    fn at_most<'a>(
        run: &ComposedRun,
        map: &dyn StepMap,
        states: impl IntoIterator<Item = &'a [f64]>,
        most: u64,
    ) -> Option<Self> {
        let parameters = run.system.parameter_values();
        let (epsilon, h) = (run.plan.epsilon, run.plan.h);
        let mut observer = run.invariants().ok()?;
        let mut values = vec![0.0; observer.observables()];
        let mut energy_at = |state: &[f64]| {
            observer.evaluate(state, &mut values);
            values[0]
        };
        let (mut spent, mut counted, mut later) = (0, 0_u64, 0);
        let mut of_the_first = None;
        for x in states.into_iter().take(STATES) {
            let mut walk = Walk::new(map, &parameters, epsilon, h, x);
            let initial = energy_at(x);
            let (mut largest, mut before) = (0.0_f64, 0);
            let ended = walk.watch_until(STEPS as u64, |walk| {
                let own = walk.statistics().operations;
                let Some(operations) = own.filter(|own| spent + own <= most) else {
                    return Some(());
                };
                if walk.steps() == FIRST as u64 {
                    before = operations;
                }
                largest = largest.max((energy_at(walk.state()) - initial).abs());
                None
            });
            if ended.ok()?.is_some() {
                return None;
            }
            let operations = walk.statistics().operations?;
            spent += operations;
            later += operations - before;
            counted += (STEPS - FIRST) as u64;
            let size = if initial == 0.0 { 1.0 } else { initial.abs() };
            let state = walk.state().to_vec();
            of_the_first.get_or_insert((before, largest / size, state));
        }
        let (first, energy, state) = of_the_first?;
        let steps = run.plan.steps.max(FIRST as u64);
        let each = later as f64 / counted as f64;
        Some(Self {
            operations: (first as f64 + each * (steps - FIRST as u64) as f64) / steps as f64,
            energy,
            state,
            spent,
        })
    }

    /// Whether it costs no more than `now`.
    pub fn is_as_cheap(&self, now: &Self) -> bool {
        self.operations <= now.operations
    }

    /// Whether it costs no more than `now` and its energy errs as little.
    pub fn is_worth_it(&self, now: &Self) -> bool {
        self.is_as_cheap(now) && self.energy <= AS_WRONG * now.energy + ROUND_OFF
    }
}
