//! Where a run of a library system starts.

use serde::Deserialize;

/// The `[default]` table of a library text.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Defaults {
    /// The initial state, as a scene's `run.initial`: a list of numbers, or a table from an
    /// indexed family such as `x[i]` to a formula in `i` and `N`.
    pub initial: toml::Value,
    /// A time step ε·h at which one step resolves the motion.
    pub time_step: f64,
    /// Variable steps, where equal ones are a waste.
    pub paced: Option<PacedDefaults>,
}

/// The `[default.paced]` table: variable steps that resolve the motion.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PacedDefaults {
    /// dt/dτ, a formula.
    pub pace: String,
    /// The step of τ.
    pub time_step: f64,
    /// The time at the end.
    pub until: f64,
    /// The time between two samples.
    pub interval: f64,
}
