//! Recorded functions of many bodies: sums over pairs in loops and shadow energies beside formulas of single coordinates.

use leafwise_core::pairs::{BodyFunction, BodyObservables};
use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, Observer, PoissonSystem};

use super::observables::{RecordedFormula, ShadowNumbers};

/// Recorded functions in their order, each of sums, a formula, or a shadow energy.
#[derive(Clone)]
pub(super) struct BodyColumns {
    sums: Option<BodyObservables>,
    written: SystemObservables,
    shadows: Vec<ShadowNumbers>,
    kinds: Vec<Kind>,
    parameters: Vec<f64>,
}

/// Where the value of a column comes from.
#[derive(Clone, Copy)]
enum Kind {
    Written,
    Sums,
    Shadow,
}

impl From<&RecordedFormula> for Kind {
    fn from(formula: &RecordedFormula) -> Self {
        match formula {
            RecordedFormula::Written(_)
            | RecordedFormula::OfSites
            | RecordedFormula::SpinTemperature => Self::Written,
            RecordedFormula::Sums(..) => Self::Sums,
            RecordedFormula::Shadow(_) => Self::Shadow,
        }
    }
}

impl BodyColumns {
    /// These functions, of which `written` are those that are formulas; `None` where all are.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn of(
        system: &PoissonSystem,
        formulas: &[RecordedFormula],
        written: SystemObservables,
    ) -> Result<Option<Self>, BuildError> {
        let (mut functions, mut shape) = (Vec::<BodyFunction>::new(), None);
        let mut shadows = Vec::new();
        for formula in formulas {
            match formula {
                RecordedFormula::Written(_)
                | RecordedFormula::OfSites
                | RecordedFormula::SpinTemperature => {}
                RecordedFormula::Sums(own, function) => {
                    functions.push((**function).clone());
                    shape = Some(own);
                }
                RecordedFormula::Shadow(shadow) => shadows.push(shadow.clone()),
            }
        }
        if shape.is_none() && shadows.is_empty() {
            return Ok(None);
        }
        let parameters = system.parameter_values();
        let sums = shape.map(|shape| BodyObservables::new(&functions, shape, &parameters));
        Ok(Some(Self {
            sums: sums.transpose()?,
            written,
            shadows,
            kinds: formulas.iter().map(Kind::from).collect(),
            parameters,
        }))
    }

    /// The same at other values of the parameters.
    pub fn at(&self, parameters: &[f64]) -> Self {
        Self {
            sums: self.sums.as_ref().map(|sums| sums.at(parameters)),
            written: self.written.at(parameters),
            parameters: parameters.to_vec(),
            ..self.clone()
        }
    }
}

impl From<BodyColumns> for Observer {
    fn from(own: BodyColumns) -> Self {
        let BodyColumns {
            mut sums,
            mut written,
            kinds,
            ..
        } = own;
        let count = sums.as_ref().map_or(0, BodyObservables::observables);
        let mut of_sums = vec![0.0; count];
        let mut of_formulas = vec![0.0; written.observables()];
        let shadows = own.shadows.iter();
        let shadows = shadows.map(|shadow| (shadow.make)(&own.parameters, shadow.t));
        let mut shadows: Vec<Self> = shadows.collect();
        let mut of_shadows = vec![0.0; shadows.len()];
        Self::new(kinds.len(), move |state, values| {
            if let Some(sums) = &mut sums {
                sums.evaluate(state, &mut of_sums);
            }
            written.evaluate(state, &mut of_formulas);
            for (shadow, value) in shadows.iter_mut().zip(of_shadows.chunks_exact_mut(1)) {
                shadow.evaluate(state, value);
            }
            let (mut sums, mut formulas) = (of_sums.iter(), of_formulas.iter());
            let mut shadows = of_shadows.iter();
            for (value, kind) in values.iter_mut().zip(&kinds) {
                let next = match kind {
                    Kind::Written => formulas.next(),
                    Kind::Sums => sums.next(),
                    Kind::Shadow => shadows.next(),
                };
                *value = next.copied().unwrap_or(f64::NAN);
            }
        })
    }
}
