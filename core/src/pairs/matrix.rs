//! Numbers for pairs of sites: matrices of couplings.

use std::sync::Arc;

/// A number for every two sites, J_ij in the row i.
#[derive(Clone, Debug, PartialEq)]
pub struct PairMatrix {
    numbers: Arc<[f64]>,
    sites: usize,
    is_symmetric: bool,
}

/// Which entry of a matrix the code of a pair reads: J_ii, J_ij, J_ji or J_jj.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PairEntry {
    /// Whether the row is that of site j.
    is_second: [bool; 2],
}

impl PairMatrix {
    /// The matrix of these numbers, row after row; `None` where they are not one for every two of so many sites.
    pub fn new(numbers: Arc<[f64]>, sites: usize) -> Option<Self> {
        if sites.checked_mul(sites) != Some(numbers.len()) {
            return None;
        }
        let mut pairs = (0..sites).flat_map(|i| (0..i).map(move |j| (i, j)));
        let is_symmetric = pairs.all(|(i, j)| numbers[i * sites + j] == numbers[j * sites + i]);
        Some(Self {
            numbers,
            sites,
            is_symmetric,
        })
    }

    /// All numbers, row after row.
    pub(super) fn numbers(&self) -> &Arc<[f64]> {
        &self.numbers
    }

    /// J_ij.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        self.numbers[i * self.sites + j]
    }
}

impl PairEntry {
    /// The number of entries of one matrix that a pair may read.
    pub(super) const COUNT: usize = 4;

    /// J_ii, J_ij, J_ji and J_jj are numbered from 0 on.
    pub(super) fn numbered(at: usize) -> Self {
        Self {
            is_second: [at & 2 != 0, at & 1 != 0],
        }
    }

    /// The number of the entry where i and j change places.
    pub(super) fn swapped(at: usize) -> usize {
        Self::COUNT - 1 - at
    }

    /// The number of the first entry that is equal to it: of a symmetric matrix J_ij is J_ji.
    pub(super) fn first_equal(at: usize, matrix: &PairMatrix) -> usize {
        match (at, matrix.is_symmetric) {
            (2, true) => 1,
            _ => at,
        }
    }

    /// The entry of the pair i, j.
    pub(super) fn of(self, matrix: &PairMatrix, pair: [usize; 2]) -> f64 {
        let [row, column] = self.is_second.map(|is_second| pair[usize::from(is_second)]);
        matrix.entry(row, column)
    }
}
