//! Orders that seams and tables leave to a method.

use std::collections::BTreeMap;

use leafwise_expression::Expression;

use super::SystemFormulas;

/// A table in a system's formulas: its degree k, and the derivatives that the motion takes of it.
///
/// A step across a cell's side is of order k − o, o derivatives later, since the next derivative jumps there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableUse {
    /// Its name in the formulas.
    pub name: &'static str,
    /// k.
    pub degree: usize,
    /// o.
    pub derivatives: usize,
}

impl TableUse {
    /// k − o: the order of a step from cell to cell; 0 where nothing is left.
    pub fn order(&self) -> usize {
        self.degree.saturating_sub(self.derivatives)
    }
}

impl SystemFormulas {
    /// The tables of H, the tensor and the forces, each with the most derivatives that the motion takes of it.
    ///
    /// It takes one of H and none of the others, beside those that the formulas name.
    pub fn table_uses(&self) -> Vec<TableUse> {
        let mut uses: BTreeMap<&'static str, TableUse> = BTreeMap::new();
        let hamiltonian = std::iter::once((self.hamiltonian(), 1));
        let entries = self.tensor().values().map(|entry| (entry, 0));
        let forces = self.forces().formulas().map(|force| (force, 0));
        for (formula, taken) in hamiltonian.chain(entries).chain(forces) {
            take(&mut uses, formula, taken);
        }
        uses.into_values().collect()
    }

    /// The order that a step across seams and sides of cells may be reduced to; `None` where every formula is smooth.
    ///
    /// It is 0 at a seam of `abs`, `if`, `min`, `max`, `mod` or `floor`, and the least [`TableUse::order`] of tables.
    pub fn smooth_order(&self) -> Option<usize> {
        if self.has_seams() {
            return Some(0);
        }
        self.table_uses().iter().map(TableUse::order).min()
    }
}

/// Counts the lookups of one formula, of which the motion takes `taken` derivatives.
fn take(uses: &mut BTreeMap<&'static str, TableUse>, formula: &Expression, taken: usize) {
    for lookup in formula.lookups() {
        let highest = lookup.orders().iter().copied().max().unwrap_or(0);
        let derivatives = (usize::from(highest) + taken).saturating_sub(1);
        let name = lookup.table().name();
        let found = uses.entry(name).or_insert(TableUse {
            name,
            degree: usize::from(lookup.table().degree()),
            derivatives,
        });
        found.derivatives = found.derivatives.max(derivatives);
    }
}
