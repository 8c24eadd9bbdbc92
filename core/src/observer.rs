//! Observables: functions of the state that a run watches.

/// Functions f₁(x), …, f_n(x) of the state that a run watches, with room of their own.
pub struct Observer {
    count: usize,
    evaluate: Box<Evaluate>,
}

/// Writes the values at a state.
type Evaluate = dyn FnMut(&[f64], &mut [f64]) + Send;

impl Observer {
    /// n = `count` functions, whose values at a state `evaluate` writes.
    pub fn new(count: usize, evaluate: impl FnMut(&[f64], &mut [f64]) + Send + 'static) -> Self {
        Self {
            count,
            evaluate: Box::new(evaluate),
        }
    }

    /// n.
    pub fn observables(&self) -> usize {
        self.count
    }

    /// Writes their values at a state, n numbers.
    pub fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        (self.evaluate)(state, values);
    }
}
