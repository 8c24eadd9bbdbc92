//! Bounds on the rounding errors of fields.

use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_expression::{AlgebraError, Graph, Term};

/// Bounds on the rounding errors of a field's code.
pub struct FieldRounding {
    bounds: Box<Bounds>,
}

/// Writes bounds, or none, for parameters, coordinates, and how far these are known.
type Bounds = dyn Fn(&[f64], &[f64], &[f64], &mut [f64]) -> Result<(), AlgebraError> + Send + Sync;

impl FieldRounding {
    /// By a function that writes a bound for each component of the field, for parameters, coordinates, and how far these
    /// are known. A bound that is infinite or no number is none.
    pub fn new(
        bounds: impl Fn(&[f64], &[f64], &[f64], &mut [f64]) -> Result<(), AlgebraError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            bounds: Box::new(bounds),
        }
    }

    /// Of code for the field.
    pub(super) fn of(graph: &Graph, field: &[Term]) -> Self {
        let (graph, field) = (graph.clone(), field.to_vec());
        Self::new(move |parameters, x, errors, out| {
            let pairs = x.iter().zip(errors);
            let inputs: Vec<Bounded> = pairs
                .map(|(&value, &error)| Bounded { value, error })
                .collect();
            let mut numbers = BoundedNumbers {
                parameters: parameters.to_vec(),
            };
            let values = numbers.values_at(&graph, &field, &inputs)?;
            for (out, value) in out.iter_mut().zip(values) {
                *out = value.error;
            }
            Ok(())
        })
    }

    /// How far rounding may move each component of the field at coordinates that are known up to these errors; 0 where
    /// there is no bound.
    pub fn bounds(&self, parameters: &[f64], x: &[f64], errors: &[f64], out: &mut [f64]) {
        if (self.bounds)(parameters, x, errors, out).is_err() {
            out.fill(0.0);
        }
        for out in out.iter_mut().filter(|out| !out.is_finite()) {
            *out = 0.0;
        }
    }
}
