//! What the error of a coordinate may be in a substep.

use leafwise_core::PoissonSystem;
use leafwise_core::solver::kept_signs;

/// What is below this part of the largest coordinate is not looked at: 2⁻¹⁰⁴.
const LEAST_PART: f64 = f64::EPSILON * f64::EPSILON;

/// δ times the size of each coordinate, but no less than 32 digits below the largest of all.
///
/// A coordinate at rest that begins to move as a high power of the time is as large as what a method leaves out of it:
/// no tolerance relative to itself can be met. A coordinate x_i whose sign the tensor keeps ([`kept_signs`]) is 0
/// always or never, and its own size is all that counts: species that nearly die out come back.
#[derive(Clone, Debug)]
pub(crate) struct Allowed {
    /// δ.
    tolerance: f64,
    kept: Vec<bool>,
}

impl Allowed {
    pub(crate) fn new(system: &PoissonSystem, tolerance: f64) -> Self {
        let mut kept = vec![false; system.dimension()];
        kept_signs(system).into_iter().for_each(|i| kept[i] = true);
        Self { tolerance, kept }
    }

    /// Whether the tensor keeps the sign of x_i.
    #[inline(always)]
    pub(crate) fn keeps_sign(&self, i: usize) -> bool {
        self.kept[i]
    }

    /// The coordinates whose sign the tensor keeps.
    pub(crate) fn kept(&self) -> Vec<usize> {
        (0..self.kept.len()).filter(|i| self.kept[*i]).collect()
    }

    /// The error that x_i may have, for its size and the largest of all.
    #[inline(always)]
    pub(crate) fn error(&self, i: usize, size: f64, largest: f64) -> f64 {
        let least = if self.kept[i] {
            0.0
        } else {
            LEAST_PART * largest
        };
        (self.tolerance * size).max(least).max(f64::MIN_POSITIVE)
    }
}
