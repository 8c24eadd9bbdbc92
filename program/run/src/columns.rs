//! The columns of a run's tables.

use leafwise_scene::compose::{ComposedRun, Observable};

use crate::csv::Headings;

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
    let headings = headings(run, run.plan.states.are_in_samples());
    headings.table().as_str().to_owned()
}

/// The columns of recorded samples, with or without those of states.
pub(super) fn headings(run: &ComposedRun, has_states: bool) -> Headings {
    let mut headings = Headings::default();
    headings.push("t", "time");
    if has_states {
        headings.extend(run.plan.states.names(), "variable");
    }
    for observable in &run.plan.observables {
        let kind = match observable {
            Observable::Invariant { index, .. } => invariant_kind(*index),
            Observable::Formula { .. }
            | Observable::Coordinate { .. }
            | Observable::Indicator { .. } => "observable",
        };
        headings.push(observable.name(), kind);
    }
    headings
}

/// The columns of `windows.csv`.
pub(super) fn windows_headings(run: &ComposedRun, invariants: usize) -> Headings {
    let mut headings = Headings::default();
    headings.push("t_end", "time");
    for index in 0..invariants {
        headings.push(invariant_name(run, index), invariant_kind(index));
    }
    headings
}
