//! Axes of tables, and what they may be.

/// The most variables of a table.
pub const MOST_AXES: usize = 3;

/// The greatest degree of a table's polynomials.
pub const HIGHEST_DEGREE: u8 = 9;

/// The degree of a table's polynomials where none is told.
pub const USUAL_DEGREE: u8 = 5;

/// One variable of a table: the place of its nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct TableAxis {
    /// The variable's name.
    pub name: String,
    /// The first node.
    pub first: f64,
    /// The last node; of a periodic axis the end of the period, where the first node stands again.
    pub last: f64,
    /// The nodes, those at both ends included.
    pub nodes: usize,
    /// Whether it goes on from its last node to the first.
    pub is_periodic: bool,
}
