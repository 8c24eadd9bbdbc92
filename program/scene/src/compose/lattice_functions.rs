//! Functions of a long lattice's state: sums over sites, and what is written out.

use std::sync::Arc;

use leafwise_core::lattice::LatticeObservables;
use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, Observe};
use leafwise_expression::{Expression, Graph, Kernel, Term, Workspace};
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

/// Functions and coordinates of a long lattice's state.
struct RecordedColumns {
    functions: LatticeFunctions,
    columns: Vec<RecordedColumn>,
    values: Vec<f64>,
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
    pub(super) fn beside(self, columns: &[RecordedColumn]) -> impl Observe + use<> {
        RecordedColumns {
            values: vec![0.0; self.observables()],
            functions: self,
            columns: columns.to_vec(),
        }
    }
}

impl Observe for RecordedColumns {
    fn observables(&self) -> usize {
        self.columns.len()
    }

    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.functions.evaluate(state, &mut self.values);
        for (value, column) in values.iter_mut().zip(&self.columns) {
            *value = match column {
                RecordedColumn::Coordinate(at) => state[*at],
                RecordedColumn::Formula(at) => self.values[*at],
            };
        }
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

/// A formula of some coordinates of a long lattice, as code of these alone.
///
/// # Errors
/// [`BuildError::Algebra`] where it has no code.
pub(super) fn of_coordinates(
    formula: &Expression,
    parameters: usize,
) -> Result<StateFunctions, BuildError> {
    let named: Vec<usize> = formula.variables().into_iter().collect();
    let mut graph = Graph::new();
    let inputs: Vec<Term> = (0..named.len()).map(|at| graph.input(at)).collect();
    let value = formula.evaluate_in(&mut graph, &mut |_, coordinate| {
        // Every variable is among the named ones.
        let at = named.binary_search(&coordinate).unwrap_or_default();
        Ok(inputs[at].clone())
    })?;
    let kernel = Arc::new(Kernel::compile(&graph, &[value], parameters, named.len()));
    let named = Arc::new(named);
    Ok(StateFunctions::each(1, move |parameters| {
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, parameters, &[1.0], &[1.0]);
        Ok(Box::new(OfCoordinates {
            kernel: Arc::clone(&kernel),
            workspace,
            values: vec![0.0; named.len()],
            named: Arc::clone(&named),
        }))
    }))
}

struct OfCoordinates {
    kernel: Arc<Kernel>,
    workspace: Workspace,
    named: Arc<Vec<usize>>,
    /// Of the named coordinates.
    values: Vec<f64>,
}

impl Observe for OfCoordinates {
    fn observables(&self) -> usize {
        1
    }

    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        for (value, coordinate) in self.values.iter_mut().zip(&*self.named) {
            *value = state[*coordinate];
        }
        self.kernel
            .evaluate(&mut self.workspace, &self.values, values);
    }
}
