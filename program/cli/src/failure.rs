//! Errors and their exit codes.

use std::io;
use std::path::PathBuf;

use leafwise::core::{BuildError, StepError};
use leafwise::plugins::PluginError;
use leafwise::report::ReportError;
use leafwise::reproduce::ReproduceError;
use leafwise::run::RunError;
use leafwise::run::shards::MergeError;
use leafwise::scene::SceneDiagnostic;
use leafwise::scene::compose::Refusal;
use leafwise::trade::TradeError;
use serde::Serialize;
use thiserror::Error;

use crate::console::Console;
use crate::guide::page_of;

/// The exit codes of the program.
pub mod exit {
    /// Done.
    pub const DONE: u8 = 0;
    /// The run failed: diverged, left its chart, or could not be written.
    pub const RUN_FAILED: u8 = 1;
    /// The command line asks for something that is not there or not allowed.
    pub const USAGE: u8 = 2;
    /// The scene is not valid.
    pub const INVALID_SCENE: u8 = 3;
    /// A plugin was refused.
    pub const PLUGIN_REFUSED: u8 = 4;
    /// A check failed.
    pub const CHECK_FAILED: u8 = 5;
    /// Some members of an ensemble or settings of a sweep failed: the results are those of the others.
    pub const SOME_FAILED: u8 = 6;
    /// Interrupted, with a checkpoint written.
    pub const INTERRUPTED: u8 = 130;
}

/// Why a command did not do what it was asked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Failure {
    /// Something wrong on the command line, with what to do instead.
    #[error("{message}")]
    Usage {
        /// Message on what is wrong.
        message: String,
        /// Advice on what to do instead.
        help: Option<String>,
    },
    /// A file that cannot be read or written.
    #[error("cannot {action} {}: {source}", file.display())]
    File {
        /// "read" or "write".
        action: &'static str,
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A scene that is not valid: each problem where it stands.
    #[error("the scene is not valid")]
    Scene(Vec<SceneDiagnostic>),
    /// A plugin that was refused, with its place in the scene that names it.
    #[error("{error}")]
    Plugin {
        /// Why.
        error: Box<PluginError>,
        /// Where it is named.
        place: Option<Box<SceneDiagnostic>>,
    },
    /// A run that could not be started or kept on disk.
    #[error(transparent)]
    Run(RunError),
    /// A step that could not be made where energies are compared.
    #[error("step {step} failed: {error}")]
    Step {
        /// Which, counted from 1.
        step: u64,
        /// Why.
        error: StepError,
    },
    /// Shards that were not joined.
    #[error(transparent)]
    Merge(Box<MergeError>),
    /// Methods that could not be compared.
    #[error(transparent)]
    Trade(TradeError),
    /// A figure of the paper that could not be measured.
    #[error(transparent)]
    Reproduce(Box<ReproduceError>),
    /// A figure that could not be drawn.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A formula that could not be evaluated.
    #[error(transparent)]
    Build(#[from] BuildError),
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        Self::Scene(vec![*refusal])
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Refused(refusal) => refusal.into(),
            other => Self::Run(other),
        }
    }
}

impl From<TradeError> for Failure {
    fn from(error: TradeError) -> Self {
        match error {
            TradeError::Refused(refusal) => refusal.into(),
            TradeError::Build(error) => error.into(),
            other => Self::Trade(other),
        }
    }
}

impl From<ReproduceError> for Failure {
    fn from(error: ReproduceError) -> Self {
        Self::Reproduce(Box::new(error))
    }
}

impl Failure {
    /// A usage error with what to do instead.
    pub fn usage(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Usage {
            message: message.into(),
            help: Some(help.into()),
        }
    }

    /// The refusal of a plugin.
    pub fn plugin(error: PluginError, place: Option<SceneDiagnostic>) -> Self {
        Self::Plugin {
            error: Box::new(error),
            place: place.map(Box::new),
        }
    }

    /// The program's exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Usage { .. } | Self::File { action: "read", .. } => exit::USAGE,
            Self::File { .. } => exit::RUN_FAILED,
            Self::Plugin { .. } => exit::PLUGIN_REFUSED,
            Self::Scene(_) | Self::Build(_) => exit::INVALID_SCENE,
            Self::Run(error) if error.is_usage() => exit::USAGE,
            Self::Trade(TradeError::NoReference { .. }) | Self::Report(_) => exit::RUN_FAILED,
            Self::Trade(_) => exit::USAGE,
            Self::Reproduce(error) => match error.as_ref() {
                ReproduceError::UnknownFigure { .. } => exit::USAGE,
                _ => exit::RUN_FAILED,
            },
            Self::Merge(error) => match error.as_ref() {
                MergeError::Missing(_) => exit::CHECK_FAILED,
                _ => exit::USAGE,
            },
            Self::Run(_) | Self::Step { .. } => exit::RUN_FAILED,
        }
    }

    /// Prints the error, as a JSON object too where one was asked for; returns the exit code.
    pub fn print(&self, console: &mut Console<'_>, json: bool) -> u8 {
        match self {
            Self::Scene(problems) => {
                for problem in problems {
                    let text = problem.render(console.color);
                    console.prose(&text);
                }
                if let Some(last) = problems.last() {
                    console.prose(&format!("  = more: leafwise explain {}", page_of(last)));
                }
            }
            Self::Plugin {
                place: Some(place), ..
            } => {
                let text = place.render(console.color);
                console.prose(&text);
            }
            _ => {
                console.prose(&format!("{} {self}", console.error_word()));
                if let Self::Usage {
                    help: Some(help), ..
                } = self
                {
                    console.prose(&format!("  = help: {help}"));
                }
            }
        }
        if json {
            console.json(&self.json());
        }
        self.code()
    }

    /// The object of a command that did not do what it was asked.
    pub(crate) fn json(&self) -> FailureJson<'_> {
        let problem = |problem: &SceneDiagnostic| {
            let (line, column) = problem.line_column();
            Problem {
                message: problem.message.clone(),
                file: problem.source_name.clone(),
                line,
                column,
                help: problem.help.clone(),
            }
        };
        FailureJson {
            outcome: match self.code() {
                exit::RUN_FAILED => "failed",
                _ => "refused",
            },
            error: Reason {
                message: self.to_string(),
                problems: match self {
                    Self::Scene(problems) => Some(problems.iter().map(problem).collect()),
                    _ => None,
                },
                plugin: match self {
                    Self::Plugin { error, .. } => Some(error),
                    _ => None,
                },
            },
        }
    }
}

/// A failure for programs.
#[derive(Serialize)]
pub(crate) struct FailureJson<'a> {
    outcome: &'static str,
    error: Reason<'a>,
}

/// Why, with the problems of a scene or the refusal of a plugin.
#[derive(Serialize)]
struct Reason<'a> {
    message: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    problems: Option<Vec<Problem>>,
    #[serde(flatten)]
    plugin: Option<&'a PluginError>,
}

/// A problem where it stands.
#[derive(Serialize)]
struct Problem {
    message: String,
    file: String,
    line: usize,
    column: usize,
    help: Option<String>,
}
