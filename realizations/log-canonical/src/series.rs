//! α_i = x_i exp(v_i(h)) with v_i = −½ Σ_j a_ij x_j p_j(h), coefficient by coefficient.

use leafwise_core::realization::{SourceRecursion, SourceSeries};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};

use crate::realization::Coefficients;

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

impl SourceSeries for LogCanonicalSeries {
    fn start(&self, ring: &mut Ring) -> Result<Box<dyn SourceRecursion>, BuildError> {
        let coefficients = crate::realization::coefficients(&self.system, ring)?;
        let x = (0..self.system.dimension()).map(|i| ring.variable(i));
        Ok(Box::new(Recursion {
            coefficients,
            source: vec![x.collect()],
            exponents: Vec::new(),
        }))
    }
}

struct Recursion {
    coefficients: Coefficients,
    /// g_0 … g_k.
    source: Vec<Vec<Polynomial>>,
    /// v_1 … v_k.
    exponents: Vec<Vec<Polynomial>>,
}

impl SourceRecursion for Recursion {
    fn push(&mut self, ring: &mut Ring, p: Vec<Polynomial>) -> Result<Vec<Polynomial>, BuildError> {
        let x = &self.source[0];
        let y: Vec<Polynomial> = x.iter().zip(&p).map(|(x, p)| ring.multiply(x, p)).collect();
        let half = Rational::new(1, 2);
        let mut rows = vec![Vec::new(); p.len()];
        for ((i, j), a) in &self.coefficients {
            rows[*i].push((-&half, ring.multiply(a, &y[*j])));
            rows[*j].push((half.clone(), ring.multiply(a, &y[*i])));
        }
        self.exponents
            .push(rows.iter().map(|row| ring.combine(row)).collect());
        let k = self.exponents.len();
        let mut next = Vec::with_capacity(p.len());
        for i in 0..p.len() {
            let terms: Vec<_> = (1..=k)
                .map(|j| {
                    let (v, g) = (&self.exponents[j - 1][i], &self.source[k - j][i]);
                    (Rational::new(j as i64, k as i64), ring.multiply(v, g))
                })
                .collect();
            next.push(ring.combine(&terms));
        }
        self.source.push(next.clone());
        Ok(next)
    }
}
