//! α_i = x_i exp(v_i(h)) with v_i = −½ Σ_j a_ij x_j p_j(h), coefficient by coefficient.

use leafwise_core::realization::{SourceRecursion, SourceSeriesIn};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{DifferentialAlgebra, Rational};

use crate::tensor::coefficients;

/// The rule of the exponential series: for g = x eᵛ, g₀ = x and k gₖ = Σ_{j=1..k} j vⱼ g_{k−j}.
#[derive(Clone, Debug)]
pub struct LogCanonicalSeries {
    system: SystemFormulas,
}

impl LogCanonicalSeries {
    /// The series for a system whose tensor is log-canonical.
    pub(crate) fn new(system: SystemFormulas) -> Self {
        Self { system }
    }
}

impl<A: DifferentialAlgebra> SourceSeriesIn<A> for LogCanonicalSeries {
    fn start(&self, algebra: &mut A) -> Result<Box<dyn SourceRecursion<A>>, BuildError> {
        let d = self.system.dimension();
        let mut pairs = Vec::new();
        let values = algebra.formed(d, |ring| {
            let found = coefficients(&self.system, ring)?;
            let (at, values): (Vec<_>, Vec<_>) = found.into_iter().unzip();
            pairs = at;
            Ok::<_, BuildError>(values)
        })?;
        let x = (0..d).map(|i| algebra.coordinate(i));
        Ok(Box::new(Recursion {
            coefficients: pairs.into_iter().zip(values).collect(),
            source: vec![x.collect()],
            exponents: Vec::new(),
        }))
    }
}

struct Recursion<E> {
    /// a_ij.
    coefficients: Vec<((usize, usize), E)>,
    /// g_0 … g_k.
    source: Vec<Vec<E>>,
    /// v_1 … v_k.
    exponents: Vec<Vec<E>>,
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursion<A::Element> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        let x = &self.source[0];
        let y: Vec<A::Element> = x
            .iter()
            .zip(&p)
            .map(|(x, p)| algebra.multiply(x, p))
            .collect();
        let half = Rational::new(1, 2);
        let mut rows = vec![Vec::new(); p.len()];
        for ((i, j), a) in &self.coefficients {
            rows[*i].push((-&half, algebra.multiply(a, &y[*j])));
            rows[*j].push((half.clone(), algebra.multiply(a, &y[*i])));
        }
        self.exponents
            .push(rows.iter().map(|row| algebra.combine(row)).collect());
        let k = self.exponents.len();
        let mut next = Vec::with_capacity(p.len());
        for i in 0..p.len() {
            let terms: Vec<_> = (1..=k)
                .map(|j| {
                    let (v, g) = (&self.exponents[j - 1][i], &self.source[k - j][i]);
                    (Rational::new(j as i64, k as i64), algebra.multiply(v, g))
                })
                .collect();
            next.push(algebra.combine(&terms));
        }
        self.source.push(next.clone());
        Ok(next)
    }
}
