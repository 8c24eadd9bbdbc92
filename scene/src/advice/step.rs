//! Steps that are too long: others of half their length lead elsewhere.

use leafwise_core::{StepError, Stepper};

use super::{Advice, AdviceKind, number};
use crate::compose::ComposedRun;

/// The part of a step's motion that halving it may change. A method of order m then errs by about (2ᵐ − 1)⁻¹ of it, and
/// its error falls as its order says, or nearly so; above, neither is known.
const COARSE: f64 = 0.1;

/// The part of the motion over the run's [`FIRST`] steps that halving them, or these once more, may change:
/// steps each a little too long err by as much as they move.
const ASTRAY: f64 = 0.25;

/// Steps that are followed from the initial state.
const FIRST: u64 = 4;

/// Where one step and two of half its length, at the run's states, or its first steps and those of a half and
/// a quarter of their length differ by more, or the shorter ones fail.
pub(super) fn advice(run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
    let message = states.iter().find_map(|x| one_step(run, x));
    let message = message.or_else(|| first_steps(run))?;
    let half = 0.5 * run.plan.epsilon * run.plan.h;
    let short: f64 = format!("{half:.12e}").parse().unwrap_or(half);
    Some(Advice {
        kind: AdviceKind::CoarseStep,
        message,
        change: format!("time-step = {short:?}"),
    })
}

/// How a step from x and two of half its length differ, where they do.
fn one_step(run: &ComposedRun, x: &[f64]) -> Option<String> {
    let whole = increment(run, x).ok()?;
    let mut halves = Walk::new(run, x, 2);
    if let Err(error) = halves.advance() {
        return Some(format!(
            "from a state of the run a step is taken, and two of half its length are not: {error}"
        ));
    }
    let part = difference(x, &whole, &halves.increment);
    (part > COARSE).then(|| {
        format!(
            "a step is too long for its order: two of half its length change a coordinate's motion by {} of it",
            number(part)
        )
    })
}

/// How the run's first steps and shorter ones differ, where they do.
fn first_steps(run: &ComposedRun) -> Option<String> {
    let x = &run.plan.initial;
    let [mut whole, mut halves, mut quarters] = [1, 2, 4].map(|parts| Walk::new(run, x, parts));
    for step in 1..=FIRST.min(run.plan.steps) {
        whole.advance().ok()?;
        if let Err(error) = halves.advance().and_then(|()| quarters.advance()) {
            return Some(format!(
                "the first {step} steps are taken, and those of half or a quarter of their length are not: {error}"
            ));
        }
        let part = difference(x, &whole.increment, &halves.increment);
        let part = part.max(difference(x, &halves.increment, &quarters.increment));
        if part > ASTRAY {
            return Some(format!(
                "steps are too long for their order: over the first {step}, those of half or a quarter of their \
                 length change a coordinate's motion by {} of it",
                number(part)
            ));
        }
    }
    None
}

/// What two increments differ by over what they are: the largest of each over the coordinates, relative to these.
pub(super) fn difference(x: &[f64], whole: &[f64], halves: &[f64]) -> f64 {
    let (mut apart, mut motion) = (0.0_f64, 0.0_f64);
    for ((x, whole), halves) in x.iter().zip(whole).zip(halves) {
        let size = x.abs().max((x + whole).abs()).max((x + halves).abs());
        if size > 0.0 {
            apart = apart.max((whole - halves).abs() / size);
            motion = motion.max(halves.abs() / size);
        }
    }
    // Round-off of a state is no motion.
    if apart > f64::EPSILON * 64.0 {
        apart / motion
    } else {
        0.0
    }
}

/// The motion from x over one step of the run.
pub(super) fn increment(run: &ComposedRun, x: &[f64]) -> Result<Vec<f64>, StepError> {
    let mut walk = Walk::new(run, x, 1);
    walk.advance()?;
    Ok(walk.increment)
}

/// A trajectory from a state, by steps of the run in so many parts each.
struct Walk {
    stepper: Box<dyn Stepper>,
    parts: u32,
    state: Vec<f64>,
    /// The motion so far.
    increment: Vec<f64>,
}

impl Walk {
    fn new(run: &ComposedRun, x: &[f64], parts: u32) -> Self {
        let values = run.system.parameter_values();
        let (map, plan) = (run.method.map(), &run.plan);
        Self {
            stepper: map.stepper(1, &values, plan.epsilon, plan.h / f64::from(parts)),
            parts,
            state: x.to_vec(),
            increment: vec![0.0; x.len()],
        }
    }

    /// One step of the run.
    fn advance(&mut self) -> Result<(), StepError> {
        let low = vec![0.0; self.state.len()];
        for _ in 0..self.parts {
            let mut increment = vec![0.0; self.state.len()];
            let mut outcome = [Ok(())];
            self.stepper
                .increment(&self.state, &low, &mut increment, &mut outcome);
            let [outcome] = outcome;
            outcome?;
            for (at, part) in increment.iter().enumerate() {
                self.state[at] += part;
                self.increment[at] += part;
            }
            if self.state.iter().any(|x| !x.is_finite()) {
                return Err(StepError::NonFinite {
                    what: "the new state",
                });
            }
        }
        Ok(())
    }
}
