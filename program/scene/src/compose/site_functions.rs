//! Functions that a long lattice's run records, by the sums over sites that they are of.

use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};

use super::Refusal;
use super::names::{check_code, function, parse, refusal};
use super::spin_temperature::is_spin_temperature;
use crate::document::{Located, SceneDocument};

/// A function of a lattice's state.
pub(super) enum SiteFunction {
    /// A combination of sums over sites, each the same at every site.
    Sum(Formula),
    /// A function of single coordinates and of such combinations.
    OfSums(Formula, Vec<Formula>),
    /// A function of sums that repeat from site to site nowhere, such as `sum(j, q[2,j])`.
    Other,
    /// The temperature of spins.
    SpinTemperature,
}

impl SiteFunction {
    /// The function that a recorded formula is.
    ///
    /// # Errors
    /// A text that is no formula.
    pub fn of(document: &SceneDocument, formula: &Located<String>) -> Result<Self, Refusal> {
        if is_spin_temperature(&formula.value) {
            return Ok(Self::SpinTemperature);
        }
        let parsed = parse(document, formula)?;
        if parsed.offsets_of_sums().is_ok() {
            return Ok(Self::Sum(parsed));
        }
        let sums = parsed.outermost_sums();
        let are_of_sites = sums.iter().all(|sum| sum.offsets_of_sums().is_ok());
        Ok(match are_of_sites {
            true => Self::OfSums(parsed, sums),
            false => Self::Other,
        })
    }

    /// The combinations of sums over sites that it is of.
    pub fn sums(&self) -> &[Formula] {
        match self {
            Self::Sum(sum) => std::slice::from_ref(sum),
            Self::OfSums(_, sums) => sums,
            Self::Other | Self::SpinTemperature => &[],
        }
    }

    /// The function of coordinates and of sums, which are the variables from `first` on; `None` for a sum alone.
    ///
    /// # Errors
    /// Names that are none, sites that are not there, and functions without code.
    pub fn outside(
        &self,
        document: &SceneDocument,
        (formula, scope): (&Located<String>, &Scope),
        first: usize,
    ) -> Result<Option<Expression>, Refusal> {
        match self {
            Self::Sum(_) => Ok(None),
            Self::Other => function(document, scope, formula).map(Some),
            Self::SpinTemperature => {
                let [turns, curvature] = [first, first + 1].map(Expression::Variable);
                let quotient = Expression::Quotient(Box::new(turns), Box::new(curvature));
                Ok(Some(quotient))
            }
            Self::OfSums(parsed, _) => {
                let outer = parsed.outside_sums(scope, first);
                let outer = outer.map_err(|error| refusal(document, formula, &error))?;
                check_code(document, formula, &outer)?;
                Ok(Some(outer))
            }
        }
    }

    /// Refuses what a lattice that is not written out evaluates nowhere.
    ///
    /// # Errors
    /// The first sum that does not repeat from site to site; those of [`outside`](Self::outside).
    pub fn check_long(
        &self,
        document: &SceneDocument,
        (formula, scope): (&Located<String>, &Scope),
    ) -> Result<(), Refusal> {
        let Self::Other = self else {
            return self.outside(document, (formula, scope), 0).map(drop);
        };
        let sums = parse(document, formula)?.outermost_sums();
        let offsets = sums
            .iter()
            .try_for_each(|sum| sum.offsets_of_sums().map(drop));
        offsets.map_err(|error| refusal(document, formula, &error))
    }

    /// How many sums it is of beside itself.
    pub fn behind(&self) -> usize {
        match self {
            Self::Sum(_) | Self::Other => 0,
            Self::OfSums(_, sums) => sums.len(),
            Self::SpinTemperature => 2,
        }
    }
}
