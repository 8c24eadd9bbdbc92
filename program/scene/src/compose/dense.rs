//! Which lattices are written out.

pub use crate::document::DENSE_LIMIT;

/// The most coordinates of a lattice that is written out where its formulas are no templates, or its stepper has no sweeps.
pub(super) const WRITTEN_LIMIT: usize = 1024;
