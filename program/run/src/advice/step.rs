//! Steps that are too long, and tolerances of adaptive steppers that are too loose: finer ones lead elsewhere.

use std::sync::Arc;

use leafwise_core::{Registry, StepError, StepMap};

use super::motion::Motion;
use super::probe::given;
use super::sizes::Sizes;
use super::{Advice, AdviceKind, JudgedStates, number};
use leafwise_scene::compose::{ComposedRun, PartChoice};

/// The part of a step's motion that halving it may change. A method of order m then errs by about (2ᵐ − 1)⁻¹ of it, and
/// its error falls as its order says, or nearly so; above, neither is known.
const COARSE: f64 = 0.1;

/// Largest part of the motion over the run's [`FIRST`] steps that finer ones, or still finer ones, may change. Steps
/// each a little too long err by as much as they move.
const ASTRAY: f64 = 0.25;

/// Steps that are followed from the initial state.
const FIRST: u64 = 4;

/// Factor that a tolerance is multiplied by.
const TIGHTER: f64 = 1e-2;

/// Methods of other kinds that choose their substeps themselves.
const ADAPTIVE: [&str; 2] = ["dop853", "taylor"];

/// The least tolerance.
const LEAST: f64 = 1e-14;

/// Warning where one step and a finer one, at the run's states, or its first steps and finer ones of two kinds differ
/// by more, or the finer ones fail. Finer are two steps of half the length and four of a quarter. A stepper with a
/// tolerance chooses its substeps itself: finer are tolerances of a hundredth, twice. Then come steps of half the
/// length, at whose ends it looks for what it has stepped over. Its errors may not exceed the root of the tolerance
/// either.
pub(super) fn advice(
    run: &ComposedRun,
    registry: &Registry,
    (states, whose): (&[Vec<f64>], JudgedStates),
) -> Option<Advice> {
    // Of a table no finer steps are made.
    if run.table_step().is_some() {
        return None;
    }
    let finer = Finer::of(run, registry, states, whose);
    let message = states.iter().find_map(|x| finer.over_one_step(x));
    let message = message.or_else(|| finer.over_the_first());
    let (message, change) = match message {
        Some(message) => (message, tighten(run).unwrap_or_else(|| half_the_step(run))),
        None => (finer.stepped_over(states)?, half_the_step(run)),
    };
    Some(Advice {
        kind: AdviceKind::CoarseStep,
        message,
        change,
    })
}

/// The line that halves the step. A table holds for its own step alone.
pub(super) fn half_the_step(run: &ComposedRun) -> String {
    if run.table_step().is_some() {
        return "a table of fewer steps, by `leafwise tabulate --steps`".to_owned();
    }
    // With the digits that were written: 0.1·0.3 is 0.03.
    let (plan, key) = (&run.plan, run.plan.step_key);
    let factor = if key == "h" { 1.0 } else { plan.epsilon };
    let half = 0.5 * factor * plan.h;
    let short: f64 = format!("{half:.12e}").parse().unwrap_or(half);
    format!("{key} = {short:?}")
}

/// The line with a hundredth of the stepper's tolerance, where it has one and takes that.
pub(super) fn tighten(run: &ComposedRun) -> Option<String> {
    let (stepper, tolerance) = adaptive(run)?;
    let tighter = tighter(tolerance);
    let name = stepper.name;
    if tighter < tolerance {
        return Some(format!(
            "stepper = {{ name = \"{name}\", tolerance = {tighter:?} }}"
        ));
    }
    // No finer one is to be had: another method, which errs otherwise, at the least tolerance that it takes.
    let other = ADAPTIVE.iter().find(|other| **other != name)?;
    Some(format!(
        "stepper = {{ name = \"{other}\", tolerance = {LEAST:?} }}"
    ))
}

fn tighter(tolerance: f64) -> f64 {
    let tighter = (TIGHTER * tolerance).max(LEAST).min(tolerance);
    format!("{tighter:.12e}").parse().unwrap_or(tighter)
}

/// The run's stepper with a tolerance.
fn adaptive(run: &ComposedRun) -> Option<(&PartChoice, f64)> {
    let mut parts = run.plan.parts.iter();
    parts.find_map(|part| Some((part, part.tolerance()?)))
}

/// The run's map, and its stepper with a hundredth of its tolerance and that of this.
struct Finer<'a> {
    run: &'a ComposedRun,
    tighter: Option<[Arc<dyn StepMap>; 2]>,
    /// The root of the tolerance, of which errors within it stay far below; infinite without one.
    outgrown: f64,
    sizes: Sizes,
    whose: JudgedStates,
}

impl<'a> Finer<'a> {
    fn of(
        run: &'a ComposedRun,
        registry: &Registry,
        states: &[Vec<f64>],
        whose: JudgedStates,
    ) -> Self {
        let tighter = adaptive(run).and_then(|(stepper, tolerance)| {
            let part = registry.stepper(stepper.name).ok()?;
            let with = |tolerance: f64| {
                let given = given(stepper).with("tolerance", tolerance);
                part.build(&run.system, &given).ok()
            };
            let first = tighter(tolerance);
            Some([with(first)?, with(tighter(first))?])
        });
        let tolerance = adaptive(run).map(|(_, tolerance)| tolerance);
        let outgrown = tolerance.map_or(f64::INFINITY, libm::sqrt);
        Self {
            run,
            tighter,
            outgrown,
            sizes: Sizes::of(run, states),
            whose,
        }
    }

