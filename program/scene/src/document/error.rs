//! Errors of a scene's text.

use std::fmt;

use thiserror::Error;

use super::located::{FOUND, Place, Source};
use super::shape::names;
use super::suggest::nearest;
use super::system_schema::{BRACKET, SUM};
use crate::diagnostic::SceneDiagnostic;

/// One thing wrong with a scene, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{cause}")]
pub struct SceneProblem {
    /// Cause: the way in which the text is wrong.
    pub cause: SceneProblemCause,
    /// Where it is written.
    pub place: Place,
}

/// Names that a formula of constants may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstantNames {
    /// None.
    None,
    /// Those of other parameters.
    Parameters,
}

impl fmt::Display for ConstantNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "numbers",
            Self::Parameters => "numbers and other parameters",
        })
    }
}

/// The ways a scene's text can be wrong.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneProblemCause {
    /// The text is not TOML.
    #[error("not valid TOML: {message}")]
    Syntax {
        /// The TOML parser's message.
        message: String,
        /// The line as it should be, where that is known.
        slip: Option<String>,
    },
    /// A key the table does not have.
    #[error("unknown key `{key}` in {table}")]
    UnknownKey {
        /// The key as written.
        key: String,
        /// The table, as a reader of the scene calls it.
        table: String,
        /// The nearest valid key.
        nearest: Option<String>,
        /// All valid keys.
        valid: Vec<String>,
    },
    /// A name that stands for nothing.
    #[error("unknown {kind} `{name}`")]
    UnknownName {
        /// Kind of thing that the name should stand for.
        kind: &'static str,
        /// The name as written.
        name: String,
        /// The nearest valid name.
        nearest: Option<String>,
        /// All valid names.
        valid: Vec<String>,
    },
    /// A value of another type than the key's.
    #[error("`{key}` must be {expected}, found {found}")]
    WrongType {
        /// The key.
        key: String,
        /// The type the key takes.
        expected: String,
        /// The type found.
        found: String,
    },
    /// A list or a table where one value is asked for.
    #[error("`{key}` takes one formula or number, found {found}")]
    NotOne {
        /// The key.
        key: String,
        /// Kind of value found: a list or a table.
        found: &'static str,
    },
    /// A text that is no formula of numbers.
    #[error("`{key}` is neither a number nor a formula of {names}: {reason}")]
    NoConstant {
        /// The key.
        key: String,
        /// The text.
        text: String,
        /// Why not.
        reason: String,
        /// Names that it may have.
        names: ConstantNames,
        /// Whether a name of the state stands in it.
        is_of_state: bool,
    },
    /// A time at the end that is too many steps away.
    #[error("`until` = {until} is more than 9e15 steps of {step}")]
    TooManySteps {
        /// The time as written.
        until: String,
        /// t of a step.
        step: f64,
    },
    /// A required key is absent.
    #[error("{table} needs `{key}`")]
    MissingKey {
        /// The table.
        table: String,
        /// The absent key.
        key: String,
        /// A line that would do.
        example: String,
    },
    /// NaN, an infinity, or a literal beyond the doubles.
    #[error("`{key}` must be a finite number, found {literal}")]
    NotFinite {
        /// The key.
        key: String,
        /// The literal as written.
        literal: String,
    },
    /// A number outside the key's range.
    #[error("`{key}` must be {allowed}, found {value}")]
    OutOfRange {
        /// The key.
        key: String,
        /// The value as written.
        value: String,
        /// The range.
        allowed: String,
    },
    /// Two keys that say the same thing.
    #[error("`{second}` cannot be combined with `{first}`")]
    Conflict {
        /// One key.
        first: String,
        /// The other, where the problem is reported.
        second: String,
        /// Advice on the change to make instead.
        advice: String,
    },
    /// A list or matrix of the wrong shape.
    #[error("{what} has {found}, expected {expected}")]
    Shape {
        /// The list.
        what: String,
        /// Its shape.
        found: String,
        /// The shape it must have.
        expected: String,
    },
    /// A name declared twice.
    #[error("`{name}` is declared twice")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// A name no formula could use.
    #[error("`{name}` cannot name a {kind}")]
    InvalidName {
        /// Kind of thing that it should name.
        kind: &'static str,
        /// The name as written.
        name: String,
        /// Why not.
        reason: &'static str,
    },
    /// A library system that cannot be made with the parameters given.
    #[error("{message}")]
    System {
        /// Why not.
        message: String,
    },
    /// Equations for which no bracket was found.
    #[error("no bracket was found for these equations: {reason}")]
    NoBracket {
        /// The reason, of each kind that was looked for.
        reason: String,
    },
    /// A bracket of which no Casimirs were found.
    #[error("no Casimir was found for this bracket: {reason}")]
    NoCasimirs {
        /// The reason.
        reason: String,
    },
    /// A bracket entry whose key is no pair of variables.
    #[error("`{key}` is not a pair of variables")]
    BracketKey {
        /// The key as written.
        key: String,
        /// The nearest kind of bracket.
        nearest: Option<String>,
    },
    /// A variable whose momentum, or coordinate, its name does not tell.
    #[error("{}", pair_message(name, partners))]
    CanonicalPair {
        /// The variable.
        name: String,
        /// Those that might be.
        partners: Vec<String>,
        /// Two names in no pair that would be one, written out.
        example: Option<[String; 2]>,
    },
    /// A variable in two summands of a direct sum.
    #[error("`{name}` is in two summands of the bracket")]
    TwoSummands {
        /// The variable.
        name: String,
    },
    /// A variable in no summand of a direct sum.
    #[error("`{name}` is in no summand of the bracket")]
    NoSummand {
        /// The variable.
        name: String,
    },
    /// A parameter of every site in a system without families.
    #[error("`{key}` is a parameter of every site, and the system has no families")]
    WithoutSites {
        /// Its key.
        key: String,
    },
    /// `magnetic`, the bracket of a charge −1 that ran time backwards under `{x,H}`.
    #[error("`magnetic` is now `magnetic-field`, with the force v' = v × B")]
    MagneticSign,
    /// An override that is not `path=value` with a path of the scene format.
    #[error("the override `{path}` cannot be applied: {reason}")]
    Override {
        /// The path as given.
        path: String,
        /// Why not.
        reason: String,
    },
    /// A key that settings of a sweep may not differ in.
    #[error("`{key}` is not a key of settings: {reason}")]
    Swept {
        /// The key.
        key: String,
        /// Why not.
        reason: String,
    },
}

