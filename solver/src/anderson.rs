//! Acceleration of an iteration that knows only residuals.

use super::judge::{WANDERING, larger};

/// How many earlier iterates are combined.
const DEPTH: usize = 5;

/// Differences below this part of the largest component are round-off.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// A direction that keeps less than this part of itself beside the newer ones is left out: what is
/// left of it is round-off.
const DEPENDENT: f64 = 1e-7;

/// Anderson's acceleration of u ← u + r(u), for residuals without derivatives.
///
/// Of the last iterates' differences Δu, Δr it takes those γ that make r − ΔR γ smallest, component by component
/// relative to the scale of u. The correction of u is r − (ΔU + ΔR) γ (D. G. Anderson, *Iterative procedures for
/// nonlinear integral equations*, J. ACM 12 (1965); H. Walker, P. Ni, *Anderson acceleration for fixed-point
/// iterations*, SIAM J. Numer. Anal. 49 (2011)). It is a secant method in as many directions as there are iterates:
/// for a linear residual in n unknowns, n ≤ 5, the n-th accelerated correction is the last.
#[derive(Clone, Debug)]
pub struct Anderson {
    size: usize,
    /// Δu and Δr, the newest column first, and an orthonormal basis of the Δr.
    steps: Vec<f64>,
    changes: Vec<f64>,
    basis: Vec<f64>,
    /// The basis' coordinates of the Δr, upper triangular, and those of r.
    triangle: [f64; DEPTH * DEPTH],
    coordinates: [f64; DEPTH],
    columns: usize,
    /// r and the correction of the iterate before.
    residual: Vec<f64>,
    correction: Vec<f64>,
    is_started: bool,
    /// The largest |Δ(u + r)|/|Δu| of this solve, and that of iterates whose differences are no round-off as a whole.
    rate: f64,
    rate_of_whole: f64,
    operations: u64,
}

impl Anderson {
    /// For residuals of this many components; cold.
    pub fn new(size: usize) -> Self {
        Self {
            size,
            steps: vec![0.0; DEPTH * size],
            changes: vec![0.0; DEPTH * size],
            basis: vec![0.0; DEPTH * size],
            triangle: [0.0; DEPTH * DEPTH],
            coordinates: [0.0; DEPTH],
            columns: 0,
            residual: vec![0.0; size],
            correction: vec![0.0; size],
            is_started: false,
            rate: 0.0,
            rate_of_whole: 0.0,
            operations: 0,
        }
    }

    /// The same for residuals of another size; cold.
    pub fn resize(&mut self, size: usize) {
        let operations = self.operations;
        *self = Self {
            operations,
            ..Self::new(size)
        };
    }

