//! What the tests of exact realizations share.
//!
//! - [`lattice`]: a long lattice beside the same one written out.
//! - [`systems`]: Poisson systems of the library by id, or from a few formulas.
//! - [`realizations`]: the ends α, β and the identities of a dual pair.
//! - [`steps`]: the tensor and the Casimirs under one step; measured orders.

pub mod lattice;
pub mod realizations;
pub mod steps;
pub mod systems;

/// u, half a unit in the last place of 1.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// max |aᵢ − bᵢ|; NaN if any entry is.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "vectors of one length");
    largest(a.iter().zip(b).map(|(a, b)| a - b))
}

/// max |vᵢ|; NaN if any entry is.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values
        .into_iter()
        .fold(0.0, |m, v| if v.abs() <= m { m } else { v.abs() })
}
