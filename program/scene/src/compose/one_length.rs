//! Generating functions that hold for steps of one length alone, as tables of many steps.

use super::Refusal;
use super::part_choice::PartChoice;
use crate::document::{SceneDocument, StepSpec};

/// How far a step may be from the length, relative to it: what the rounding of a quotient of decimals leaves.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// Refuses steps of another length than the chosen parts hold for.
///
/// # Errors
/// At `until` where that shortens the steps, else at the step itself.
pub(super) fn check_length(
    document: &SceneDocument,
    choices: &[PartChoice],
) -> Result<(), Refusal> {
    let Some(length) = choices.iter().find_map(PartChoice::time_step) else {
        return Ok(());
    };
    let step = document.method.step.time_step();
    let is_length = |step: f64| (step.abs() - length).abs() <= ROUNDED * length;
    if is_length(step) {
        return Ok(());
    }
    let run = &document.run;
    let is_shortened = run.shortened.is_some_and(is_length);
    let until = run.comes_to.as_ref().filter(|_| is_shortened);
    let refuse = |place, message: String, help: String| {
        Err(Box::new(document.diagnostic(
            &place,
            message,
            "here",
            Some(help),
        )))
    };
    let alone = format!("the generating function holds for steps of {length:?} alone");
    if let Some(until) = until {
        let steps = libm::fmax(libm::round(until.value.value / length).abs(), 1.0);
        return refuse(
            until.place(),
            format!(
                "{alone}, and `until` = {} is not a whole number of them",
                until.value.literal
            ),
            format!(
                "write steps = {steps} in place of `until`: it ends at {:?}",
                steps * length
            ),
        );
    }
    let (place, help) = match &document.method.step {
        StepSpec::TimeStep(step) => (
            step.place(),
            format!("time-step = {:?}", length.copysign(step.value.value)),
        ),
        StepSpec::Factors { epsilon, h } => (
            h.place(),
            format!(
                "h = {:?}",
                (length / epsilon.value.value).copysign(h.value.value)
            ),
        ),
    };
    refuse(
        place,
        format!("{alone}, and this one is {step:?}"),
        format!("write {help}, or make a table of other steps by `leafwise tabulate`"),
    )
}
