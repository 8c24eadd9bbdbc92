//! Vector fields in exact algebra.

use std::collections::{BTreeMap, BTreeSet};

use leafwise_expression::{Polynomial, Ring};

/// The components X^j of a field; those that it does not have are zero.
pub type Field = BTreeMap<usize, Polynomial>;

/// The variables that f depends on, through its generators too.
pub(crate) fn variables(ring: &Ring, f: &Polynomial) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    for symbol in f.symbols() {
        match ring.generator(symbol) {
            None => drop(found.insert(symbol as usize)),
            Some(generator) => {
                let of_arguments = generator.arguments().map(|u| variables(ring, u));
                found.extend(of_arguments.flatten());
            }
        }
    }
    found
}
