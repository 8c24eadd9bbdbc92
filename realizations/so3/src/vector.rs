//! Cross and scalar products of three components over any algebra.

use leafwise_expression::{Arithmetic, Rational};

/// u × v.
pub fn cross<A: Arithmetic>(
    arithmetic: &mut A,
    u: &[A::Element],
    v: &[A::Element],
) -> Vec<A::Element> {
    let mut minor = |i: usize, j: usize| {
        let (a, b) = (
            arithmetic.multiply(&u[i], &v[j]),
            arithmetic.multiply(&u[j], &v[i]),
        );
        arithmetic.subtract(&a, &b)
    };
    vec![minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// u · v.
pub fn dot<A: Arithmetic>(arithmetic: &mut A, u: &[A::Element], v: &[A::Element]) -> A::Element {
    let products: Vec<_> = u
        .iter()
        .zip(v)
        .map(|(a, b)| (Rational::one(), arithmetic.multiply(a, b)))
        .collect();
    arithmetic.combine(&products)
}

/// c u.
pub fn times<A: Arithmetic>(
    arithmetic: &mut A,
    c: &A::Element,
    u: &[A::Element],
) -> Vec<A::Element> {
    u.iter().map(|u| arithmetic.multiply(c, u)).collect()
}
