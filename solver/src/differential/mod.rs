//! The differential of a step.
//!
//! - `solved`: of steps that solve β̂(L(y)) = x, with solves by foreseen Jacobians in `foreseen`.
//! - `explicit`: of explicit ones.

mod explicit;
mod foreseen;
mod solved;

pub use explicit::Inverse;
pub(crate) use explicit::{Explicit, in_reverse};
pub use solved::{Solved, by_parameters};

use crate::error::StepError;
use crate::{DenseFactors, Stepper};

/// Steps x ↦ Φ(x; λ) of one trajectory in one thread, with their derivatives by x and by the parameters λ.
///
/// A step is taken by [`step`](Self::step); the others apply its differential, in place. Vectors and covectors have d
/// numbers, those of parameters one a parameter, or none where parameters do not matter.
pub trait Differential: Send {
    /// Φ(x + low) − (x + low), as [`Stepper::increment`].
    ///
    /// # Errors
    /// The solver's [`StepError`].
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError>;
    /// v ← DΦ v + ∂_λΦ μ. Vectors v are contiguous in `tangents`, and as many μ in `parameters`.
    ///
    /// # Errors
    /// [`StepError::NoTangent`] for a map without an exact tangent, [`StepError::NonFinite`] where a matrix is singular.
    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError>;
    /// w ← DΦᵀ w, and g ← g + ∂_λΦᵀ w of the old w.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError>;
    /// The pull-back by the inverse of the step taken: w ← DΦ⁻ᵀ w, and g ← g − ∂_λΦᵀ w of the new w. A step of Φ_{−h}
    /// is so pulled back through by the covector of a self-adjoint Φ_h.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    fn pull_inverse(&mut self, covector: &mut [f64], gradient: &mut [f64])
    -> Result<(), StepError>;
    /// [`step`](Self::step) from x + low and [`pull_inverse`](Self::pull_inverse) at once, where that is less work than one
    /// after the other.
    ///
    /// # Errors
    /// As theirs.
    fn step_and_pull_inverse(
        &mut self,
        [x, low]: [&[f64]; 2],
        increment: &mut [f64],
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        self.step(x, low, increment)?;
        self.pull_inverse(covector, gradient)
    }
    /// Whether derivatives by parameters are known.
    fn knows_parameters(&self) -> bool;
    /// Work so far: of the steps, and of their differentials.
    fn operations(&self) -> Option<u64>;
}

/// Error of a linear solve whose matrix is singular or not finite.
const SINGULAR: StepError = StepError::NonFinite {
    what: "the differential of a step",
};

/// The differential by a stepper's own tangents, of any map that offers them; not by parameters.
pub struct ByTangents {
    stepper: Box<dyn Stepper>,
    dimension: usize,
    matrix: Vec<f64>,
    factors: DenseFactors,
    room: Vec<f64>,
    is_current: bool,
}

impl ByTangents {
    /// Steps of a stepper of one lane.
    pub fn new(stepper: Box<dyn Stepper>, dimension: usize) -> Self {
        Self {
            stepper,
            dimension,
            matrix: Vec::new(),
            factors: DenseFactors::new(dimension),
            room: vec![0.0; dimension * dimension],
            is_current: false,
        }
    }

    fn find(&mut self) -> Result<(), StepError> {
        if !self.is_current {
            self.matrix = self.stepper.tangent(0).ok_or(StepError::NoTangent)?;
            self.is_current = true;
        }
        Ok(())
    }
}

impl Differential for ByTangents {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.is_current = false;
        one_step(self.stepper.as_mut(), x, low, increment)
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        debug_assert!(
            parameters.is_empty(),
            "derivatives by parameters are not known"
        );
        self.find()?;
        let d = self.dimension;
        for tangent in tangents.chunks_exact_mut(d) {
            let room = &mut self.room[..d];
            room.copy_from_slice(tangent);
            for (out, row) in tangent.iter_mut().zip(self.matrix.chunks_exact(d)) {
                *out = dot(row, room);
            }
        }
        Ok(())
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        debug_assert!(
            gradient.is_empty(),
            "derivatives by parameters are not known"
        );
        self.find()?;
        let d = covector.len();
        let room = &mut self.room[..d];
        room.copy_from_slice(covector);
        covector.fill(0.0);
        for (w, row) in room.iter().zip(self.matrix.chunks_exact(d)) {
            add_multiple(covector, *w, row);
        }
        Ok(())
    }

    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        debug_assert!(
            gradient.is_empty(),
            "derivatives by parameters are not known"
        );
        self.find()?;
        transpose(&self.matrix, &mut self.room, covector.len());
        if !self.factors.factor(&self.room) {
            return Err(SINGULAR);
        }
        self.factors.solve(covector);
        Ok(())
    }

    fn knows_parameters(&self) -> bool {
        false
    }

    fn operations(&self) -> Option<u64> {
        self.stepper.statistics().operations
    }
}

/// One step of a stepper of one lane.
pub fn one_step(
    stepper: &mut dyn Stepper,
    x: &[f64],
    low: &[f64],
    increment: &mut [f64],
) -> Result<(), StepError> {
    let mut outcome = [Ok(())];
    stepper.increment(x, low, increment, &mut outcome);
    let [outcome] = outcome;
    outcome
}

/// a·b.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// y ← y + a x.
fn add_multiple(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Writes the transpose of a d × d matrix.
fn transpose(matrix: &[f64], out: &mut [f64], d: usize) {
    for (i, row) in matrix.chunks_exact(d).enumerate() {
        for (j, entry) in row.iter().enumerate() {
            out[j * d + i] = *entry;
        }
    }
}
