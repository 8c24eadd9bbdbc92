//! Kepler's problem: K = a|p|² − k/|q − c| in two or three dimensions, an exact flow for every conic.
//!
//! With {q_i, p_j} = ±δ_ij, all with one sign, the motion is x′ = w, w′ = −μx/|x|³. Here x = q − c, w = Ap, A = ±2a,
//! B = ±k and μ = AB. Constants are β = 2μ/r₀ − |w|², positive on ellipses, and the angular momentum. In the time s
//! with dt = r ds the motion is linear, r″ = μ − βr. Stumpff's functions close it: G_k = sᵏ c_k(βs²),
//! c_k(z) = Σ_j (−z)ʲ/(2j + k)!. From r₀ = |x|, η = x·w, κ = μ − βr₀ follow s and r:
//!
//! t = r₀s + ηG₂ + κG₃, r = r₀ + ηG₁ + κG₂.
//!
//! The increments come without cancellation:
//!
//! x(t) − x = −(μ/r₀)G₂ x + (r₀G₁ + ηG₂)w, p(t) − p = −(B/(r r₀))G₁ x − (μ/r)G₂ p.
//!
//! These lie on the conic through the state whatever s is: an error of s is one of the time. So energy, angular
//! momentum and the ellipse's direction stay at round-off. Nothing distinguishes ellipses, parabolas and hyperbolas,
//! and μ < 0 repels.
//!
//! Sources are the textbooks of Stumpff, *Himmelsmechanik I* (1959), and Danby, *Fundamentals of Celestial Mechanics*. As
//! a piece it goes back to Wisdom and Holman, Astronomical Journal 102, 1528–1538 (1991).

mod code;
mod find;

use leafwise_expression::graph::lift;
use leafwise_expression::{AlgebraError, Arithmetic, Graph, Polynomial, Ring, Term};

use crate::sums::Code;
use code::Conic;
pub(crate) use find::find;

/// Bodies that move about fixed centres, each by itself: the sum of their energies is a piece.
#[derive(Clone, Debug)]
pub(crate) struct KeplerMotions(Vec<KeplerBody>);

/// A body about a centre.
#[derive(Clone, Debug)]
struct KeplerBody {
    /// The variables q_i and p_i, by dimension.
    pairs: Vec<[usize; 2]>,
    /// c, of numbers and of coordinates at rest.
    centre: Vec<Polynomial>,
    /// A and B, of the same.
    rates: [Polynomial; 2],
}

impl KeplerMotions {
    /// x(t) − x from the state `x` over the time `time`.
    ///
    /// # Errors
    /// [`AlgebraError`] where a parameter's function has no code.
    pub(crate) fn increment(
        &self,
        graph: &mut Graph,
        ring: &Ring,
        time: &Term,
        x: &[Term],
    ) -> Result<Vec<Term>, AlgebraError> {
        let mut increment = vec![graph.zero(); x.len()];
        for body in &self.0 {
            let numbers = body.numbers(graph, ring, x)?;
            let change = Code(graph).conic(&numbers, time);
            body.scatter(change, &mut increment);
        }
        Ok(increment)
    }

    /// (Ap, −Bx/|x|³) of every body, 0 of the other coordinates.
    ///
    /// # Errors
    /// [`AlgebraError`] where a parameter's function has no code.
    pub(crate) fn field(
        &self,
        graph: &mut Graph,
        ring: &Ring,
        x: &[Term],
    ) -> Result<Vec<Term>, AlgebraError> {
        let mut field = vec![graph.zero(); x.len()];
        for body in &self.0 {
            let numbers = body.numbers(graph, ring, x)?;
            let change = Code(graph).conic_field(&numbers);
            body.scatter(change, &mut field);
        }
        Ok(field)
    }
}

impl KeplerBody {
    /// A, B, q − c and p.
    fn numbers(&self, graph: &mut Graph, ring: &Ring, x: &[Term]) -> Result<Conic, AlgebraError> {
        let one = graph.one();
        let wanted = self.rates.iter().chain(&self.centre);
        let wanted: Vec<_> = wanted
            .map(|number| vec![(one.clone(), number.clone())])
            .collect();
        let mut lifted = lift(graph, ring, &wanted, x)?.into_iter();
        let mut next = || lifted.next().expect("one term for each polynomial");
        let rates = [next(), next()];
        let mut code = Code(graph);
        let place = self.pairs.iter().map(|[q, _]| {
            let centre = next();
            code.sum(&[(1, &[&x[*q]]), (-1, &[&centre])])
        });
        Ok(Conic {
            place: place.collect(),
            momentum: self.pairs.iter().map(|[_, p]| x[*p].clone()).collect(),
            rates,
        })
    }

    /// Writes the changes of q and p to their coordinates.
    fn scatter(&self, [place, momentum]: [Vec<Term>; 2], to: &mut [Term]) {
        for ([q, p], (x, w)) in self.pairs.iter().zip(place.into_iter().zip(momentum)) {
            to[*q] = x;
            to[*p] = w;
        }
    }
}
