//! Which lattices are written out.

/// The largest dimension of a lattice that is written out site by site; longer ones are templates.
pub const DENSE_LIMIT: usize = 24;
