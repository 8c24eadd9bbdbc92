//! Where elements of the ring change from one piece to another.

use std::collections::BTreeSet;

use super::generator::Generator;
use super::polynomial::Polynomial;
use super::ring::Ring;
use crate::expression::Function;

impl Ring {
    /// The elements that decide of which piece of f a state is, those inside of arguments too. They are c of a choice by
    /// c > 0, and the arguments of magnitudes, signs, largest integers below and remainders.
    pub fn seams(&self, f: &Polynomial) -> Vec<Polynomial> {
        let mut seams: Vec<Polynomial> = Vec::new();
        let mut open = f.symbols();
        let mut seen: BTreeSet<_> = open.iter().copied().collect();
        while let Some(symbol) = open.pop() {
            let Some(generator) = self.generator(symbol) else {
                continue;
            };
            let deciding: Vec<&Polynomial> = match generator {
                Generator::Kept(_, c, _) => vec![c],
                Generator::Binary(function, u, v) if function.has_seams() => vec![u, v],
                Generator::Function(function, u)
                    if function.is_step() || *function == Function::Abs =>
                {
                    vec![u]
                }
                _ => Vec::new(),
            };
            for part in deciding {
                if !seams.contains(part) {
                    seams.push(part.clone());
                }
            }
            let inner = generator.arguments().flat_map(Polynomial::symbols);
            open.extend(inner.filter(|symbol| seen.insert(*symbol)));
        }
        seams
    }
}
