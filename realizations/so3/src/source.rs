//! The source map α = x − ½ moment + even, which the charts of T*SO(3) share.

use leafwise_core::lattice::StageEnds;
use leafwise_expression::{Arithmetic, Graph, Rational, Term};

/// Where T*SO(3) is treated.
pub(crate) const LITERATURE: &str = "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic \
                          Realizations, section 2; Marsden, Ratiu, Introduction to Mechanics and \
                          Symmetry, chapters 13 and 15";

/// α = x − ½ moment + even.
pub(crate) struct Source<E> {
    /// x × q.
    pub moment: Vec<E>,
    /// The part even in q, without x.
    pub even: Vec<E>,
}

impl<E: Clone> Source<E> {
    /// α.
    pub(crate) fn total<A: Arithmetic<Element = E>>(&self, algebra: &mut A, x: &[E]) -> Vec<E> {
        let mut component = |i: usize| {
            algebra.combine(&[
                (Rational::one(), x[i].clone()),
                (Rational::new(-1, 2), self.moment[i].clone()),
                (Rational::one(), self.even[i].clone()),
            ])
        };
        (0..3).map(&mut component).collect()
    }
}

impl Source<Term> {
    /// β − x = ½ moment + even and α − β = −moment. That the moment is one term of both keeps the Casimir |x|²:
    /// it is orthogonal to x + even, whatever the rounding of even.
    pub(crate) fn ends(&self, graph: &mut Graph) -> StageEnds {
        let half = Rational::new(1, 2);
        let parts = self.even.iter().zip(&self.moment);
        StageEnds {
            offset: parts
                .map(|(even, moment)| {
                    graph.combine(&[
                        (Rational::one(), even.clone()),
                        (half.clone(), moment.clone()),
                    ])
                })
                .collect(),
            increment: self.moment.iter().map(|w| graph.negate(w)).collect(),
        }
    }
}
