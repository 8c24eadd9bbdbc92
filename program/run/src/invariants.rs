//! Deviations of energy and Casimirs at every step, their maxima over windows.

use std::ops::Range;

use leafwise_scene::json::{double, optional};
use leafwise_walk::Steps;
use serde::{Deserialize, Serialize};

/// How far an invariant strayed, over every step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InvariantDrift {
    /// Its name.
    #[serde(skip)]
    pub name: String,
    /// I(x_0).
    #[serde(serialize_with = "double")]
    pub initial: f64,
    /// max_k |I(x_k) − I(x_0)|.
    #[serde(serialize_with = "double")]
    pub maximum: f64,
    /// The same over |I(x_0)|; it has no meaning where that is 0, or no more than its round-off.
    #[serde(serialize_with = "optional")]
    pub relative: Option<f64>,
}

/// The most windows that are kept; one more and neighbours are merged.
const MOST_WINDOWS: usize = 2048;

/// Maxima of |I(x_k) − I(x_0)| over windows of steps, for each invariant, and the solver's
/// evaluations in each window. Windows double in width when there are too many, so that a run of
/// any length keeps between a thousand and two thousand of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Windows {
    /// I(x_0).
    pub initial: Vec<f64>,
    /// Steps in a full window.
    pub width: u64,
    /// Steps in the window that is being filled.
    pub filled: u64,
    /// The maxima of the window that is being filled.
    pub current: Vec<f64>,
    /// The maxima of full windows, one row of invariants after the other.
    pub maxima: Vec<f64>,
    /// Evaluations up to the end of each full window.
    pub evaluations: Vec<u64>,
    /// The time at the end of each full window.
    pub times: Vec<f64>,
    /// The time after the last step.
    pub time: f64,
    #[serde(skip)]
    peaks: Peaks,
}

/// The maxima over all full windows, formed again in each session.
#[derive(Clone, Debug, Default)]
struct Peaks(Option<Vec<f64>>);

/// Of what they are formed from two are equal or not.
impl PartialEq for Peaks {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Windows {
    /// No step yet.
    pub fn new(initial: &[f64]) -> Self {
        Self {
            initial: initial.to_vec(),
            width: 1,
            filled: 0,
            current: vec![0.0; initial.len()],
            maxima: Vec::with_capacity(initial.len() * MOST_WINDOWS),
            evaluations: Vec::with_capacity(MOST_WINDOWS),
            times: Vec::with_capacity(MOST_WINDOWS),
            time: 0.0,
            peaks: Peaks::default(),
        }
    }

    /// Takes in the values after one more step, and its time; `evaluations` are the solver's so far.
    pub fn push(&mut self, values: &[f64], time: f64, evaluations: impl FnOnce() -> u64) {
        self.time = time;
        for ((value, initial), maximum) in values.iter().zip(&self.initial).zip(&mut self.current) {
            *maximum = larger(*maximum, (value - initial).abs());
        }
        self.filled += 1;
        if self.filled < self.width {
            return;
        }
        self.end_window(evaluations());
    }

    /// Takes in the values after each of these steps, to the same bits; `before` are the evaluations of earlier sessions.
    pub fn push_steps(&mut self, steps: &Steps<'_>, range: Range<usize>, before: u64) {
        if !steps.are_all_looked_at() {
            for k in range.filter(|k| steps.is_looked_at(*k)) {
                let count = self.initial.len();
                let values: Vec<f64> = (0..count).map(|i| steps.invariant(i)[k]).collect();
                let at = steps.at(k);
                self.push(&values, at.time, || before + at.evaluations);
            }
            return;
        }
        let mut begin = range.start;
        while begin < range.end {
            let room = (self.width - self.filled).min(MOST_WINDOWS as u64 * 1024) as usize;
            let end = range.end.min(begin + room);
            for (at, (maximum, initial)) in self.current.iter_mut().zip(&self.initial).enumerate() {
                let values = &steps.invariant(at)[begin..end];
                *maximum = larger(*maximum, largest_change(values, *initial));
            }
            let last = steps.at(end - 1);
            self.time = last.time;
            self.filled += (end - begin) as u64;
            if self.filled == self.width {
                self.end_window(before + last.evaluations);
            }
            begin = end;
        }
    }

    fn end_window(&mut self, evaluations: u64) {
        let mut peaks = self.peaks.0.take().unwrap_or_else(|| self.peaks());
        take_larger(&mut peaks, &self.current);
        self.peaks = Peaks(Some(peaks));
        self.maxima.extend_from_slice(&self.current);
        self.evaluations.push(evaluations);
        self.times.push(self.time);
        self.current.fill(0.0);
        self.filled = 0;
        if self.evaluations.len() == MOST_WINDOWS {
            self.merge();
        }
    }

