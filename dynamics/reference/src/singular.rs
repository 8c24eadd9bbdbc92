//! Small linear systems of any rank.

/// Pivots smaller than this part of the first are round-off.
const RANK: f64 = 1e-12;

/// A z = r where A may be singular: elimination with complete pivoting. What does not add to the rank
/// gets none of z, so that of parallel equations one counts.
pub(crate) struct SingularSystem {
    /// A, row-major n × n; destroyed by [`solve`](Self::solve).
    pub(crate) matrix: Vec<f64>,
    /// The unknown that stands in each column.
    unknowns: Vec<usize>,
    solution: Vec<f64>,
}

impl SingularSystem {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            matrix: vec![0.0; n * n],
            unknowns: vec![0; n],
            solution: vec![0.0; n],
        }
    }

    /// z in place of r; `false` where a number is not finite.
    pub(crate) fn solve(&mut self, right: &mut [f64]) -> bool {
        let n = right.len();
        let a = &mut self.matrix;
        if !a.iter().chain(&*right).all(|v| v.is_finite()) {
            return false;
        }
        for (at, unknown) in self.unknowns.iter_mut().enumerate() {
            *unknown = at;
        }
        let mut first = 0.0;
        let mut rank = 0;
        while rank < n {
            let k = rank;
            let rest = (k..n).flat_map(|i| (k..n).map(move |j| (i, j)));
            let larger = |best: (usize, usize), (i, j): (usize, usize)| {
                if a[i * n + j].abs() > a[best.0 * n + best.1].abs() {
                    (i, j)
                } else {
                    best
                }
            };
            let (row, column) = rest.fold((k, k), larger);
            let pivot = a[row * n + column].abs();
            first = if k == 0 { pivot } else { first };
            if pivot <= RANK * first {
                break;
            }
            (0..n).for_each(|j| a.swap(k * n + j, row * n + j));
            (0..n).for_each(|i| a.swap(i * n + k, i * n + column));
            right.swap(k, row);
            self.unknowns.swap(k, column);
            for i in k + 1..n {
                let factor = a[i * n + k] / a[k * n + k];
                for j in k + 1..n {
                    a[i * n + j] -= factor * a[k * n + j];
                }
                right[i] -= factor * right[k];
            }
            rank += 1;
        }
        self.solution.fill(0.0);
        for i in (0..rank).rev() {
            let known: f64 = (i + 1..rank).map(|j| a[i * n + j] * self.solution[j]).sum();
            self.solution[i] = (right[i] - known) / a[i * n + i];
        }
        for (value, unknown) in self.solution.iter().zip(&self.unknowns) {
            right[*unknown] = *value;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::SingularSystem;

    #[test]
    fn of_parallel_equations_one_counts() {
        let mut system = SingularSystem::new(3);
        // The second row and column are twice the first.
        system.matrix = vec![1.0, 2.0, 0.0, 2.0, 4.0, 0.0, 0.0, 0.0, 8.0];
        let mut z = [3.0, 6.0, 16.0];
        assert!(system.solve(&mut z));
        assert_eq!(z, [0.0, 1.5, 2.0]);
    }

    #[test]
    fn nothing_but_zeros_moves_nothing_and_no_number_is_refused() {
        let mut system = SingularSystem::new(2);
        let mut z = [1.0, 1.0];
        assert!(system.solve(&mut z));
        assert_eq!(z, [0.0, 0.0]);
        assert!(!system.solve(&mut [f64::NAN, 0.0]));
    }
}
