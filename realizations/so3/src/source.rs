//! What the charts of T*SO(3) share.

use leafwise_expression::{Arithmetic, Rational};

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
