//! Functions of the state that a run watches.

use std::sync::Arc;

use leafwise_expression::{Expression, Kernel, Workspace};

use super::formula_kernel::kernel;
use super::numbers::SystemEvaluator;
use super::{Definition, PoissonSystem};
use crate::error::BuildError;
use crate::observer::Observer;

/// Formulas in a system's variables, compiled for one set of parameters.
#[derive(Clone, Debug)]
pub struct SystemObservables {
    kernel: Arc<Kernel>,
    workspace: Workspace,
    /// A step size that no formula depends on, for each lane.
    ones: Vec<f64>,
}

impl SystemObservables {
    /// Compiles `formulas` of the variables and parameters of `system`, whatever that is given by.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn new(
        system: &PoissonSystem,
        formulas: &[&Expression],
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        Self::over(system.dimension(), formulas, parameters)
    }

    /// Compiles `formulas` of so many variables.
    ///
    /// # Errors
    /// As [`SystemObservables::new`].
    pub fn over(
        dimension: usize,
        formulas: &[&Expression],
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let kernel = kernel(formulas, dimension, parameters.len())?;
        Ok(Self::of(Arc::new(kernel), 1, parameters))
    }

    /// The same formulas, compiled once, for another set of parameters.
    #[must_use]
    pub fn at(&self, parameters: &[f64]) -> Self {
        self.side_by_side(1, parameters)
    }

    /// The same formulas in `lanes` with parameters of their own: states, parameters and values are structures of arrays.
    #[must_use]
    pub fn side_by_side(&self, lanes: usize, parameters: &[f64]) -> Self {
        Self::of(Arc::clone(&self.kernel), lanes, parameters)
    }

    fn of(kernel: Arc<Kernel>, lanes: usize, parameters: &[f64]) -> Self {
        let mut workspace = kernel.workspace(lanes);
        let ones = vec![1.0; lanes];
        kernel.prepare(&mut workspace, parameters, &ones, &ones);
        Self {
            kernel,
            workspace,
            ones,
        }
    }

    /// Takes other parameters, as many lanes of them.
    ///
    /// # Panics
    /// When they are not as many.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        let (kernel, ones) = (&self.kernel, &self.ones);
        kernel.prepare(&mut self.workspace, parameters, ones, ones);
    }
}

impl SystemObservables {
    /// How many.
    pub fn observables(&self) -> usize {
        self.kernel.outputs()
    }

    /// Writes their values at a state.
    pub fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.kernel.evaluate(&mut self.workspace, state, values);
    }
}

impl From<SystemObservables> for Observer {
    fn from(mut own: SystemObservables) -> Self {
        Self::new(own.observables(), move |state, values| {
            own.evaluate(state, values);
        })
    }
}

/// The energy, then each Casimir. A value that cannot be computed is NaN.
pub struct SystemInvariants {
    values: Values,
}

enum Values {
    Formulas(Box<SystemObservables>),
    Numbers {
        evaluator: Box<dyn SystemEvaluator>,
        casimirs: usize,
    },
}

impl SystemInvariants {
    /// The invariants of a system for one set of parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn new(system: &PoissonSystem, parameters: &[f64]) -> Result<Self, BuildError> {
        let values = match &system.definition {
            Definition::Formulas(formulas) => {
                let casimirs = formulas.casimirs().iter().map(|c| &c.expression);
                let formulas: Vec<_> = std::iter::once(formulas.hamiltonian())
                    .chain(casimirs)
                    .collect();
                Values::Formulas(Box::new(SystemObservables::new(
                    system, &formulas, parameters,
                )?))
            }
            Definition::Numbers(opaque) => Values::Numbers {
                evaluator: opaque.numbers.evaluator(parameters),
                casimirs: opaque.casimirs.len(),
            },
        };
        Ok(Self { values })
    }
}

impl SystemInvariants {
    /// How many.
    pub fn observables(&self) -> usize {
        match &self.values {
            Values::Formulas(formulas) => formulas.observables(),
            Values::Numbers { casimirs, .. } => 1 + casimirs,
        }
    }

    /// Writes their values at a state.
    pub fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        match &mut self.values {
            Values::Formulas(formulas) => formulas.evaluate(state, values),
            Values::Numbers {
                evaluator,
                casimirs,
            } => {
                let (energy, rest) = values.split_at_mut(1);
                if evaluator.hamiltonian(state, energy).is_err() {
                    energy.fill(f64::NAN);
                }
                if *casimirs > 0 && evaluator.casimirs(state, rest).is_err() {
                    rest.fill(f64::NAN);
                }
            }
        }
    }
}

impl From<SystemInvariants> for Observer {
    fn from(mut own: SystemInvariants) -> Self {
        Self::new(own.observables(), move |state, values| {
            own.evaluate(state, values);
        })
    }
}
