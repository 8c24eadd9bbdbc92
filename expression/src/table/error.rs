//! Errors of a table.

use thiserror::Error;

use super::axis::{HIGHEST_DEGREE, MOST_AXES};

/// Why numbers at nodes make no spline.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// No axis, or more than [`MOST_AXES`].
    #[error("a table has 1 to {MOST_AXES} axes, and this one has {count}")]
    Axes {
        /// How many there are.
        count: usize,
    },
    /// A degree that no table has.
    #[error("the degree {degree} is not one from 1 to {HIGHEST_DEGREE}")]
    Degree {
        /// The degree.
        degree: u8,
    },
    /// An axis that does not go up from its first node to the last.
    #[error(
        "the axis {name} runs from {first:?} to {last:?}: the first node must lie below the last"
    )]
    Ends {
        /// The axis.
        name: String,
        /// The first node.
        first: f64,
        /// The last one.
        last: f64,
    },
    /// Fewer nodes than a polynomial of the degree is determined by.
    #[error(
        "the axis {name} has {nodes} nodes, and the degree {degree} takes {} at least: take more{}",
        degree + 1, or_lower(*nodes)
    )]
    Nodes {
        /// The axis.
        name: String,
        /// Its nodes.
        nodes: usize,
        /// The degree.
        degree: u8,
    },
    /// Another number of values than nodes.
    #[error("{found} numbers, and the axes have {} nodes", written(shape))]
    Shape {
        /// The nodes along each axis.
        shape: Vec<usize>,
        /// The numbers.
        found: usize,
    },
    /// A value that is no number.
    #[error(
        "the value at the node {node:?}, counted from 0, is {value:?}: every value must be a finite number"
    )]
    NotFinite {
        /// The node's place along each axis.
        node: Vec<usize>,
        /// The value.
        value: f64,
    },
    /// The end of a period among its nodes.
    #[error(
        "the last of the {nodes} nodes of the periodic axis {name} has the values of the first: it is the end of the period, where the \
         first node stands again; leave it out, and take {} nodes",
        nodes - 1
    )]
    EndRepeated {
        /// The axis.
        name: String,
        /// Its nodes.
        nodes: usize,
    },
    /// More coefficients than are kept in memory.
    #[error("a table of {count} coefficients is larger than 2^26: take fewer nodes")]
    TooLarge {
        /// The coefficients.
        count: usize,
    },
    /// More tables than a program has numbers for.
    #[error("a program has at most 2^32 tables")]
    TooMany,
}

/// The highest odd degree for so many nodes, as advice.
fn or_lower(nodes: usize) -> String {
    match nodes.saturating_sub(1) {
        0 => String::new(),
        most => format!(", or degree = {}", most - (most + 1) % 2),
    }
}

/// `33 x 33`.
fn written(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    lengths.join(" x ")
}
