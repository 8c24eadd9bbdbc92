//! Advice about the scene of an ensemble: what to change in it.

use leafwise_core::Registry;
use leafwise_expression::words::counted;

use super::plan::ComposedEnsemble;
use super::report::EnsembleReport;
use super::tables::summaries;
use crate::advice::{
    Advice, AdviceKind, EnergyError, JudgedStates, MOST_STATES, about_the_scene, advise,
    off_constraints, orbit_from, states_from,
};
use crate::short;
use leafwise_scene::document::SceneDocument;

/// Members at whose states the method is judged.
const JUDGED: u64 = 4;

/// States of a member that tell how far its orbit reaches.
const MOST_ORBIT_STATES: u64 = 1000;

/// Advice from the results of an ensemble, beside that about its scene: an energy kept badly, observables without a
/// value.
pub(super) fn measured(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    report: &EnsembleReport,
) -> Vec<Advice> {
    let all = &report.reductions;
    let mut advice = about_the_scene(document, &ensemble.run);
    let is_on = !advice
        .iter()
        .any(|found| found.kind == AdviceKind::OffConstraint);
    let mut judged = (0..JUDGED.min(ensemble.population.members())).filter(|_| is_on);
    advice.extend(judged.find_map(|member| {
        let (state, _) = ensemble.population.draw(member).ok()?;
        let whose = format!(" of member {member}");
        off_constraints(document, &ensemble.run, &state, &whose)
    }));
    let (members, left_out) = (
        ensemble.population.members(),
        ensemble.population.left_out(),
    );
    if left_out > 0 {
        advice.push(Advice {
            kind: AdviceKind::UnusedStates,
            message: format!(
                "{} of states are given beyond those of the {members} members, and are not used",
                counted(left_out as usize, "row")
            ),
            change: "no `members` in [ensemble], to take every row".to_owned(),
        });
    }
    let worst = all.whole.first().filter(|energy| energy.maximum > 0.0);
    let worst =
        worst.and_then(|energy| Some((energy, ensemble.population.draw(energy.member).ok()?)));
    if let Some((energy, (state, parameters))) = worst {
        let evaluator = ensemble.course.invariants.values(1, &parameters);
        let values = evaluator.map(|mut evaluator| {
            evaluator.measure_from(ensemble.origin(&state).as_slice());
            evaluator.at(&state).to_vec()
        });
        let initial = values.ok().and_then(|values| values.first().copied());
        let error = EnergyError {
            parameters: &parameters,
            initial: initial.unwrap_or(0.0),
            largest: energy.maximum,
            whose: &format!(" of member {}", energy.member),
        };
        if error.is_notable() {
            let steps = ensemble.run.plan.steps.min(MOST_ORBIT_STATES);
            let states = orbit_from(&ensemble.run, &parameters, &state, steps);
            advice.extend(error.advice(&ensemble.run, &states));
        }
    }
    let names = ensemble.observables();
    let mut told = vec![false; names.len()];
    for (at, (time, _, summary)) in summaries(ensemble, report).enumerate() {
        let column = at % names.len();
        if summary.undefined > 0 && !std::mem::replace(&mut told[column], true) {
            advice.push(Advice {
                kind: AdviceKind::UndefinedObservable,
                message: format!(
                    "`{}` has no finite value for {} of {} members, first at t = {}: the statistics cover the \
                     others",
                    names[column],
                    summary.undefined,
                    all.done(),
                    short(time)
                ),
                change: "observables = [a formula that has values there: no ln or root of a negative \
                         number, no division by zero]"
                    .to_owned(),
            });
        }
    }
    advice
}

/// Advice about the scene of an ensemble, judged at states of some of its members with the scene's own parameters; see
/// [`advise`].
pub fn advise_ensemble(ensemble: &ComposedEnsemble, registry: &Registry) -> Vec<Advice> {
    let members = ensemble.population.members();
    let judged = JUDGED.min(members);
    let each = MOST_STATES / JUDGED as usize;
    let states: Vec<Vec<f64>> = (0..judged)
        .filter_map(|k| {
            ensemble
                .population
                .draw((u128::from(k) * u128::from(members) / u128::from(judged)) as u64)
                .ok()
        })
        .flat_map(|(state, _)| states_from(&ensemble.run, &state, each))
        .collect();
    let Some(first) = states.first() else {
        return Vec::new();
    };
    // Members need not lie near the initial state of [run].
    let mut run = ensemble.run.clone();
    run.plan.initial.clone_from(first);
    advise(&run, registry, (&states, JudgedStates::OfMembers))
}
