//! The columns of a sweep's table.

use serde::Serialize;

use super::settings::Settings;
use crate::columns::invariant_name;
use crate::csv::{Headings, Table};
use leafwise_scene::compose::{ComposedRun, Observable};

/// Headings of `sweep.csv`, by what they are. These are the number of the setting, its values, how its run has ended
/// and why, the time and drifts, the observables of its last state, and its cost.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SweepColumns {
    /// The keys of settings; a column before them holds the number.
    pub settings: Vec<String>,
    /// max_k |I(x_k) − I(x_0)| of energy and Casimirs; before them stand `outcome`, `error` and `t`.
    pub drifts: Vec<String>,
    /// Observables of the last state.
    pub observables: Vec<String>,
    /// `steps`, `evaluations` and `operations`: counts that depend on the scene alone.
    pub cost: Vec<String>,
}

impl SweepColumns {
    pub(super) fn of(settings: &Settings, run: &ComposedRun) -> Self {
        let mut headings = Headings::default();
        headings.push("setting", "number");
        headings.extend(settings.keys(), "setting");
        for name in ["outcome", "error", "t"] {
            headings.push(name, "of the run");
        }
        let invariants = 1 + run.system.casimir_names().len();
        headings.extend(
            (0..invariants).map(|at| format!("{}_drift", invariant_name(run, at))),
            "drift",
        );
        let observables = &run.plan.observables;
        headings.extend(observables.iter().map(Observable::name), "observable");
        headings.extend(["steps", "evaluations", "operations"], "cost");
        let mut names = headings.into_names().into_iter().skip(1);
        let mut next = |count: usize| names.by_ref().take(count).collect::<Vec<_>>();
        let settings = next(settings.keys().len());
        let _ = next(3);
        Self {
            settings,
            drifts: next(invariants),
            observables: next(observables.len()),
            cost: next(3),
        }
    }

    /// Headings of the quantities that are measured of each setting: drifts, then observables.
    pub fn measured(&self) -> Vec<&str> {
        let all = self.drifts.iter().chain(&self.observables);
        all.map(String::as_str).collect()
    }

    /// All headings, in order.
    pub fn all(&self) -> Vec<&str> {
        let mut all = vec!["setting"];
        all.extend(self.settings.iter().map(String::as_str));
        all.extend(["outcome", "error", "t"]);
        all.extend(self.measured());
        all.extend(self.cost.iter().map(String::as_str));
        all
    }

    /// The first row of the table.
    pub(super) fn heading(&self) -> String {
        Table::new(self.all()).as_str().to_owned()
    }
}
