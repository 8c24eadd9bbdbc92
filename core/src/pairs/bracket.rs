//! The tensor of one site, applied to a covector.

use leafwise_expression::{Arithmetic, Expression, Graph, Term};

use super::BodyShape;
use super::function::BodyFunction;
use crate::error::BuildError;

/// The parts of a system of bodies that move it: H, and the tensor of one site.
pub(super) struct BodyMotion<'a> {
    pub(super) shape: &'a BodyShape,
    /// The number of parameters.
    pub(super) parameters: usize,
    /// Π_ab, a < b.
    pub(super) bracket: &'a [((usize, usize), Expression)],
    pub(super) hamiltonian: &'a BodyFunction,
}

/// (Πv)_a for each family with an entry of these, or −Πv.
pub(super) fn applied(
    entries: &[((usize, usize), Expression)],
    graph: &mut Graph,
    x: &[Term],
    v: &[Term],
    is_negative: bool,
) -> Result<Vec<(usize, Term)>, BuildError> {
    let mut results: Vec<(usize, Term)> = Vec::new();
    let mut add = |graph: &mut Graph, family: usize, term: Term| match results
        .iter_mut()
        .find(|(own, _)| *own == family)
    {
        Some((_, sum)) => *sum = graph.add(sum, &term),
        None => results.push((family, term)),
    };
    for ((a, b), entry) in entries {
        let entry = entry.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))?;
        let entry = if is_negative {
            graph.negate(&entry)
        } else {
            entry
        };
        let row = graph.multiply(&entry, &v[*b]);
        add(graph, *a, row);
        let row = graph.multiply(&entry, &v[*a]);
        let row = graph.negate(&row);
        add(graph, *b, row);
    }
    Ok(results)
}
