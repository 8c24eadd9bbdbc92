//! Sums held as unevaluated pairs of doubles.

/// Knuth's two-sum: s + e = a + b exactly, s = a + b rounded.
#[inline(always)]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let back = sum - a;
    (sum, (a - (sum - back)) + (b - back))
}

/// A vector held as unevaluated sums high + low.
pub struct Compensated {
    /// The sums rounded.
    pub high: Vec<f64>,
    /// Remainders of the sums: the part that rounding took.
    pub low: Vec<f64>,
}

impl Compensated {
    /// Zeros.
    pub fn new(size: usize) -> Self {
        Self {
            high: vec![0.0; size],
            low: vec![0.0; size],
        }
    }

    /// high + low.
    pub fn set(&mut self, high: &[f64], low: &[f64]) {
        self.high.copy_from_slice(high);
        self.low.copy_from_slice(low);
    }

    /// 0.
    pub fn clear(&mut self) {
        self.high.fill(0.0);
        self.low.fill(0.0);
    }

    /// Adds doubles.
    pub fn add(&mut self, change: &[f64]) {
        for ((high, low), change) in self.high.iter_mut().zip(&mut self.low).zip(change) {
            let (sum, error) = two_sum(*high, *change);
            (*high, *low) = two_sum(sum, error + *low);
        }
    }
}
