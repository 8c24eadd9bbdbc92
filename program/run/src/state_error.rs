//! Estimate of a state's error: two passes, of steps t and t/2.
//!
//! A method of order m errs by C tᵐ, so that |x_t − x_{t/2}| is 1 − 2⁻ᵐ of the error of the first pass. The energy does not
//! show it: an orbit may keep its energy and lag behind in phase.

use leafwise_core::solver::judge::larger;
use leafwise_core::{SystemFormulas, Walk};
use leafwise_scene::compose::{ComposedRun, Refusal};
use leafwise_scene::document::SceneDocument;
use serde::Serialize;
use thiserror::Error;

use crate::outcome::{RunOutcome, RunReport};
use crate::short;

/// The part of the way from the start at which two passes have parted.
const PARTED: f64 = 0.1;

/// Steps between two questions whether to go on.
const BETWEEN_QUESTIONS: u64 = 256;

/// Estimated error of the states of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StateError {
    /// max |x_k − x(t_k)| over the steps and coordinates.
    pub largest: f64,
    /// The time where that is.
    pub time: f64,
    /// max |x_N − x(t_N)| over the coordinates, at the last step N.
    pub at_end: f64,
    /// Whether the passes part by a tenth of the way that the states go: the error is large, and its size is not known.
    pub is_large: bool,
}

/// Why there is no estimate.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoStateError {
    /// The run has noise.
    #[error("other steps draw new noise: compare means of ensembles")]
    Noise,
    /// The run has a pace.
    #[error(
        "with a pace steps of another length end at other times: compare with `leafwise compare`"
    )]
    Pace,
    /// Events change the state.
    #[error("events change the state: run it with half the step, and compare")]
    Acts,
    /// The formulas are smooth in pieces.
    #[error(
        "steps across the seams of functions in pieces err alike in both passes: run it with other steps, and compare"
    )]
    Seams,
    /// The method has no order.
    #[error(
        "a tolerance sets this method's error: run it with a tenth of the tolerance, and compare"
    )]
    NoOrder,
    /// The map is a table of many steps.
    #[error(
        "the generating function holds for steps of {length} alone: compare with the scene whose steps it puts together, as \
         `leafwise tabulate` did"
    )]
    OneLength {
        /// The length of its steps, as text.
        length: String,
    },
    /// Someone wants it to end.
    #[error("it was interrupted")]
    Interrupted,
    /// A step of a pass could not be taken.
    #[error("a pass with steps of {step} fails at t = {time}: {reason}")]
    Failed {
        /// Its step, as text.
        step: String,
        /// The time of the last state.
        time: String,
        /// The solver's error.
        reason: String,
    },
}

/// Refuses a scene that asks for the estimate where there is none: of many runs at once.
pub(crate) fn refuse_estimate(document: &SceneDocument, what: &str) -> Result<(), Refusal> {
    match &document.run.estimates_error {
        None => Ok(()),
        Some(asked) => Err(Box::new(document.diagnostic(
            &asked.place(),
            format!("the error of states is estimated of single runs, and this is {what}"),
            "here",
            Some(
                "remove `error` from [run]: `leafwise run --error` estimates it for the scene's own run"
                    .to_owned(),
            ),
        ))),
    }
}

impl StateError {
    /// Estimates it for a run that is done; `None` for one that was not.
    ///
    /// # Errors
    /// Those of [`measured`](Self::measured).
    pub fn of_report(
        run: &ComposedRun,
        report: &RunReport,
        is_interrupted: &dyn Fn() -> bool,
    ) -> Option<Result<Self, NoStateError>> {
        let is_over = matches!(report.outcome, RunOutcome::Done | RunOutcome::Stopped(_));
        // A condition ends a run within a step.
        let part = u64::from(report.outcome.stopped_by().is_some());
        let steps = report.steps.saturating_sub(part);
        is_over.then(|| Self::measured(run, steps, is_interrupted))
    }

    /// Estimates it over so many steps of a run from its initial state, at the cost of three times these. It is asked at times
    /// whether someone wants it to end.
    ///
    /// # Errors
    /// [`NoStateError`]: noise, a pace, a method without an order, a table, a step that fails, and an interruption.
    pub fn measured(
        run: &ComposedRun,
        steps: u64,
        is_interrupted: &dyn Fn() -> bool,
    ) -> Result<Self, NoStateError> {
        let order = run.method.declared_order();
        if let Some(length) = run.table_step() {
            let length = short(length);
            return Err(NoStateError::OneLength { length });
        }
        let names = run.plan.parts.iter().flat_map(|part| &part.parameters);
        let has_tolerance = names.map(|(name, _)| *name).any(|name| name == "tolerance");
        match (run.method.noise(), run.pace(), order) {
            (Some(_), ..) => return Err(NoStateError::Noise),
            (_, Some(_), _) => return Err(NoStateError::Pace),
            (.., 0) => return Err(NoStateError::NoOrder),
            _ if run.plan.events.act.is_some() => return Err(NoStateError::Acts),
            _ if has_tolerance => return Err(NoStateError::NoOrder),
            _ => {}
        }
        if run
            .system
            .expressions()
            .is_some_and(SystemFormulas::has_seams)
        {
            return Err(NoStateError::Seams);
        }
        let parameters = run.system.parameter_values();
        let (epsilon, h, initial) = (run.plan.epsilon, run.plan.h, &run.plan.initial);
        let walk = |h: f64| Walk::new(run.method.map(), &parameters, epsilon, h, initial);
        let (mut whole, mut halves) = (walk(h), walk(0.5 * h));
        let mut found = Self {
            largest: 0.0,
            time: 0.0,
            at_end: 0.0,
            is_large: false,
        };
        let (mut way, mut parted) = (0.0_f64, 0.0_f64);
        for step in 1..=steps {
            if step.is_multiple_of(BETWEEN_QUESTIONS) && is_interrupted() {
                return Err(NoStateError::Interrupted);
            }
            for (walk, h, times) in [(&mut whole, h, 1), (&mut halves, 0.5 * h, 2)] {
                walk.advance(times).map_err(|error| NoStateError::Failed {
                    step: short(epsilon * h),
                    time: short(epsilon * h * walk.steps() as f64),
                    reason: error.to_string(),
                })?;
            }
            let (x, finer) = (run.own(whole.state()), run.own(halves.state()));
            let apart = x.iter().zip(finer);
            let apart = apart.fold(0.0, |most, (x, finer)| larger(most, (x - finer).abs()));
            let far = x.iter().zip(run.own(initial));
            way = far.fold(way, |most, (x, x0)| larger(most, (x - x0).abs()));
            parted = larger(parted, apart);
            found.at_end = apart;
            // A NaN is no small error.
            if apart.is_nan() || apart > found.largest {
                (found.largest, found.time) = (apart, epsilon * h * step as f64);
            }
        }
        let part = 1.0 - libm::exp2(-(order as f64));
        found.largest /= part;
        found.at_end /= part;
        found.is_large = parted.is_nan() || parted > PARTED * way;
        Ok(found)
    }

    /// In a sentence.
    pub fn text(&self) -> String {
        if self.is_large {
            return format!(
                "large: a pass with half the step differs by {:.1e} at t = {}; shorter steps, or a higher order",
                self.largest,
                short(self.time)
            );
        }
        format!(
            "about {:.1e} at the end, {:.1e} at most, by a pass with half the step",
            self.at_end, self.largest
        )
    }
}
