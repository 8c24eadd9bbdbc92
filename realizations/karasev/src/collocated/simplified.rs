//! Corrections of a curve by Newton's method with the derivatives of V at one point.
//!
//! Let r_m and a_m be the Legendre coefficients of a residual and of its correction, w_m those of δV = V_y δY + Π δp.
//! The equations of the curve are, for m ≥ 1, a_m = r_m + (ε/2)(w_{m−1}/(2m−1) − w_{m+1}/(2m+3)). For m = 0 they are
//! a_0 = r_0 where its mean is fixed, and a_0 = r_0 − (ε/2)(w_0 + w_1/3) where its end Y(1) is.
//!
//! With K = (ε/2) V_y and N = K + (ε/2) Π Dθ of one point, (ε/2) w_0 = N a_0 and (ε/2) w_m = K a_m. From the last
//! coefficient to the first, r_m ← r_m − K r_{m+1}/(2m+3). Then (1 + N + K N/3) a_0 = r_0 − K r_1/3 is solved. Finally
//! a_1 = r_1 + N a_0 and a_m = r_m + K a_{m−1}/(2m−1). The terms left out are K²/15 of a correction at most (simplified
//! Newton iterations: Hairer, Wanner, *Solving Ordinary Differential Equations II*, section IV.8).

use leafwise_core::StepError;
use leafwise_core::solver::{DenseFactors, elimination_operations, substitution_operations};

use super::field::FieldEvaluator;

/// Part of a curve that stays fixed while its nodes are corrected.
#[derive(Clone, Copy, Debug)]
pub(super) enum Fixed<'a> {
    /// Its mean, with p.
    Mean,
    /// Its end Y(1), and p = θ(mean): Dθ, row-major.
    End(&'a [f64]),
}

/// V_y and V_y + Π Dθ at one point, and the factors of 1 + N + K N/3.
pub(super) struct Simplified {
    dimension: usize,
    half: f64,
    by_y: Slope,
    by_mean: Slope,
    is_mean_fixed: bool,
    factors: DenseFactors,
    /// (|N| + |K|)|y|: what the round-off of all coordinates puts into each.
    pub(super) put_in: Vec<f64>,
    /// Room for 1 + N + K N/3, V_y, Π and V_y + Π Dθ.
    matrices: [Vec<f64>; 4],
    /// Operations of the products and solves.
    pub(super) operations: u64,
}

impl Simplified {
    pub(super) fn new(dimension: usize) -> Self {
        Self {
            dimension,
            half: 0.0,
            by_y: Slope::new(dimension),
            by_mean: Slope::new(dimension),
            is_mean_fixed: true,
            factors: DenseFactors::new(dimension),
            put_in: vec![0.0; dimension],
            matrices: std::array::from_fn(|_| vec![0.0; dimension * dimension]),
            operations: 0,
        }
    }

    /// Takes the derivatives at (y, p).
    ///
    /// # Errors
    /// The system's [`StepError`]; [`StepError::NonFinite`] where 1 + N + K N/3 is singular.
    pub(super) fn linearize(
        &mut self,
        field: &mut FieldEvaluator,
        epsilon: f64,
        (y, p): (&[f64], &[f64]),
        fixed: Fixed<'_>,
    ) -> Result<(), StepError> {
        let d = self.dimension;
        let [matrix, by_y, by_p, by_mean] = &mut self.matrices;
        self.half = 0.5 * epsilon;
        field.slopes(y, p, by_y, by_p)?;
        self.by_y.take(by_y, d);
        by_mean.copy_from_slice(by_y);
        self.is_mean_fixed = matches!(fixed, Fixed::Mean);
        if let Fixed::End(slope) = fixed {
            self.operations += add_product(by_p, slope, by_mean, d);
        }
        self.by_mean.take(by_mean, d);
        self.put_in.fill(0.0);
        for slope in [&self.by_y, &self.by_mean] {
            for (row, column, entry) in &slope.entries {
                self.put_in[*row] += (self.half * entry * y[*column]).abs();
            }
        }
        if self.is_mean_fixed {
            return Ok(());
        }
        // 1 + N + K N/3 = 1 + (ε/2)(1 + (ε/6) V_y)(V_y + Π Dθ).
        matrix.copy_from_slice(by_mean);
        by_y.iter_mut().for_each(|v| *v *= self.half / 3.0);
        self.operations += add_product(by_y, by_mean, matrix, d);
        matrix.iter_mut().for_each(|entry| *entry *= self.half);
        (0..d).for_each(|i| matrix[i * d + i] += 1.0);
        self.operations += (2 * d * d) as u64 + elimination_operations(d);
        let is_regular = self.factors.factor_of_sizes(matrix, y);
        for (at, put_in) in self.put_in.iter_mut().enumerate() {
            *put_in *= self.factors.left(at);
        }
        match is_regular {
            true => Ok(()),
            false => Err(StepError::NonFinite {
                what: "a correction of the curve",
            }),
        }
    }

