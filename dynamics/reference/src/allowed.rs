//! Errors that coordinates may have in a substep, from a tolerance.

use leafwise_core::PoissonSystem;
use leafwise_core::solver::kept_signs;

use crate::floors::{Floors, LEAST_PART};

/// Coordinates up to which floors are in units of their own: they are found in as many sweeps.
const MOST_OF_THEIR_OWN: usize = 64;

/// δ times the size of each coordinate, but no less than 32 digits below what it comes to.
///
/// A coordinate at rest that begins to move as a high power of the time is as large as what a method leaves out of it.
/// No tolerance relative to itself can be met there. Once the tolerance is not met, the field tells how large the
/// coordinate becomes ([`Floors`]).
///
/// The largest coordinate takes the place of that size in two kinds of systems, at once and in whatever units. These
/// are systems of numbers, which have no bounds on the field's rounding errors, and systems of more than 64
/// coordinates. A coordinate x_i whose sign the tensor keeps ([`kept_signs`]) is 0 always or never. Its own size is
/// all that counts: species that nearly die out come back.
#[derive(Clone, Debug)]
pub(crate) struct Allowed {
    /// δ.
    tolerance: f64,
    kept: Vec<bool>,
    /// Whether floors are in units of their own.
    has_floors: bool,
}

impl Allowed {
    /// For a field with or without bounds on its rounding errors.
    pub(crate) fn new(system: &PoissonSystem, tolerance: f64, has_bounds: bool) -> Self {
        let d = system.dimension();
        let mut kept = vec![false; d];
        kept_signs(system).into_iter().for_each(|i| kept[i] = true);
        Self {
            tolerance,
            kept,
            has_floors: has_bounds && d <= MOST_OF_THEIR_OWN,
        }
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

    /// Whether floors are in units of each coordinate, to be formed where they are needed.
    #[inline(always)]
    pub(crate) fn has_floors(&self) -> bool {
        self.has_floors
    }

    /// The error that x_i may have, for its size and the largest of all.
    #[inline(always)]
    pub(crate) fn error(&self, i: usize, size: f64, largest: f64, floors: &Floors) -> f64 {
        let least = if self.kept[i] {
            0.0
        } else if self.has_floors {
            floors.least(i)
        } else {
            LEAST_PART * largest
        };
        self.of_itself(size).max(least)
    }

    /// The error that a coordinate of this size may have whatever the others are.
    #[inline(always)]
    pub(crate) fn of_itself(&self, size: f64) -> f64 {
        (self.tolerance * size).max(f64::MIN_POSITIVE)
    }
}
