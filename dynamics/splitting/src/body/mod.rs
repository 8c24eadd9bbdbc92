//! The free rigid body: K = Σ c_l m_l² where m, and vectors n beside it, turn as so(3) does.
//!
//! The motion is m′ = Ω × m and n′ = Ω × n with Ω_l = κ_l m_l, κ_l = ±2c_l. Differences of the κ_l are
//!
//! a₁ = κ₂ − κ₃, a₂ = κ₃ − κ₁, a₃ = κ₁ − κ₂.
//!
//! Constants of the motion are
//!
//! P = a₃m₂² − a₂m₃², Q = a₁m₂² − a₂m₁², R = a₃m₁² − a₁m₃²,
//!
//! and so are p = a₁P and q = a₃Q. Functions S, C and D solve S′ = CD, C² = 1 − pS², D² = 1 − qS²: they are Jacobi's
//! sn, cn and dn with sn = √p·S. Their addition theorem gives
//!
//! m(τ) = (m₁C + a₁SD m₂m₃, m₂CD + a₂S m₁m₃, m₃D + a₃SC m₁m₂)/(1 − a₁a₃S²m₂²).
//!
//! This comes from the state itself: without the phase of the motion, amplitudes, an order of the axes or a
//! separatrix.
//!
//! The rotation from −τ to τ about the state m between is the quaternion (α, β₁m₁, β₂m₂, β₃m₃) over its length. In it
//! α and the β_l depend on τ and the constants of the motion alone: both sides have the same poles and zeros in
//! complex time. The state m(τ) is m(−τ) turned where α a₁S = β₂ − β₃C, α a₂S = β₃C − β₁D, α a₃SC = (β₁D − β₂)C. For
//! κ₂ = 0 the derivative of α obeys
//!
//! (1 − pS²)(1 − qS²) dα/dS = −Rβ₂ − αS(q − a₁R − pqS²).
//!
//! That of β₂ obeys
//!
//! (1 − pS²)(1 − qS²) dβ₂/dS = −a₁a₃S((|m|² − PQS²)β₂ + RSα).
//!
//! Two such rotations after one another are one. So everything doubles in time by sums and products, from series over
//! a short time on, at p = q and m = 0 as elsewhere. Let r = 1/(1 − pqS⁴), and on the right take S, C, D, α and the
//! β_l at τ. Then
//!
//! S(2τ) = 2rSCD, 1 − C(2τ) = 2r pS²(1 − qS²), 1 − D(2τ) = 2r qS²(1 − pS²), 1 + α(2τ) = 2r(α² + PQS²β₂²).
//!
//! The β_l double by
//!
//! β₁(2τ) = 2r(αβ₁C − PSDβ₂β₃), β₂(2τ) = 2r(αβ₂CD + RSβ₃β₁), β₃(2τ) = 2r(αβ₃D + QSCβ₁β₂).
//!
//! The code forms 1 − α in the place of α, whose round-off would grow fourfold each time. What κ₂ adds is a rotation
//! about m.
//!
//! C. G. J. Jacobi, Journal für die reine und angewandte Mathematik 39, 293–350 (1850); exact flows in splittings: R. van Zon,
//! J. Schofield, Journal of Computational Physics 225, 145–164 (2007); E. Celledoni, F. Fassò, N. Säfström, A. Zanna, SIAM
//! Journal on Scientific Computing 30, 2084–2112 (2008).

mod code;
mod vectors;

