//! Algebras over the state's coordinates, with exact derivatives along them.

use crate::algebra::{Polynomial, Ring};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::graph::{Graph, Term, lift};
use crate::rational::Rational;

/// A differential algebra over the coordinates x₁ … x_d: the exact [`Ring`], where sums are expanded
/// and cancel, or straight-line code ([`Graph`]), where nothing is expanded.
pub trait DifferentialAlgebra: Arithmetic<Element: 'static> {
    /// xᵢ.
    fn coordinate(&mut self, index: usize) -> Self::Element;
    /// ∂f/∂xᵢ.
    ///
    /// # Errors
    /// [`AlgebraError`] when the derivative of a function does not exist.
    fn partial(&mut self, f: &Self::Element, index: usize) -> Result<Self::Element, AlgebraError>;
    /// ∂f/∂x₁ … ∂f/∂x_d for d = `dimension`.
    ///
    /// # Errors
    /// Those of [`partial`](Self::partial).
    fn differential(
        &mut self,
        f: &Self::Element,
        dimension: usize,
    ) -> Result<Vec<Self::Element>, AlgebraError>;
    /// Elements that `form` finds in an exact ring over x₁ … x_d, taken into this algebra, of whose coordinates these
    /// d are x₁ … x_d. This serves elements whose normal form matters.
    ///
    /// # Errors
    /// Those of `form`, and [`AlgebraError`] when an adjoined function has no code.
    fn formed<E: From<AlgebraError>>(
        &mut self,
        coordinates: &[usize],
        form: impl FnOnce(&mut Ring) -> Result<Vec<Polynomial>, E>,
    ) -> Result<Vec<Self::Element>, E>;
}

impl DifferentialAlgebra for Ring {
    fn coordinate(&mut self, index: usize) -> Polynomial {
        self.variable(index)
    }
    fn partial(&mut self, f: &Polynomial, index: usize) -> Result<Polynomial, AlgebraError> {
        self.derivative(f, index)
    }
    fn differential(
        &mut self,
        f: &Polynomial,
        dimension: usize,
    ) -> Result<Vec<Polynomial>, AlgebraError> {
        (0..dimension).map(|at| self.derivative(f, at)).collect()
    }
    fn formed<E: From<AlgebraError>>(
        &mut self,
        coordinates: &[usize],
        form: impl FnOnce(&mut Ring) -> Result<Vec<Polynomial>, E>,
    ) -> Result<Vec<Polynomial>, E> {
        let mut own = Ring::new(coordinates.len());
        let elements = form(&mut own)?.into_iter();
        let of_this_ring = |f| {
            let formula = own.formula(&f).with_variables(coordinates);
            formula.evaluate_in(self, &mut |ring: &mut Self, at| Ok(ring.variable(at)))
        };
        Ok(elements.map(of_this_ring).collect::<Result<_, _>>()?)
    }
}

/// Coordinates are the kernel's inputs.
impl DifferentialAlgebra for Graph {
    fn coordinate(&mut self, index: usize) -> Term {
        self.input(index)
    }
    fn partial(&mut self, f: &Term, index: usize) -> Result<Term, AlgebraError> {
        self.derivative(f, index)
    }
    fn differential(&mut self, f: &Term, dimension: usize) -> Result<Vec<Term>, AlgebraError> {
        self.gradient(f, dimension)
    }
    fn formed<E: From<AlgebraError>>(
        &mut self,
        coordinates: &[usize],
        form: impl FnOnce(&mut Ring) -> Result<Vec<Polynomial>, E>,
    ) -> Result<Vec<Term>, E> {
        let mut ring = Ring::new(coordinates.len());
        let one = self.constant(&Rational::one());
        let elements = form(&mut ring)?.into_iter();
        let outputs: Vec<_> = elements.map(|f| vec![(one.clone(), f)]).collect();
        let x: Vec<Term> = coordinates.iter().map(|at| self.input(*at)).collect();
        Ok(lift(self, &ring, &outputs, &x)?)
    }
}
