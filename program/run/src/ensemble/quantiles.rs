//! Quantiles of a stream of numbers in bounded memory.

use serde::{Deserialize, Serialize};

/// Numbers a level holds before half of them move on, with twice the weight.
const CAPACITY: usize = 1024;

/// A sketch of a distribution: a number at level l stands for 2ˡ of those that were put in.
///
/// A full level is sorted and every other number of it moves up, by turns the odd and the even places
/// (I. Munro, M. Paterson, *Selection and sorting with limited storage*, Theor. Comput. Sci. 12
/// (1980)). Each time ranks change by at most 2ˡ, up by the odd places and down by the even ones: the error of a rank is at
/// most Σ_l max(o_l, e_l) 2ˡ for so many compactions of level l of either kind. Up to a thousand numbers are kept as they are.
/// Two sketches are joined level by level (R. Agarwal and others, *Mergeable summaries*, PODS 2012). The result depends on the
/// numbers and their order, and on the order of joining, alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Sketch {
    /// The numbers of each level.
    pub levels: Vec<Vec<f64>>,
    /// o_l and e_l.
    pub compactions: Vec<[u64; 2]>,
}

impl Sketch {
    /// Takes in a number.
    pub fn push(&mut self, value: f64) {
        self.level(0).push(value);
        self.compact();
    }

    /// Takes in the numbers of another sketch.
    pub fn join(&mut self, other: Self) {
        for (at, (level, compactions)) in
            other.levels.into_iter().zip(other.compactions).enumerate()
        {
            self.level(at).extend(level);
            for (own, more) in self.compactions[at].iter_mut().zip(compactions) {
                *own += more;
            }
        }
        self.compact();
    }

    /// Moves numbers up from full levels.
    fn compact(&mut self) {
        let mut level = 0;
        while level < self.levels.len() {
            if self.levels[level].len() >= CAPACITY {
                let mut full = std::mem::take(&mut self.levels[level]);
                full.sort_unstable_by(f64::total_cmp);
                // Of an odd number the largest stays.
                let rest = (!full.len().is_multiple_of(2))
                    .then(|| full.pop())
                    .flatten();
                let [odd, even] = self.compactions[level];
                let turn = usize::from(odd > even);
                self.compactions[level][turn] += 1;
                self.level(level + 1)
                    .extend(full.iter().skip(turn).step_by(2));
                full.clear();
                full.extend(rest);
                self.levels[level] = full;
            }
            level += 1;
        }
    }

    fn level(&mut self, level: usize) -> &mut Vec<f64> {
        if level == self.levels.len() {
            self.levels.push(Vec::new());
            self.compactions.push([0; 2]);
        }
        &mut self.levels[level]
    }

    /// How many numbers were put in.
    pub fn count(&self) -> u64 {
        let weights = self.levels.iter().zip(0_u32..);
        weights.map(|(level, l)| (level.len() as u64) << l).sum()
    }

    /// The smallest number that at least the part `p` of all do not exceed, for each `p`; NaN where
    /// there is none.
    pub fn quantiles(&self, parts: &[f64]) -> Vec<f64> {
        let levels = self.levels.iter().zip(0_u32..);
        let mut all: Vec<(f64, u64)> = levels
            .flat_map(|(level, l)| level.iter().map(move |value| (*value, 1 << l)))
            .collect();
        all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let count = self.count();
        let quantile = |p: f64| {
            let wanted = (libm::ceil(p * count as f64) as u64).clamp(1, count.max(1));
            let mut below = 0;
            let reached = all.iter().find(|(_, weight)| {
                below += weight;
                below >= wanted
            });
            reached.map_or(f64::NAN, |(value, _)| *value)
        };
        parts.iter().map(|p| quantile(*p)).collect()
    }

    /// The largest error of a quantile's rank, as a part of the count.
    pub fn rank_error(&self) -> f64 {
        let levels = self.compactions.iter().zip(0_u32..);
        let error: u64 = levels.map(|([odd, even], l)| *odd.max(even) << l).sum();
        error as f64 / self.count().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_numbers_have_their_exact_quantiles() {
        let mut sketch = Sketch::default();
        for k in 0..1000_u64 {
            sketch.push((k * 383 % 1000) as f64);
        }
        assert_eq!(
            sketch.quantiles(&[0.0, 0.001, 0.25, 0.5, 1.0]),
            [0.0, 0.0, 249.0, 499.0, 999.0]
        );
        assert_eq!(sketch.rank_error(), 0.0);
        assert!(Sketch::default().quantiles(&[0.5])[0].is_nan());
    }

    #[test]
    fn ranks_of_many_numbers_are_as_near_as_the_sketch_says() {
        let count = 300_007_u64;
        for stride in [1, 104_729, 299_993] {
            let mut sketch = Sketch::default();
            (0..count).for_each(|k| sketch.push((k * stride % count) as f64));
            assert_eq!(sketch.count(), count);
            let bound = sketch.rank_error();
            assert!(bound < 0.005, "{bound}");
            for (p, value) in [0.01, 0.1, 0.5, 0.9, 0.99]
                .into_iter()
                .zip(sketch.quantiles(&[0.01, 0.1, 0.5, 0.9, 0.99]))
            {
                // The numbers are 0 … count − 1: a number is its rank. Beside the ranks' error, a
                // quantile falls on a number that is kept, one of the heaviest weight at worst.
                let heaviest = (1_u64 << (sketch.levels.len() - 1)) as f64 / count as f64;
                let error = ((value + 1.0) / count as f64 - p).abs();
                assert!(error <= bound + heaviest, "{p}: {error}");
            }
            let kept: usize = sketch.levels.iter().map(Vec::len).sum();
            assert!(kept < CAPACITY * sketch.levels.len());
        }
    }

    #[test]
    fn joined_sketches_are_as_near_as_they_say() {
        let count = 300_007_u64;
        for part in [64, 1000, 70_001] {
            let mut sketch = Sketch::default();
            for first in (0..count).step_by(part) {
                let mut more = Sketch::default();
                let end = count.min(first + part as u64);
                (first..end).for_each(|k| more.push((k * 104_729 % count) as f64));
                sketch.join(more);
            }
            assert_eq!(sketch.count(), count);
            let bound = sketch.rank_error();
            assert!(bound < 0.01, "{bound}");
            let heaviest = (1_u64 << (sketch.levels.len() - 1)) as f64 / count as f64;
            for p in [0.01, 0.1, 0.5, 0.9, 0.99] {
                let error = ((sketch.quantiles(&[p])[0] + 1.0) / count as f64 - p).abs();
                assert!(error <= bound + heaviest, "{p}: {error}");
            }
            assert!(sketch.levels.iter().all(|level| level.len() < CAPACITY));
        }
    }
}
