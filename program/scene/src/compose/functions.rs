//! Functions of the state that a run and its copies at other values share.

use std::sync::{Arc, Mutex, PoisonError};

use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::Expression;

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