impl SceneProblemCause {
    /// An unknown name of a kind beside those that are known, with the nearest of them.
    pub(super) fn unknown<'a>(
        kind: &'static str,
        name: &str,
        valid: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let valid: Vec<String> = valid.into_iter().map(str::to_owned).collect();
        Self::UnknownName {
            kind,
            nearest: nearest(name, valid.iter().map(String::as_str)),
            name: name.to_owned(),
            valid,
        }
    }

    /// Label to write under the underlined piece.
    pub fn label(&self) -> String {
        match self {
            Self::Syntax { .. } => "here".to_owned(),
            Self::UnknownKey { .. } => "not a key of this table".to_owned(),
            Self::UnknownName { kind, .. } => format!("no such {kind}"),
            Self::WrongType { expected, .. } => format!("expected {expected}"),
            Self::NotOne { .. } => "one value is expected".to_owned(),
            Self::NoConstant { .. } => "no formula of parameters".to_owned(),
            Self::TooManySteps { .. } => "too far".to_owned(),
            Self::MissingKey { key, .. } => format!("`{key}` is missing"),
            Self::NotFinite { .. } => "not a finite number".to_owned(),
            Self::OutOfRange { allowed, .. } => format!("must be {allowed}"),
            Self::Conflict { first, .. } => format!("conflicts with `{first}`"),
            Self::Shape { expected, .. } => format!("expected {expected}"),
            Self::Duplicate { .. } => "declared before".to_owned(),
            Self::InvalidName { reason, .. } => (*reason).to_owned(),
            Self::BracketKey { .. } => "expected two variables and a comma".to_owned(),
            Self::CanonicalPair { name, .. } => format!("`{name}` is in no pair"),
            Self::System { .. } => "here".to_owned(),
            Self::NoBracket { .. } | Self::NoCasimirs { .. } => "nothing to put here".to_owned(),
            Self::TwoSummands { .. } => "in an earlier summand".to_owned(),
            Self::NoSummand { .. } => "of no summand".to_owned(),
            Self::WithoutSites { .. } => "of no lattice".to_owned(),
            Self::MagneticSign => "write `magnetic-field`".to_owned(),
            Self::Override { .. } => "given on the command line".to_owned(),
            Self::Swept { .. } => "not a key of settings".to_owned(),
        }
    }

    /// Advice: a remedy to try, where there is one.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::UnknownName {
                name,
                nearest: None,
                ..
            } if name.contains('/') => Some(format!(
                "a name with a `/` is that of a plugin's part; name its library at the top of the \
                 scene: plugins = [\"./lib{}.so\"]",
                name.split('/').next().unwrap_or_default()
            )),
            Self::UnknownKey { key, table, .. } if time_help(key, table).is_some() => {
                time_help(key, table).map(str::to_owned)
            }
            Self::UnknownKey { nearest, valid, .. } | Self::UnknownName { nearest, valid, .. } => {
                match nearest {
                    Some(name) => Some(format!("did you mean `{name}`?")),
                    None if valid.is_empty() => None,
                    None => Some(format!("valid here: {}", valid.join(", "))),
                }
            }
            Self::Syntax {
                slip: Some(slip), ..
            } => Some(slip.clone()),
            Self::Syntax { message, .. } if message.contains("unquoted key") => Some(
                "a key with other letters than a to z, A to Z, 0 to 9, `-` and `_` needs quotes: \"Iα\" = 1.0"
                    .to_owned(),
            ),
            Self::WrongType { key, .. } if key == "bracket" => Some(
                "bracket = \"canonical\" pairs q with p, for q' = ∂H/∂p and p' = -∂H/∂q; otherwise write the pairs that do not \
                 vanish: bracket = { \"x,y\" = \"x*y\" }"
                    .to_owned(),
            ),
            Self::NotOne {
                key,
                found: "a table",
            } => Some(format!(
                "a name with a point stands in quotes, that of a family with its index: \"{key}.x[i]\" = 1, or a formula for each \
                 component: \"{key}[i]\" = [1, 0, 0]"
            )),
            Self::NotOne { key, .. } => Some(format!(
                "write a value for each site of a family under its name with an index: \"{key}[i]\" = [1, 2, 3]"
            )),
            Self::NoConstant {
                text,
                names,
                is_of_state: false,
                ..
            } => Some(match names {
                _ if text.contains('N') => "write the length of a family as a number here".to_owned(),
                ConstantNames::Parameters => {
                    "numbers, other parameters by their names, and functions of them are allowed here".to_owned()
                }
                ConstantNames::None => {
                    "numbers and functions of them are allowed here, as \"sqrt(3)/2\"".to_owned()
                }
            }),
            Self::NoConstant { key, text, .. } => Some(format!(
                "a formula of the state is a definition: define = {{ {key} = \"{text}\" }} in [system], without the \
                 parameter; one of the index is \"{key}[i]\""
            )),
            Self::TooManySteps { .. } => Some("take a longer `time-step`".to_owned()),
            Self::MissingKey { key, .. } if key == "steps" => Some(
                "for example: steps = 1000, or until = 100, the time at the end".to_owned(),
            ),
            Self::MissingKey { example, .. } => Some(format!("for example: {example}")),
            Self::Conflict { advice, .. } => Some(advice.clone()),
            Self::BracketKey {
                nearest: Some(name),
                ..
            } => Some(format!("did you mean `{name}`?")),
            Self::BracketKey { nearest: None, .. } => {
                let kinds: Vec<&str> = names(&BRACKET).chain(names(&SUM)).collect();
                Some(format!(
                    "write \"x1,x2\" = \"…\" for {{x1, x2}}, or one of {}",
                    kinds.join(", ")
                ))
            }
            Self::CanonicalPair { example, .. } => {
                let [coordinate, momentum] = match example {
                    Some([coordinate, momentum]) => [coordinate.as_str(), momentum.as_str()],
                    None => ["theta", "L"],
                };
                Some(format!(
                    "pairs that are known: q and p, q1 and p1, x and px, theta and L; write others out, the coordinate \
                     first: bracket = {{ canonical = [[\"{coordinate}\", \"{momentum}\"], …] }}"
                ))
            }
            Self::TwoSummands { .. } => Some(
                "each variable is of one summand; couple the summands by the Hamiltonian".to_owned(),
            ),
            Self::NoSummand { name } => Some(format!(
                "a variable that commutes with all others is a summand with an empty bracket: \
                 {{ variables = [\"{name}\"], bracket = {{}} }}"
            )),
            Self::WithoutSites { .. } => Some(
                "declare the lattice that it belongs to: families = { q = 100, p = 100 }".to_owned(),
            ),
            Self::NoBracket { .. } => Some(
                "`leafwise find SCENE` prints what was tried; give a bracket without damping and driving, and add these \
                 as `damping` and `forces`"
                    .to_owned(),
            ),
            Self::NoCasimirs { .. } => Some(
                "leave `casimirs` out, or write those that you know; `leafwise find SCENE --degree D` looks for others".to_owned(),
            ),
            Self::MagneticSign => Some(
                "under \"{H,x}\" `magnetic` meant v' = -v × B, under \"{x,H}\" it ran time backwards; for \
                 H = v^2/2 + V(x), magnetic-field = [\"Bx\", \"By\", \"Bz\"] means x' = v and \
                 v' = v × B - dV/dx under both: negate B to keep the old motion"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

/// Message of a variable that is in no canonical pair.
fn pair_message(name: &str, partners: &[String]) -> String {
    match partners {
        [] => format!("no variable is the momentum or the coordinate of `{name}` by its name"),
        _ => {
            let partners: Vec<String> = partners.iter().map(|name| format!("`{name}`")).collect();
            format!("`{name}` may be paired with {}", partners.join(" or "))
        }
    }
}

/// Help for a step or an end of time as other programs call them: the key that stands in its place.
fn time_help(key: &str, table: &str) -> Option<&'static str> {
    let letters: String = key.chars().filter(|c| c.is_alphanumeric()).collect();
    match (table, letters.to_lowercase().as_str()) {
        ("[method]", "dt" | "step" | "stepsize" | "tstep" | "deltat") => {
            Some("did you mean `time-step`? One step advances t by it")
        }
        (
            "[run]",
            "tend" | "end" | "endtime" | "tmax" | "tfinal" | "finaltime" | "time" | "duration"
            | "t",
        ) => Some(
            "a run ends after `steps`, the total time divided by `time-step`, or at the time `until`",
        ),
        _ => None,
    }
}

