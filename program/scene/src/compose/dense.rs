//! Which lattices are written out.

/// The largest dimension of a lattice that is written out site by site; longer ones are templates.
pub const DENSE_LIMIT: usize = 24;

/// The most coordinates of a lattice that is written out where its formulas are no templates, or its stepper has no sweeps.
pub(super) const WRITTEN_LIMIT: usize = 1024;