    /// Operations so far, as [`SolverStatistics::operations`] counts them.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    pub fn operations(&self) -> u64 {
        self.operations
    }

    /// Forgets every iterate: the next solve begins.
    pub fn clear(&mut self) {
        self.columns = 0;
        self.is_started = false;
        (self.rate, self.rate_of_whole) = (0.0, 0.0);
    }

    /// Largest |Δ(u + r)|/|Δu| of two iterates in a row of this solve: the rate of the iteration without
    /// acceleration. Sizes are taken in the largest component or in the largest relative one, whichever gives the
    /// smaller ratio. Iterates closer than 1e-6 of the scale tell of round-off and are left out.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// The same of iterates further apart than round-off of the largest component. Coordinates near 0 that are sums of others are
    /// round-off themselves, and change by parts of their own as long as one iterates.
    pub fn rate_of_whole(&self) -> f64 {
        self.rate_of_whole
    }

    /// Replaces the residual r(u) by the correction to be added to u. A component of the residual is measured against
    /// its `scale`, 0 to leave it out.
    ///
    /// # Panics
    /// When a slice has another length than the residuals.
    pub fn correct(&mut self, residual: &mut [f64], scale: &[f64]) {
        let n = self.size;
        if self.is_started {
            self.record(residual, scale);
        }
        self.is_started = true;
        self.residual.copy_from_slice(residual);
        self.orthogonalize(scale);
        // Each column in its basis, along the residual and into the correction.
        let columns = self.columns;
        self.operations += (2 * n * columns * columns.saturating_sub(1) + 12 * n * columns) as u64;
        let coordinates = self.coordinates_of(residual, scale);
        for (j, gamma) in coordinates.iter().enumerate().take(self.columns) {
            if *gamma == 0.0 {
                continue;
            }
            let (step, change) = (&self.steps[j * n..][..n], &self.changes[j * n..][..n]);
            for i in 0..n {
                residual[i] -= gamma * (step[i] + change[i]);
            }
        }
        self.correction.copy_from_slice(residual);
    }

    /// Takes in the differences to the iterate before as the newest column.
    fn record(&mut self, residual: &[f64], scale: &[f64]) {
        let n = self.size;
        self.columns = DEPTH.min(self.columns + 1);
        let kept = (self.columns - 1) * n;
        self.steps.copy_within(..kept, n);
        self.changes.copy_within(..kept, n);
        self.steps[..n].copy_from_slice(&self.correction);
        // By components, each over its scale, and as a whole: that of step and of step + change.
        let (mut from, mut to) = ([0.0; 2], [0.0; 2]);
        let mut largest = 0.0;
        for i in 0..n {
            largest = larger(largest, scale[i]);
            let (step, change) = (self.steps[i], residual[i] - self.residual[i]);
            self.changes[i] = change;
            for (sizes, value) in [(&mut from, step), (&mut to, step + change)] {
                sizes[0] = larger(sizes[0], scaled(value, scale[i]).abs());
                sizes[1] = larger(sizes[1], value.abs());
            }
        }
        if from[0] > WANDERING {
            let rate = (to[0] / from[0]).min(to[1] / from[1]);
            self.rate = larger(self.rate, rate);
            if from[1] > ROUND_OFF * largest {
                self.rate_of_whole = larger(self.rate_of_whole, rate);
            }
        }
        self.operations += 9 * n as u64;
    }

    /// The scaled Δr as basis times triangle, by Gram and Schmidt; a dependent column has a zero on
    /// the diagonal.
    fn orthogonalize(&mut self, scale: &[f64]) {
        let n = self.size;
        for j in 0..self.columns {
            let (before, own) = self.basis.split_at_mut(j * n);
            let own = &mut own[..n];
            let change = &self.changes[j * n..][..n];
            for i in 0..n {
                own[i] = scaled(change[i], scale[i]);
            }
            let whole = norm(own);
            for (k, direction) in before.chunks_exact(n).enumerate() {
                let along = product(direction, own);
                self.triangle[k * DEPTH + j] = along;
                own.iter_mut()
                    .zip(direction)
                    .for_each(|(o, d)| *o -= along * d);
            }
            let rest = norm(own);
            let is_independent = rest > DEPENDENT * whole && whole.is_finite();
            let inverse = if is_independent { 1.0 / rest } else { 0.0 };
            own.iter_mut().for_each(|o| *o *= inverse);
            self.triangle[j * DEPTH + j] = if is_independent { rest } else { 0.0 };
        }
    }

    /// γ of the smallest r − ΔR γ.
    fn coordinates_of(&mut self, residual: &[f64], scale: &[f64]) -> [f64; DEPTH] {
        let n = self.size;
        for (j, direction) in self.basis.chunks_exact(n).enumerate().take(self.columns) {
            self.coordinates[j] = (0..n)
                .map(|i| direction[i] * scaled(residual[i], scale[i]))
                .sum();
        }
        let mut gamma = [0.0; DEPTH];
        for j in (0..self.columns).rev() {
            let pivot = self.triangle[j * DEPTH + j];
            if pivot == 0.0 {
                continue;
            }
            let known: f64 = (j + 1..self.columns)
                .map(|k| self.triangle[j * DEPTH + k] * gamma[k])
                .sum();
            gamma[j] = (self.coordinates[j] - known) / pivot;
        }
        gamma
    }
}