/// Everything found wrong with a scene, in the order of the text.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", .problems.first().map_or_else(String::new, ToString::to_string))]
pub struct SceneErrors {
    /// The scene's file name.
    pub name: String,
    /// The scene's text, after overrides.
    pub text: String,
    /// The library fragment the scene uses, as id and text.
    pub fragment: Option<(String, String)>,
    /// The problems; at least one.
    pub problems: Vec<SceneProblem>,
}

impl SceneErrors {
    /// The first problems, each with its text and place, ready to print; the last of them says how many
    /// more there are.
    pub fn diagnostics(&self) -> Vec<SceneDiagnostic> {
        let fragment = self.fragment.as_ref();
        let shown = self.problems.iter().take(MOST_SHOWN);
        let mut shown: Vec<SceneDiagnostic> = shown
            .map(|problem| {
                let (source_name, source_text) =
                    source_text(&problem.place.source, &self.name, &self.text, fragment);
                SceneDiagnostic {
                    message: problem.cause.to_string(),
                    label: problem.cause.label(),
                    source_name,
                    source_text,
                    span: problem.place.span.clone(),
                    help: problem.cause.help(),
                }
            })
            .collect();
        if let (Some(more), Some(last)) = (
            self.problems.len().checked_sub(MOST_SHOWN + 1),
            shown.last_mut(),
        ) {
            let more = format!("and {} more problems, which are not shown", more + 1);
            last.help = Some(match last.help.take() {
                Some(help) => format!("{help}\n{more}"),
                None => more,
            });
        }
        shown
    }
}

/// The most problems that are shown: each comes with the text it stands in.
const MOST_SHOWN: usize = 20;

/// Name and text of a source.
pub(super) fn source_text(
    source: &Source,
    name: &str,
    text: &str,
    fragment: Option<&(String, String)>,
) -> (String, String) {
    match source {
        Source::Scene => (name.to_owned(), text.to_owned()),
        Source::Library(id) => (
            match &**id == FOUND {
                true => FOUND.to_owned(),
                false => format!("library system {id}"),
            },
            fragment.map_or_else(String::new, |(_, text)| text.clone()),
        ),
        Source::Override(given) => ("--set".to_owned(), given.to_string()),
    }
}
