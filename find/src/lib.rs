//! Poisson brackets and Hamiltonians of equations of motion ẋ = f(x) that are written as formulas, found and proved.
//!
//! The function [`find`] looks for J and H with ẋ = J ∇H = {x, H} in exact algebra over ℚ.
//!
//! - `constant`: J constant in x, or log-canonical.
//! - `affine`: J affine in x, of those that the motion preserves (`invariant`), H a combination of first integrals.
//! - `low`: two or three variables, J made of first integrals.
//! - `integrals`: first integrals, polynomials or products of powers.
//! - `casimirs`: functions C with J ∇C = 0, of any tensor.
//! - `never`: stable equilibria, about which no bracket exists.

mod affine;
mod candidates;
mod casimirs;
mod constant;
mod equations;
mod error;
mod field;
mod identity;
mod integrals;
mod invariant;
mod low;
mod matrix;
mod modular;
mod never;
mod potential;
mod report;
mod search;
mod written;

pub use casimirs::{casimirs_of, corank, named_casimirs_of};
pub use equations::Equations;
pub use error::FindError;
pub use report::{FoundBracket, Kind, RefusedKind, Report};
pub use search::{Options, find};