fn scaled(value: f64, scale: f64) -> f64 {
    if scale > 0.0 { value / scale } else { 0.0 }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    libm::sqrt(product(a, a))
}

#[cfg(test)]
mod tests {
    use super::Anderson;

    /// r(u) = b − A u with a matrix that is no contraction: u ← u + r(u) diverges.
    fn residual(u: &[f64; 3]) -> [f64; 3] {
        let a = [[3.0, 1.0, 0.0], [-1.0, 2.5, 0.5], [0.0, 0.5, 4.0]];
        let b = [1.0, 2.0, 3.0];
        std::array::from_fn(|i| b[i] - (0..3).map(|j| a[i][j] * u[j]).sum::<f64>())
    }

    #[test]
    fn a_linear_residual_is_solved_after_as_many_corrections_as_unknowns() {
        let mut anderson = Anderson::new(3);
        let mut u = [0.0; 3];
        for _ in 0..5 {
            let mut correction = residual(&u);
            anderson.correct(&mut correction, &[1.0; 3]);
            u.iter_mut().zip(correction).for_each(|(u, c)| *u += c);
        }
        // Iterates reach a size of 30 before the last one, whose differences hold its round-off.
        let size = residual(&u).iter().fold(0.0_f64, |m, r| m.max(r.abs()));
        assert!(size <= 512.0 * f64::EPSILON, "{size:e}");
    }

    #[test]
    fn components_of_any_size_count_alike() {
        // The same system in units that differ by 1e40: bit for bit the same relative corrections,
        // since the units are powers of two.
        let units = [1.0, libm::exp2(130.0), libm::exp2(-130.0)];
        let (mut plain, mut other) = (Anderson::new(3), Anderson::new(3));
        let mut u = [0.0; 3];
        for _ in 0..4 {
            let mut correction = residual(&u);
            let mut scaled: [f64; 3] = std::array::from_fn(|i| correction[i] * units[i]);
            plain.correct(&mut correction, &[1.0; 3]);
            other.correct(&mut scaled, &units);
            assert_eq!(scaled, std::array::from_fn(|i| correction[i] * units[i]));
            u.iter_mut().zip(correction).for_each(|(u, c)| *u += c);
        }
    }

    /// Of u + r(u) = A u + b: |A Δu|/|Δu| lies below the largest row sum of |A| and, over enough directions, above
    /// the spectral radius of a symmetric A; in any units.
    #[test]
    fn the_rate_is_that_of_the_plain_iteration() {
        for (rate, unit) in [(0.125, 1.0), (0.75, 1e-20), (3.0, 1e20)] {
            let a = [[0.5 * rate, 0.5 * rate], [0.5 * rate, 0.5 * rate]];
            let scale = [unit, unit];
            let mut anderson = Anderson::new(2);
            let mut u = [0.0; 2];
            for _ in 0..4 {
                let mut correction: [f64; 2] =
                    std::array::from_fn(|i| a[i][0] * u[0] + a[i][1] * u[1] + unit - u[i]);
                anderson.correct(&mut correction, &scale);
                u.iter_mut().zip(correction).for_each(|(u, c)| *u += c);
            }
            let error = (anderson.rate() - rate).abs();
            assert!(
                error <= 8.0 * f64::EPSILON * rate,
                "{rate}: {}",
                anderson.rate()
            );
            anderson.clear();
            assert_eq!(anderson.rate(), 0.0);
        }
    }

    #[test]
    fn a_cleared_acceleration_starts_with_the_residual_itself() {
        let mut anderson = Anderson::new(2);
        let mut first = [1.0, -2.0];
        anderson.correct(&mut first, &[1.0; 2]);
        assert_eq!(first, [1.0, -2.0]);
        anderson.correct(&mut [0.5, 0.25], &[1.0; 2]);
        anderson.clear();
        let mut again = [3.0, 4.0];
        anderson.correct(&mut again, &[1.0; 2]);
        assert_eq!(again, [3.0, 4.0]);
    }
}
