//! Equations that no bracket is looked for.

use leafwise_core::BuildError;
use leafwise_expression::AlgebraError;
use thiserror::Error;

/// Reason why nothing is looked for.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum FindError {
    /// Another number of formulas than of variables.
    #[error("{equations} equations for {variables} variables: write one for each")]
    Count {
        /// The number of equations.
        equations: usize,
        /// The number of variables.
        variables: usize,
    },
    /// A formula that the exact algebra cannot read.
    #[error("the equation {variable}' = … has no value in exact algebra: {error}")]
    Equation {
        /// The variable whose derivative it is.
        variable: String,
        /// The reason.
        error: AlgebraError,
    },
    /// Functions in pieces, of which only the pieces are integrated: what is found might jump between them.
    #[error(
        "the equation {variable}' = … is in pieces, by `if`, `abs`, `min`, `max`, `mod` or `floor`: look for the bracket of each piece"
    )]
    Pieces {
        /// The variable whose derivative it is.
        variable: String,
    },
    /// A computation past a limit of the exact algebra.
    #[error("the search ends: {0}")]
    Algebra(#[from] AlgebraError),
    /// More unknowns than are solved for.
    #[error(
        "integrals of degree {degree} in {symbols} functions have {unknowns} coefficients, more than {most}: look for a lower degree"
    )]
    TooMany {
        /// The degree.
        degree: usize,
        /// Variables and functions of them.
        symbols: usize,
        /// Their monomials.
        unknowns: usize,
        /// The greatest number of unknowns.
        most: usize,
    },
    /// A tensor without formulas.
    #[error(transparent)]
    System(#[from] BuildError),
}
