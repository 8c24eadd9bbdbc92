//! Formulas that stand in several others.

use std::ops::Deref;
use std::sync::Arc;

use rustc_hash::FxHashMap;

/// A value that several formulas hold together: each of them evaluates it once, wherever and how often it stands
/// there.
#[derive(Clone, Debug)]
pub struct Shared<T> {
    value: Arc<T>,
    height: usize,
}

impl<T> Shared<T> {
    /// A value of so many levels of nesting.
    pub(crate) fn new(value: T, height: usize) -> Self {
        let value = Arc::new(value);
        Self { value, height }
    }

    /// The levels of nesting, those of shared values inside included.
    pub fn height(&self) -> usize {
        self.height
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// By value; what is one in memory is not looked into.
impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.value, &other.value) || self.value == other.value
    }
}

/// Results made of the shared values met so far, by their address, while these values live.
pub(crate) struct Known<T, U>(FxHashMap<*const T, U>);

impl<T, U> Default for Known<T, U> {
    fn default() -> Self {
        Self(FxHashMap::default())
    }
}

impl<T, U: Clone> Known<T, U> {
    pub(crate) fn get(&self, shared: &Shared<T>) -> Option<U> {
        self.0.get(&Arc::as_ptr(&shared.value)).cloned()
    }

    pub(crate) fn insert(&mut self, shared: &Shared<T>, made: U) -> Option<U> {
        self.0.insert(Arc::as_ptr(&shared.value), made)
    }
}

#[cfg(test)]
mod tests {
    use crate::algebra::Ring;
    use crate::arithmetic::Arithmetic;
    use crate::expression::Expression;
    use crate::graph::Graph;
    use crate::operators::Quantity;
    use crate::rational::Rational;

    /// x → 1 + x/2 + x²/8, forty times: 2⁴⁰ copies of x where nothing is shared.
    fn nested() -> Expression {
        (0..40).fold(Quantity::Variable(0).into(), |x: Expression, _| {
            let x = x.shared();
            1 + &x / 2 + &x * &x / 8
        })
    }

    #[test]
    fn what_is_shared_is_evaluated_once() {
        let formula = nested();
        let by_hand = (0..40).fold(0.25, |x: f64, _| 1.0 + x / 2.0 + x * x / 8.0);
        assert_eq!(formula.evaluate(&[0.25], &[]), by_hand);
        let mut graph = Graph::new();
        let code = formula.evaluate_in(&mut graph, &mut |graph, at| Ok(graph.input(at)));
        code.expect("code");
        // Each of the forty steps is a square and a sum.
        assert!(graph.len() <= 2 + 40 * 3, "{} nodes", graph.len());
        assert_eq!(formula.variables().into_iter().collect::<Vec<_>>(), [0]);
    }

    #[test]
    fn equal_formulas_are_equal_however_they_are_shared() {
        let sum = |at| (Quantity::Variable(at) + 1).shared();
        assert_eq!(sum(0), sum(0));
        assert_ne!(sum(0), sum(1));
        // 2⁴⁰ comparisons where what is one in memory were looked into.
        let once = nested();
        assert_eq!(once.clone(), once);
    }

    /// With numbers for the parameters it is shared as before, and the same in the ring.
    #[test]
    fn parameters_are_replaced_inside() {
        let half = (Quantity::Parameter(0) * Quantity::Variable(0)).shared();
        let formula = half.clone() * half;
        let fixed = formula.with_parameters(&[Rational::new(1, 2)]);
        assert_eq!(fixed.evaluate(&[6.0], &[]), 9.0);
        let mut ring = Ring::new(1);
        let in_ring = |ring: &mut Ring, formula: &Expression| {
            let value = formula.evaluate_in(ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)));
            value.expect("in the ring")
        };
        let value = in_ring(&mut ring, &fixed);
        let x = ring.variable(0);
        let square = ring.multiply(&x, &x);
        assert_eq!(value, ring.scale(&Rational::new(1, 4), &square));
    }

    #[test]
    fn heights_count_what_is_shared() {
        let x = Expression::from(Quantity::Variable(0));
        assert_eq!(x.clone().shared().height(), 0);
        let one = (x + 1).shared();
        assert_eq!(one.height(), 1);
        assert_eq!(one.sin().shared().height(), 2);
    }
}