    /// The factors of 1 + N + K N/3, the derivative of the end by the mean.
    pub(super) fn factors(&self) -> &DenseFactors {
        &self.factors
    }

    /// Replaces the coefficients of a residual by those of its correction.
    pub(super) fn correct(&mut self, a: &mut [f64]) {
        let (d, half) = (self.dimension, self.half);
        let q = a.len() / d;
        for m in (1..q.saturating_sub(1)).rev() {
            let (low, high) = a[m * d..].split_at_mut(d);
            self.operations += self.by_y.add(-half / (2 * m + 3) as f64, high, low);
        }
        if !self.is_mean_fixed {
            let (mean, rest) = a.split_at_mut(d);
            if q > 1 {
                self.operations += self.by_y.add(-half / 3.0, rest, mean);
            }
            self.factors.solve(mean);
            self.operations += substitution_operations(d);
        }
        for m in 1..q {
            let slope = if m == 1 {
                &mut self.by_mean
            } else {
                &mut self.by_y
            };
            let (low, high) = a[(m - 1) * d..].split_at_mut(d);
            self.operations += slope.add(half / (2 * m - 1) as f64, low, high);
        }
    }

    /// Adds to the coefficients of V what the correction a changes there, to first order.
    pub(super) fn add_change(&mut self, a: &[f64], velocity: &mut [f64]) {
        let d = self.dimension;
        let both = a.chunks_exact(d).zip(velocity.chunks_exact_mut(d));
        for (m, (a, velocity)) in both.enumerate() {
            let slope = if m == 0 {
                &mut self.by_mean
            } else {
                &mut self.by_y
            };
            self.operations += slope.add(1.0, a, velocity);
        }
    }
}

/// The entries of a d × d matrix that are not zero, row by row.
struct Slope {
    entries: Vec<(usize, usize, f64)>,
    /// Room for a multiple of a vector.
    scaled: Vec<f64>,
}

impl Slope {
    fn new(dimension: usize) -> Self {
        Self {
            entries: Vec::with_capacity(dimension * dimension),
            scaled: vec![0.0; dimension],
        }
    }

    fn take(&mut self, matrix: &[f64], d: usize) {
        self.entries.clear();
        let entries = matrix.iter().enumerate().filter(|(_, v)| **v != 0.0);
        self.entries
            .extend(entries.map(|(at, v)| (at / d, at % d, *v)));
    }

    /// Adds c M a to the sums; counts the operations.
    fn add(&mut self, c: f64, a: &[f64], sums: &mut [f64]) -> u64 {
        let scaled = self.scaled.iter_mut().zip(a);
        scaled.for_each(|(scaled, a)| *scaled = c * a);
        for (row, column, entry) in &self.entries {
            sums[*row] += entry * self.scaled[*column];
        }
        (self.scaled.len() + 2 * self.entries.len()) as u64
    }
}

/// Adds A B, row-major d × d, to the sums, but for zeros of A; counts the operations.
fn add_product(a: &[f64], b: &[f64], sums: &mut [f64], d: usize) -> u64 {
    let mut operations = 0;
    for (sums, row) in sums.chunks_exact_mut(d).zip(a.chunks_exact(d)) {
        let factors = row.iter().zip(b.chunks_exact(d));
        for (factor, entries) in factors.filter(|(factor, _)| **factor != 0.0) {
            let entries = sums.iter_mut().zip(entries);
            entries.for_each(|(sum, entry)| *sum += factor * entry);
            operations += 2 * d as u64;
        }
    }
    operations
}
