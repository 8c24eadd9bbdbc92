//! Differences from a summand.

use std::collections::BTreeSet;

use super::node::{Graph, Node, Operation, Term};
use crate::rational::Rational;

impl Graph {
    /// a − b as a list of summands, b taken out of the sums that it stands in. Of x + u and x the list adds up to u,
    /// without the rounding of x + u.
    pub fn summands_beside(&self, a: &Term, b: &Term) -> Vec<(Rational, Term)> {
        let mut open = vec![(a.scale.clone(), a.node)];
        let mut found = vec![(-Rational::one(), b.clone())];
        while let Some((scale, node)) = open.pop() {
            match self.operation(node) {
                Operation::Sum(terms) if self.has_summand(node, b.node) => {
                    open.extend(terms.iter().map(|(factor, part)| (&scale * factor, *part)));
                }
                _ => found.push((scale, Term::of(node))),
            }
        }
        found
    }

    fn has_summand(&self, sum: Node, wanted: Node) -> bool {
        let (mut open, mut met) = (vec![sum], BTreeSet::new());
        while let Some(node) = open.pop() {
            if node == wanted {
                return true;
            }
            if let Operation::Sum(terms) = self.operation(node) {
                open.extend(
                    terms
                        .iter()
                        .map(|(_, part)| *part)
                        .filter(|part| met.insert(*part)),
                );
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Arithmetic;

    #[test]
    fn what_two_sums_share_drops_out() {
        let mut graph = Graph::new();
        let [x, u, v] = [0, 1, 2].map(|at| graph.input(at));
        let inner = graph.add(&u, &x);
        let product = graph.multiply(&inner, &v);
        let nested = graph.subtract(&inner, &v);
        for (sum, expected) in [
            (inner.clone(), u.clone()),
            (nested, graph.subtract(&u, &v)),
            (graph.add(&x, &product), product.clone()),
            (product.clone(), graph.subtract(&product, &x)),
            (x.clone(), graph.zero()),
        ] {
            let summands = graph.summands_beside(&sum, &x);
            assert_eq!(graph.combine(&summands), expected);
        }
    }
}
