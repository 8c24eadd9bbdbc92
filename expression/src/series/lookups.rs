//! Taylor coefficients of tables along a curve.

use rustc_hash::FxHashMap;

use super::tape::{TapeIndex, TaylorState};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::rational::Rational;
use crate::table::Lookup;

/// The coefficients known so far of each table and derivative at a point of the tape.
pub(super) type Lookups<E> = FxHashMap<(Lookup, Vec<TapeIndex>), Vec<E>>;

impl<E: Clone + std::fmt::Debug> TaylorState<E> {
    /// The coefficient of order k of g = f(u₁, …, u_d): k gₖ = Σ_l Σ_{j=1..k} j u_{l,j} d_{l,k−j} with d_l = ∂_l f(u).
    pub(super) fn look_up<A: Arithmetic<Element = E>>(
        &mut self,
        arithmetic: &mut A,
        lookup: Lookup,
        point: &[TapeIndex],
        k: usize,
    ) -> Result<E, AlgebraError> {
        let key = (lookup, point.to_vec());
        loop {
            let known = self.lookups.get(&key).map_or(0, Vec::len);
            if known > k {
                return Ok(self.lookups[&key][k].clone());
            }
            let next = self.next_of(arithmetic, lookup, point, known)?;
            self.lookups.entry(key.clone()).or_default().push(next);
        }
    }

    fn next_of<A: Arithmetic<Element = E>>(
        &mut self,
        arithmetic: &mut A,
        lookup: Lookup,
        point: &[TapeIndex],
        k: usize,
    ) -> Result<E, AlgebraError> {
        if k == 0 {
            let begins = point.iter().map(|u| self.coefficients[*u][0].clone());
            return arithmetic.look_up(lookup, &begins.collect::<Vec<_>>());
        }
        let mut factors = Vec::new();
        for (axis, u) in point.iter().enumerate() {
            let Some(slope) = lookup.derivative(axis) else {
                continue;
            };
            for j in 1..=k {
                let u = self.coefficients[*u][j].clone();
                if !arithmetic.is_zero(&u) {
                    let d = self.look_up(arithmetic, slope, point, k - j)?;
                    factors.push((Rational::new(j as i64, k as i64), u, d));
                }
            }
        }
        let products: Vec<_> = factors.iter().map(|(c, u, d)| (c.clone(), u, d)).collect();
        Ok(arithmetic.combine_products(&[], &products))
    }
}
