//! Matrices of couplings: a number for every two sites of a chain.

use std::sync::Arc;

/// A number for every two sites.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    pub(super) order: usize,
    /// Row after row.
    pub(super) numbers: Arc<[f64]>,
}

impl Matrix {
    pub(super) fn at(&self, [row, column]: [usize; 2]) -> Option<f64> {
        self.numbers.get(row * self.order + column).copied()
    }
}

/// The number of an entry among those of two sites, and of several matrices: J_00, J_01, J_10, J_11, then those of the next.
pub(super) fn entry_of_two(matrix: usize, [row, column]: [usize; 2]) -> usize {
    4 * matrix + 2 * row.min(1) + column.min(1)
}
