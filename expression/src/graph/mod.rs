//! Straight-line code as a graph: shared nodes, exact constants, exact derivatives.

mod cancel;
mod coupled;
mod denominators;
mod derivative;
mod factor;
mod formula;
mod gradient;
mod import;
mod lift;
mod lookups;
mod node;
mod normal_form;
mod summands;

pub use lift::lift;
pub use node::{Graph, Node, Operation, StepSize, Term, Tier};
