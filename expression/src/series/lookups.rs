//! Taylor coefficients of tables along a curve.

use rustc_hash::FxHashMap;

use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::rational::Rational;
use crate::table::Lookup;

/// The coefficients known so far of each table and derivative at a point, whose numbers are nodes of a tape.
#[derive(Clone, Debug)]
pub(super) struct LookupSeries<E>(FxHashMap<(Lookup, Vec<usize>), Vec<E>>);

impl<E> Default for LookupSeries<E> {
    fn default() -> Self {
        Self(FxHashMap::default())
    }
}

impl<E: Clone + std::fmt::Debug> LookupSeries<E> {
    /// The coefficient of order k of g = f(u₁, …, u_d): k gₖ = Σ_l Σ_{j=1..k} j u_{l,j} d_{l,k−j} with d_l = ∂_l f(u). Those of
    /// all nodes u are `nodes`.
    pub(super) fn coefficient<A: Arithmetic<Element = E>>(
        &mut self,
        arithmetic: &mut A,
        nodes: &[Vec<E>],
        (lookup, point): (Lookup, &[usize]),
        k: usize,
    ) -> Result<E, AlgebraError> {
        let key = (lookup, point.to_vec());
        loop {
            let known = self.0.get(&key).map_or(0, Vec::len);
            if known > k {
                return Ok(self.0[&key][k].clone());
            }
            let next = self.next(arithmetic, nodes, (lookup, point), known)?;
            self.0.entry(key.clone()).or_default().push(next);
        }
    }

    fn next<A: Arithmetic<Element = E>>(
        &mut self,
        arithmetic: &mut A,
        nodes: &[Vec<E>],
        (lookup, point): (Lookup, &[usize]),
        k: usize,
    ) -> Result<E, AlgebraError> {
        if k == 0 {
            let begins = point.iter().map(|u| nodes[*u][0].clone());
            return arithmetic.look_up(lookup, &begins.collect::<Vec<_>>());
        }
        let mut factors = Vec::new();
        for (axis, u) in point.iter().enumerate() {
            let Some(slope) = lookup.derivative(axis) else {
                continue;
            };
            for j in 1..=k {
                let u = nodes[*u][j].clone();
                if !arithmetic.is_zero(&u) {
                    let d = self.coefficient(arithmetic, nodes, (slope, point), k - j)?;
                    factors.push((Rational::new(j as i64, k as i64), u, d));
                }
            }
        }
        let products: Vec<_> = factors.iter().map(|(c, u, d)| (c.clone(), u, d)).collect();
        Ok(arithmetic.combine_products(&[], &products))
    }
}
