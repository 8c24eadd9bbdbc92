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
}
