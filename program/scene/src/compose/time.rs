//! Where a scene names the time.

use std::collections::BTreeSet;

use leafwise_core::{Evaluator, PoissonSystem};
use leafwise_expression::syntax::Formula;

use super::Refusal;
use super::dense::WRITTEN_LIMIT;
use crate::document::{BracketSpec, InitialSpec, Located, Place, SceneDocument};

/// Name of the time in formulas.
pub(super) const TIME: &str = "t";

/// Formula that makes the time a coordinate of a scene, with its kind in words: a Hamiltonian, a one-form or a force
/// that names it, or a pace.
pub(super) fn wants_time(document: &SceneDocument) -> Option<(&Located<String>, &'static str)> {
    let hamiltonian = &document.system.hamiltonian;
    if names_time(document, hamiltonian) {
        return Some((hamiltonian, "a Hamiltonian that names the time t"));
    }
    if let BracketSpec::OneForm(form) = &document.system.bracket.value
        && let Some(component) = form.iter().find(|formula| names_time(document, formula))
    {
        return Some((component, "a one-form that names the time t"));
    }
    let mut forces = document.system.forces.formulas().into_iter();
    if let Some(force) = forces.find(|formula| names_time(document, formula)) {
        return Some((force, "a force that names the time t"));
    }
    document.method.pace.as_ref().map(|pace| (pace, "a pace"))
}

/// Whether a formula names the time, which no declared name hides, or a definition that does.
pub(super) fn names_time(document: &SceneDocument, formula: &Located<String>) -> bool {
    !declares_time(document) && leads_to_time(document, formula, &mut BTreeSet::new())
}

/// Whether a name is that of the time, or of a definition that names it.
pub(super) fn is_time(document: &SceneDocument, name: &str) -> bool {
    let mut define = document.system.define.iter();
    let defined = define.find(|(defined, _)| defined.value == name);
    match defined {
        Some((_, formula)) => names_time(document, formula),
        None => name == TIME,
    }
}

/// `seen` holds the definitions that were followed.
fn leads_to_time<'a>(
    document: &'a SceneDocument,
    formula: &'a Located<String>,
    seen: &mut BTreeSet<&'a str>,
) -> bool {
    let Ok(parsed) = Formula::parse(&formula.value) else {
        return false;
    };
    let names = parsed.references();
    let mut define = document.system.define.iter();
    names.contains(TIME)
        || define.any(|(name, formula)| {
            names.contains(name.value.as_str())
                && seen.insert(&name.value)
                && leads_to_time(document, formula, seen)
        })
}

/// Whether a variable, vector, family, parameter or definition is called t.
pub(super) fn declares_time(document: &SceneDocument) -> bool {
    let system = &document.system;
    let variables = system.variables.iter();
    let families = system.families.iter().map(|(name, _)| name);
    let parameters = system.parameters.iter().map(|(name, _)| name);
    let defined = system.define.iter().map(|(name, _)| name);
    let vectors = system.all_vectors().map(|vector| &vector.name);
    let declared = variables.chain(families).chain(parameters);
    let mut declared = declared.chain(defined).chain(vectors);
    declared.any(|name| name.value == TIME)
}

/// Message and advice for a formula that names the time and may not.
pub(super) fn about_time(
    document: &SceneDocument,
    formula: &Located<String>,
) -> Option<(String, String)> {
    let system = &document.system;
    let is = |other: &Located<String>| other.place() == formula.place();
    let within = |whole: &Place| {
        let (outer, inner) = (&whole.span, &formula.span);
        whole.source == formula.source && outer.start <= inner.start && inner.end <= outer.end
    };
    let told = |message: &str, help: &str| Some((message.to_owned(), help.to_owned()));
    if system.casimirs.iter().any(|(_, casimir)| is(casimir)) {
        return told(
            "a Casimir cannot name the time t: it would move with it",
            "record a function of t and of Casimirs in run.record.observables",
        );
    }
    if system.constraints.iter().any(is) {
        return told(
            "a constraint cannot name the time t: with t as a coordinate it would move t's energy",
            "write coordinates in which the constraint does not depend on the time",
        );
    }
    if within(&system.bracket.place()) {
        return told(
            "the bracket cannot name the time t: a motion keeps a bracket only where it does not change, and with t as \
             a coordinate the Jacobi identity fails",
            "a factor f(t) of the whole bracket belongs in the Hamiltonian; a magnetic field that changes comes with \
             an electric one: write positions and canonical momenta, with the vector potential A(x, t) in H, or the bracket by a \
             one-form, whose components may name t",
        );
    }
    if let InitialSpec::Fields(fields) = &document.run.initial.value
        && fields
            .iter()
            .any(|(_, field)| field.formula().is_some_and(is))
    {
        return told(
            "the initial state cannot name the time t: every run begins at t = 0, or at `t0`",
            "begin later by t0 in [run], or by another phase, as in cos(omega*t + phase) with a parameter",
        );
    }
    let run = &document.run;
    let is_event = run.stop.as_ref().is_some_and(is);
    let is_section = run.section.as_ref().is_some_and(|section| is(&section.at));
    if !system.families.is_empty() && system.coordinates() > WRITTEN_LIMIT {
        return told(
            "t cannot be named by a formula on a lattice of this length: with t as a coordinate every site would move its energy",
            match (is_event, is_section) {
                (true, _) => {
                    "leave t out of `stop`: a run ends at a time by `until` in the place of `steps`"
                }
                (_, true) => {
                    "leave t out of `section`: record = { times = [1, 2.5] } keeps samples at given times"
                }
                _ => {
                    "leave t out: it is the first column of samples.csv, with which other columns are combined afterwards"
                }
            },
        );
    }
    told(
        "t is the time where the Hamiltonian, a one-form, a force or a pace names it, and here none does",
        "the first column of samples.csv is t; `+ 0*t` in the Hamiltonian makes the time a name for every recorded formula",
    )
}

/// Refuses a Hamiltonian that names the time and does not change smoothly where every run begins. Such are sqrt(t) and
/// ln(t).
///
/// # Errors
/// The Hamiltonian, where its gradient is not finite at the initial state and t = 0, and is a step later.
pub(super) fn check_begin(
    document: &SceneDocument,
    system: &PoissonSystem,
    initial: &[f64],
    time: usize,
) -> Result<(), Refusal> {
    let hamiltonian = &document.system.hamiltonian;
    if !names_time(document, hamiltonian) {
        return Ok(());
    }
    let Ok(gradient) = system.gradient_values() else {
        return Ok(());
    };
    let mut gradient = gradient.evaluator(&system.parameter_values(), 1.0, 1.0);
    let mut is_smooth = |state: &[f64]| {
        let mut values = vec![0.0; initial.len()];
        let values = gradient.values(state, &mut values).map(|()| values);
        values.is_ok_and(|values| values.iter().all(|value| value.is_finite()))
    };
    // Where a step later nothing is well either, the time is not to blame.
    let mut later = initial.to_vec();
    later[time] = document.method.step.time_step();
    if is_smooth(initial) || !is_smooth(&later) {
        return Ok(());
    }
    let t0 = &document.run.t0;
    let t0 = t0.as_ref().map_or("0", |t0| t0.value.literal.as_str());
    Err(Box::new(document.diagnostic(
        &document.place_in_formula(hamiltonian, 0..hamiltonian.value.len()),
        format!(
            "the Hamiltonian has no value or no derivative at t = {t0}, where the run begins, and has them later"
        ),
        "at the initial state",
        Some("begin a little later: write t0 into [run]".to_owned()),
    )))
}
