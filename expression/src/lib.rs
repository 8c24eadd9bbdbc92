//! Formulas, their exact algebra, and the straight-line code that evaluates them.
//!
//! - [`rational`]: exact rationals of arbitrary precision.
//! - [`syntax`]: scene formulas with byte spans, indexed families and typed errors.
//! - [`expression`]: resolved formulas over numbered variables and parameters.
//! - [`operators`]: formulas written in Rust.
//! - [`elementary`]: `libm`'s functions on many numbers at once, to the same bits.
//! - [`analytic`]: functions that a crate evaluates itself, with their derivatives.
//! - [`arithmetic`]: the operations a formula needs, over any algebra.
//! - [`bounded`]: formulas in double arithmetic, with a bound on what rounding does to them.
//! - [`algebra`]: the differential ring of Laurent polynomials with adjoined functions.
//! - [`differential`]: the ring and the code as algebras over the state's coordinates.
//! - [`shared`]: values that several formulas hold.
//! - [`series`]: Taylor coefficients of formulas along a curve, one order at a time.
//! - [`graph`]: straight-line code with shared nodes and exact derivatives.
//! - [`table`]: tables of numbers as functions, with all derivatives.
//! - [`kernel`]: coefficient kernel and step kernel, evaluated W lanes at a time.
//! - [`pairs`]: functions that are computed two at a time.
//! - [`vector`]: loops with the widest registers of a machine.
//! - [`words`]: numbers of things in words.

pub mod algebra;
pub mod analytic;
pub mod arithmetic;
pub mod bounded;
mod corners;
pub mod differential;
pub mod elementary;
mod evaluate;
mod even_powers;
pub mod expression;
mod function;
pub mod graph;
pub mod kernel;
mod magnitude;
pub mod operators;
pub mod pairs;
pub mod rational;
mod reach;
pub mod series;
pub mod shared;
mod slope;
pub mod special;
pub mod syntax;
pub mod table;
pub mod vector;
pub mod words;
mod written;

pub use algebra::{Polynomial, Ring};
pub use analytic::{AnalyticFunction, FunctionPair, Member};
pub use arithmetic::{AlgebraError, Arithmetic};
pub use differential::DifferentialAlgebra;
pub use evaluate::VariableIn;
pub use expression::{Binary, Expression, Function, Side};
pub use graph::{Graph, StepSize, Term};
pub use kernel::{
    Aligned, Distance, Execution, Kernel, MachineCodeSize, OperationCount, Passes, Workspace,
};
pub use operators::Quantity;
pub use rational::Rational;
pub use table::{Lookup, Outside, TableFunction};