use leafwise_core::SystemFormulas;
use leafwise_expression::algebra::{Coefficient, Monomial};
use leafwise_expression::graph::lift;
use leafwise_expression::{AlgebraError, Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use crate::sums::Code;
use crate::tensor::Tensor;
use vectors::{Turns, Vector, vector};

/// A free rigid body within a system.
#[derive(Clone, Debug)]
pub(crate) struct FreeBody {
    /// m, and the vectors that turn with it.
    vectors: Vec<Vector>,
    /// κ.
    rates: [Polynomial; 3],
}

impl FreeBody {
    /// A body of the squares in `hamiltonian`, and Σ c_l m_l².
    ///
    /// # Errors
    /// [`AlgebraError`] where a derivative does not exist.
    pub(crate) fn find(
        system: &SystemFormulas,
        ring: &mut Ring,
        tensor: &Tensor,
        hamiltonian: &Polynomial,
    ) -> Result<Option<(Self, Polynomial)>, AlgebraError> {
        let dimension = system.dimension();
        let mut turns = Vec::with_capacity(dimension);
        for at in 0..dimension {
            let x = ring.variable(at);
            let field = tensor.field(ring, &x)?;
            turns.push(Turns::new(ring, &field));
        }
        for i in 0..dimension {
            for j in i + 1..dimension {
                let Some((_, k)) = turns[i].of(j).filter(|(_, k)| *k > j) else {
                    continue;
                };
                if let Some(found) = Self::about(system, ring, &turns, hamiltonian, [i, j, k]) {
                    return Ok(Some(found));
                }
            }
        }
        Ok(None)
    }

    /// The body whose m has these coordinates.
    fn about(
        system: &SystemFormulas,
        ring: &mut Ring,
        turns: &[Turns],
        hamiltonian: &Polynomial,
        momentum: [usize; 3],
    ) -> Option<(Self, Polynomial)> {
        let squares = momentum.map(|at| Monomial::power(at as u32, 2));
        let coefficient = |monomial: &Monomial| {
            let mut terms = hamiltonian.terms().iter();
            terms.find(|(m, _)| m == monomial).map(|(_, c)| c.clone())
        };
        let of_squares = squares.each_ref().map(coefficient);
        if of_squares.iter().flatten().count() < 2 {
            return None;
        }
        let axes = momentum.map(|at| &turns[at]);
        // e₁ × m = (0, −m₃, m₂), up to the sign that all brackets share.
        let (sign, _) = axes[0].of(momentum[1])?;
        let sign = -sign;
        let mut vectors = vec![momentum.map(|at| (at, 1))];
        if vector(axes, sign, momentum[0]).as_ref() != vectors.first() {
            return None;
        }
        for at in 0..turns.len() {
            let is_taken = vectors.iter().flatten().any(|(other, _)| *other == at);
            if is_taken || axes.iter().all(|axis| axis.rests(at)) {
                continue;
            }
            let mut candidates = (0..turns.len()).filter_map(|first| vector(axes, sign, first));
            vectors.push(candidates.find(|vector| vector.iter().any(|(other, _)| *other == at))?);
        }
        let terms = squares.into_iter().zip(&of_squares);
        let terms = terms.filter_map(|(m, c)| Some((m, c.clone()?)));
        let energy = Polynomial::collect(terms);
        let twice = Rational::from_integer(2 * sign);
        let rates = of_squares.map(|c| c.map_or_else(Polynomial::zero, Polynomial::constant));
        let body = Self {
            rates: rates.map(|c| c.scaled(&twice)),
            vectors,
        };
        let middle = body.middle_axis(system, ring);
        Some((body.turned_by(middle + 2), energy))
    }

    /// The axis of the middle κ at the parameters' values: about the two others p and q are not negative.
    fn middle_axis(&self, system: &SystemFormulas, ring: &Ring) -> usize {
        let values = system.parameter_values();
        let value = |c: &Coefficient| ring.coefficient_formula(c).evaluate(&[], &values);
        let values = self.rates.each_ref().map(|rate| {
            let constant = rate.terms().first();
            constant.map_or(0.0, |(_, c)| value(c))
        });
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        order[1]
    }

    /// The same with the axes in another cyclic order, `by` as the first.
    fn turned_by(mut self, by: usize) -> Self {
        self.rates.rotate_left(by % 3);
        for vector in &mut self.vectors {
            vector.rotate_left(by % 3);
        }
        self
    }

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
        let [first, second, third] = self.rates.each_ref();
        let mut sums = ring.clone();
        let wanted = [
            sums.subtract(second, third),
            sums.subtract(third, first),
            sums.subtract(first, second),
            second.clone(),
        ];
        let wanted = wanted.map(|rate| vec![(time.clone(), rate)]);
        let angles = lift(graph, ring, &wanted, x)?;
        let mut code = Code(graph);
        let m = code.components(&self.vectors[0], x);
        let mut turn = code.turn(&angles, &m, self.vectors.len() == 1);
        let mut increment = vec![code.0.zero(); x.len()];
        for (at, vector) in self.vectors.iter().enumerate() {
            if at == 1 {
                let about = code.turn_about(&angles[3], &m);
                turn = code.quaternion_product(&turn, &about);
            }
            let n = code.components(vector, x);
            let change = code.turned(&turn, &n);
            code.scatter(vector, &change, &mut increment);
        }
        Ok(increment)
    }

    /// Ω × n of every vector, 0 of the other coordinates.
    pub(crate) fn field(
        &self,
        graph: &mut Graph,
        ring: &Ring,
        x: &[Term],
    ) -> Result<Vec<Term>, AlgebraError> {
        let one = graph.one();
        let wanted = self
            .rates
            .each_ref()
            .map(|rate| vec![(one.clone(), rate.clone())]);
        let rates = lift(graph, ring, &wanted, x)?;
        let mut code = Code(graph);
        let m = code.components(&self.vectors[0], x);
        let omega = rates
            .iter()
            .zip(&m)
            .map(|(rate, m)| code.product(&[rate, m]));
        let omega: Vec<Term> = omega.collect();
        let mut field = vec![code.0.zero(); x.len()];
        for vector in &self.vectors {
            let n = code.components(vector, x);
            let change = code.cross(&omega, &n);
            code.scatter(vector, &change, &mut field);
        }
        Ok(field)
    }
}
