//! Systems of numbers: what a library would offer.

use leafwise_core::system::{
    Derivatives, OpaqueSystem, SystemEvaluator, SystemFunction, SystemNumbers,
};
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
    let all = opaque.numbers.clone();
    let numbers = SystemNumbers::new(Derivatives::default(), move |parameters| {
        Box::new(ValuesEvaluator(all.evaluator(parameters)))
    });
    OpaqueSystem {
        name: "test/values".to_owned(),
        numbers,
        ..opaque.clone()
    }
    .into()
}

struct ValuesEvaluator(Box<dyn SystemEvaluator>);

impl SystemEvaluator for ValuesEvaluator {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        match function {
            SystemFunction::TensorTangent(..)
            | SystemFunction::Hessian(_)
            | SystemFunction::CasimirGradients => Err(StepError::NoTangent),
            value => self.0.evaluate(value, y, out),
        }
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}