    /// From x: the run's steps, finer ones and still finer ones.
    fn walks(&self, x: &[f64]) -> [Motion; 3] {
        let (run, own) = (self.run, self.run.method.map());
        match &self.tighter {
            None => [1, 2, 4].map(|parts| Motion::new(run, own, x, parts)),
            Some([first, second]) => {
                [own, first.as_ref(), second.as_ref()].map(|map| Motion::new(run, map, x, 1))
            }
        }
    }

    fn over_one_step(&self, x: &[f64]) -> Option<String> {
        let [mut whole, mut finer, _] = self.walks(x);
        if let Err(error) = whole.advance() {
            // A run and the members of an ensemble say themselves that their first step fails.
            let is_first = *x == self.run.plan.initial;
            let what = match self.whose {
                JudgedStates::OfTheRun => "a step of the run fails when it is repeated",
                JudgedStates::Ahead => "a step later in the run fails when it is repeated",
                JudgedStates::OfMembers => return None,
            };
            return (!is_first).then(|| format!("{what}: {error}"));
        }
        if let Err(error) = finer.advance() {
            return self.refusal("a step succeeds, and two of half its length fail", &error);
        }
        let part = self.difference(x, [&whole, &finer], COARSE);
        (part > self.outgrown.min(COARSE)).then(|| match self.tighter {
            None => format!(
                "a step is too long for its order: two of half its length change a coordinate's motion by {} of it",
                number(part)
            ),
            Some(_) => format!(
                "errors outgrow the stepper's tolerance: a hundredth of it changes a coordinate's motion over one step \
                 by {} of it",
                number(part)
            ),
        })
    }

    fn over_the_first(&self) -> Option<String> {
        let x = &self.run.plan.initial;
        let [mut whole, mut finer, mut finest] = self.walks(x);
        for step in 1..=FIRST.min(self.run.plan.steps) {
            whole.advance().ok()?;
            if let Err(error) = finer.advance().and_then(|()| finest.advance()) {
                let what = format!(
                    "the first {step} steps succeed, and those of half or a quarter of their length fail"
                );
                return self.refusal(&what, &error);
            }
            let part = self.difference(x, [&whole, &finer], ASTRAY);
            let part = part.max(self.difference(x, [&finer, &finest], ASTRAY));
            if part > self.outgrown.min(ASTRAY) {
                let part = number(part);
                return Some(match self.tighter {
                    None => format!(
                        "steps are too long for their order: over the first {step}, those of half or a quarter of \
                         their length change a coordinate's motion by {part} of it"
                    ),
                    Some(_) => format!(
                        "errors outgrow the stepper's tolerance: a hundredth of it, or of that, changes a coordinate's \
                         motion over the first {step} steps by {part} of it"
                    ),
                });
            }
        }
        None
    }

    /// Of a stepper that chooses its substeps, where two steps of half the length lead elsewhere.
    fn stepped_over(&self, states: &[Vec<f64>]) -> Option<String> {
        self.tighter.as_ref()?;
        let (run, own) = (self.run, self.run.method.map());
        states.iter().find_map(|x| {
            let [mut whole, mut halves] = [1, 2].map(|parts| Motion::new(run, own, x, parts));
            whole.advance().and_then(|()| halves.advance()).ok()?;
            let part = self.sizes.difference(x, &whole.increment, &halves.increment);
            (part > self.outgrown.min(COARSE)).then(|| {
                format!(
                    "the stepper misses something shorter than a step: two of half its length change a coordinate's \
                     motion by {} of it",
                    number(part)
                )
            })
        })
    }

    /// How far the motions of two are apart, as a part of the finer one; of a state at rest, whose motion is all error,
    /// those of its neighbours.
    fn difference(&self, x: &[f64], [coarse, finer]: [&Motion; 2], allowed: f64) -> f64 {
        let increments = [coarse, finer].map(|motion| motion.increment.as_slice());
        let part = self.sizes.difference(x, increments[0], increments[1]);
        if part <= allowed || self.tighter.is_some() {
            return part;
        }
        let (run, own) = (self.run, self.run.method.map());
        let of_neighbours = || {
            let tangents = [coarse.tangent(run, own)?, finer.tangent(run, own)?];
            self.sizes
                .at_rest(x, increments, [&tangents[0], &tangents[1]])
        };
        of_neighbours().unwrap_or(part)
    }

    /// Shorter steps that fail say something of the step; substeps of a smaller tolerance may be too many.
    fn refusal(&self, what: &str, error: &StepError) -> Option<String> {
        let is_told = self.tighter.is_none();
        is_told.then(|| format!("{what}: {error}"))
    }
}
