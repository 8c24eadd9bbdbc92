//! How far round-off reaches through a linear solve.

use super::larger;

/// Replaces a residual by its correction by Newton's method.
pub type LinearSolve<'a> = &'a mut dyn FnMut(&mut [f64]);

/// Patterns of signs that stand for those of round-off.
const PATTERNS: u64 = 4;

/// Room for what round-off of sizes puts into n unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Reached {
    /// Sizes s, to which what others put there is added.
    pub sizes: Vec<f64>,
    reached: Vec<f64>,
    signed: Vec<f64>,
}

impl Reached {
    pub fn new(n: usize) -> Self {
        Self {
            sizes: vec![0.0; n],
            reached: vec![0.0; n],
            signed: vec![0.0; n],
        }
    }

    /// Adds to each size s_i the largest |A⁻¹ (±s)|_i of four patterns of signs. That is what round-off of the sizes s puts
    /// into the unknowns of A u = r, directly or through others. `solve` replaces r by A⁻¹ r.
    pub fn add(&mut self, solve: LinearSolve<'_>) {
        self.reached.fill(0.0);
        for pattern in 0..PATTERNS {
            let rows = self.signed.iter_mut().zip(&self.sizes).enumerate();
            for (row, (signed, size)) in rows {
                *signed = match is_negative(pattern, row as u64) {
                    true => -size,
                    false => *size,
                };
            }
            solve(&mut self.signed);
            for (reached, found) in self.reached.iter_mut().zip(&self.signed) {
                *reached = larger(*reached, found.abs());
            }
        }
        for (size, reached) in self.sizes.iter_mut().zip(&self.reached) {
            *size += reached;
        }
    }
}

/// Signs without a pattern that a matrix could share: bits of a product, well mixed.
fn is_negative(pattern: u64, row: u64) -> bool {
    let mut bits = (row * PATTERNS + pattern + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits ^= bits >> 29;
    bits.wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 63 == 1
}

#[cfg(test)]
mod tests {
    use super::{Reached, is_negative};

    /// Of a chain 0 ← 1 ← … in which each puts a tenth of itself into the one before, all sizes but the last are 0.
    #[test]
    fn a_size_reaches_as_far_as_the_solve_does() {
        let mut reached = Reached::new(4);
        reached.sizes[3] = 2.0;
        reached.add(&mut |r| {
            for i in (0..3).rev() {
                r[i] += 0.1 * r[i + 1];
            }
        });
        let expected = [0.002, 0.02, 0.2, 4.0];
        let sizes = reached.sizes;
        for (size, expected) in sizes.iter().zip(expected) {
            assert!((size - expected).abs() <= 1e-15, "{sizes:?}");
        }
    }

    /// Neighbours that cancel each other under equal signs do not under all patterns.
    #[test]
    fn no_pattern_of_signs_is_that_of_a_difference() {
        for row in 0..4096 {
            let kept = |p| is_negative(p, row) != is_negative(p, row + 1);
            let other = |p| is_negative(p, row) == is_negative(p, row + 1);
            assert!((0..4).any(kept) || (0..4).any(other));
        }
        let negative = |p| (0..4096).filter(|row| is_negative(p, *row)).count();
        for pattern in 0..4 {
            // Half of 4096 within five standard deviations of 32.
            assert!(
                negative(pattern).abs_diff(2048) <= 160,
                "{}",
                negative(pattern)
            );
        }
    }
}
