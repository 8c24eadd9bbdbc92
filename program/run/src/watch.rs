//! States of a run that its method is judged at, whatever the scene records.

use std::ops::Range;

use leafwise_walk::Steps;
use serde::{Deserialize, Serialize};

use crate::advice::{LARGEST, MOST_STATES};

/// Evenly spaced states are kept up to this number; then every other one goes.
const MOST_EVEN: usize = 32;

/// States of more coordinates are not kept evenly: a checkpoint holds them.
const LONGEST: usize = 4096;

/// States before steps that were taken, the last one always, and states evenly spaced over the run. Where steps are
/// judged, in [`LARGEST`] coordinates at most, two more are kept. One is the state before the step with most
/// evaluations; the first step, which has none to begin with, does not count. The other is the state before the step
/// with the largest motion Σ_i |Δx_i|/(max x_i − min x_i).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Watch {
    /// Steps between two evenly spaced states.
    stride: u64,
    /// x_0, x_stride, x_{2 stride}, …, one after the other.
    even: Vec<f64>,
    /// x_{k−1}, where x_k is the present state.
    before: Vec<f64>,
    /// The state before the step with most evaluations, and these.
    dearest: (Vec<f64>, u64),
    /// The state before the step with the largest motion.
    fastest: Vec<f64>,
    /// That motion, and its size.
    motion: Vec<f64>,
    size: f64,
    /// The least and the largest value of each coordinate.
    low: Vec<f64>,
    high: Vec<f64>,
    /// One over the ranges, 0 where there is none yet; formed again in each session.
    #[serde(skip)]
    inverse: Vec<f64>,
    /// The state before the step at hand.
    #[serde(skip)]
    from: Vec<f64>,
    /// Evaluations of this session so far.
    #[serde(skip)]
    evaluations: u64,
    /// The motions of many steps.
    #[serde(skip)]
    sizes: Vec<f64>,
    /// The steps after which the next evenly spaced state is kept, 0 where that is to be found.
    #[serde(skip)]
    next: u64,
}

/// Whether all values lie between two.
fn is_within(values: &[f64], low: f64, high: f64) -> bool {
    let inside = values.iter().map(|x| u32::from(!(*x < low || *x > high)));
    inside.sum::<u32>() as usize == values.len()
}

/// By what a checkpoint keeps.
impl PartialEq for Watch {
    fn eq(&self, other: &Self) -> bool {
        let kept = |watch: &Self| {
            let Watch {
                stride,
                even,
                before,
                dearest,
                fastest,
                motion,
                size,
                low,
                high,
                ..
            } = watch.clone();
            (
                stride, even, before, dearest, fastest, motion, size, low, high,
            )
        };
        kept(self) == kept(other)
    }
}

impl Watch {
    /// No step yet.
    pub fn new(initial: &[f64]) -> Self {
        let evenly = if initial.len() <= LONGEST {
            initial
        } else {
            &[]
        };
        let judged = if initial.len() <= LARGEST {
            initial
        } else {
            &[]
        };
        Self {
            stride: 1,
            even: evenly.to_vec(),
            low: judged.to_vec(),
            high: judged.to_vec(),
            ..Self::default()
        }
    }

    /// Takes in the state that a session begins at.
    pub fn begin(&mut self, state: &[f64]) {
        if state.len() == self.low.len() {
            self.from.clear();
            self.from.extend_from_slice(state);
        }
    }

    /// Takes in the state after so many steps, and the session's evaluations up to there.
    pub fn take(&mut self, state: &[f64], steps: u64, evaluations: u64) {
        if steps >= self.next && !self.even.is_empty() {
            self.keep_evenly(state, steps);
        }
        if state.len() != self.low.len() {
            return;
        }
        let before = std::mem::replace(&mut self.evaluations, evaluations);
        let evaluations = evaluations - before;
        if steps > 1 && evaluations > self.dearest.1 {
            self.dearest.0.clone_from(&self.from);
            self.dearest.1 = evaluations;
        }
        let d = self.low.len();
        let (low, high, from) = (&self.low[..d], &self.high[..d], &self.from[..d]);
        let mut is_wider = self.inverse.len() != d;
        let mut size = 0.0;
        for (i, inverse) in self.inverse.iter().enumerate() {
            is_wider |= state[i] < low[i] || state[i] > high[i];
            size += (state[i] - from[i]).abs() * inverse;
        }
        if is_wider {
            size = self.widen(state);
        }
        if size > self.size {
            self.size = size;
            self.fastest.clone_from(&self.from);
            self.motion.clear();
            let motion = state.iter().zip(&self.from).map(|(x, from)| x - from);
            self.motion.extend(motion);
        }
        std::mem::swap(&mut self.before, &mut self.from);
        self.begin(state);
    }

