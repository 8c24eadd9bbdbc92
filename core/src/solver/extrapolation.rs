//! Where to start a solve: polynomial extrapolation of earlier solutions.

/// Backward differences of the displacements y_k − x_k of one lane.
///
/// The predictor of order q is Σ_{j<q} ∇ʲd_k; ∇^q d_k is its error one step ago, so the order with
/// the smallest one is taken.
#[derive(Clone, Debug)]
pub struct Extrapolation {
    dimension: usize,
    /// ∇⁰d_k, ∇¹d_k, …, d numbers each.
    differences: Vec<f64>,
    filled: usize,
}

/// Differences kept: predictors up to this order.
const DEPTH: usize = 7;

impl Extrapolation {
    /// No history.
    pub fn new(dimension: usize) -> Self {
        Self {
            dimension,
            differences: vec![0.0; dimension * DEPTH],
            filled: 0,
        }
    }

    /// Forgets the history.
    pub fn clear(&mut self) {
        self.filled = 0;
        self.differences.fill(0.0);
    }

    /// Writes the predicted displacement of the next step, 0 without history.
    pub fn predict(&self, displacement: &mut [f64]) {
        displacement.fill(0.0);
        if self.filled == 0 {
            return;
        }
        let d = self.dimension;
        let size = |j: usize| {
            self.differences[j * d..][..d]
                .iter()
                .fold(0.0_f64, |m, v| m.max(v.abs()))
        };
        let mut order = 1;
        let mut smallest = f64::INFINITY;
        for candidate in 1..self.filled {
            let error = size(candidate);
            if error < smallest {
                smallest = error;
                order = candidate;
            }
        }
        for j in 0..order {
            for (value, difference) in displacement.iter_mut().zip(&self.differences[j * d..]) {
                *value += difference;
            }
        }
    }

    /// Records the displacement of a step that was taken.
    pub fn record(&mut self, displacement: &[f64]) {
        let d = self.dimension;
        for (i, &value) in displacement.iter().enumerate() {
            let mut carried = value;
            for j in 0..DEPTH.min(self.filled + 1) {
                let slot = &mut self.differences[j * d + i];
                let next = carried - *slot;
                *slot = carried;
                carried = next;
            }
        }
        self.filled = DEPTH.min(self.filled + 1);
    }

    /// The history as numbers.
    pub fn memory(&self, into: &mut Vec<f64>) {
        into.push(self.filled as f64);
        into.extend_from_slice(&self.differences);
    }

    /// How many numbers [`Extrapolation::memory`] writes.
    pub fn memory_len(&self) -> usize {
        1 + self.differences.len()
    }

    /// Restores what [`Extrapolation::memory`] wrote.
    pub fn restore(&mut self, memory: &[f64]) {
        self.filled = (memory[0] as usize).min(DEPTH);
        self.differences.copy_from_slice(&memory[1..]);
    }
}
