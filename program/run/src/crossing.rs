//! Where a run in memory crosses a surface.

/// The time and the state of a crossing.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// The time.
    pub time: f64,
    /// The scene's own coordinates.
    pub state: Vec<f64>,
}
