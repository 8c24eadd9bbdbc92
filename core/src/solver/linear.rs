//! Small dense linear solves in caller's memory.

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
    use super::solve_in_place;

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
