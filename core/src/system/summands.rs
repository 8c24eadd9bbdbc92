//! The summands of a tensor that is a direct sum.

use leafwise_expression::Expression;

use super::{Convention, PoissonSystem, SystemFormulas};
use crate::error::BuildError;

impl SystemFormulas {
    /// The coordinates of each summand of the tensor, in the order of their first ones. An entry Π_ij joins i, j and the
    /// coordinates that it depends on. All constant entries together are one summand.
    pub fn summands(&self) -> Vec<Vec<usize>> {
        let d = self.dimension();
        let mut joined = Joined((0..d).collect());
        let mut varies = vec![false; d];
        for (&(i, j), entry) in self.tensor() {
            let variables = entry.variables();
            varies[i] |= !variables.is_empty();
            for other in variables.into_iter().chain([j]) {
                joined.join(i, other);
            }
        }
        let mut is_constant = vec![true; d];
        for at in (0..d).filter(|at| varies[*at]) {
            is_constant[joined.first(at)] = false;
        }
        let mut blocks: Vec<Vec<usize>> = Vec::new();
        // No coordinate has the index d: it stands for all that is constant.
        let mut known = vec![None; d + 1];
        for at in 0..d {
            let first = Some(joined.first(at)).filter(|first| !is_constant[*first]);
            let block = *known[first.unwrap_or(d)].get_or_insert(blocks.len());
            match blocks.get_mut(block) {
                Some(block) => block.push(at),
                None => blocks.push(vec![at]),
            }
        }
        blocks
    }

    /// The summand of these coordinates, in whose entries no others stand, with nothing that moves.
    ///
    /// # Errors
    /// Those of [`PoissonSystem::new`].
    pub fn summand(&self, block: &[usize]) -> Result<PoissonSystem, BuildError> {
        let of_block = |all: &[f64]| -> Vec<f64> { block.iter().map(|at| all[*at]).collect() };
        let mut own = vec![usize::MAX; self.dimension()];
        for (k, at) in block.iter().enumerate() {
            own[*at] = k;
        }
        let entries = self.tensor().iter();
        let entries = entries.filter(|((i, _), _)| own[*i] != usize::MAX);
        let names = block.iter().map(|at| self.variables()[*at].clone());
        let summand = PoissonSystem::new(
            names.collect(),
            self.parameters().to_vec(),
            entries.map(|((i, j), entry)| ((own[*i], own[*j]), entry.with_variables(&own))),
            Expression::from(0),
            Vec::new(),
            Convention::HamiltonianFirst,
        )?;
        summand.with_near(&of_block(self.near()))
    }
}

/// Of each coordinate one that is joined to it, the first of them all for the first one.
struct Joined(Vec<usize>);

impl Joined {
    /// The first coordinate that is joined to this one.
    fn first(&mut self, at: usize) -> usize {
        let mut first = at;
        while self.0[first] != first {
            first = self.0[first];
        }
        self.0[at] = first;
        first
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b)] = a.min(b);
    }
}
