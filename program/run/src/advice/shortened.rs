//! Steps that are shortened so that a whole number of them comes to `until`.

use super::{Advice, AdviceKind};
use leafwise_scene::document::SceneDocument;

/// The step that is taken in place of the scene's.
pub(super) fn advice(document: &SceneDocument) -> Option<Advice> {
    let (before, until) = (document.run.shortened?, document.run.comes_to.as_ref()?);
    let (steps, step) = (document.run.steps.value, document.method.step.time_step());
    Some(Advice {
        kind: AdviceKind::ShortenedStep,
        message: format!(
            "`until` = {} is not a whole number of steps of {before:?}: steps of {step:?} reach it, {steps} in all",
            until.value.literal
        ),
        change: format!("time-step = {step:?}"),
    })
}
