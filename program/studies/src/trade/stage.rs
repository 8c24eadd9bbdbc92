//! How far a tuner has come.

/// Stage of a tuner, told before it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage<'a> {
    /// To build a method: forming series and code takes the longest for high orders.
    Building {
        /// The method.
        method: &'a str,
    },
    /// To compute the reference.
    Reference,
    /// To run a method.
    Running {
        /// The method.
        method: &'a str,
        /// The runs before.
        runs: u64,
    },
}
