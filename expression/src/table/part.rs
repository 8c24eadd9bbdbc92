//! Functions of one number of which tables are evaluated.

use super::axis::MOST_AXES;

/// Functions of one number of which code evaluates a table.
///
/// A value is Σ_j c[q + o_j] Π_l b_{j_l}(u_l). Here u_l is the fraction of x_l, q the sum of the places of all x_l, and
/// each offset o_j a constant.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    /// The place of x in its cell, from 0 to 1.
    Fraction(usize),
    /// The number of the first coefficient that the cell of x sees along an axis.
    Place(usize),
    /// The coefficient so far behind the one of number q.
    Coefficient(usize),
}

impl Part {
    /// A number for each.
    pub(crate) fn code(self) -> u32 {
        match self {
            Self::Fraction(axis) => axis as u32,
            Self::Place(axis) => (MOST_AXES + axis) as u32,
            Self::Coefficient(offset) => (2 * MOST_AXES + offset) as u32,
        }
    }

    pub(super) fn of_code(code: u32) -> Self {
        let code = code as usize;
        match code.checked_sub(2 * MOST_AXES) {
            Some(offset) => Self::Coefficient(offset),
            None if code < MOST_AXES => Self::Fraction(code),
            None => Self::Place(code - MOST_AXES),
        }
    }
}
