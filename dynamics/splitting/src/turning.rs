//! Two vectors that turn about one axis, as two vortices on a sphere do.
//!
//! The motion is x′ = a y × x, y′ = b x × y with constants of the motion a and b. A Hamiltonian of x·y has such a motion in
//! the brackets of so(3), each multiplied by a number. The vector Ω = a y + b x is at rest. Both turn about it: x′ = Ω × x,
//! y′ = Ω × y. The flow is the rotation by |Ω|t about Ω. It keeps the lengths and x/a + y/b.
//!
//! Source: Newton, *The N-Vortex Problem* (2001), section 4.2.

use std::collections::BTreeSet;

use leafwise_expression::algebra::quotient;
use leafwise_expression::graph::lift;
use leafwise_expression::{AlgebraError, Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use crate::entire::{STUMPFF_1, STUMPFF_2};
use crate::field::Field;
use crate::flow::lie_derivative;
use crate::sums::Code;
use crate::tensor::Tensor;

/// Components of the second vector beside those of the first, which stand in the order of their coordinates.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// x′ = a y × x, y′ = b x × y.
#[derive(Clone, Debug)]
pub(crate) struct TurningPair {
    /// x and y by their coordinates.
    vectors: [[usize; 3]; 2],
    /// a and b.
    rates: [Polynomial; 2],
    /// The coordinates that its motion depends on.
    reads: BTreeSet<usize>,
}

impl TurningPair {
    /// The two vectors that a field moves, where it moves them so.
    ///
    /// # Errors
    /// [`AlgebraError`] where a derivative does not exist.
    pub(crate) fn find(
        ring: &mut Ring,
        tensor: &Tensor,
        field: &Field,
    ) -> Result<Option<Self>, AlgebraError> {
        let Some([first, second]) = vectors(tensor, field) else {
            return Ok(None);
        };
        for order in ORDERS {
            let vectors = [first, order.map(|k| second[k])];
            let [x, y] = vectors;
            let Some(a) = rate(ring, field, x, y) else {
                continue;
            };
            let Some(b) = rate(ring, field, y, x) else {
                continue;
            };
            let mut reads: BTreeSet<usize> = field.keys().copied().collect();
            for rate in [&a, &b] {
                let change = lie_derivative(ring, field, rate, &mut reads)?;
                if !change.is_zero() {
                    return Ok(None);
                }
            }
            let rates = [a, b];
            return Ok(Some(Self {
                vectors,
                rates,
                reads,
            }));
        }
        Ok(None)
    }

    /// The coordinates that it moves.
    fn moved(&self) -> impl Iterator<Item = usize> {
        self.vectors.iter().flatten().copied()
    }
}

/// Six moving coordinates as two vectors: those of one have brackets with each other.
fn vectors(tensor: &Tensor, field: &Field) -> Option<[[usize; 3]; 2]> {
    let moving: Vec<usize> = field.keys().copied().collect();
    let [first, ..] = moving[..] else { return None };
    let is_beside = |at: &usize| *at == first || tensor.are_joined(first, *at);
    let (own, others): (Vec<usize>, Vec<usize>) = moving.into_iter().partition(is_beside);
    Some([own.try_into().ok()?, others.try_into().ok()?])
}

/// a of x′ = a y × x.
fn rate(ring: &mut Ring, field: &Field, x: [usize; 3], y: [usize; 3]) -> Option<Polynomial> {
    let mut found: Option<Polynomial> = None;
    for k in 0..3 {
        let [own, other] = [(k + 1) % 3, (k + 2) % 3];
        let mut product = |at: [usize; 2]| {
            let [one, other] = at.map(|at| ring.variable(at));
            ring.multiply(&one, &other)
        };
        let parts = [product([y[own], x[other]]), product([y[other], x[own]])];
        let component = ring.subtract(&parts[0], &parts[1]);
        let rate = quotient(&field[&x[k]], &component)?;
        if *found.get_or_insert_with(|| rate.clone()) != rate {
            return None;
        }
    }
    found
}

/// Pairs of which none moves what another reads.
#[derive(Clone, Debug)]
pub(crate) struct TurningPairs(Vec<TurningPair>);

impl TurningPairs {
    pub(crate) fn of(pair: TurningPair) -> Self {
        Self(vec![pair])
    }

    /// Adds a pair that shares no coordinate with these; whether it does not.
    pub(crate) fn add(&mut self, pair: &TurningPair) -> bool {
        let is_apart = |own: &TurningPair| {
            let moves =
                |a: &TurningPair, b: &TurningPair| a.moved().any(|at| b.reads.contains(&at));
            !moves(own, pair) && !moves(pair, own)
        };
        let is_apart = self.0.iter().all(is_apart);
        if is_apart {
            self.0.push(pair.clone());
        }
        is_apart
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
        self.moves(graph, ring, time, x, |code, angle, vector| {
            let turn = code.quaternion_of(angle);
            code.turned(&turn, vector)
        })
    }

    /// Ω × x of every vector, 0 of the other coordinates.
    ///
    /// # Errors
    /// [`AlgebraError`] where a parameter's function has no code.
    pub(crate) fn field(
        &self,
        graph: &mut Graph,
        ring: &Ring,
        x: &[Term],
    ) -> Result<Vec<Term>, AlgebraError> {
        let one = graph.one();
        self.moves(graph, ring, &one, x, |code, omega, vector| {
            code.cross(omega, vector)
        })
    }

    /// The change of every vector by a rotation vector, Ω times `time`.
    fn moves(
        &self,
        graph: &mut Graph,
        ring: &Ring,
        time: &Term,
        x: &[Term],
        change: impl Fn(&mut Code<'_>, &[Term], &[Term; 3]) -> Vec<Term>,
    ) -> Result<Vec<Term>, AlgebraError> {
        let rates = self.0.iter().flat_map(|pair| &pair.rates);
        let wanted: Vec<_> = rates
            .map(|rate| vec![(time.clone(), rate.clone())])
            .collect();
        let rates = lift(graph, ring, &wanted, x)?;
        let mut moved = vec![graph.zero(); x.len()];
        let mut code = Code(graph);
        for (pair, rates) in self.0.iter().zip(rates.chunks_exact(2)) {
            let vectors = pair.vectors.map(|vector| vector.map(|at| x[at].clone()));
            let [one, other] = &vectors;
            let component =
                |k: usize| code.whole(&[(1, &[&rates[0], &other[k]]), (1, &[&rates[1], &one[k]])]);
            let omega: Vec<Term> = (0..3).map(component).collect();
            for (places, vector) in pair.vectors.iter().zip(&vectors) {
                let change = change(&mut code, &omega, vector);
                for (at, change) in places.iter().zip(change) {
                    moved[*at] = change;
                }
            }
        }
        Ok(moved)
    }
}

impl Code<'_> {
    /// (cos ½θ, sin ½θ q/θ) of the rotation by θ = |q| about q.
    fn quaternion_of(&mut self, q: &[Term]) -> Vec<Term> {
        let half = Rational::new(1, 2);
        let halves: Vec<Term> = q.iter().map(|q| self.0.scale(&half, q)).collect();
        let square = self.whole(&[
            (1, &[&halves[0], &halves[0]]),
            (1, &[&halves[1], &halves[1]]),
            (1, &[&halves[2], &halves[2]]),
        ]);
        let odd = self.0.apply_analytic(STUMPFF_1, 0, &square);
        let even = self.0.apply_analytic(STUMPFF_2, 0, &square);
        let one = self.0.one();
        let mut quaternion = vec![self.whole(&[(1, &[&one]), (-1, &[&square, &even])])];
        quaternion.extend(halves.iter().map(|half| self.whole(&[(1, &[&odd, half])])));
        quaternion
    }
}
