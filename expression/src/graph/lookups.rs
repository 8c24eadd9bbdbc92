//! Tables in straight-line code.

use super::node::{Graph, Node, Operation, Term};
use crate::table::TableFunction;

impl Graph {
    /// The tables that terms call, each with the points at which they do, in the order of the code.
    pub fn lookups(&self, terms: &[Term]) -> Vec<(TableFunction, Vec<Term>)> {
        let is_read = self.read_by(terms);
        let mut found: Vec<(TableFunction, Vec<Term>)> = Vec::new();
        for index in (0..self.len()).filter(|&index| is_read[index]) {
            if let Operation::Lookup(lookup, point) = self.operation(Node(index as u32)) {
                let point = point.iter().copied().map(Term::of).collect();
                let own = (lookup.table(), point);
                if !found.contains(&own) {
                    found.push(own);
                }
            }
        }
        found
    }
}
