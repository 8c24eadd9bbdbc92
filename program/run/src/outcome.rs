//! How a run ends.

use std::path::PathBuf;

use leafwise_core::{PartKind, SolverStatistics, StepError};

use serde_json::{Value, json};

use crate::advice::Advice;
use crate::json::json_number;
use leafwise_scene::compose::PartChoice;

/// A step that could not be taken, or a state outside the formulas' domain.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// What happened and what to try.
    pub message: String,
    /// The step that failed, counted from 1.
    pub step: u64,
    /// The time before that step.
    pub time: f64,
    /// The last good state: the one before that step.
    pub state: Vec<f64>,
    /// What to try.
    pub hint: String,
}

impl Failure {
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

    /// What to try with these parts: a stepper has no realization whose order could be raised.
    pub(super) fn of_parts(&mut self, parts: &[PartChoice]) {
        let Some(stepper) = parts.iter().find(|part| part.kind == PartKind::Stepper) else {
            return;
        };
        let instead = match stepper.tolerance() {
            Some(_) => "reduce its tolerance or epsilon*h",
            None => "reduce epsilon*h",
        };
        let of_a_realization = "reduce epsilon*h or raise the realization's order";
        self.hint = self.hint.replace(of_a_realization, instead);
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
    /// It was asked to stop; the same command resumes it.
    Interrupted,
    /// It cannot go on; what was recorded before is in the directory.
    Failed(Failure),
}

/// How far an invariant strayed, over every step.
#[derive(Clone, Debug, PartialEq)]
pub struct InvariantDrift {
    /// Its name.
    pub name: String,
    /// I(x_0).
    pub initial: f64,
    /// max_k |I(x_k) − I(x_0)|.
    pub maximum: f64,
}

impl InvariantDrift {
    /// The drift over |I(x_0)|; it has no meaning where that is 0.
    pub fn relative(&self) -> Option<f64> {
        (self.initial != 0.0).then(|| self.maximum / self.initial.abs())
    }
}

/// A run that has ended and left its directory complete.
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
    /// Seconds of integration, observers included, build and files apart; all sessions together.
    pub wall_seconds: f64,
    /// Energy, then each Casimir.
    pub invariants: Vec<InvariantDrift>,
    /// The solver's work, all sessions together.
    pub statistics: SolverStatistics,
    /// Samples recorded.
    pub samples: u64,
    /// The step an earlier session had come to.
    pub resumed_at: Option<u64>,
    /// Whether it had come to its end before: nothing was computed or written.
    pub is_repeated: bool,
    /// What to change in the scene.
    pub advice: Vec<Advice>,
    /// The run directory.
    pub directory: PathBuf,
}

impl RunReport {
    /// The largest deviations by the invariants' names: `drift` of `run --json` and of the manifest.
    pub fn drift_json(&self) -> Value {
        let entry = |i: &InvariantDrift| (i.name.clone(), json_number(i.maximum));
        Value::Object(self.invariants.iter().map(entry).collect())
    }

    /// Initial value, largest deviation and relative one by the invariants' names: `invariants` of both.
    pub fn invariants_json(&self) -> Value {
        let entry = |invariant: &InvariantDrift| {
            let entry = json!({
                "initial": json_number(invariant.initial),
                "maximum": json_number(invariant.maximum),
                "relative": invariant.relative().map(json_number),
            });
            (invariant.name.clone(), entry)
        };
        Value::Object(self.invariants.iter().map(entry).collect())
    }

    /// The page to open in a browser.
    pub fn report(&self) -> PathBuf {
        self.directory.join("report.html")
    }
}
