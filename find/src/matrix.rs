//! Square matrices of rationals.

use leafwise_expression::Rational;

pub(crate) type Matrix = Vec<Vec<Rational>>;

pub(crate) fn zeros(rows: usize, columns: usize) -> Matrix {
    vec![vec![Rational::zero(); columns]; rows]
}

/// A⁻¹ by Gauss and Jordan, `None` of a singular matrix.
pub(crate) fn inverse(a: &Matrix) -> Option<Matrix> {
    let n = a.len();
    let mut rows: Matrix = a.clone();
    for (i, row) in rows.iter_mut().enumerate() {
        row.extend((0..n).map(|j| Rational::from_integer(i64::from(i == j))));
    }
    for column in 0..n {
        let pivot = (column..n).find(|&row| !rows[row][column].is_zero())?;
        rows.swap(column, pivot);
        let unit = rows[column][column].recip();
        for entry in &mut rows[column] {
            *entry = &*entry * &unit;
        }
        let lead = rows[column].clone();
        for (row, entries) in rows.iter_mut().enumerate() {
            let factor = entries[column].clone();
            if row == column || factor.is_zero() {
                continue;
            }
            for (entry, above) in entries.iter_mut().zip(&lead) {
                *entry -= &(&factor * above);
            }
        }
    }
    Some(rows.into_iter().map(|row| row[n..].to_vec()).collect())
}

/// A B.
pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = b.first().map_or(0, Vec::len);
    let entry = |row: &Vec<Rational>, j: usize| {
        (row.iter().zip(b)).fold(Rational::zero(), |sum, (left, right)| {
            sum + left * &right[j]
        })
    };
    (a.iter())
        .map(|row| (0..columns).map(|j| entry(row, j)).collect())
        .collect()
}

/// Aᵀ.
pub(crate) fn transposed(a: &Matrix) -> Matrix {
    let columns = a.first().map_or(0, Vec::len);
    (0..columns)
        .map(|j| a.iter().map(|row| row[j].clone()).collect())
        .collect()
}
