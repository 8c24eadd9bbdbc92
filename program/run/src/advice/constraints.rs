//! A start off the constraints: Dirac's bracket keeps each at the value that it begins with, and that is meant to be 0.

use leafwise_core::system::Casimir;
use leafwise_scene::compose::ComposedRun;
use leafwise_scene::document::{BracketSpec, InitialSpec, SceneDocument};

use super::{Advice, AdviceKind, number};
use crate::level_set::WayOntoLevel;
use crate::round_off::round_off;

/// Units of round-off in a coordinate that was written with all its digits, or computed.
const DIGITS: f64 = 4.0;

/// Warning where a constraint has another value than 0 at `initial`, by more than the round-off of computing it from
/// rounded coordinates. In the message `whose` tells whose initial state it is: nothing, or a member of an ensemble.
pub(crate) fn off_constraints(
    document: &SceneDocument,
    run: &ComposedRun,
    initial: &[f64],
    whose: &str,
) -> Option<Advice> {
    let constraints = constraints(document, run);
    let off: Vec<String> = (constraints.iter())
        .filter(|constraint| is_off(run, constraint, initial))
        .map(|constraint| {
            let parameters = run.system.parameter_values();
            let value = constraint.expression.evaluate(initial, &parameters);
            format!("{} = {}", constraint.name, number(value))
        })
        .collect();
    if off.is_empty() {
        return None;
    }
    let has_one_list =
        matches!(document.run.initial.value, InitialSpec::Vector(_)) && whose.is_empty();
    let near = has_one_list
        .then(|| on(run, &constraints, initial))
        .flatten();
    Some(Advice {
        kind: AdviceKind::OffConstraint,
        message: format!(
            "the initial state{whose} is off the constraints, and the motion keeps them where they begin: {}",
            off.join(", ")
        ),
        change: match near {
            Some(state) => format!("initial = {:?}", run.own(&state)),
            None => "initial: a state at which every constraint is 0".to_owned(),
        },
    })
}

/// The constraints among the Casimirs.
fn constraints<'a>(document: &SceneDocument, run: &'a ComposedRun) -> Vec<&'a Casimir> {
    let mut texts: Vec<&str> = Vec::new();
    texts.extend(
        document
            .system
            .constraints
            .iter()
            .map(|text| text.value.as_str()),
    );
    if let BracketSpec::Sum(summands) = &document.system.bracket.value {
        let constraints = summands.iter().flat_map(|summand| &summand.constraints);
        texts.extend(constraints.map(|text| text.value.as_str()));
    }
    let casimirs = run.system.expressions().map(|formulas| formulas.casimirs());
    let casimirs = casimirs.unwrap_or_default().iter();
    casimirs
        .filter(|casimir| texts.contains(&casimir.name.as_str()))
        .collect()
}

fn is_off(run: &ComposedRun, constraint: &Casimir, x: &[f64]) -> bool {
    let bounded = round_off(run, &constraint.expression, x, DIGITS);
    bounded.is_some_and(|bounded| bounded.value.abs() > bounded.error)
}

/// A state near x on all constraints: Gauss and Newton's corrections of the least size.
fn on(run: &ComposedRun, constraints: &[&Casimir], x: &[f64]) -> Option<Vec<f64>> {
    let map = run.system.invariants_map().ok()?;
    if !map.has_jacobian() {
        return None;
    }
    let names = run.system.casimir_names();
    // The energy is the first output.
    let place = |constraint: &&Casimir| {
        let at = names.iter().position(|name| *name == constraint.name);
        at.map(|at| at + 1)
    };
    let which: Option<Vec<usize>> = constraints.iter().map(place).collect();
    let mut way = WayOntoLevel::new(&map, which?, &run.system.parameter_values());
    let mut x = x.to_vec();
    way.go(&mut x)?;
    let is_on = |constraint: &&Casimir| !is_off(run, constraint, &x);
    constraints.iter().all(is_on).then_some(x)
}
