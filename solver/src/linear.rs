//! Dense linear solves for one right-hand side at a time, and what they cost.

use super::elimination::{ANY, Factors};
use super::judge::{reach, settled};
use crate::error::BuildError;

/// The most equations that a step solves together: matrices of 128 megabytes each, and 5·10¹⁰ operations an
/// elimination, half a minute.
pub const MOST_EQUATIONS: usize = 4096;

/// The number of equations from which on a step is first solved without a matrix. An elimination takes n³ operations there,
/// and an iteration of a sparse field about n: it is the shorter way wherever it converges.
pub const MANY_EQUATIONS: usize = 96;

/// Largest number of variables by which the functions of a step are differentiated. While code is formed, each of the
/// entries of a Jacobian that are not zero takes up to a kilobyte.
pub const MOST_VARIABLES: usize = 2048;

/// Refuses more than [`MOST_EQUATIONS`].
///
/// # Errors
/// [`BuildError::TooManyEquations`].
pub fn check_equations(equations: usize) -> Result<(), BuildError> {
    if equations <= MOST_EQUATIONS {
        return Ok(());
    }
    Err(BuildError::TooManyEquations {
        equations,
        most: MOST_EQUATIONS,
    })
}

/// Refuses a Jacobian of more than [`MOST_VARIABLES`], before its code is formed.
///
/// # Errors
/// [`BuildError::TooManyVariables`].
pub fn check_variables(variables: usize) -> Result<(), BuildError> {
    if variables <= MOST_VARIABLES {
        return Ok(());
    }
    Err(BuildError::TooManyVariables {
        variables,
        most: MOST_VARIABLES,
    })
}

/// Operations of an LU elimination of an n × n matrix.
pub fn elimination_operations(n: usize) -> u64 {
    let n = n as u64;
    // Σ_{m<n} (1 + m + 2m²): the inverse of a pivot, m factors, m rows of m entries.
    n + n * n.saturating_sub(1) / 2 + n * n.saturating_sub(1) * (2 * n).saturating_sub(1) / 3
}

/// Operations of a forward and backward substitution with its factors, for one right-hand side.
pub fn substitution_operations(n: usize) -> u64 {
    let n = n as u64;
    n * (2 * n).saturating_sub(1)
}

/// P A = L U of a dense matrix, in memory of its own: neither factoring nor solving allocates. Rows stay where they
/// stand as long as every pivot lies between 1/2 and 2; elsewhere they are chosen by partial pivoting.
#[derive(Clone, Debug)]
pub struct DenseFactors {
    factors: Factors<1>,
    /// Part of the round-off put into each unknown that A⁻¹ leaves; room for N s.
    left: Vec<f64>,
    first_hand: Vec<f64>,
}

impl DenseFactors {
    /// Room for n × n matrices.
    pub fn new(n: usize) -> Self {
        Self {
            factors: Factors::new(n),
            left: vec![1.0; n],
            first_hand: vec![0.0; n],
        }
    }

    /// Factors `matrix`, row-major; `false` where it is singular or not finite.
    ///
    /// # Panics
    /// When `matrix` is not n × n.
    pub fn factor(&mut self, matrix: &[f64]) -> bool {
        self.factor_of_sizes(matrix, &[])
    }

    /// The same for unknowns of these sizes: pivots are then chosen as independently of the unknowns' units.
    ///
    /// # Panics
    /// When `matrix` is not n × n.
    pub fn factor_of_sizes(&mut self, matrix: &[f64], sizes: &[f64]) -> bool {
        let (rows, own) = (matrix.as_chunks().0, sizes.as_chunks().0);
        let [singular] = self.factors.factor::<ANY>(rows, own, &[true]);
        self.take_left(matrix, sizes);
        !singular
    }

    fn take_left(&mut self, matrix: &[f64], sizes: &[f64]) {
        if sizes.is_empty() || self.is_near_identity() {
            self.left.fill(1.0);
            return;
        }
        let n = sizes.len();
        let put_in = |row: &[f64], i: usize, sizes: &[f64]| {
            reach(row, sizes) - (row[i] * sizes[i]).abs() + ((row[i] - 1.0) * sizes[i]).abs()
        };
        let rows = || matrix.chunks_exact(n).enumerate();
        for (first, (i, row)) in self.first_hand.iter_mut().zip(rows()) {
            *first = put_in(row, i, sizes);
        }
        for (left, (i, row)) in self.left.iter_mut().zip(rows()) {
            let first = self.first_hand[i];
            let kept = settled(first, put_in(row, i, &self.first_hand));
            *left = if first > 0.0 { kept / first } else { 1.0 };
        }
    }

    /// Part of the round-off put into an unknown at first hand that A⁻¹ leaves: 1 near the identity. That round-off
    /// is N s with N = |A − 1| and the sizes s of the last [`factor_of_sizes`](Self::factor_of_sizes).
    pub fn left(&self, unknown: usize) -> f64 {
        self.left[unknown]
    }

    /// Whether every pivot lies between 1/2 and 2, rows as they stand, in any units.
    pub fn is_near_identity(&self) -> bool {
        self.factors.is_near_identity(0)
    }

    /// Whether the determinant of the matrix is positive.
    pub fn has_positive_determinant(&self) -> bool {
        self.factors.has_positive_determinant(0)
    }

    /// A⁻¹ r in place of r.
    ///
    /// # Panics
    /// When `right` has not n components.
    pub fn solve(&self, right: &mut [f64]) {
        self.factors.solve_columns(right, 1);
    }

    /// A⁻¹ R in place of R, n × `columns`, row-major: in each column the bits of [`solve`](Self::solve).
    ///
    /// # Panics
    /// When `right` has not n rows.
    pub fn solve_columns(&self, right: &mut [f64], columns: usize) {
        self.factors.solve_columns(right, columns);
    }
}

#[cfg(test)]
mod tests {
    use super::{elimination_operations, substitution_operations};

    #[test]
    fn operations_are_those_of_the_loops() {
        for n in 0..9_u64 {
            let (mut elimination, mut substitution) = (0, 0);
            for m in 0..n {
                elimination += 1 + m + 2 * m * m;
                substitution += 2 * m + (2 * m + 1);
            }
            assert_eq!(elimination_operations(n as usize), elimination);
            assert_eq!(substitution_operations(n as usize), substitution);
        }
    }
}
