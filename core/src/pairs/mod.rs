//! Sums over pairs of sites: the code of one pair in a loop over all.
//!
//! H = F(S_1, …, S_m) with S_k = Σ_i s_k(x_i) + Σ_{i<j} p_k(x_i, x_j), x_i the coordinates of site i, and a tensor
//! whose entries couple coordinates of one site. Building takes a time that does not depend on the number N of sites, an
//! evaluation O(N²). Of a site are also its parameters, which rest.
//!
//! Coordinates stand family after family: coordinate f of site i at `[f·N + i]`. Several points stand side by side, each
//! coordinate in a row over the points. A point's results have the same bits however many there are.
//!
//! - [`function`]: functions of sums over sites and pairs, as formulas.
//! - `pair_code`: the code of one pair, and where its inputs and results stand.
//! - `tiles`: the loop over pairs.
//! - `site_code`: the code of one site, and the loop over sites.
//! - `values`: values and gradients of functions.
//! - `shears`: H = T + V in which each part moves what it does not depend on.
//! - [`system`]: Poisson systems of such functions.

pub mod function;
mod pair_code;
mod shears;
mod site_code;
pub mod system;
#[cfg(test)]
mod tests;
mod tiles;
mod values;

pub use function::{BodyFunction, BodySum};
pub use system::BodySystem;
pub use values::BodyObservables;

/// The numbers of families and of sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyShape {
    /// The number of coordinates of a site, parameters of sites among them.
    pub families: usize,
    /// N, the number of sites.
    pub sites: usize,
}

impl BodyShape {
    /// The number of coordinates of all sites.
    pub fn dimension(self) -> usize {
        self.families * self.sites
    }
}
