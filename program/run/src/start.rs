//! Whether a run can begin: its system's formulas, the energy and the motion at the initial state.

use leafwise_core::BuildError;

use crate::RunError;
use crate::advice::{Advice, AdviceKind};
use crate::undefined_motion::{place_of, undefined_motion};
use leafwise_scene::compose::{ComposedRun, Refusal, SceneChecks};
use leafwise_scene::document::SceneDocument;
use leafwise_walk::outside;

/// Checks of the formulas of a scene's system.
///
/// # Errors
/// [`RunError::Refused`] for a tensor that is not Poisson or a Casimir that is not one.
pub(super) fn checked(
    document: &SceneDocument,
    run: &ComposedRun,
    allow_non_poisson: bool,
) -> Result<SceneChecks, RunError> {
    let checks = SceneChecks::of(&run.system, &run.near)?;
    match checks.refusal(document, (&run.system, &run.near), allow_non_poisson) {
        Some(refusal) => Err(RunError::Refused(refusal)),
        None => Ok(checks),
    }
}

/// Reason why no step can be taken from the initial state; `None` where one can. That state is outside the energy's
/// domain, or the motion has no finite value there and the method takes no step.
///
/// # Errors
/// [`BuildError::Algebra`] where the energy has no code.
pub(super) fn refusal(
    document: &SceneDocument,
    composed: &ComposedRun,
) -> Result<Option<Refusal>, BuildError> {
    let initial = &composed.plan.initial;
    let mut invariants = composed.invariants()?;
    let mut values = vec![0.0; invariants.observables()];
    let is_outside = outside(initial, 1, |state, is_nan| {
        invariants.evaluate(state, &mut values);
        is_nan.push(values[0].is_nan());
    }) == [true];
    invariants.evaluate(initial, &mut values);
    let energy = values[0];
    let undefined = undefined_motion(composed);
    let message = match &undefined {
        _ if is_outside => "the energy has no value at the initial state".to_owned(),
        Some(undefined) => undefined.message.clone(),
        None if composed.method.lattice().is_some() && !energy.is_finite() => {
            "the energy has no finite value at the initial state".to_owned()
        }
        None => return Ok(None),
    };
    if !is_outside && composed.walk().step().is_ok() {
        return Ok(None);
    }
    if let Some(zero) = undefined.and_then(|undefined| undefined.zero) {
        return Ok(Some(Box::new(document.diagnostic(
            &place_of(document, &zero),
            format!("{message}, where `{zero}` is 0"),
            "no step can be taken with this value",
            Some("give it another value: no division by zero, no ln of 0".to_owned()),
        ))));
    }
    let help = "check `initial` and the parameters: no ln or root of a negative number, no division by zero";
    Ok(Some(Box::new(document.diagnostic(
        &document.run.initial.place(),
        message,
        "no step can be taken from here",
        Some(help.to_owned()),
    ))))
}

/// Advice about an invariant without a finite value, at the start or from some time on.
pub(super) fn unwatched((name, at_start): (&str, bool)) -> Advice {
    let place = if at_start { "initial" } else { "last" };
    let change = match name {
        "energy" => {
            "initial = [a state where H has a value], or leave the coordinates that are 0 out of the system"
        }
        _ => "casimirs = {} in [system], or those that have values there",
    };
    Advice {
        kind: AdviceKind::UndefinedObservable,
        message: format!(
            "`{name}` has no finite value at the {place} state, where the motion has one: its drift has no meaning"
        ),
        change: change.to_owned(),
    }
}
