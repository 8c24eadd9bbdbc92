//! Which terms have nothing in common.

use super::node::{Graph, Node, Operation, Term, Tier};

impl Graph {
    /// The sets of groups that read a common number that changes with the inputs, directly or by way of other groups;
    /// groups by their places, in order. What reads constants, parameters and step sizes alone is a set of its own.
    pub fn coupled(&self, groups: &[Vec<Term>]) -> Vec<Vec<usize>> {
        let terms = groups.concat();
        let is_read = self.read_by(&terms);
        let changes = |node: Node| self.tier(node) == Tier::Step;
        let mut sets = Sets((0..self.len()).collect());
        for index in (0..self.len()).filter(|&index| is_read[index]) {
            let node = Node(index as u32);
            for operand in self.operands(node) {
                if changes(node) && changes(operand) {
                    sets.unite(index, operand.index());
                }
            }
        }
        let firsts: Vec<Option<usize>> = groups
            .iter()
            .map(|group| {
                let mut nodes = group.iter().map(|term| term.node).filter(|n| changes(*n));
                let first = nodes.next()?.index();
                nodes.for_each(|node| sets.unite(first, node.index()));
                Some(first)
            })
            .collect();
        let mut coupled: Vec<Vec<usize>> = Vec::new();
        // Of a root the place of its set.
        let mut known: Vec<Option<usize>> = vec![None; self.len()];
        for (at, first) in firsts.into_iter().enumerate() {
            let root = first.map(|first| sets.root(first));
            match root.and_then(|root| known[root]) {
                Some(place) => coupled[place].push(at),
                None => {
                    if let Some(root) = root {
                        known[root] = Some(coupled.len());
                    }
                    coupled.push(vec![at]);
                }
            }
        }
        coupled
    }

    /// The inputs that terms read, in order.
    pub fn inputs_read(&self, terms: &[Term]) -> Vec<usize> {
        let is_read = self.read_by(terms);
        let inputs = (0..self.len()).filter(|&index| is_read[index]);
        let inputs = inputs.filter_map(|index| match self.operation(Node(index as u32)) {
            Operation::Input(input) => Some(*input as usize),
            _ => None,
        });
        let mut inputs: Vec<usize> = inputs.collect();
        inputs.sort_unstable();
        inputs
    }
}

/// Disjoint sets: of each element one nearer to its set's root, which is its own.
struct Sets(Vec<usize>);

impl Sets {
    fn root(&mut self, mut at: usize) -> usize {
        while self.0[at] != at {
            self.0[at] = self.0[self.0[at]];
            at = self.0[at];
        }
        at
    }

    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::Graph;
    use crate::arithmetic::Arithmetic;

    #[test]
    fn groups_that_share_no_input_are_apart() {
        let mut graph = Graph::new();
        let x: Vec<_> = (0..5).map(|i| graph.input(i)).collect();
        let k = graph.parameter(0);
        // The parameter is common to all, and couples none.
        let scaled: Vec<_> = x.iter().map(|x| graph.multiply(&k, x)).collect();
        let joint = graph.multiply(&scaled[0], &scaled[3]);
        let sum = graph.add(&joint, &x[1]);
        let groups = [
            vec![joint],
            vec![scaled[1].clone()],
            vec![scaled[2].clone(), k.clone()],
            vec![x[3].clone()],
            vec![k],
            vec![scaled[4].clone()],
        ];
        let expected: [&[usize]; 5] = [&[0, 3], &[1], &[2], &[4], &[5]];
        assert_eq!(graph.coupled(&groups), expected);
        let by_sum = [groups.to_vec(), vec![vec![sum.clone()]]].concat();
        let expected: [&[usize]; 4] = [&[0, 1, 3, 6], &[2], &[4], &[5]];
        assert_eq!(graph.coupled(&by_sum), expected);
        assert_eq!(graph.inputs_read(&[sum]), [0, 1, 3]);
    }
}
