//! Files and questions that give no equilibrium.

use leafwise_expression::table::TableError;
use thiserror::Error;

/// Reason why a g-file, or a start of ions in it, is none.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum EquilibriumError {
    /// A first line without the numbers of nodes.
    #[error(
        "the first line does not end with two whole numbers, the nodes along R and Z: is it a g-file of EFIT, such as `g123456.01000`?"
    )]
    Header,
    /// Fewer numbers than the first line tells of.
    #[error("the file ends in {name}: {found} of {needed} numbers")]
    Short {
        /// The quantity.
        name: &'static str,
        /// The numbers that are there.
        found: usize,
        /// The numbers that belong there.
        needed: usize,
    },
    /// A word in the place of a number.
    #[error("line {line}: `{word}` is not a number, and {name} needs one here")]
    Number {
        /// The quantity.
        name: &'static str,
        /// The line, from 1.
        line: usize,
        /// The word.
        word: String,
    },
    /// An entry of a file by names that is none.
    #[error("`{place}` is {found}, and must be {expected}")]
    Entry {
        /// Its name, with places in lists from 0.
        place: String,
        /// Its value, in words.
        found: String,
        /// The kind of value that belongs there.
        expected: &'static str,
    },
    /// Numbers that no equilibrium has.
    #[error("{0}")]
    Odd(String),
    /// F that is 0 at a node, or changes its sign after it.
    #[error(
        "F = R B_phi is {f} at the value {node} of {count}, at s = {surface}, and {next}: a field without a toroidal part has no such one-form",
        next = if *f == 0.0 { "must not be 0" } else { "changes its sign after it" }
    )]
    NoToroidalField {
        /// The number of the value, from 1 on the axis.
        node: usize,
        /// How many there are.
        count: usize,
        /// Its normalized flux.
        surface: f64,
        /// F there.
        f: f64,
    },
    /// A grid that makes no spline.
    #[error("the table of {name}: {error}")]
    Table {
        /// The table.
        name: &'static str,
        /// The reason.
        error: TableError,
    },
    /// A surface that is not closed about the axis within the grid.
    #[error(
        "the surface s = {surface} is not closed about the axis inside the grid: take one nearer to the axis, which has s = 0"
    )]
    Open {
        /// Its normalized flux.
        surface: f64,
    },
}
