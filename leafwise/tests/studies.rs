//! Claims about comparisons, examples, tuning, verification and lattices, a module each:
//! `cargo test --test studies compare`.

mod chain;
mod compare;
mod conformance;
mod examples;
mod fit;
mod lattice;
mod lattice_splitting;
mod operations;
mod scenes;
mod tune;
mod verify;
