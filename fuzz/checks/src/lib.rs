//! Checks of the program on inputs made from bytes: the same for fuzzers and for property tests.
//!
//! Each of these modules has a `check(bytes)` that returns the failure, with the input:
//!
//! - [`formulas`]: values and gradients against dual numbers;
//! - [`kernels`]: interpreter, machine code and lanes, to the bit;
//! - [`documents`]: scene texts, arbitrary and mutated;
//! - [`scenes`]: random scenes take a few steps;
//! - [`lattices`]: long lattices, against the same written out site by site;
//! - [`states`]: files of initial states;
//! - [`resumed`]: an interrupted run with one file changed.
//!
//! They draw their inputs by
//!
//! - [`source`]: choices and numbers from bytes;
//! - [`tree`]: formulas; [`dual`]: their values and gradients with error bounds;
//! - [`tensor`], [`method`], [`scene`]: brackets, methods and whole scenes.
//!
//! The function [`judge`](judge::judge) tells whether the result of a random scene is right, by the independent
//! solution of [`mod@reference`].

use std::sync::Mutex;

pub mod documents;
pub mod dual;
pub mod formulas;
pub mod judge;
pub mod kernels;
pub mod lattices;
pub mod method;
pub mod reference;
pub mod resumed;
pub mod scene;
pub mod scenes;
pub mod source;
pub mod states;
pub mod tensor;
pub mod tree;

/// How far an input came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The program refused it with a typed error, or nothing in it can be compared.
    Refusal,
    /// Results were compared.
    Comparison,
}

/// Held by whoever sets how kernels run in the whole process.
static EXECUTION: Mutex<()> = Mutex::new(());

/// Systems of more coordinates than this take long to build for their size alone.
const LARGEST: usize = 400;
