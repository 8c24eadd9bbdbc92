//! Coordinates with a constant tensor: logarithms of species, Clebsch variables of momenta.
//!
//! A lift is a map J: z ↦ x from ℝⁿ with a constant Poisson tensor Ω onto (an open set of) M that is Poisson,
//! {x_i∘J, x_j∘J}_Ω = Π_ij∘J. The collective Hamiltonian K = H∘J moves z by ż = −Ω∇K, and J∘z is the motion of x.
//! A Gauss method steps z by a Poisson map of Ω (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, theorem
//! VI.4.3). Where the method takes fibres of J to fibres, the step descends to a Poisson map of M, to round-off. It
//! does so where they are orbits of affine symmetries of K and Ω. These are the collective integrators of McLachlan,
//! Modin and Verdier (Nonlinearity 27 (2014)) and of section 4.3 of Cabrera, Martín de Diego and Vaquero.
//!
//! The types:
//!
//! - [`ConstantLift`]: x itself, where its tensor is constant.
//! - [`Slowing`]: Casimirs taken off H.
//! - [`LiftSum`]: the lifts of a direct sum's summands side by side.

mod constant;
mod map;
mod slowing;
mod sum;

use leafwise_expression::{Graph, Polynomial, Term};

use crate::error::{BuildError, StepError};

pub use constant::ConstantLift;
pub(crate) use map::LiftedMap;
pub use slowing::{Met, Slowing};
pub use sum::{LiftSum, Summand};

/// Where a step has ended: z and the base point.
#[derive(Clone, Copy, Debug)]
pub struct End<'a> {
    /// z.
    pub z: &'a [f64],
    /// The base point that z is about.
    pub base: &'a [f64],
}

/// Numbers of coordinates of a [`Lift`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiftShape {
    /// n, the number of coordinates z.
    pub coordinates: usize,
    /// How many numbers the base point has.
    pub base: usize,
    /// Whether base points depend on where the step before has ended.
    pub follows: bool,
}

/// Coordinates z of a realization with a constant tensor, about a base point of each step: z is 0 where a step begins.
pub trait Lift: Send + Sync + std::fmt::Debug {
    /// The numbers of coordinates.
    fn shape(&self) -> LiftShape;
    /// Writes the base point of a step from x + low. The end of the step before, if there was one, is `before`.
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
    /// Writes what is known of each z relative to: the size of a change that changes x by its own size.
    fn sizes(&self, base: &[f64], sizes: &mut [f64]);
    /// Casimir C, a function of the coordinates `places` of the system, to be taken off H. The function H − C moves x
    /// as H does, and z along the fibres of J more slowly. Returns 0 where nothing is gained.
    ///
    /// # Errors
    /// [`BuildError`] where the choice cannot be made.
    fn slowing(
        &self,
        slowing: &mut Slowing<'_>,
        places: &[usize],
    ) -> Result<Polynomial, BuildError> {
        let _ = (slowing, places);
        Ok(Polynomial::zero())
    }
    /// x = J(z) as code.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where it has no code.
    fn image(&self, graph: &mut Graph, z: &[Term], base: &[Term]) -> Result<Vec<Term>, BuildError>;
    /// The covector that [`field`](Self::field) reads, of x and ∇H(x): in a graph of these, where what both share is known.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where it has no code.
    fn covector(
        &self,
        graph: &mut Graph,
        x: &[Term],
        slopes: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let _ = (graph, x);
        Ok(slopes.to_vec())
    }
    /// ż = −Ω∇(H∘J) as code, of the [`covector`](Self::covector) at J(z).
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where it has no code.
    fn field(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
        covector: &[Term],
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
    /// Writes the derivative of base points by x, row-major m × d: of any that J takes back to the identity; NaN where there
    /// is none.
    fn slopes_of_base(&self, base: &[f64], slopes: &mut [f64]);
    /// Takes off an increment of x what rounding has added to quadratic Casimirs Σ c x_i x_j. Returns the most of
    /// that, as a part of Σ |c x_i x_j|, and 0 where none is held.
    fn hold(&self, x: &[f64], low: &[f64], increment: &mut [f64]) -> f64 {
        let _ = (x, low, increment);
        0.0
    }
}
