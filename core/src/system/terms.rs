//! H as a sum of terms of one site and of two sites.

use std::sync::Arc;

use super::SystemFormulas;

/// H = Σ_i s(x_i) + Σ_{i<j} p(x_i, x_j) as the systems of one site with H = s and of two with H = p.
///
/// Coordinates of both systems are those of site i, those of site j, then of each matrix J_ii, J_ij, J_ji and J_jj. Entries
/// rest. So does the second site under s.
#[derive(Clone, Debug)]
pub struct BodyTerms {
    /// The number of coordinates of a site.
    pub families: usize,
    /// N, the number of sites.
    pub sites: usize,
    /// Numbers for pairs of sites, row after row.
    pub matrices: Vec<Arc<[f64]>>,
    /// H = s, where there is such a term.
    pub site: Option<SystemFormulas>,
    /// H = p, where there is such a term.
    pub pair: Option<SystemFormulas>,
}

impl BodyTerms {
    /// The number of coordinates of all sites.
    pub fn dimension(&self) -> usize {
        self.families * self.sites
    }

    /// The number of coordinates of either system.
    pub fn variables(&self) -> usize {
        2 * self.families + 4 * self.matrices.len()
    }

    /// Where the coordinates of the sites i and j stand, one after the other.
    pub fn places(&self, [i, j]: [usize; 2]) -> impl Iterator<Item = BodyPlace> {
        let (families, sites) = (self.families, self.sites);
        let coordinates = [i, j].into_iter();
        let coordinates = coordinates.flat_map(move |site| {
            (0..families).map(move |family| BodyPlace::Coordinate(family * sites + site))
        });
        let entries = self.matrices.iter().flat_map(move |matrix| {
            let entries = [[i, i], [i, j], [j, i], [j, j]];
            entries.map(|[row, column]| BodyPlace::Entry(matrix[row * sites + column]))
        });
        coordinates.chain(entries)
    }
}

/// Where a coordinate of one or two sites stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyPlace {
    /// In the state of all sites, family after family.
    Coordinate(usize),
    /// A number of a matrix.
    Entry(f64),
}
