//! Vector fields in exact algebra.

use std::collections::{BTreeMap, BTreeSet};

use leafwise_expression::{Polynomial, Ring};

/// The components X^j of a field; those that it does not have are zero.
pub type Field = BTreeMap<usize, Polynomial>;

/// The variables that f depends on, through its generators too.
pub(crate) fn variables(ring: &Ring, f: &Polynomial) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut open = f.symbols();
    let mut seen: BTreeSet<_> = open.iter().copied().collect();
    while let Some(symbol) = open.pop() {
        match ring.generator(symbol) {
            None => drop(found.insert(symbol as usize)),
            Some(generator) => {
                let inner = generator.arguments().flat_map(Polynomial::symbols);
                open.extend(inner.filter(|symbol| seen.insert(*symbol)));
            }
        }
    }
    found
}
