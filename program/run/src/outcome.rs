//! How a run ends.

use leafwise_core::part::ParameterSetting;
use leafwise_core::{Hint, PartKind, SolverStatistics, StepError};
use leafwise_scene::compose::{ComposedRun, PartChoice};
use leafwise_walk::{Ended, Fault};
use serde::Serialize;

use crate::advice::Advice;
use crate::chaos::ChaosVerdict;
use crate::columns::invariant_name;
use crate::invariants::InvariantDrift;
use crate::seam::crossed;
use crate::shadow::ShadowVerdict;
use leafwise_scene::json::{Double, double, doubles};

/// A step that could not be taken, or a state outside the formulas' domain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// Message on what happened.
    pub message: String,
    /// The step that failed, counted from 1.
    pub step: u64,
    /// The time before that step.
    #[serde(serialize_with = "double")]
    pub time: f64,
    /// The last good state: the one before that step.
    #[serde(serialize_with = "doubles")]
    pub state: Vec<f64>,
    /// Advice on what to try.
    pub hint: String,
}

impl Failure {
    /// The failure of a lane that has ended by a fault.
    pub(crate) fn of(fault: &Fault, ended: &Ended, run: &ComposedRun) -> Self {
        let (steps, time, state) = (ended.steps, ended.time, run.own(&ended.state));
        match fault {
            Fault::Step(error) => {
                let failure = Self::of_step(error, run, steps, time, state);
                let is_of_seams =
                    error.is_of_a_solve() || matches!(error, StepError::Singularity { .. });
                match crossed(run, &ended.state).filter(|_| is_of_seams) {
                    Some(seam) => failure.at_seam(&seam),
                    None => failure,
                }
            }
            Fault::Undefined(text) => {
                Self::of_observable(&format!("`{text}`"), run, steps, time, state)
            }
            Fault::Outside => {
                Self::of_observable(invariant_name(run, 0), run, steps, time, state)
            }
            Fault::Leaf => Self {
                message: fault.to_string(),
                step: steps + 1,
                time,
                state: state.to_vec(),
                hint: "record fewer exponents: as many as coordinates with a bracket and H alone; with forces, a pace or a time in H one \
                       for every two dimensions of the symplectic leaf; and none at a state where the bracket vanishes"
                    .to_owned(),
            },
            Fault::Accumulates(_) => Self {
                message: fault.to_string(),
                step: steps + 1,
                time,
                state: state.to_vec(),
                hint: "end the run before, by a condition that holds near rest, as stop = \"p^2/2 + q < 1e-6\"".to_owned(),
            },
            Fault::TooMany(..) => Self {
                message: fault.to_string(),
                step: steps + 1,
                time,
                state: state.to_vec(),
                hint: format!(
                    "reduce {}, or move the surface away from where the event leads",
                    step_key(run)
                ),
            },
            fault => Self {
                message: fault.to_string(),
                step: steps + 1,
                time,
                state: state.to_vec(),
                hint: format!(
                    "write a pace that is positive along the motion, or reduce {}",
                    step_key(run)
                ),
            },
        }
    }

    /// The same where the step crosses a seam, at which its equation may have no solution.
    fn at_seam(self, seam: &str) -> Self {
        Self {
            message: format!(
                "{}; the step crosses a seam of the formulas, where `{seam}` goes from one piece to another",
                self.message
            ),
            hint: "take splitting, or dop853, whose substeps end at seams, or a smooth function such as tanh instead of a \
                   jump: the equation of an implicit step may have no solution there"
                .to_owned(),
            ..self
        }
    }

    /// The failure of a step of a run from `state`.
    pub(crate) fn of_step(
        error: &StepError,
        run: &ComposedRun,
        steps: u64,
        time: f64,
        state: &[f64],
    ) -> Self {
        let (message, hint) = told(error, &run.plan.parts, &step_key(run));
        Self {
            message,
            step: steps + 1,
            time,
            state: state.to_vec(),
            hint,
        }
    }

