//! Functions of a long lattice's state: sums over sites, and what is written out.

use leafwise_core::lattice::LatticeObservables;
use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, Observe};
use leafwise_expression::Expression;

/// Functions of a long lattice's state.
#[derive(Clone, Debug)]
pub struct LatticeFunctions {
    /// All, with 0 in the place of those that are no sums over sites.
    sums: LatticeObservables,
    /// The places of these, what computes them and room for their values.
    written: Option<(Vec<usize>, SystemObservables, Vec<f64>)>,
}

impl LatticeFunctions {
    /// Sums over sites, with formulas of all `dimension` coordinates at their places among them.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub(super) fn new(
        sums: LatticeObservables,
        dimension: usize,
        written: &[(usize, Expression)],
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let formulas: Vec<&Expression> = written.iter().map(|(_, formula)| formula).collect();
        let places = written.iter().map(|(place, _)| *place).collect();
        let written = match formulas.is_empty() {
            true => None,
            false => {
                let written = SystemObservables::over(dimension, &formulas, parameters)?;
                Some((places, written, vec![0.0; formulas.len()]))
            }
        };
        Ok(Self { sums, written })
    }
}

impl Observe for LatticeFunctions {
    fn observables(&self) -> usize {
        self.sums.observables()
    }

    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.sums.evaluate(state, values);
        if let Some((places, written, own)) = &mut self.written {
            written.evaluate(state, own);
            for (place, value) in places.iter().zip(own) {
                values[*place] = *value;
            }
        }
    }
}
