//! Recorded functions of many bodies: sums over pairs in loops beside formulas of single coordinates.

use leafwise_core::pairs::{BodyFunction, BodyObservables};
use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, Observer, PoissonSystem};

use super::observables::RecordedFormula;

/// Recorded functions in their order, each of sums or a formula.
#[derive(Clone)]
pub(super) struct BodyColumns {
    sums: BodyObservables,
    written: SystemObservables,
    /// Whether each is of sums.
    are_sums: Vec<bool>,
    of_sums: Vec<f64>,
    of_formulas: Vec<f64>,
}

impl BodyColumns {
    /// These functions, of which `written` are those that are formulas; `None` where none is of sums.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn of(
        system: &PoissonSystem,
        formulas: &[RecordedFormula],
        written: SystemObservables,
    ) -> Result<Option<Self>, BuildError> {
        let (mut functions, mut shape) = (Vec::<BodyFunction>::new(), None);
        for formula in formulas {
            if let RecordedFormula::Sums(own, function) = formula {
                functions.push((**function).clone());
                shape = Some(own);
            }
        }
        let Some(shape) = shape else {
            return Ok(None);
        };
        Ok(Some(Self {
            sums: BodyObservables::new(&functions, shape, &system.parameter_values())?,
            of_sums: vec![0.0; functions.len()],
            of_formulas: vec![0.0; written.observables()],
            written,
            are_sums: (formulas.iter())
                .map(|formula| matches!(formula, RecordedFormula::Sums(..)))
                .collect(),
        }))
    }

    /// The same at other values of the parameters.
    pub fn at(&self, parameters: &[f64]) -> Self {
        Self {
            sums: self.sums.at(parameters),
            written: self.written.at(parameters),
            ..self.clone()
        }
    }
}

impl From<BodyColumns> for Observer {
    fn from(mut own: BodyColumns) -> Self {
        Self::new(own.are_sums.len(), move |state, values| {
            own.evaluate(state, values);
        })
    }
}

impl BodyColumns {
    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.sums.evaluate(state, &mut self.of_sums);
        self.written.evaluate(state, &mut self.of_formulas);
        let (mut sums, mut formulas) = (self.of_sums.iter(), self.of_formulas.iter());
        for (value, is_sum) in values.iter_mut().zip(&self.are_sums) {
            let next = if *is_sum {
                sums.next()
            } else {
                formulas.next()
            };
            *value = next.copied().unwrap_or(f64::NAN);
        }
    }
}
