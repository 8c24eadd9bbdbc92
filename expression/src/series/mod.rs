//! Truncated power series of formulas, one order at a time.

mod polynomial;
mod tape;

pub use polynomial::{Univariate, UnivariateElement};
pub use tape::{Tape, TapeIndex, TaylorState};