    /// Takes in each of these steps, to the same bits.
    pub fn take_steps(&mut self, steps: &Steps<'_>, range: Range<usize>) {
        let d = self.low.len();
        let is_judged = steps.at(range.start).state.len() == d;
        let columns = || (0..d).map(|i| &steps.coordinate(i)[range.clone()]);
        let is_inside = is_judged
            && self.inverse.len() == d
            && columns()
                .zip(self.low.iter().zip(&self.high))
                .all(|(column, (low, high))| is_within(column, *low, *high));
        if !is_inside {
            for at in range.map(|k| steps.at(k)) {
                self.take(at.state, at.steps, at.evaluations);
            }
            return;
        }
        let (first, last) = (
            steps.before + range.start as u64 + 1,
            steps.before + range.end as u64,
        );
        while !self.even.is_empty() && self.next <= last {
            let next = self.next.max(first);
            let at = steps.at((next - steps.before) as usize - 1);
            self.keep_evenly(at.state, next);
        }
        let mut dearest = None;
        for (k, evaluations) in range.clone().zip(&steps.evaluations()[range.clone()]) {
            let before = std::mem::replace(&mut self.evaluations, *evaluations);
            let is_first = steps.before + k as u64 == 0;
            if !is_first && evaluations - before > self.dearest.1 {
                self.dearest.1 = evaluations - before;
                dearest = Some(k);
            }
        }
        self.sizes.clear();
        self.sizes.resize(range.len(), 0.0);
        for (column, (from, inverse)) in columns().zip(self.from.iter().zip(&self.inverse)) {
            self.sizes[0] += (column[0] - from).abs() * inverse;
            let moves = column
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).abs() * inverse);
            let sizes = self.sizes[1..].iter_mut().zip(moves);
            sizes.for_each(|(size, moved)| *size += moved);
        }
        let mut fastest = None;
        for (k, size) in range.clone().zip(&self.sizes) {
            if *size > self.size {
                self.size = *size;
                fastest = Some(k);
            }
        }
        // The state before a step.
        let begin = std::mem::take(&mut self.from);
        let before = |k: usize| match k == range.start {
            true => begin.as_slice(),
            false => steps.at(k - 1).state,
        };
        if let Some(k) = dearest {
            self.dearest.0 = before(k).to_vec();
        }
        if let Some(k) = fastest {
            self.fastest = before(k).to_vec();
            let motion = steps.at(k).state.iter().zip(before(k));
            self.motion.clear();
            self.motion.extend(motion.map(|(x, from)| x - from));
        }
        let end = range.end - 1;
        self.before.clear();
        self.before.extend_from_slice(before(end));
        self.from = begin;
        self.begin(steps.at(end).state);
    }

    /// Takes a state beyond the ranges into them, and returns the size of the step at hand in the new ones.
    #[cold]
    fn widen(&mut self, state: &[f64]) -> f64 {
        for (x, (low, high)) in state.iter().zip(self.low.iter_mut().zip(&mut self.high)) {
            (*low, *high) = (x.min(*low), x.max(*high));
        }
        let ranges = self.low.iter().zip(&self.high);
        let ranges = ranges.map(|(low, high)| high - low);
        self.inverse.clear();
        self.inverse
            .extend(ranges.map(|range| if range > 0.0 { 1.0 / range } else { 0.0 }));
        self.size = self.of(self.motion.iter().copied());
        self.of(state.iter().zip(&self.from).map(|(x, from)| x - from))
    }

    /// Keeps a state that is evenly spaced.
    #[cold]
    fn keep_evenly(&mut self, state: &[f64], steps: u64) {
        if steps.is_multiple_of(self.stride) {
            self.even.extend_from_slice(state);
            if self.even.len() > MOST_EVEN * state.len() {
                self.halve(state.len());
            }
        }
        self.next = (steps / self.stride + 1) * self.stride;
    }

    /// Σ_i |Δx_i|/(max x_i − min x_i).
    fn of(&self, motion: impl Iterator<Item = f64>) -> f64 {
        let parts = motion.zip(&self.inverse);
        parts.map(|(motion, inverse)| motion.abs() * inverse).sum()
    }

    /// Keeps every other evenly spaced state.
    fn halve(&mut self, d: usize) {
        let kept: Vec<f64> = self
            .even
            .chunks_exact(d)
            .step_by(2)
            .flatten()
            .copied()
            .collect();
        (self.even, self.stride) = (kept, 2 * self.stride);
    }

    /// States from which the run has made a step, [`MOST_STATES`] at most. These are the first, that before the last
    /// step, those before the steps with most evaluations and the largest motion, and evenly spaced ones. The first
    /// alone where no step was made.
    pub fn judged<'a>(&'a self, initial: &'a [f64]) -> Vec<Vec<f64>> {
        let chosen = [initial, &self.before, &self.dearest.0, &self.fastest];
        let mut states: Vec<&[f64]> = Vec::new();
        let even: Vec<&[f64]> = self.even.chunks_exact(initial.len()).collect();
        let places = MOST_STATES - chosen.len();
        // Without the first and the last one.
        let between = (1..=places).map(|k| k * even.len() / (places + 1));
        let between = between.filter(|at| (1..even.len().saturating_sub(1)).contains(at));
        for state in chosen.into_iter().chain(between.map(|at| even[at])) {
            if !state.is_empty() && !states.contains(&state) {
                states.push(state);
            }
        }
        states.into_iter().map(<[f64]>::to_vec).collect()
    }

    /// States along the whole run: how far its orbit reaches.
    pub fn along(&self, d: usize) -> Vec<Vec<f64>> {
        self.even.chunks_exact(d).map(<[f64]>::to_vec).collect()
    }

    /// Whether its lists are of `d` coordinates.
    pub fn agrees(&self, d: usize) -> bool {
        let is_whole = |list: &Vec<f64>| list.is_empty() || list.len() == d;
        let lists = [
            &self.before,
            &self.dearest.0,
            &self.fastest,
            &self.motion,
            &self.low,
        ];
        self.stride > 0
            && self.even.len().is_multiple_of(d.max(1))
            && self.high.len() == self.low.len()
            && lists.into_iter().all(is_whole)
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST_EVEN, Watch};

    /// A watch over a path of one coordinate and its square, as if by steps that took these evaluations.
    fn watched(path: &[f64], evaluations: &[u64]) -> Watch {
        let state = |x: f64| [x, x * x];
        let mut watch = Watch::new(&state(path[0]));
        let mut sum = 0;
        for (k, (pair, evaluations)) in path.windows(2).zip(evaluations).enumerate() {
            watch.begin(&state(pair[0]));
            sum += evaluations;
            watch.take(&state(pair[1]), k as u64 + 1, sum);
        }
        watch
    }

    /// The first, the last, the longest and the dearest step are among what is judged; the rest is spread evenly, and the
    /// memory does not grow.
    #[test]
    fn the_steps_that_matter_are_kept_at_any_length() {
        for steps in [1_usize, 2, 5, 31, 32, 33, 1000, 4099] {
            let mut path: Vec<f64> = (0..=steps).map(|k| k as f64 / steps as f64).collect();
            let (long, dear) = (steps / 3, steps / 2);
            // One step goes ten times as far as the others.
            path.iter_mut()
                .skip(long + 1)
                .for_each(|x| *x += 9.0 / steps as f64);
            let mut evaluations = vec![2; steps];
            evaluations[0] = 9;
            evaluations[dear] = 5;
            let watch = watched(&path, &evaluations);
            let first = [path[0], path[0] * path[0]];
            let judged = watch.judged(&first);
            let has = |at: usize| judged.iter().any(|state| state[0] == path[at]);
            for at in [0, steps - 1, long, if dear > 0 { dear } else { 0 }] {
                assert!(has(at), "{at} of {steps}: {judged:?}");
            }
            assert!(judged.len() <= crate::advice::MOST_STATES);
            // No step was made from the last one.
            assert!(!has(steps), "{judged:?}");
            let along = watch.along(2);
            assert!(along.len() <= MOST_EVEN && along.len() >= steps.min(MOST_EVEN / 2));
            assert!(watch.agrees(2) && !watch.agrees(3));
        }
    }
}
