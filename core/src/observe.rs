//! Observables: functions of the state that a run watches.

/// Functions of the state that a run watches.
pub trait Observe: Send {
    /// How many.
    fn observables(&self) -> usize;
    /// Writes their values at a state.
    fn evaluate(&mut self, state: &[f64], values: &mut [f64]);
}
