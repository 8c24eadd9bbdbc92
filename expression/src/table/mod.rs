//! Tables as functions: tensor products of B-splines on uniform knots, in one to three variables.
//!
//! f(x₁, …, x_d) = Σ c_{i+j} Π_l b_{j_l}(u_l). Here i_l is the cell of x_l, u_l its place in it from 0 to 1, and j_l goes from 0
//! to the degree k. The coefficients c are those for which f has the table's numbers at its nodes. Derivatives are those of f: of
//! order up to k along each axis, and continuous up to k − 1.

mod axis;
mod banded;
mod check;
mod error;
mod function;
mod interpolation;
mod part;
mod repeated;

pub use axis::{HIGHEST_DEGREE, MOST_AXES, TableAxis, USUAL_DEGREE};
pub use error::TableError;
pub use function::{Lookup, Outside, TableFunction};
pub(crate) use part::Part;

#[cfg(test)]
mod tests;
