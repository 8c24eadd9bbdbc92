//! A case: what is asked, what is expected, and what was measured.

use leafwise_core::{BuildError, StepError};
use leafwise_scene::{Refusal, SceneErrors};
use serde::Serialize;

use crate::verify::{FlowError, ProblemError};

/// One extreme.
#[derive(Debug, Serialize)]
pub struct Case {
    /// The family it belongs to.
    pub family: &'static str,
    /// Its name within the family.
    pub name: &'static str,
    /// Task that the case sets the program.
    pub asked: &'static str,
    /// Expected answer, with the reason for its bound.
    pub expected: &'static str,
    /// Runs it.
    #[serde(skip)]
    pub(super) run: fn(&StressOptions) -> Result<Outcome, StressError>,
}

/// How long the long cases run.
#[derive(Clone, Copy, Debug)]
pub struct StressOptions {
    /// Steps of the long orbits.
    pub steps: u64,
}

impl StressOptions {
    /// 10⁶ steps: seconds.
    pub const SHORT: Self = Self { steps: 1_000_000 };
    /// 10⁸ steps: minutes.
    pub const LONG: Self = Self { steps: 100_000_000 };
}

/// Outcome of a case: the measurement, and whether it is as expected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Measurement in words, or the error that prevented it.
    pub measured: String,
    /// Whether it is what was expected.
    #[serde(rename = "met")]
    pub is_met: bool,
}

/// Why a case could not be measured: it is then not met.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StressError {
    /// A system that cannot be set up.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A scene that cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// A scene that cannot be composed.
    #[error("{0}")]
    Refused(Refusal),
    /// A part that cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A step that fails where it should not.
    #[error("a step failed: {0}")]
    Step(#[from] StepError),
    /// A reference flow that cannot be computed.
    #[error(transparent)]
    Flow(#[from] FlowError),
}

impl Case {
    /// Family and name, as the command line takes them.
    pub fn id(&self) -> String {
        format!("{}/{}", self.family, self.name)
    }

    /// Whether `name` is its family or its id.
    pub fn is_called(&self, name: &str) -> bool {
        self.family == name || self.id() == name
    }

    /// Runs it. An error that the case does not expect is an outcome that is not met.
    pub fn run(&self, options: &StressOptions) -> Outcome {
        (self.run)(options).unwrap_or_else(|error| Outcome {
            is_met: false,
            measured: error.to_string(),
        })
    }
}

/// Outcomes of many attempts under one claim.
#[derive(Debug, Default)]
pub(super) struct Tally {
    met: usize,
    failures: Vec<String>,
}

impl Tally {
    /// Counts an attempt; `what` is asked only if it failed.
    pub fn take(&mut self, is_met: bool, what: impl FnOnce() -> String) {
        if is_met {
            self.met += 1;
        } else {
            self.failures.push(what());
        }
    }

    /// The outcome: `summary` where all attempts met the claim, else the first that did not.
    pub fn outcome(self, summary: impl FnOnce(usize) -> String) -> Outcome {
        let Self { met, failures } = self;
        match failures.first() {
            None => Outcome {
                is_met: met > 0,
                measured: summary(met),
            },
            Some(first) => Outcome {
                is_met: false,
                measured: format!(
                    "{} of {} attempts: {first}",
                    failures.len(),
                    met + failures.len()
                ),
            },
        }
    }
}
