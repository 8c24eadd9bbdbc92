//! Coordinates with a constant tensor: logarithms of species, Clebsch variables of momenta.
//!
//! A lift is a map J: z ↦ x from ℝⁿ with a constant Poisson tensor Ω onto (an open set of) M that is Poisson,
//! {x_i∘J, x_j∘J}_Ω = Π_ij∘J. The collective Hamiltonian K = H∘J moves z by ż = −Ω∇K, and J∘z is the motion of x.
//! A Gauss method steps z by a Poisson map of Ω (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, theorem
//! VI.4.3). Where it takes fibres of J to fibres, as it does where they are orbits of affine symmetries of K and Ω, the step
//! descends to a Poisson map of M, to round-off: the collective integrators of McLachlan, Modin and Verdier (Nonlinearity 27 (2014)) and
//! of section 4.3 of Cabrera, Martín de Diego and Vaquero.

mod map;

use leafwise_expression::{Graph, Term};

use crate::error::{BuildError, StepError};
use crate::system::SystemFormulas;

pub(crate) use map::LiftedMap;

/// Where a step has ended: z and the base point.
#[derive(Clone, Copy, Debug)]
pub struct End<'a> {
    /// z.
    pub z: &'a [f64],
    /// The base point that z is about.
    pub base: &'a [f64],
}

/// Coordinates z of a realization with a constant tensor, about a base point of each step: z is 0 where a step begins.
pub trait Lift: Send + Sync + std::fmt::Debug {
    /// n, the number of coordinates z.
    fn dimension(&self) -> usize;
    /// How many numbers the base point has.
    fn base_dimension(&self) -> usize;
    /// Writes the base point of a step from x + low; `before` is where the step before has ended, if there was one.
    ///
    /// # Errors
    /// [`StepError`] where x is not in the image of J.
    fn place(
        &self,
        x: &[f64],
        low: &[f64],
        before: Option<End<'_>>,
        base: &mut [f64],
    ) -> Result<(), StepError>;
    /// Whether base points depend on where the step before has ended.
    fn follows(&self) -> bool {
        false
    }
    /// Writes what is known of each z relative to: the size of a change that changes x by its own size.
    fn sizes(&self, base: &[f64], sizes: &mut [f64]);
    /// ż = −Ω∇(H∘J) as code.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where H or its derivative has no code.
    fn field(
        &self,
        system: &SystemFormulas,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
    ) -> Result<Vec<Term>, BuildError>;
    /// J(z) − J(0) as code, without cancellation.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where it has no code.
    fn increment(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
    ) -> Result<Vec<Term>, BuildError>;
    /// Writes the derivative of base points by x, row-major m × d: of any that J takes back to the identity.
    fn slopes_of_base(&self, base: &[f64], slopes: &mut [f64]);
    /// Takes off an increment of x what rounding has added to Casimirs.
    fn hold(&self, x: &[f64], low: &[f64], increment: &mut [f64]) {
        let _ = (x, low, increment);
    }
}