    /// An invariant that has no value at the state after `steps` steps: no further step is taken.
    pub(crate) fn of_observable(
        name: &str,
        run: &ComposedRun,
        steps: u64,
        time: f64,
        state: &[f64],
    ) -> Self {
        let place = if steps == 0 {
            "the initial state"
        } else {
            "this state"
        };
        let hint = if steps == 0 {
            "check `initial` and the parameters: no ln or root of a negative number, no division \
             by zero"
                .to_owned()
        } else {
            let shorter = Hint::ReduceStepOrRaiseOrder;
            let shorter = fitting(shorter, &run.plan.parts).with_step(&step_key(run));
            format!(
                "{shorter}, or check `initial`: the state left the formulas' domain (ln or root of a negative number, \
                 division by zero)"
            )
        };
        Self {
            message: format!("{name} has no finite value at {place}"),
            step: steps + 1,
            time,
            state: state.to_vec(),
            hint,
        }
    }
}

/// The scene's key of the length of a step, as it is quoted.
fn step_key(run: &ComposedRun) -> String {
    format!("`{}`", run.plan.step_key)
}

/// Message and advice of a step that could not be taken with these parts.
fn told(error: &StepError, parts: &[PartChoice], step_key: &str) -> (String, String) {
    if overturns(error, parts) {
        return (
            "the increment is not finite: in one step a whole body moves beyond the range of its flow (about half a nutation, 64 radians, a period of an ellipse, or 8 units of a hyperbola's anomaly, over which \
             the distance from the centre grows by up to e^8), or falls into the centre, or the state left the formulas' \
             domain"
                .to_owned(),
            format!("reduce {step_key}, or take bodies by their terms: bodies = \"axes\""),
        );
    }
    let stated = error.hint().unwrap_or(Hint::ReduceStep);
    let hint = match fitting(stated, parts) {
        // The state has a key too.
        Hint::CheckInitialOrReduceStep => format!("check `initial` or reduce {step_key}"),
        hint => hint.with_step(step_key),
    };
    (error.cause().to_string(), hint)
}

/// Advice with these parts: a stepper has no realization, and an exact realization no order that could be raised.
fn fitting(stated: Hint, parts: &[PartChoice]) -> Hint {
    if stated != Hint::ReduceStepOrRaiseOrder {
        return stated;
    }
    let mut realizations = parts.iter().filter(|p| p.kind == PartKind::Realization);
    match stepper(parts) {
        Some(stepper) if stepper.tolerance().is_some() => Hint::RaiseToleranceOrReduceStep,
        None if realizations
            .any(|part| part.parameters.iter().any(|(name, _)| *name == "order")) =>
        {
            stated
        }
        _ => Hint::ReduceStep,
    }
}

/// Whether a body that is taken whole may have turned too far: it turns exactly over short steps alone.
fn overturns(error: &StepError, parts: &[PartChoice]) -> bool {
    let whole = ("bodies", ParameterSetting::Text("whole".to_owned()));
    *error == StepError::OF_INCREMENT
        && stepper(parts).is_some_and(|stepper| stepper.parameters.contains(&whole))
}

fn stepper(parts: &[PartChoice]) -> Option<&PartChoice> {
    parts.iter().find(|part| part.kind == PartKind::Stepper)
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum RunOutcome {
    /// All steps were made.
    Done,
    /// The scene's condition, as written, began to hold.
    Stopped(String),
    /// It was asked to stop; the same command resumes it.
    Interrupted,
    /// It cannot go on; what was recorded before is in the directory.
    Failed(Failure),
}

impl RunOutcome {
    /// In a word: `done`, `stopped`, `interrupted`, `failed`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Stopped(_) => "stopped",
            Self::Interrupted => "interrupted",
            Self::Failed(_) => "failed",
        }
    }

    /// The condition that ended the run, where one did.
    pub fn stopped_by(&self) -> Option<&str> {
        match self {
            Self::Stopped(condition) => Some(condition),
            _ => None,
        }
    }

    /// Why the run failed, where it did.
    pub fn failure(&self) -> Option<&Failure> {
        match self {
            Self::Failed(failure) => Some(failure),
            _ => None,
        }
    }
}

/// Fields of a solver's work that programs are told.
#[derive(Serialize)]
#[serde(remote = "SolverStatistics")]
pub struct SolverFields {
    #[serde(getter = "SolverStatistics::evaluations_per_step")]
    evaluations_per_step: f64,
    #[serde(getter = "SolverStatistics::operations_per_step")]
    operations_per_step: Option<f64>,
    failures: u64,
    rounded: u64,
    held: f64,
}

