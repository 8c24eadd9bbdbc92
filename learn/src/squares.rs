//! Linear least squares by Householder's factorization with pivoted columns.

/// A matrix, column after column.
#[derive(Clone, Debug)]
pub(crate) struct ColumnMatrix {
    rows: usize,
    numbers: Vec<f64>,
}

impl ColumnMatrix {
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            numbers: vec![0.0; rows * columns],
        }
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    pub fn len(&self) -> usize {
        self.numbers.len().checked_div(self.rows).unwrap_or(0)
    }

    pub fn column(&self, j: usize) -> &[f64] {
        &self.numbers[j * self.rows..(j + 1) * self.rows]
    }

    pub fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.numbers[j * self.rows..(j + 1) * self.rows]
    }

    fn swap(&mut self, i: usize, j: usize) {
        if i != j {
            let (low, high) = (i.min(j), i.max(j));
            let (before, behind) = self.numbers.split_at_mut(high * self.rows);
            before[low * self.rows..(low + 1) * self.rows]
                .swap_with_slice(&mut behind[..self.rows]);
        }
    }

    /// A c.
    pub fn times(&self, c: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.rows];
        for (j, c) in c.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            for (sum, a) in sum.iter_mut().zip(self.column(j)) {
                *sum += c * a;
            }
        }
        sum
    }

    /// The rows for which `keeps` holds.
    pub fn filtered(&self, keeps: &[bool]) -> Self {
        let kept = |column: &[f64]| -> Vec<f64> {
            let rows = column.iter().zip(keeps);
            rows.filter(|(_, keeps)| **keeps).map(|(a, _)| *a).collect()
        };
        let numbers: Vec<f64> = (0..self.len()).flat_map(|j| kept(self.column(j))).collect();
        Self {
            rows: keeps.iter().filter(|keeps| **keeps).count(),
            numbers,
        }
    }
}

/// The solution of min ‖A c − b‖² + λ²‖N c‖² with N = diag ‖A_j‖. Where columns depend on others, c is the shortest.
#[derive(Clone, Debug)]
pub(crate) struct Squares {
    /// R of A N⁻¹ P = Q R: as many rows as columns.
    r: ColumnMatrix,
    /// ‖A_j‖, 1 for a column of zeros.
    norms: Vec<f64>,
    /// P: which column stands where.
    order: Vec<usize>,
    pub rank: usize,
    /// λ.
    ridge: f64,
    pub solution: Vec<f64>,
    /// Orthonormal vectors with A v = 0, one for each column that depends on others.
    pub null: Vec<Vec<f64>>,
}

impl Squares {
    /// Of A, b, λ and the part of the first pivot below which columns count as dependent.
    pub fn solve(a: &ColumnMatrix, b: &[f64], ridge: f64, tolerance: f64) -> Self {
        let (m, n) = (a.rows(), a.len());
        let extra = if ridge > 0.0 { n } else { 0 };
        let mut norms = Vec::with_capacity(n);
        let mut q = ColumnMatrix::zeros(m + extra, n);
        for j in 0..n {
            let norm = norm(a.column(j));
            let norm = if norm > 0.0 { norm } else { 1.0 };
            let column = q.column_mut(j);
            for (q, a) in column.iter_mut().zip(a.column(j)) {
                *q = a / norm;
            }
            if extra > 0 {
                column[m + j] = ridge;
            }
            norms.push(norm);
        }
        let mut right = b.to_vec();
        right.resize(m + extra, 0.0);
        let (order, rank) = factorize(&mut q, &mut right, tolerance);
        let mut r = ColumnMatrix::zeros(n, n);
        for j in 0..n {
            let rows = rank.min(n);
            r.column_mut(j)[..rows].copy_from_slice(&q.column(j)[..rows]);
        }
        let mut own = Self {
            r,
            norms,
            order,
            rank,
            ridge,
            solution: vec![0.0; n],
            null: Vec::with_capacity(n - rank),
        };
        let c = own.back_substituted(&right[..rank]);
        for (c, &j) in c.iter().zip(&own.order) {
            own.solution[j] = c / own.norms[j];
        }
        for at in rank..n {
            let weights = own.back_substituted(&own.r.column(at)[..rank]);
            let mut v = vec![0.0; n];
            for (w, &j) in weights.iter().zip(&own.order) {
                v[j] = -w / own.norms[j];
            }
            v[own.order[at]] = 1.0 / own.norms[own.order[at]];
            // Twice: what one pass leaves is round-off of what it takes.
            for _ in 0..2 {
                subtract(&mut v, &own.null);
            }
            let length = norm(&v);
            if length > 0.0 {
                v.iter_mut().for_each(|v| *v /= length);
                own.null.push(v);
            }
        }
        own.solution = own.least(&own.solution);
        own
    }

