//! How a run ends.

use leafwise_core::part::ParameterSetting;
use leafwise_core::{PartKind, SolverStatistics, StepError};
use leafwise_scene::compose::{ComposedRun, PartChoice};
use leafwise_walk::{Ended, Fault};
use serde::Serialize;

use crate::advice::Advice;
use crate::columns::invariant_name;
use crate::shadow::ShadowVerdict;
use leafwise_scene::json::{Double, double, doubles, optional};

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

/// The hint of a solver that knows nothing of its parts.
const OF_A_REALIZATION: &str = "reduce epsilon*h or raise the realization's order";

impl Failure {
    /// The failure of a lane that has ended by a fault.
    pub(crate) fn of(fault: &Fault, ended: &Ended, run: &ComposedRun) -> Self {
        let (steps, time, state) = (ended.steps, ended.time, run.own(&ended.state));
        match fault {
            Fault::Step(error) => {
                let mut failure = Self::of_step(error, steps, time, state);
                failure.of_parts(&run.plan.parts);
                failure
            }
            Fault::Undefined(text) => Self::of_observable(&format!("`{text}`"), steps, time, state),
            Fault::Outside => Self::of_observable(invariant_name(run, 0), steps, time, state),
            fault => Self {
                message: fault.to_string(),
                step: steps + 1,
                time,
                state: state.to_vec(),
                hint: "write a pace that is positive along the motion, or reduce epsilon*h"
                    .to_owned(),
            },
        }
    }

    /// The failure of a step from `state`.
    pub(crate) fn of_step(error: &StepError, steps: u64, time: f64, state: &[f64]) -> Self {
        let text = error.to_string();
        // The solver's messages end in what to try, after a semicolon.
        let (message, hint) = text
            .split_once("; ")
            .unwrap_or((text.as_str(), "reduce epsilon*h"));
        Self {
            message: message.to_owned(),
            step: steps + 1,
            time,
            state: state.to_vec(),
            hint: hint.to_owned(),
        }
    }

    /// Fits message and hint to these parts. A stepper has no realization, an exact realization no order that could be
    /// raised, and a body that is taken whole turns exactly over short steps alone.
    pub(crate) fn of_parts(&mut self, parts: &[PartChoice]) {
        let stepper = parts.iter().find(|part| part.kind == PartKind::Stepper);
        let mut realizations = parts.iter().filter(|p| p.kind == PartKind::Realization);
        let has_order =
            realizations.any(|part| part.parameters.iter().any(|(name, _)| *name == "order"));
        let instead = match stepper {
            Some(stepper) if stepper.tolerance().is_some() => {
                "raise its tolerance or reduce epsilon*h"
            }
            None if has_order => OF_A_REALIZATION,
            _ => "reduce epsilon*h",
        };
        self.hint = self.hint.replace(OF_A_REALIZATION, instead);
        let Some(stepper) = stepper else {
            return;
        };
        let whole = ParameterSetting::Text("whole".to_owned());
        if stepper.parameters.contains(&("bodies", whole))
            && self.message.starts_with("the increment is not finite")
        {
            self.message = "the increment is not finite: in one step a body that is taken whole turns further than its flow \
                            is formed for, about half a nutation or 64 radians, or the state left the formulas' domain"
                .to_owned();
            "reduce epsilon*h, or take the axes of bodies one by one: bodies = \"axes\""
                .clone_into(&mut self.hint);
        }
    }

    /// An invariant that has no value at the state after `steps` steps: no further step is taken.
    pub(crate) fn of_observable(name: &str, steps: u64, time: f64, state: &[f64]) -> Self {
        let place = if steps == 0 {
            "the initial state"
        } else {
            "this state"
        };
        let hint = if steps == 0 {
            "check `initial` and the parameters: no ln or root of a negative number, no division \
             by zero"
        } else {
            "reduce epsilon*h, raise the realization's order, or check `initial`: the state left \
             the formulas' domain (ln or root of a negative number, division by zero)"
        };
        Self {
            message: format!("{name} has no finite value at {place}"),
            step: steps + 1,
            time,
            state: state.to_vec(),
            hint: hint.to_owned(),
        }
    }
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

/// How far an invariant strayed, over every step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InvariantDrift {
    /// Its name.
    #[serde(skip)]
    pub name: String,
    /// I(x_0).
    #[serde(serialize_with = "double")]
    pub initial: f64,
    /// max_k |I(x_k) − I(x_0)|.
    #[serde(serialize_with = "double")]
    pub maximum: f64,
    /// The same over |I(x_0)|; it has no meaning where that is 0, or no more than its round-off.
    #[serde(serialize_with = "optional")]
    pub relative: Option<f64>,
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
    /// Whether it had come to its end before: nothing was computed or written.
    pub is_repeated: bool,
    /// How the energy of the map's shadow was kept, where it is recorded.
    pub shadow: Option<ShadowVerdict>,
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