/// A run that has ended.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// How it ended.
    pub outcome: RunOutcome,
    /// The last state.
    pub final_state: Vec<f64>,
    /// The last time.
    pub time: f64,
    /// Steps made.
    pub steps: u64,
    /// The least and the largest time of a step, where they differ by a pace.
    pub step_times: Option<[f64; 2]>,
    /// Seconds of integration, observers included, build and files apart; all sessions together.
    pub wall_seconds: f64,
    /// Energy, then each Casimir.
    pub invariants: Vec<InvariantDrift>,
    /// The solver's work, all sessions together.
    pub statistics: SolverStatistics,
    /// Samples recorded.
    pub samples: u64,
    /// Crossings recorded, where there is a section.
    pub crossings: Option<u64>,
    /// The step an earlier session had come to.
    pub resumed_at: Option<u64>,
    /// Whether it was already complete: nothing was computed or written.
    pub is_repeated: bool,
    /// How the energy of the map's shadow was kept, where it is recorded.
    pub shadow: Option<ShadowVerdict>,
    /// Whether the motion is regular or chaotic, where MEGNO is recorded.
    pub chaos: Option<ChaosVerdict>,
    /// Advice on what to change in the scene.
    pub advice: Vec<Advice>,
}

impl RunReport {
    /// The largest deviations by the invariants' names: `drift` of `run --json` and of the manifest.
    pub fn drift(&self) -> Vec<(&str, Double)> {
        let drift = |(name, invariant): (_, &InvariantDrift)| (name, Double(invariant.maximum));
        self.named_invariants().into_iter().map(drift).collect()
    }

    /// The invariants by their names: `invariants` of both.
    pub fn named_invariants(&self) -> Vec<(&str, &InvariantDrift)> {
        let all = self.invariants.iter();
        all.map(|invariant| (invariant.name.as_str(), invariant))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use leafwise_core::part::ParameterSetting;
    use leafwise_core::{PartKind, StepError};
    use leafwise_scene::compose::PartChoice;

    fn part(kind: PartKind, parameters: Vec<(&'static str, ParameterSetting)>) -> PartChoice {
        PartChoice {
            kind,
            name: "acme/part",
            parameters,
            is_automatic: false,
            reason: None,
            origin: None,
            path: None,
        }
    }

    fn told(error: &StepError, parts: &[PartChoice]) -> (String, String) {
        super::told(error, parts, "`h`")
    }

    #[test]
    fn only_what_the_parts_have_is_advised() {
        let error = StepError::NoConvergence {
            evaluations: 20,
            correction: 1e-3,
        };
        let exact = part(PartKind::Realization, Vec::new());
        let series = part(PartKind::Realization, vec![("order", 4.into())]);
        let plain = part(PartKind::Stepper, Vec::new());
        let adaptive = part(PartKind::Stepper, vec![("tolerance", 1e-6.into())]);
        let message = error.cause().to_string();
        for (part, hint) in [
            (exact, "reduce `h`"),
            (series, "reduce `h` or raise the realization's order"),
            (plain, "reduce `h`"),
            (adaptive, "raise its tolerance or reduce `h`"),
        ] {
            assert_eq!(told(&error, &[part]), (message.clone(), hint.to_owned()));
        }
    }

    #[test]
    fn a_body_taken_whole_is_named_where_the_increment_fails() {
        let whole = [part(PartKind::Stepper, vec![("bodies", "whole".into())])];
        let axes = [part(PartKind::Stepper, vec![("bodies", "axes".into())])];
        let other = StepError::NonFinite { what: "the field" };
        let (message, hint) = told(&StepError::OF_INCREMENT, &whole);
        assert!(
            message.contains("a whole body moves beyond the range of its flow"),
            "{message}"
        );
        assert!(hint.contains("bodies = \"axes\""), "{hint}");
        for (error, parts) in [(&StepError::OF_INCREMENT, &axes), (&other, &whole)] {
            let (message, hint) = told(error, parts);
            assert_eq!(message, error.cause().to_string());
            assert_eq!(hint, "check `initial` or reduce `h`");
        }
    }

    /// Words of a part outside the program stay together, whatever stands in them.
    #[test]
    fn the_words_of_a_part_are_not_taken_for_a_hint() {
        let error = StepError::Part {
            part: "acme/part".to_owned(),
            message: "no root; the table ends at 3".to_owned(),
        };
        let (message, hint) = told(&error, &[]);
        assert_eq!(message, error.to_string());
        assert_eq!(hint, "reduce `h`");
    }
}
