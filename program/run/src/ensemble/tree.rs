//! Reductions over a fixed tree of members, whatever they are taken in by.
//!
//! Leaves are 64 members each, by number; a node of level l covers 2ˡ leaves, the first of them a multiple of 2ˡ, and
//! is its two halves joined. Sums over members are thus formed in an order that depends on their number alone. One
//! process, and any number of shards whose bounds are multiples of 64, reduce them to the same bits.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::statistics::{Reductions, Shape};

/// Members of a leaf.
pub(super) const LEAF: u64 = 64;

/// Joined leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Node {
    /// The first leaf, a multiple of 2^`level`.
    first: u64,
    level: u32,
    reductions: Reductions,
}

impl Node {
    fn leaves(&self) -> Range<u64> {
        self.first..self.first + (1 << self.level)
    }

    /// Whether the two are halves of one node.
    fn is_left_of(&self, other: &Self) -> bool {
        let is_left = (self.first >> self.level).is_multiple_of(2);
        is_left && self.level == other.level && self.leaves().end == other.first
    }
}

/// The members from a multiple of 64 on, as the largest nodes that they fill and a leaf that is being filled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Tree {
    shape: Shape,
    /// The first member.
    first: u64,
    nodes: Vec<Node>,
    filling: Reductions,
}

impl Tree {
    /// No member yet, of those from `first` on.
    pub fn new(shape: Shape, first: u64) -> Self {
        debug_assert!(first.is_multiple_of(LEAF));
        Self {
            shape,
            first,
            nodes: Vec::new(),
            filling: Reductions::new(shape),
        }
    }

    /// Shape of the reductions that it holds.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The member that is taken in next.
    pub fn next(&self) -> u64 {
        let leaves = self.nodes.last().map(|node| node.leaves().end);
        leaves.map_or(self.first, |leaves| leaves * LEAF) + self.filling.members
    }

    /// The members taken in.
    pub fn members(&self) -> Range<u64> {
        self.first..self.next()
    }

    /// Takes the next member in.
    pub fn take(&mut self, member: impl FnOnce(&mut Reductions)) {
        member(&mut self.filling);
        self.filling.members += 1;
        if self.filling.members == LEAF {
            let first = self.next() / LEAF - 1;
            let reductions = std::mem::replace(&mut self.filling, Reductions::new(self.shape));
            self.push(Node {
                first,
                level: 0,
                reductions,
            });
        }
    }

    /// Adds what does not depend on the order of members.
    pub fn add_work(&mut self, work: leafwise_core::SolverStatistics) {
        self.filling.add_work(work);
    }

    fn push(&mut self, mut node: Node) {
        while let Some(left) = self.nodes.pop_if(|left| left.is_left_of(&node)) {
            let mut joined = left;
            joined.reductions.join(node.reductions);
            joined.level += 1;
            node = joined;
        }
        self.nodes.push(node);
    }

    /// Takes in the members that follow, of another tree of the same ensemble.
    ///
    /// # Panics
    /// When they do not follow.
    pub fn append(&mut self, other: Self) {
        assert_eq!(self.next(), other.first, "members follow one another");
        assert_eq!(self.filling.members, 0, "a shard ends with a whole leaf");
        for node in other.nodes {
            self.push(node);
        }
        self.filling.join(other.filling);
    }

    /// The largest deviation of the first invariant.
    pub fn largest_deviation(&self) -> f64 {
        let nodes = self.nodes.iter().map(|node| &node.reductions);
        let all = nodes.chain([&self.filling]);
        let largest = all.filter_map(|reductions| reductions.whole.first());
        largest.map(|whole| whole.maximum).fold(0.0, f64::max)
    }

    /// All members: the nodes joined from the last one on.
    pub fn total(&self) -> Reductions {
        let nodes = self.nodes.iter().rev();
        nodes.fold(self.filling.clone(), |right, node| {
            let mut left = node.reductions.clone();
            left.join(right);
            left
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SHAPE: Shape = Shape {
        times: 1,
        observables: 1,
        windows: 1,
        invariants: 1,
        has_quantiles: true,
        losses: 2,
    };

    /// The members of a range, each with numbers of its own.
    fn tree(members: Range<u64>) -> Tree {
        let mut tree = Tree::new(SHAPE, members.start);
        for member in members {
            tree.take(|into| {
                let value = libm::sin(member as f64 * 0.7) / 3.0;
                into.summaries[0].push(value, member);
                into.windows[0].push(value.abs(), member);
                into.whole[0].push(value.abs(), member);
                into.initial[0].push(value, member);
                if member % 7 == 0 {
                    into.stopped += 1;
                    into.losses[1] += 1;
                }
            });
        }
        tree
    }

    #[test]
    fn nodes_are_the_binary_digits_of_the_leaves() {
        let tree = tree(0..64 * 13 + 5);
        let levels: Vec<u32> = tree.nodes.iter().map(|node| node.level).collect();
        assert_eq!(levels, [3, 2, 0]);
        assert_eq!((tree.filling.members, tree.next()), (5, 64 * 13 + 5));
        let total = tree.total();
        assert_eq!(total.members, tree.next());
        assert_eq!(total.stopped, total.members.div_ceil(7));
        assert_eq!(total.losses, [0, total.stopped]);
    }

    /// Moments against sums in another order, by the mathematics of both.
    #[test]
    fn moments_are_those_of_all_members() {
        let count = 5000;
        let total = tree(0..count).total();
        let values: Vec<f64> = (0..count)
            .map(|member| libm::sin(member as f64 * 0.7) / 3.0)
            .collect();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let summary = &total.summaries[0];
        // 5000 additions of numbers below 1/3.
        assert!((summary.mean - mean).abs() < 5000.0 * f64::EPSILON);
        assert!((summary.squares / squares - 1.0).abs() < 5000.0 * f64::EPSILON);
        assert_eq!(
            summary.maximum.0,
            values.iter().copied().fold(-1.0, f64::max)
        );
        let first = values.iter().position(|v| *v == summary.maximum.0);
        assert_eq!(Some(summary.maximum.1 as usize), first);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 48, ..ProptestConfig::default() })]

        /// However members are cut into shards, every bit is that of one process.
        #[test]
        fn shards_join_to_the_bits_of_one_process(
            members in 0_u64..6000,
            mut bounds in prop::collection::vec(0_u64..94, 0..9),
        ) {
            bounds.retain(|bound| bound * LEAF < members);
            bounds.sort_unstable();
            bounds.dedup();
            let whole = tree(0..members);
            let mut joined = Tree::new(SHAPE, 0);
            let ends = bounds.iter().map(|bound| bound * LEAF).chain([members]);
            for end in ends {
                joined.append(tree(joined.next()..end));
            }
            prop_assert_eq!(joined.total(), whole.total());
            prop_assert_eq!(joined, whole);
        }
    }
}
