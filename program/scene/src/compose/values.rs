//! A composed run at other values: of parameters, initial state, step and number of steps.

use std::sync::{Arc, Mutex, PoisonError};

use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::Expression;

use super::Refusal;
use super::initial::initial_state;
use super::run::ComposedRun;
use crate::document::SceneDocument;

/// Functions of the state that were compiled for a run; its copies at other values share them.
#[derive(Clone, Default)]
pub(super) struct CompiledFunctions(Arc<Mutex<Vec<Compiled>>>);

struct Compiled {
    formulas: Vec<Expression>,
    observables: SystemObservables,
}

impl CompiledFunctions {
    /// These formulas at the values of a system's parameters, compiled unless they were.
    pub fn observables(
        &self,
        system: &PoissonSystem,
        formulas: &[&Expression],
    ) -> Result<SystemObservables, BuildError> {
        let values = system.parameter_values();
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |one: &&Compiled| one.formulas.iter().eq(formulas.iter().copied());
        if let Some(compiled) = all.iter().find(is_same) {
            return Ok(compiled.observables.at(&values));
        }
        let observables = SystemObservables::new(system, formulas, &values)?;
        let own = observables.at(&values);
        all.push(Compiled {
            formulas: formulas.iter().copied().cloned().collect(),
            observables,
        });
        Ok(own)
    }
}

impl ComposedRun {
    /// The same run at the values of a scene that differs from its own in what
    /// [`assign`](SceneDocument::assign) sets: its method, whose kernels take parameters and steps when they run, is shared.
    /// `None` where a part of it holds values: a long lattice, a system of numbers, a recorded shadow energy; and with noise,
    /// whose strengths are checked when it is composed.
    ///
    /// # Errors
    /// An initial state that is none.
    pub fn at(&self, document: &SceneDocument) -> Result<Option<Self>, Refusal> {
        let has_values = self.method.lattice().is_some()
            || self.plan.shadow.is_some()
            || self.method.noise().is_some()
            || self.system.expressions().is_none();
        if has_values {
            return Ok(None);
        }
        let parameters = document.system.parameters.iter();
        let parameters: Vec<f64> = parameters.map(|(_, value)| value.value.value).collect();
        let Ok(system) = self.system.with_parameter_values(&parameters) else {
            return Ok(None);
        };
        let own = initial_state(document)?;
        let initial = match &self.extension {
            Some(extension) => extension.state(document, &own, &parameters)?,
            None => own,
        };
        self.plan.events.check(document, &initial, &parameters)?;
        let mut run = self.clone();
        run.system = system;
        run.near.clone_from(&initial);
        let step = &document.method.step;
        (run.plan.epsilon, run.plan.h) = (step.epsilon(), step.h());
        run.plan.steps = document.run.steps.value;
        run.plan.initial = initial;
        Ok(Some(run))
    }
}
