//! Truncated power series of formulas, one order at a time.

mod jet;
mod lookups;
mod polynomial;
mod tape;

pub use jet::{along_curve, jet};
pub use polynomial::{Univariate, UnivariateElement};
pub use tape::{Tape, TapeIndex, TaylorState};
