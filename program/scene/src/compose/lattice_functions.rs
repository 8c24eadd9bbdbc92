//! Functions of a long lattice's state: sums over sites, functions of them and of coordinates.

use std::collections::BTreeSet;
use std::sync::Arc;

use leafwise_core::lattice::LatticeObservables;
use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, Observer};
use leafwise_expression::Expression;
use leafwise_walk::StateFunctions;

/// Functions of a long lattice's state.
#[derive(Clone, Debug)]
pub struct LatticeFunctions {
    /// Sums over sites: 0 in the place of functions of others, and those others behind all.
    sums: LatticeObservables,
    sums_at: Vec<f64>,
    functions: NamedFunctions,
    functions_at: Vec<f64>,
    /// The place of each function among all.
    places: Vec<usize>,
    /// How many there are, without the sums behind.
    count: usize,
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
    /// The first of these sums over sites, so many as are not `behind`, with functions at places among them. Variables of a
    /// function are the coordinates, and after those the sums behind.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a function has no code.
    pub(super) fn new(
        sums: LatticeObservables,
        behind: usize,
        functions: &[(usize, Expression)],
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let formulas: Vec<&Expression> = functions.iter().map(|(_, formula)| formula).collect();
        Ok(Self {
            sums_at: vec![0.0; sums.observables()],
            functions: NamedFunctions::compile(&formulas, parameters)?,
            functions_at: vec![0.0; functions.len()],
            places: functions.iter().map(|(place, _)| *place).collect(),
            count: sums.observables() - behind,
            sums,
        })
    }
}

impl LatticeFunctions {
    /// The same at other values of the parameters.
    pub(super) fn at(&self, parameters: &[f64]) -> Self {
        Self {
            sums: self.sums.at(parameters),
            functions: self.functions.at(parameters),
            ..self.clone()
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
        self.count
    }

    /// Writes their values at a state.
    pub fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.sums.evaluate(state, &mut self.sums_at);
        let (own, behind) = self.sums_at.split_at(self.count);
        values.copy_from_slice(own);
        let value_of = |variable: usize| match state.get(variable) {
            Some(coordinate) => *coordinate,
            None => behind[variable - state.len()],
        };
        self.functions.evaluate(value_of, &mut self.functions_at);
        for (place, value) in self.places.iter().zip(&self.functions_at) {
            values[*place] = *value;
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

/// Functions of some coordinates of a long state, and of numbers behind it, as code of these alone.
#[derive(Clone, Debug)]
struct NamedFunctions {
    /// The variables that some function names.
    named: Arc<Vec<usize>>,
    inputs: Vec<f64>,
    code: SystemObservables,
}

impl NamedFunctions {
    /// Compiles formulas at these values of the parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    fn compile(formulas: &[&Expression], parameters: &[f64]) -> Result<Self, BuildError> {
        let named = formulas.iter().flat_map(|formula| formula.variables());
        let named: Vec<usize> = named.collect::<BTreeSet<_>>().into_iter().collect();
        // Every variable is among the named ones.
        let at = |variable: usize| named.binary_search(&variable).unwrap_or_default();
        let own = formulas.iter();
        let own = own.map(|formula| formula.at_formulas(&|by| Expression::Variable(at(by))));
        let own: Vec<Expression> = own.collect();
        let own: Vec<&Expression> = own.iter().collect();
        Ok(Self {
            inputs: vec![0.0; named.len()],
            code: SystemObservables::over(named.len(), &own, parameters)?,
            named: Arc::new(named),
        })
    }

    /// The same at other values of the parameters.
    fn at(&self, parameters: &[f64]) -> Self {
        Self {
            code: self.code.at(parameters),
            ..self.clone()
        }
    }

    /// Writes the values at variables of these values.
    fn evaluate(&mut self, value_of: impl Fn(usize) -> f64, values: &mut [f64]) {
        for (value, variable) in self.inputs.iter_mut().zip(&*self.named) {
            *value = value_of(*variable);
        }
        self.code.evaluate(&self.inputs, values);
    }
}

/// Formulas of some coordinates of a long lattice, as code of these alone.
///
/// # Errors
/// [`BuildError::Algebra`] where one has no code.
pub(super) fn of_coordinates(
    formulas: &[&Expression],
    parameters: &[f64],
) -> Result<StateFunctions, BuildError> {
    let functions = NamedFunctions::compile(formulas, parameters)?;
    let count = formulas.len();
    Ok(StateFunctions::each(count, move |parameters| {
        let mut functions = functions.at(parameters);
        Ok(Observer::new(count, move |state, values| {
            functions.evaluate(|coordinate| state[coordinate], values);
        }))
    }))
}
