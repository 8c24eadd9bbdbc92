//! Functions of a long lattice's state: sums over sites, and what is written out.

use std::collections::BTreeSet;
use std::sync::Arc;

use leafwise_core::lattice::LatticeObservables;
use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, Observer};
use leafwise_expression::{Expression, Graph, Kernel, Term};
use leafwise_walk::StateFunctions;

/// Functions of a long lattice's state.
#[derive(Clone, Debug)]
pub struct LatticeFunctions {
    /// All, with 0 in the place of those that are no sums over sites.
    sums: LatticeObservables,
    /// The places of these, what computes them and room for their values.
    written: Option<(Vec<usize>, SystemObservables, Vec<f64>)>,
}

/// A column of what a long lattice records.
#[derive(Clone, Copy, Debug)]
pub(super) enum RecordedColumn {
    /// A coordinate of the state.
    Coordinate(usize),
    /// A function by its number.
    Formula(usize),
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

impl LatticeFunctions {
    /// The same at other values of the parameters.
    pub(super) fn at(&self, parameters: &[f64]) -> Self {
        let written = self
            .written
            .as_ref()
            .map(|(places, written, room)| (places.clone(), written.at(parameters), room.clone()));
        Self {
            sums: self.sums.at(parameters),
            written,
        }
    }

    /// These and coordinates, as the columns tell.
    pub(super) fn beside(mut self, columns: &[RecordedColumn]) -> Observer {
        let (columns, mut own) = (columns.to_vec(), vec![0.0; self.observables()]);
        Observer::new(columns.len(), move |state, values| {
            self.evaluate(state, &mut own);
            for (value, column) in values.iter_mut().zip(&columns) {
                *value = match column {
                    RecordedColumn::Coordinate(at) => state[*at],
                    RecordedColumn::Formula(at) => own[*at],
                };
            }
        })
    }
}

impl LatticeFunctions {
    /// How many.
    pub fn observables(&self) -> usize {
        self.sums.observables()
    }

    /// Writes their values at a state.
    pub fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.sums.evaluate(state, values);
        if let Some((places, written, own)) = &mut self.written {
            written.evaluate(state, own);
            for (place, value) in places.iter().zip(own) {
                values[*place] = *value;
            }
        }
    }
}

impl From<LatticeFunctions> for Observer {
    fn from(mut own: LatticeFunctions) -> Self {
        Self::new(own.observables(), move |state, values| {
            own.evaluate(state, values);
        })
    }
}

/// Formulas of some coordinates of a long lattice, as code of these alone.
///
/// # Errors
/// [`BuildError::Algebra`] where one has no code.
pub(super) fn of_coordinates(
    formulas: &[&Expression],
    parameters: usize,
) -> Result<StateFunctions, BuildError> {
    let named = formulas.iter().flat_map(|formula| formula.variables());
    let named: Vec<usize> = named.collect::<BTreeSet<_>>().into_iter().collect();
    let mut graph = Graph::new();
    let inputs: Vec<Term> = (0..named.len()).map(|at| graph.input(at)).collect();
    let values = formulas.iter().map(|formula| {
        formula.evaluate_in(&mut graph, &mut |_, coordinate| {
            // Every variable is among the named ones.
            let at = named.binary_search(&coordinate).unwrap_or_default();
            Ok(inputs[at].clone())
        })
    });
    let values = values.collect::<Result<Vec<_>, _>>()?;
    let (count, whole) = (values.len(), named.len());
    let kernel = Arc::new(Kernel::compile(&graph, &values, parameters, whole));
    let named = Arc::new(named);
    Ok(StateFunctions::each(count, move |parameters| {
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, parameters, &[1.0], &[1.0]);
        let (kernel, named) = (Arc::clone(&kernel), Arc::clone(&named));
        let mut own = vec![0.0; named.len()];
        Ok(Observer::new(count, move |state, values| {
            for (value, coordinate) in own.iter_mut().zip(&*named) {
                *value = state[*coordinate];
            }
            kernel.evaluate(&mut workspace, &own, values);
        }))
    }))
}
