//! The columns of a run's tables.

use leafwise_scene::compose::{ComposedRun, Observable};

use crate::csv::{Headings, Table};

/// The name of the energy (0) or of a Casimir.
pub(super) fn invariant_name(run: &ComposedRun, index: usize) -> &str {
    match index.checked_sub(1) {
        None => "energy",
        Some(casimir) => run.system.casimir_names()[casimir],
    }
}

/// The kind of an invariant, beside its name.
fn invariant_kind(index: usize) -> &'static str {
    if index == 0 { "Hamiltonian" } else { "Casimir" }
}

/// The first line of `samples.csv`.
pub(super) fn header(run: &ComposedRun) -> String {
    let mut headings = Headings::default();
    headings.push("t", "time");
    if run.plan.states.are_in_samples() {
        headings.extend(run.plan.states.names(), "variable");
    }
    for observable in &run.plan.observables {
        let kind = match observable {
            Observable::Invariant { index, .. } => invariant_kind(*index),
            Observable::Formula { .. } | Observable::Coordinate { .. } => "observable",
        };
        headings.push(observable.name(), kind);
    }
    headings.table().as_str().to_owned()
}

/// `windows.csv` without a row.
pub(super) fn windows_table(run: &ComposedRun, invariants: usize) -> Table {
    let mut headings = Headings::default();
    headings.push("t_end", "time");
    for index in 0..invariants {
        headings.push(invariant_name(run, index), invariant_kind(index));
    }
    headings.table()
}
