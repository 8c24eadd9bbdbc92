//! Fields of Hamiltonians in exact algebra.

use std::collections::BTreeMap;

use leafwise_core::SystemFormulas;
use leafwise_expression::algebra::Monomial;
use leafwise_expression::{AlgebraError, Arithmetic, Polynomial, Rational, Ring};

use crate::field::{Field, variables};

/// The tensor in exact algebra, by rows.
pub(crate) struct Tensor {
    /// For each j, the i with Π_ij ≠ 0 and that entry.
    columns: Vec<Vec<(usize, Polynomial)>>,
}

impl Tensor {
    pub(crate) fn new(system: &SystemFormulas, ring: &mut Ring) -> Result<Self, AlgebraError> {
        let mut columns = vec![Vec::new(); system.dimension()];
        for (&(i, j), formula) in system.tensor() {
            let entry =
                formula.evaluate_in(ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)))?;
            if !entry.is_zero() {
                columns[i].push((j, ring.negate(&entry)));
                columns[j].push((i, entry));
            }
        }
        Ok(Self { columns })
    }

    /// Whether two coordinates have a bracket.
    pub(crate) fn are_joined(&self, one: usize, other: usize) -> bool {
        self.columns[one].iter().any(|(at, _)| *at == other)
    }

    /// Whether a coordinate commutes with all others: nothing moves it.
    pub(crate) fn rests(&self, at: usize) -> bool {
        self.columns[at].is_empty()
    }

    /// A monomial as a product of what rests, and of what may move.
    pub(crate) fn parted(&self, ring: &Ring, monomial: &Monomial) -> (Monomial, Monomial) {
        let (mut resting, mut moving) = (Monomial::one(), Monomial::one());
        for (symbol, exponent) in monomial.factors() {
            let own = Polynomial::symbol(*symbol);
            let rests = variables(ring, &own).iter().all(|at| self.rests(*at));
            let part = if rests { &mut resting } else { &mut moving };
            *part = part.shifted(*symbol, *exponent);
        }
        (resting, moving)
    }

    /// X_K = −Π∇K, the components that are not zero.
    pub(crate) fn field(
        &self,
        ring: &mut Ring,
        hamiltonian: &Polynomial,
    ) -> Result<Field, AlgebraError> {
        let mut parts = BTreeMap::<usize, Vec<(Rational, Polynomial)>>::new();
        for j in variables(ring, hamiltonian) {
            let derivative = ring.derivative(hamiltonian, j)?;
            for (i, entry) in &self.columns[j] {
                let product = ring.multiply(entry, &derivative);
                parts
                    .entry(*i)
                    .or_default()
                    .push((-Rational::one(), product));
            }
        }
        let sums = parts
            .into_iter()
            .map(|(i, parts)| (i, ring.combine(&parts)));
        Ok(sums.filter(|(_, sum)| !sum.is_zero()).collect())
    }
}
