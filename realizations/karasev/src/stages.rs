//! K̂_ε as sweeps over a lattice: one stage an order.

use leafwise_core::BuildError;
use leafwise_core::lattice::{StageBuilder, StageEnds};
use leafwise_core::realization::RealizationData;
use leafwise_expression::{Arithmetic, Rational, Term};

use crate::curve::KarasevCurve;
use crate::truncated::TruncatedKarasev;

impl TruncatedKarasev {
    /// Stage k computes Y_k from Y_0 … Y_{k−1} at neighbouring sites; the last one adds up
    /// α̂ − β̂ and β̂ − y at each site alone.
    pub(crate) fn write_stages(
        &self,
        builder: &mut StageBuilder,
        epsilon: &Term,
        y: &[Term],
        p: &[Term],
    ) -> Result<StageEnds, BuildError> {
        let d = self.dimension();
        let q: Vec<Term> = p
            .iter()
            .map(|p| builder.graph.multiply(epsilon, p))
            .collect();
        let zero = vec![builder.graph.zero(); d];
        let mut curve = KarasevCurve::new(self.system(), y)?;
        for k in 0..self.order() {
            curve.push(&mut builder.graph, if k == 0 { &q } else { &zero })?;
            let stored = store_curve(builder, curve.last());
            builder.finish_stage();
            curve.replace_last(stored);
        }
        let mut offset = Vec::with_capacity(d);
        let mut increment = Vec::with_capacity(d);
        let graph = &mut builder.graph;
        let alpha: Vec<Vec<Term>> = (0..=self.order()).map(|k| curve.source(graph, k)).collect();
        for i in 0..d {
            let (odd, even) = crate::truncated::odd_and_even(graph, &alpha, i);
            offset.push(graph.subtract(&even, &odd));
            increment.push(graph.scale(&Rational::from_integer(2), &odd));
        }
        Ok(StageEnds { offset, increment })
    }
}

/// Stores the coefficients of Y_k, one field for all those that are one function up to rational
/// factors (for a linear tensor, all of them).
fn store_curve(builder: &mut StageBuilder, curve: &[Vec<Term>]) -> Vec<Vec<Term>> {
    let powers = curve.iter().map(Vec::len).max().unwrap_or(0);
    let zero = builder.graph.zero();
    let column = |j: usize| -> Vec<Term> {
        curve
            .iter()
            .map(|c| c.get(j).cloned().unwrap_or_else(|| zero.clone()))
            .collect()
    };
    let mut stored: Vec<Vec<Term>> = vec![Vec::new(); curve.len()];
    let mut fields: Vec<(Vec<Term>, Vec<Term>)> = Vec::new();
    for j in 0..powers {
        let values = column(j);
        let code = if values.iter().all(|v| builder.graph.is_zero(v)) {
            values
        } else if let Some((ratio, known)) = fields
            .iter()
            .find_map(|(of, code)| Some((ratio(&values, of)?, code)))
        {
            known
                .iter()
                .map(|k| builder.graph.scale(&ratio, k))
                .collect()
        } else {
            let code = builder.store(values.clone());
            fields.push((values, code.clone()));
            code
        };
        for (all, term) in stored.iter_mut().zip(code) {
            all.push(term);
        }
    }
    stored
}

/// r with a = r·b in every component, if there is one.
fn ratio(a: &[Term], b: &[Term]) -> Option<Rational> {
    let mut ratio: Option<Rational> = None;
    for (a, b) in a.iter().zip(b) {
        if a.scale.is_zero() && b.scale.is_zero() {
            continue;
        }
        if a.node != b.node || a.scale.is_zero() || b.scale.is_zero() {
            return None;
        }
        let here = &a.scale * &b.scale.recip();
        if ratio.as_ref().is_some_and(|known| *known != here) {
            return None;
        }
        ratio = Some(here);
    }
    ratio
}
