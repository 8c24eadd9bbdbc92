//! Sums of products as straight-line code.

use leafwise_expression::{AnalyticFunction, Arithmetic, Function, Graph, Rational, Term};

/// 0 where |s| ≤ 1, else NaN, which refuses the step.
pub(crate) const WITHIN: AnalyticFunction = AnalyticFunction::new("splitting-within", |_, s| {
    if s.abs() <= 1.0 { 0.0 } else { f64::NAN }
});

/// Straight-line code that is being written.
pub(crate) struct Code<'a>(pub(crate) &'a mut Graph);

impl Code<'_> {
    pub(crate) fn product(&mut self, factors: &[&Term]) -> Term {
        let [first, rest @ ..] = factors else {
            return self.0.one();
        };
        rest.iter().fold((*first).clone(), |product, factor| {
            self.0.multiply(&product, factor)
        })
    }

    /// Σ c Π over the factors.
    pub(crate) fn sum(&mut self, terms: &[(i64, &[&Term])]) -> Term {
        let products = terms
            .iter()
            .map(|(c, factors)| (Rational::from_integer(*c), self.product(factors)));
        let products: Vec<_> = products.collect();
        self.0.combine(&products)
    }

    /// The same as one node.
    pub(crate) fn whole(&mut self, terms: &[(i64, &[&Term])]) -> Term {
        let sum = self.sum(terms);
        self.0.whole(&sum)
    }

    pub(crate) fn function(&mut self, function: Function, argument: &Term) -> Term {
        self.0
            .apply(function, argument)
            .expect("its argument depends on the state")
    }

    pub(crate) fn reciprocal(&mut self, below: &Term) -> Term {
        let one = self.0.one();
        self.0.divide(&one, below).expect("it is 1 at t = 0")
    }

    /// Σ_k cₖ zᵏ.
    pub(crate) fn horner(&mut self, coefficients: &[Term], z: &Term) -> Term {
        let zero = self.0.zero();
        coefficients
            .iter()
            .rev()
            .fold(zero, |sum, c| self.sum(&[(1, &[&sum, z]), (1, &[c])]))
    }
}