    /// Joins neighbours; their number is even.
    fn merge(&mut self) {
        let count = self.initial.len();
        for window in 0..MOST_WINDOWS / 2 {
            for at in 0..count {
                let (a, b) = (2 * window * count + at, (2 * window + 1) * count + at);
                self.maxima[window * count + at] = larger(self.maxima[a], self.maxima[b]);
            }
            self.evaluations[window] = self.evaluations[2 * window + 1];
            self.times[window] = self.times[2 * window + 1];
        }
        self.maxima.truncate(MOST_WINDOWS / 2 * count);
        self.evaluations.truncate(MOST_WINDOWS / 2);
        self.times.truncate(MOST_WINDOWS / 2);
        self.width *= 2;
    }

    /// The largest deviation of each invariant over every step.
    pub fn largest(&self) -> Vec<f64> {
        let mut largest = self.peaks();
        take_larger(&mut largest, &self.current);
        largest
    }

    fn peaks(&self) -> Vec<f64> {
        if let Some(peaks) = &self.peaks.0 {
            return peaks.clone();
        }
        let count = self.initial.len();
        let mut peaks = vec![0.0; count];
        for row in self.maxima.chunks_exact(count.max(1)) {
            take_larger(&mut peaks, row);
        }
        peaks
    }

    /// The time at which each window ends, the last one as far as it is filled.
    pub fn ends(&self) -> Vec<f64> {
        let mut ends = self.times.clone();
        ends.extend((self.filled > 0).then_some(self.time));
        ends
    }

    /// One invariant's maximum in each window of [`ends`](Self::ends).
    pub fn series(&self, invariant: usize) -> Vec<f64> {
        let count = self.initial.len();
        let mut series: Vec<f64> = self
            .maxima
            .chunks_exact(count)
            .map(|row| row[invariant])
            .collect();
        if self.filled > 0 {
            series.push(self.current[invariant]);
        }
        series
    }

    /// Mean evaluations a step in each full window, of looks that are so many steps apart. A last look that
    /// comes sooner ends no window that counts.
    pub fn evaluations_per_step(&self, (every, steps): (u64, u64)) -> Vec<f64> {
        let ends_sooner = !steps.is_multiple_of(every) && self.filled == 0;
        let whole = self
            .evaluations
            .len()
            .saturating_sub(usize::from(ends_sooner));
        let mut before = 0;
        self.evaluations[..whole]
            .iter()
            .map(|&evaluations| {
                let steps = self.width * every;
                let mean = evaluations.saturating_sub(before) as f64 / steps as f64;
                before = evaluations;
                mean
            })
            .collect()
    }
}

/// Takes in others.
fn take_larger(largest: &mut [f64], others: &[f64]) {
    for (largest, other) in largest.iter_mut().zip(others) {
        *largest = larger(*largest, *other);
    }
}

/// max |v − initial|, NaN where one is.
fn largest_change(values: &[f64], initial: f64) -> f64 {
    // In lanes, which do not wait for each other.
    let mut lanes = [0.0_f64; 8];
    let (whole, rest) = values.as_chunks::<8>();
    for values in whole {
        for (lane, value) in lanes.iter_mut().zip(values) {
            *lane = larger(*lane, (value - initial).abs());
        }
    }
    for (lane, value) in lanes.iter_mut().zip(rest) {
        *lane = larger(*lane, (value - initial).abs());
    }
    lanes.into_iter().fold(0.0, larger)
}

/// The larger of two deviations; NaN once either is.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_hold_the_maximum_over_every_step_at_any_length() {
        let mut windows = Windows::new(&[10.0, 0.0]);
        let steps = 10_000_u64;
        for k in 1..=steps {
            let peak = if k == 4321 { 7.0 } else { 0.0 };
            windows.push(&[10.0 + peak, -(k as f64)], k as f64, || 3 * k);
        }
        assert_eq!(windows.largest(), [7.0, steps as f64]);
        assert!(windows.evaluations.len() < MOST_WINDOWS);
        assert_eq!(windows.ends().last(), Some(&(steps as f64)));
        assert_eq!(windows.ends().len(), windows.series(0).len());
        assert_eq!(
            windows
                .series(0)
                .iter()
                .filter(|value| **value == 7.0)
                .count(),
            1
        );
        let growing = windows.series(1);
        assert_eq!(growing, windows.ends());
        assert!(
            windows
                .evaluations_per_step((1, windows.filled))
                .iter()
                .all(|mean| *mean == 3.0)
        );
    }

    #[test]
    fn a_deviation_that_is_not_a_number_is_kept() {
        let mut windows = Windows::new(&[1.0]);
        for value in [1.5, f64::NAN, 2.0] {
            windows.push(&[value], 1.0, || 0);
        }
        assert!(windows.largest()[0].is_nan());
    }
}
