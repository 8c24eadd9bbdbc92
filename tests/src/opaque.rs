//! Systems of numbers: what a library would offer.

use std::sync::Arc;

use leafwise_core::system::{Derivatives, OpaqueSystem, SystemEvaluator, SystemNumbers};
use leafwise_core::{PoissonSystem, StepError};

/// The same system as numbers, with every derivative.
///
/// # Panics
/// When a formula has no code.
pub fn with_derivatives(system: &PoissonSystem) -> PoissonSystem {
    system.without_formulas("test/numbers").expect("code")
}

/// The same system as numbers, with values alone: Π(y)v, H, ∇H and the Casimirs.
///
/// # Panics
/// When a formula has no code.
pub fn values_only(system: &PoissonSystem) -> PoissonSystem {
    let all = with_derivatives(system);
    let opaque = all.opaque().expect("a system of numbers");
    OpaqueSystem {
        name: "test/values".to_owned(),
        numbers: Arc::new(ValuesOnly(Arc::clone(&opaque.numbers))),
        ..opaque.clone()
    }
    .into()
}

#[derive(Debug)]
struct ValuesOnly(Arc<dyn SystemNumbers>);

impl SystemNumbers for ValuesOnly {
    fn derivatives(&self) -> Derivatives {
        Derivatives::default()
    }

    fn evaluator(&self, parameters: &[f64]) -> Box<dyn SystemEvaluator> {
        Box::new(ValuesEvaluator(self.0.evaluator(parameters)))
    }
}

struct ValuesEvaluator(Box<dyn SystemEvaluator>);

impl SystemEvaluator for ValuesEvaluator {
    fn tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.0.tensor(y, v, out)
    }

    fn hamiltonian(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.0.hamiltonian(y, out)
    }

    fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.0.gradient(y, out)
    }

    fn casimirs(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.0.casimirs(y, out)
    }
}
