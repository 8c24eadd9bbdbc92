//! A composed run at other values: of parameters, initial state, step and number of steps.

use super::Refusal;
use super::forces::check_forces;
use super::initial::initial_state;
use super::run::{ComposedRun, check_times};
use super::sample_times::sample_times;
use super::system::{check_contradictions, with_beside};
use crate::document::SceneDocument;

/// Keys whose values no part of a method is made of.
const VALUES: [&str; 9] = [
    "method.time-step",
    "method.epsilon",
    "method.h",
    "run.initial",
    "run.steps",
    "run.record.every",
    "run.record.drift-every",
    "run.record.interval",
    "run.record.times",
];

/// Whether overrides, keys and values, leave the method as it is, so that [`ComposedRun::at`] serves.
pub fn are_values(overrides: &[(String, String)]) -> bool {
    let is_value = |key: &str| VALUES.contains(&key) || key.starts_with("run.initial.");
    overrides.iter().all(|(key, _)| is_value(key))
}

impl ComposedRun {
    /// Run of the same method at the values of a scene. This scene differs from the run's own in what
    /// [`assign`](SceneDocument::assign) sets, and in when samples are kept. The method is shared: its kernels take
    /// parameters and steps when they run.
    ///
    /// Returns `None` where a part of the run holds values: a long lattice, a system of numbers, a matrix of couplings, a recorded shadow
    /// energy. Noise gives `None` too, since its strengths are checked when it is composed.
    ///
    /// # Errors
    /// An initial state that is none, and times that the run does not come to.
    pub fn at(&self, document: &SceneDocument) -> Result<Option<Self>, Refusal> {
        let has_values = self.method.lattice().is_some()
            || self.plan.shadow.is_some()
            || self.method.noise().is_some()
            || !document.system.matrices.is_empty()
            || self.system.expressions().is_none();
        if has_values {
            return Ok(None);
        }
        let parameters = document.system.parameters.iter();
        let parameters: Vec<f64> = parameters.map(|(_, value)| value.value.value).collect();
        let Ok(system) = self.system.with_parameter_values(&parameters) else {
            return Ok(None);
        };
        check_contradictions(document)?;
        check_times(document)?;
        let stepped_beside = (self.extension.as_ref(), self.contact.as_ref());
        let initial = initial_state(document)?;
        let initial = with_beside(document, initial, stepped_beside, &parameters)?;
        self.plan.events.check(document, &initial, &parameters)?;
        check_forces(document, &system, &initial)?;
        let mut run = self.clone();
        run.system = system;
        run.near.clone_from(&initial);
        let step = &document.method.step;
        (run.plan.epsilon, run.plan.h) = (step.epsilon(), step.h());
        run.plan.step_key = step.key();
        run.plan.steps = document.run.steps.value;
        run.plan.samples = sample_times(document);
        run.plan.drift_every = document.run.record.drift_every;
        run.plan.initial = initial;
        Ok(Some(run))
    }
}
