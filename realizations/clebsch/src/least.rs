//! Least changes that do what is asked: δ = Aᵀ(A Aᵀ)⁻¹ r.

/// Pivots below this part of their diagonal are those of rows that depend on others.
const DEPENDENT: f64 = 1e-12;

/// A matrix G = L D Lᵀ, positive semidefinite, the first rows and columns of it.
pub struct Gram<const D: usize> {
    /// G below and on the diagonal, L and D after [`factor`](Self::factor).
    pub entries: [[f64; D]; D],
    count: usize,
}

impl<const D: usize> Gram<D> {
    /// So many rows of 0.
    pub fn new(count: usize) -> Self {
        Self {
            entries: [[0.0; D]; D],
            count,
        }
    }

    /// Factors it; how many rows depend on others.
    pub fn factor(&mut self) -> usize {
        let mut dependent = 0;
        let gram = &mut self.entries;
        for j in 0..self.count {
            let diagonal = gram[j][j];
            let mut pivot = diagonal;
            for k in 0..j {
                pivot -= gram[j][k] * gram[j][k] * gram[k][k];
            }
            if pivot.is_nan() || pivot <= DEPENDENT * diagonal || pivot < f64::MIN_POSITIVE {
                pivot = 0.0;
                dependent += 1;
            }
            gram[j][j] = pivot;
            for i in j + 1..self.count {
                let mut entry = gram[i][j];
                for k in 0..j {
                    entry -= gram[i][k] * gram[j][k] * gram[k][k];
                }
                gram[i][j] = if pivot > 0.0 { entry / pivot } else { 0.0 };
            }
        }
        dependent
    }

    /// r ← G⁻¹ r, once it is factored; 0 for rows that depend on others.
    pub fn solve(&self, r: &mut [f64]) {
        let gram = &self.entries;
        for i in 0..self.count {
            for k in 0..i {
                r[i] -= gram[i][k] * r[k];
            }
        }
        for (i, r) in r.iter_mut().enumerate().take(self.count) {
            let pivot = gram[i][i];
            *r = if pivot > 0.0 { *r / pivot } else { 0.0 };
        }
        for i in (0..self.count).rev() {
            for k in i + 1..self.count {
                r[i] -= gram[k][i] * r[k];
            }
        }
    }
}

/// Rows of A, and A Aᵀ.
pub struct Rows<const D: usize, const N: usize> {
    /// A, the first rows and columns of it.
    pub rows: [[f64; N]; D],
    gram: Gram<D>,
    width: usize,
}

impl<const D: usize, const N: usize> Rows<D, N> {
    /// So many rows of 0.
    pub fn new(count: usize, width: usize) -> Self {
        Self {
            rows: [[0.0; N]; D],
            gram: Gram::new(count),
            width,
        }
    }

    /// Factors A Aᵀ; how many rows depend on others.
    pub fn factor(&mut self) -> usize {
        for i in 0..self.gram.count {
            for j in 0..=i {
                let (first, second) = (&self.rows[i][..self.width], &self.rows[j][..self.width]);
                self.gram.entries[i][j] = first.iter().zip(second).map(|(a, b)| a * b).sum();
            }
        }
        self.gram.factor()
    }

    /// r ← (A Aᵀ)⁻¹ r.
    pub fn solve(&self, r: &mut [f64]) {
        self.gram.solve(r);
    }

    /// z ← z + Aᵀ r.
    pub fn add_combination(&self, r: &[f64], z: &mut [f64]) {
        for (row, r) in self.rows.iter().zip(r).take(self.gram.count) {
            for (z, slope) in z.iter_mut().zip(row) {
                *z += r * slope;
            }
        }
    }
}
