//! Sums over pairs of sites: the code of one pair in a loop over all.
//!
//! H = F(S_1, …, S_m) with S_k = Σ_i s_k(x_i) + Σ_{i<j} p_k(x_i, x_j), x_i the coordinates of site i, and a tensor
//! whose entries couple coordinates of one site. Building takes a time that does not depend on the number N of sites, an
//! evaluation O(N²). Of a site are also its parameters, which rest, and of a pair the entries of matrices of couplings.
//!
//! Coordinates stand family after family: coordinate f of site i at `[f·N + i]`. Several points stand side by side, each
//! coordinate in a row over the points. A point's results have the same bits however many there are.
//!
//! - [`function`]: functions of sums over sites and pairs, as formulas.
//! - [`matrix`]: numbers for pairs of sites.
//! - `pair_code`: the code of one pair, and where its inputs and results stand.
//! - `tiles`: the loop over pairs.
//! - `site_code`: the code of one site, and the loop over sites.
//! - `values`: values and gradients of functions.
//! - `bracket`: the tensor of one site, applied to a covector.
//! - `curve`: Taylor coefficients of the code of sites and pairs; `series`: those of a motion.
//! - `poles`: denominators that no step takes through 0.
//! - `rounding`: bounds on the rounding errors of a field.
//! - `tangent`: products with the Jacobian of a field.
//! - `shears`: H = T + V in which each part moves what it does not depend on.
//! - `terms`: H as a sum of terms of one site and of two sites.
//! - [`system`]: Poisson systems of such functions.

mod bracket;
mod curve;
pub mod function;
pub mod matrix;
mod pair_code;
mod poles;
mod rounding;
mod series;
mod shears;
mod site_code;
pub mod system;
mod tangent;
mod terms;
#[cfg(test)]
mod tests;
mod tiles;
mod values;

pub use function::{BodyFunction, BodySum};
pub use matrix::PairMatrix;
pub use system::BodySystem;
pub use values::BodyObservables;

use matrix::PairEntry;

/// The numbers of families and of sites, and what pairs have of their own.
///
/// Formulas of a pair have as variables the coordinates of site i, then those of site j, then of each matrix J_ii, J_ij,
/// J_ji and J_jj. Those of a site have the same, of which only coordinates of site i and entries J_ii mean something.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyShape {
    /// The number of coordinates of a site, parameters of sites among them.
    pub families: usize,
    /// N, the number of sites.
    pub sites: usize,
    /// Numbers for pairs of sites.
    pub matrices: Vec<PairMatrix>,
}

impl BodyShape {
    /// The number of coordinates of all sites.
    pub fn dimension(&self) -> usize {
        self.families * self.sites
    }

    /// The number of variables of a pair's formula.
    pub fn variables(&self) -> usize {
        2 * self.families + PairEntry::COUNT * self.matrices.len()
    }

    /// The variable that each of a pair's formula becomes where so many families stand behind those of a site.
    fn places_beside(&self, further: usize) -> Vec<usize> {
        let place = |variable: usize| variable + further * (variable / self.families).min(2);
        (0..self.variables()).map(place).collect()
    }

    /// The matrix that a variable of a pair's formula is an entry of, and the entry's number; `None` for a coordinate.
    fn entry_of(&self, variable: usize) -> Option<(usize, usize)> {
        let at = variable.checked_sub(2 * self.families)?;
        Some((at / PairEntry::COUNT, at % PairEntry::COUNT))
    }

    /// The variable of an entry of a matrix.
    fn variable_of(&self, matrix: usize, entry: usize) -> usize {
        2 * self.families + PairEntry::COUNT * matrix + entry
    }

    /// The variable of a pair with i and j in each other's place.
    fn swapped(&self, variable: usize) -> usize {
        match self.entry_of(variable) {
            None => (variable + self.families) % (2 * self.families),
            Some((matrix, entry)) => self.variable_of(matrix, PairEntry::swapped(entry)),
        }
    }

    /// The first variable of a pair that has the same value: entries of a symmetric matrix are equal.
    fn first_equal(&self, variable: usize) -> usize {
        match self.entry_of(variable) {
            Some((matrix, entry)) if matrix < self.matrices.len() => {
                let first = PairEntry::first_equal(entry, &self.matrices[matrix]);
                self.variable_of(matrix, first)
            }
            _ => variable,
        }
    }
}
