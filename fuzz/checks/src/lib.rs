//! Checks of the program on inputs made from bytes: the same for fuzzers and for property tests.
//!
//! Each module has a `check(bytes)` that panics nowhere and returns what went wrong, with the input:
//!
//! - [`formulas`]: values and gradients against dual numbers;
//! - [`kernels`]: interpreter, machine code and lanes, to the bit;
//!
//! They draw their inputs by
//!
//! - [`source`]: choices and numbers from bytes;
//! - [`tree`]: formulas; [`dual`]: their values and gradients with error bounds;

pub mod dual;
pub mod formulas;
pub mod kernels;
pub mod source;
pub mod tree;

/// How far an input came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The program refused it with a typed error, or nothing in it can be compared.
    Refusal,
    /// Results were compared.
    Comparison,
}
