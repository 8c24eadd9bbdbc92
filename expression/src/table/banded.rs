//! Systems of linear equations with few diagonals.

/// Rows with `below` diagonals under the main one and `above` over it, factored in place.
///
/// Partial pivoting fills `below` further diagonals. Every operation has its place, so the bits of a solution are fixed.
pub(super) struct Banded {
    size: usize,
    below: usize,
    width: usize,
    /// Row i from column i − `below` on.
    rows: Vec<f64>,
    /// The row that was taken for column i.
    pivots: Vec<usize>,
    /// The factors by which row i was subtracted from the `below` rows after it.
    factors: Vec<f64>,
}

impl Banded {
    /// The matrix of these entries; those far from the diagonal must be 0.
    pub(super) fn new(
        size: usize,
        [below, above]: [usize; 2],
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Self {
        let width = 2 * below + above + 1;
        let mut rows = vec![0.0; size * width];
        for (row, column, value) in entries {
            rows[row * width + column + below - row] += value;
        }
        let mut matrix = Self {
            size,
            below,
            width,
            rows,
            pivots: Vec::with_capacity(size),
            factors: vec![0.0; size * below],
        };
        matrix.factor();
        matrix
    }

    fn at(&self, row: usize, column: usize) -> usize {
        row * self.width + column + self.below - row
    }

    /// The last column in which a row at or before `row` + `below` may hold an entry.
    fn last(&self, row: usize) -> usize {
        (row + self.width - self.below - 1).min(self.size - 1)
    }

    fn factor(&mut self) {
        for column in 0..self.size {
            let last = (column + self.below).min(self.size - 1);
            let size_of = |row: usize| self.rows[self.at(row, column)].abs();
            let pivot = (column..=last).fold(column, |best, row| {
                if size_of(row) > size_of(best) {
                    row
                } else {
                    best
                }
            });
            self.pivots.push(pivot);
            let end = self.last(column);
            if pivot != column {
                for at in column..=end {
                    let (a, b) = (self.at(column, at), self.at(pivot, at));
                    self.rows.swap(a, b);
                }
            }
            for row in column + 1..=last {
                let factor = self.rows[self.at(row, column)] / self.rows[self.at(column, column)];
                self.factors[column * self.below + row - column - 1] = factor;
                for at in column..=end {
                    let above = self.rows[self.at(column, at)];
                    let here = self.at(row, at);
                    self.rows[here] -= factor * above;
                }
            }
        }
    }

    /// Replaces the right-hand side by the solution.
    pub(super) fn solve(&self, x: &mut [f64]) {
        for column in 0..self.size {
            x.swap(column, self.pivots[column]);
            let last = (column + self.below).min(self.size - 1);
            for row in column + 1..=last {
                x[row] -= self.factors[column * self.below + row - column - 1] * x[column];
            }
        }
        for row in (0..self.size).rev() {
            let mut sum = x[row];
            for column in row + 1..=self.last(row) {
                sum -= self.rows[self.at(row, column)] * x[column];
            }
            x[row] = sum / self.rows[self.at(row, row)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Banded;

    /// A x for entries of hash-like values, whose leading ones call for exchanges of rows.
    #[test]
    fn solutions_solve() {
        for (size, below, above) in [(1_usize, 0, 0), (2, 1, 1), (7, 2, 3), (40, 3, 1), (9, 8, 8)] {
            let value = |i: usize, j: usize| {
                let mixed = (31 * i + 17 * j + i * j) % 23;
                if i == j {
                    1e-3
                } else {
                    mixed as f64 / 23.0 - 0.4
                }
            };
            let mut entries = Vec::new();
            for i in 0..size {
                for j in i.saturating_sub(below)..(i + above + 1).min(size) {
                    entries.push((i, j, value(i, j)));
                }
            }
            let solution: Vec<f64> = (0..size).map(|i| 1.0 + i as f64 / 3.0).collect();
            let mut x = vec![0.0; size];
            for &(i, j, value) in &entries {
                x[i] += value * solution[j];
            }
            Banded::new(size, [below, above], entries).solve(&mut x);
            for (found, expected) in x.iter().zip(&solution) {
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{size}: {found} {expected}"
                );
            }
        }
    }
}
