//! Couplings in formulas: matrices in a scope, and their values by a formula of two indices.

use std::sync::Arc;

use super::bound::{Bound, bind};
use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::matrices::Matrix;
use super::place::Place;
use super::scope::{Entry, Scope};
use super::tree::Reference;
use super::value::Evaluator;

impl Scope {
    /// Adds the matrix `name[0,0]`, `name[0,1]`, … of `order` rows, the numbers row after row. They are numbers of a formula,
    /// as exact as if they were written in it.
    ///
    /// ```
    /// use leafwise_expression::syntax::{Formula, Scope};
    ///
    /// let numbers = [0.0, 0.5, 2.0, 0.0];
    /// let scope = Scope::new().with_family("q", 0, 2).with_matrix("J", 2, numbers.into());
    /// let formula = Formula::parse("sum(i<j, J[i,j]*q[i]*q[j])").expect("a formula");
    /// let expression = formula.resolve(&scope, None).expect("known names").expect("no boundary");
    /// assert_eq!(expression.evaluate(&[3.0, 4.0], &[]), 6.0);
    /// ```
    pub fn with_matrix(mut self, name: &str, order: usize, numbers: Arc<[f64]>) -> Self {
        self.declare(name, Entry::Matrix(self.matrices.len()));
        self.matrices.push(Matrix { order, numbers });
        self
    }

    /// The entry of a matrix that a reference names.
    pub(super) fn place_in_matrix(
        &self,
        text: &str,
        (matrix, reference): (usize, &Reference),
        bound: Option<&Bound<'_>>,
    ) -> Result<Place, SyntaxError> {
        let name = || reference.name.of(text).to_owned();
        let [row, column] = &reference.sites[..] else {
            let kind = SyntaxErrorKind::AxesDiffer {
                name: name(),
                axes: 2,
                written: reference.sites.len(),
            };
            return Err(SyntaxError::new(reference.span(), kind));
        };
        let order = self.matrices[matrix].order;
        let mut at = [0; 2];
        for (own, site) in at.iter_mut().zip([row, column]) {
            // Both count sites, along the one axis of a chain.
            *own = match self.along(text, (0, order), site, bound)? {
                Ok(inside) => inside,
                Err(Some(level)) => return Ok(Place::Outside { level }),
                Err(None) => {
                    let kind = SyntaxErrorKind::IndexOutOfRange {
                        name: name(),
                        position: self.position(text, 0, site, bound)?.0,
                        length: order,
                    };
                    return Err(SyntaxError::new(site.span, kind));
                }
            };
        }
        Ok(Place::Entry { matrix, at })
    }
}

impl Formula {
    /// The values of a formula of two indices at every two sites, row after row.
    ///
    /// # Errors
    /// Those of [`Formula::value`].
    pub fn matrix(
        &self,
        scope: &Scope,
        parameters: &[f64],
        (names, order): ([&str; 2], usize),
    ) -> Result<Vec<f64>, SyntaxError> {
        let mut evaluator = Evaluator::new(self.source(), scope, parameters);
        let mut numbers = Vec::with_capacity(order * order);
        for (row, column) in (0..order).flat_map(|i| (0..order).map(move |j| (i, j))) {
            let at = [(row, order), (column, order)];
            let mut value = |bound: Option<&Bound<'_>>| evaluator.value(self.root(), bound);
            let value = bind(&names, &at, 0, None, &mut value);
            numbers.push(value.map_err(|error| *error)?);
        }
        Ok(numbers)
    }
}