    /// P c, the shortest coefficients of the same A c. P is symmetric: of a row v of coefficients P v has v·P c = P v·c.
    pub fn least(&self, c: &[f64]) -> Vec<f64> {
        let mut c = c.to_vec();
        subtract(&mut c, &self.null);
        c
    }

    /// R⁻¹ v over the determined columns.
    fn back_substituted(&self, v: &[f64]) -> Vec<f64> {
        let mut v = v.to_vec();
        for k in (0..v.len()).rev() {
            let column = self.r.column(k);
            v[k] /= column[k];
            let pivot = v[k];
            for (v, r) in v[..k].iter_mut().zip(column) {
                *v -= pivot * r;
            }
        }
        v
    }

    /// The columns whose coefficients are determined.
    pub fn kept(&self) -> &[usize] {
        &self.order[..self.rank]
    }

    /// How far the ridge pulls the solution, to second order in its part of AᵀA: b = M(c + M c) with M = λ² (AᵀA + λ²N²)⁻¹ N².
    pub fn ridge_bias(&self) -> Vec<f64> {
        let mut bias = vec![0.0; self.norms.len()];
        if self.ridge == 0.0 {
            return bias;
        }
        let scaled = |c: &[f64]| -> Vec<f64> {
            let kept = self.kept().iter();
            kept.map(|&j| c[j] * self.norms[j]).collect()
        };
        for _ in 0..2 {
            let sum: Vec<f64> = (self.solution.iter().zip(&bias))
                .map(|(c, b)| c + b)
                .collect();
            let below = self.forward_substituted(scaled(&sum));
            let pulled = self.back_substituted(&below);
            for (pulled, &j) in pulled.iter().zip(&self.order) {
                bias[j] = self.ridge * self.ridge * pulled / self.norms[j];
            }
        }
        self.least(&bias)
    }

    /// vᵀ (AᵀA)⁻¹ v over the determined columns, of a row v of all columns: the variance of v·c at unit noise.
    pub fn variance(&self, row: &[f64]) -> f64 {
        let kept = self.kept().iter();
        let v = self.forward_substituted(kept.map(|&j| row[j] / self.norms[j]).collect());
        v.iter().map(|v| v * v).sum()
    }

    /// R⁻ᵀ v over the determined columns.
    fn forward_substituted(&self, mut v: Vec<f64>) -> Vec<f64> {
        for k in 0..self.rank {
            let column = self.r.column(k);
            let below: f64 = v[..k].iter().zip(column).map(|(v, r)| v * r).sum();
            v[k] = (v[k] - below) / column[k];
        }
        v
    }

    /// Standard errors of the solution's coefficients at unit noise.
    pub fn deviations(&self) -> Vec<f64> {
        let n = self.norms.len();
        let mut squares = vec![0.0; n];
        for k in 0..self.rank {
            let mut unit = vec![0.0; self.rank];
            unit[k] = 1.0;
            let mut v = vec![0.0; n];
            for (c, &j) in self.back_substituted(&unit).iter().zip(&self.order) {
                v[j] = c / self.norms[j];
            }
            let least = self.least(&v);
            squares
                .iter_mut()
                .zip(least)
                .for_each(|(sum, v)| *sum += v * v);
        }
        squares.into_iter().map(libm::sqrt).collect()
    }

    /// How far the row is from depending on the determined columns as the rows of A do, relative to its largest entry.
    pub fn strangeness(&self, row: &[f64]) -> f64 {
        let entries = || row.iter().zip(&self.norms).map(|(a, norm)| a / norm);
        let largest = entries().fold(0.0_f64, |most, a| most.max(a.abs()));
        if largest == 0.0 {
            return 0.0;
        }
        let strange = self.null.iter().map(|v| {
            let along: f64 = v.iter().zip(row).map(|(v, a)| v * a).sum();
            let size = v
                .iter()
                .zip(&self.norms)
                .fold(1.0_f64, |most, (v, norm)| most.max((v * norm).abs()));
            (along / size).abs()
        });
        strange.fold(0.0, f64::max) / largest
    }
}

