//! Small dense linear solves in caller's memory.

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

/// Solves A z = r in place by elimination with partial pivoting: `matrix` is A (row-major d × d,
/// destroyed), `right` is r and becomes z. Returns `false` when a pivot is zero or not finite.
pub(super) fn solve_in_place(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let d = right.len();
    for column in 0..d {
        let mut pivot = column;
        for row in column + 1..d {
            if matrix[row * d + column].abs() > matrix[pivot * d + column].abs() {
                pivot = row;
            }
        }
        let value = matrix[pivot * d + column];
        if value == 0.0 || !value.is_finite() {
            return false;
        }
        if pivot != column {
            for k in column..d {
                matrix.swap(pivot * d + k, column * d + k);
            }
            right.swap(pivot, column);
        }
        let inverse = 1.0 / value;
        for row in column + 1..d {
            let factor = matrix[row * d + column] * inverse;
            if factor != 0.0 {
                for k in column + 1..d {
                    matrix[row * d + k] -= factor * matrix[column * d + k];
                }
                right[row] -= factor * right[column];
            }
        }
    }
    for row in (0..d).rev() {
        let mut sum = right[row];
        for k in row + 1..d {
            sum -= matrix[row * d + k] * right[k];
        }
        right[row] = sum / matrix[row * d + row];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::{elimination_operations, solve_in_place, substitution_operations};

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

    #[test]
    fn solves_with_a_zero_leading_entry() {
        let mut a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0];
        let mut r = [7.0, 3.0, 6.0];
        assert!(solve_in_place(&mut a, &mut r));
        // The residual of elimination with pivoting: a few roundings of entries up to 7.
        for (found, expected) in r.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() <= 8.0 * f64::EPSILON, "{r:?}");
        }
    }

    #[test]
    fn refuses_a_singular_matrix() {
        assert!(!solve_in_place(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0]));
    }
}
