//! Judgements of declarations by measurements.

use serde::Serialize;

/// Whether a declaration is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// The measurement agrees.
    Met,
    /// It does not.
    NotMet,
    /// The measurement does not tell the declared order from the one below.
    Undecided,
    /// Nothing was declared, or the map offers nothing to measure it by.
    Open,
}