/// Householder's reflections on A and b, the column of the largest rest first; P and the rank.
fn factorize(q: &mut ColumnMatrix, right: &mut [f64], tolerance: f64) -> (Vec<usize>, usize) {
    let (m, n) = (q.rows(), q.len());
    let mut order: Vec<usize> = (0..n).collect();
    let least = tolerance.max(f64::EPSILON * m.max(n) as f64);
    let mut first = 0.0;
    for k in 0..n.min(m) {
        let rests = (k..n).map(|j| norm(&q.column(j)[k..]));
        let largest =
            rests.enumerate().fold(
                (0, 0.0),
                |best, (at, rest)| {
                    if rest > best.1 { (at, rest) } else { best }
                },
            );
        let (at, length) = (k + largest.0, largest.1);
        if k == 0 {
            first = length;
        }
        if length <= least * first {
            return (order, k);
        }
        q.swap(k, at);
        order.swap(k, at);
        let mut mirror = q.column(k)[k..].to_vec();
        let pivot = if mirror[0] > 0.0 { -length } else { length };
        mirror[0] -= pivot;
        let square: f64 = mirror.iter().map(|v| v * v).sum();
        let reflect = |column: &mut [f64]| {
            let along: f64 = mirror.iter().zip(&*column).map(|(v, a)| v * a).sum();
            let factor = 2.0 * along / square;
            for (a, v) in column.iter_mut().zip(&mirror) {
                *a -= factor * v;
            }
        };
        for j in k + 1..n {
            reflect(&mut q.column_mut(j)[k..]);
        }
        reflect(&mut right[k..]);
        let column = &mut q.column_mut(k)[k..];
        column.fill(0.0);
        column[0] = pivot;
    }
    (order, n.min(m))
}

/// v less its parts along orthonormal vectors.
fn subtract(v: &mut [f64], directions: &[Vec<f64>]) {
    for direction in directions {
        let along: f64 = direction.iter().zip(&*v).map(|(a, b)| a * b).sum();
        v.iter_mut()
            .zip(direction)
            .for_each(|(v, a)| *v -= along * a);
    }
}

/// ‖v‖ without overflow.
fn norm(v: &[f64]) -> f64 {
    let largest = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    let squares: f64 = v.iter().map(|v| (v / largest) * (v / largest)).sum();
    largest * libm::sqrt(squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns 1, t, t² and the sum of the first two at seven nodes.
    fn dependent() -> ColumnMatrix {
        let mut a = ColumnMatrix::zeros(7, 4);
        for t in 0..7 {
            let x = t as f64;
            for (j, value) in [1.0, x, x * x, 1.0 + x].into_iter().enumerate() {
                a.column_mut(j)[t] = value;
            }
        }
        a
    }

    /// b = 3 + 2t − t² is met, with one of three dependent columns left out; rows of the same kind are not strange, others are.
    #[test]
    fn dependent_columns_are_left_out() {
        let b: Vec<f64> = (0..7)
            .map(|t| 3.0 + 2.0 * f64::from(t) - f64::from(t * t))
            .collect();
        let a = dependent();
        let squares = Squares::solve(&a, &b, 0.0, 0.0);
        assert_eq!(squares.rank, 3);
        let found = a.times(&squares.solution);
        // Condition number of three scaled columns at seven nodes below 100.
        assert!(
            found.iter().zip(&b).all(|(f, b)| (f - b).abs() < 1e-12),
            "{found:?}"
        );
        // The shortest c has 1 and t in equal parts with their sum: (3, 2, −1, 0) + s (1, 1, 0, −1), s = −5/3.
        let shortest = [4.0 / 3.0, 1.0 / 3.0, -1.0, 5.0 / 3.0];
        let parts = squares.solution.iter().zip(shortest);
        assert!(parts.map(|(c, s)| (c - s).abs()).fold(0.0, f64::max) < 1e-12);
        assert!(squares.strangeness(&[1.0, 9.0, 81.0, 10.0]) < 1e-12);
        assert!(squares.strangeness(&[1.0, 9.0, 81.0, 0.0]) > 1e-3);
    }

    /// The mean of N numbers has the variance 1/N; a line through t = −1, 0, 1 has 1/3 at its middle and 1/3 + t²/2 at t.
    #[test]
    fn variances_are_those_of_textbooks() {
        let mut a = ColumnMatrix::zeros(3, 2);
        for t in 0..3 {
            a.column_mut(0)[t] = 1.0;
            a.column_mut(1)[t] = t as f64 - 1.0;
        }
        let squares = Squares::solve(&a, &[1.0, 2.0, 4.0], 0.0, 0.0);
        for t in [0.0, 1.0, 4.0] {
            let expected = 1.0 / 3.0 + t * t / 2.0;
            assert!((squares.variance(&[1.0, t]) - expected).abs() < 1e-14 * expected.max(1.0));
        }
        let [mean, slope] = squares.deviations()[..] else {
            panic!("two columns");
        };
        assert!((mean * mean - 1.0 / 3.0).abs() < 1e-15 && (slope * slope - 0.5).abs() < 1e-15);
        // Slope 3/2; a ridge λ on unit columns shrinks it by 1/(1 + λ²).
        assert!((squares.solution[1] - 1.5).abs() < 1e-14);
        let ridge = Squares::solve(&a, &[1.0, 2.0, 4.0], 0.5, 0.0);
        assert!((ridge.solution[1] - 1.5 / 1.25).abs() < 1e-14);
    }
}
