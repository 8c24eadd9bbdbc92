//! Quantiles of a stream of numbers in bounded memory.

use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// Numbers a sketch holds before it is thinned: fewer are all kept.
const CAPACITY: usize = 2048;

/// Numbers that stay of a full sketch. An odd number: the median is one of them.
const KEPT: usize = 1025;

/// sin²(π j / 2(KEPT − 1)): the parts of the count at which numbers stay. They lie π √(p (1 − p)) / (KEPT − 1) apart, densest at both
/// ends.
static PARTS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let angle = |j: usize| FRAC_PI_2 * j as f64 / (KEPT - 1) as f64;
    let sines = (0..KEPT).map(|j| libm::sin(angle(j)));
    sines.map(|sine| sine * sine).collect()
});

/// A quantile: the smallest number that at least a part p of all do not exceed, or one near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantile {
    /// One of the numbers; NaN where there is none.
    pub value: f64,
    /// How far its rank is from ⌈p count⌉ at most, as a part of the count.
    pub rank_error: f64,
}

/// One of the numbers that were put in, with bounds of its rank among all of them, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Kept {
    value: f64,
    low: u64,
    high: u64,
}

impl Kept {
    fn center(&self) -> f64 {
        0.5 * (self.low + self.high) as f64
    }
}

/// A sketch of a distribution: some of the numbers, each with bounds of its rank.
///
/// Numbers of two sketches are joined in their order. A number of one comes behind those of the other that were kept
/// before it, and before those that were kept behind it. These are bounds of its rank in the other, and they are added
/// to its own. Of a full sketch those numbers stay whose ranks, taken for the centers of their bounds, are nearest to
/// given parts of the count, both extremes among them (M. Greenwald, S. Khanna, *Power-conserving computation of
/// order-statistics over sensor networks*, PODS 2004; parts that are denser at the ends as in T. Dunning, *Computing
/// extremely accurate quantiles using t-digests*, 2019). Where the numbers that are joined come from one distribution,
/// a number lies above the center of its bounds as often as below. The result depends on the numbers and on the order
/// of joining alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Sketch {
    /// All numbers, in any order.
    All(Vec<f64>),
    /// Some of `count`, in their order.
    Some { count: u64, kept: Vec<Kept> },
}

impl Default for Sketch {
    fn default() -> Self {
        Self::All(Vec::new())
    }
}

impl Sketch {
    /// Takes in a number.
    pub fn push(&mut self, value: f64) {
        match self {
            Self::All(values) if values.len() + 1 < CAPACITY => values.push(value),
            _ => self.join(Self::All(vec![value])),
        }
    }

    /// Takes in the numbers of another sketch.
    pub fn join(&mut self, other: Self) {
        if let (Self::All(values), Self::All(more)) = (&mut *self, &other)
            && values.len() + more.len() < CAPACITY
        {
            values.extend(more);
            return;
        }
        let counts = (self.count(), other.count());
        let count = counts.0 + counts.1;
        let mut kept = joined((&self.ranked(), counts.0), (&other.ranked(), counts.1));
        if kept.len() >= CAPACITY {
            kept = thinned(&kept, count);
        }
        *self = Self::Some { count, kept };
    }

    /// How many numbers were put in.
    pub fn count(&self) -> u64 {
        match self {
            Self::All(values) => values.len() as u64,
            Self::Some { count, .. } => *count,
        }
    }

    /// The numbers in their order.
    fn ranked(&self) -> Vec<Kept> {
        match self {
            Self::All(values) => {
                let mut values = values.clone();
                values.sort_unstable_by(f64::total_cmp);
                let ranks = values.into_iter().zip(1..);
                ranks
                    .map(|(value, rank)| Kept {
                        value,
                        low: rank,
                        high: rank,
                    })
                    .collect()
            }
            Self::Some { kept, .. } => kept.clone(),
        }
    }

    /// The quantile of each part of the numbers.
    pub fn quantiles(&self, parts: &[f64]) -> Vec<Quantile> {
        let (kept, count) = (self.ranked(), self.count());
        let quantile = |p: &f64| {
            let wanted = (libm::ceil(p * count as f64) as u64).clamp(1, count.max(1));
            let nearest = kept.get(nearest(&kept, 0, wanted as f64));
            nearest.map_or(
                Quantile {
                    value: f64::NAN,
                    rank_error: 0.0,
                },
                |of| Quantile {
                    value: of.value,
                    rank_error: wanted.abs_diff(of.low).max(wanted.abs_diff(of.high)) as f64
                        / count as f64,
                },
            )
        };
        parts.iter().map(quantile).collect()
    }
}

/// The numbers of two lists with their counts, in their order; of equal ones those of the first list come first.
fn joined((first, ahead): (&[Kept], u64), (second, behind): (&[Kept], u64)) -> Vec<Kept> {
    let mut all = Vec::with_capacity(first.len() + second.len());
    let (mut i, mut j) = (0, 0);
    while i < first.len() || j < second.len() {
        let is_of_first = match (first.get(i), second.get(j)) {
            (Some(a), Some(b)) => a.value.total_cmp(&b.value).is_le(),
            (a, _) => a.is_some(),
        };
        let (next, others, at, count) = if is_of_first {
            i += 1;
            (first[i - 1], second, j, behind)
        } else {
            j += 1;
            (second[j - 1], first, i, ahead)
        };
        let before = at.checked_sub(1).map_or(0, |before| others[before].low);
        let until = others.get(at).map_or(count, |after| after.high - 1);
        all.push(Kept {
            value: next.value,
            low: next.low + before,
            high: next.high + until,
        });
    }
    all
}

/// The numbers nearest to the [`PARTS`] of the count, each of them once.
fn thinned(kept: &[Kept], count: u64) -> Vec<Kept> {
    let mut at = 0;
    let mut places: Vec<usize> = PARTS
        .iter()
        .map(|part| {
            at = nearest(kept, at, 1.0 + part * (count - 1) as f64);
            at
        })
        .collect();
    places.dedup();
    places.into_iter().map(|place| kept[place]).collect()
}

/// The place, from `from` on, of the number whose rank is nearest to `rank`, the first of two.
fn nearest(kept: &[Kept], from: usize, rank: f64) -> usize {
    // Ranks rise, and one that is looked for lies a few behind the last.
    let below = kept[from..].iter().take_while(|of| of.center() < rank);
    let above = from + below.count();
    let distance = |at: usize| (kept[at].center() - rank).abs();
    match above.checked_sub(1).filter(|below| *below >= from) {
        Some(below) if above == kept.len() || distance(below) <= distance(above) => below,
        _ => above,
    }
}

#[cfg(test)]
mod tests {
    use leafwise_core::random::Random;
    use proptest::prelude::*;

    use super::*;

    const ASKED: [f64; 11] = [
        0.0, 1e-4, 0.001, 0.01, 0.05, 0.3, 0.5, 0.75, 0.95, 0.999, 1.0,
    ];

    /// Numbers put in by leaves of 64 and joined by the tree that an ensemble joins them by.
    fn sketch(numbers: &[f64]) -> Sketch {
        let mut nodes: Vec<(u32, Sketch)> = Vec::new();
        for leaf in numbers.chunks(64) {
            let mut node = Sketch::default();
            leaf.iter().for_each(|number| node.push(*number));
            let mut level = 0;
            while let Some((_, mut left)) = nodes.pop_if(|(of, _)| *of == level) {
                left.join(node);
                node = left;
                level += 1;
            }
            nodes.push((level, node));
        }
        let all = nodes
            .into_iter()
            .rev()
            .reduce(|(_, right), (level, mut left)| {
                left.join(right);
                (level, left)
            });
        all.map_or_else(Sketch::default, |(_, sketch)| sketch)
    }

    /// How far the rank of a number is from the wanted one, up or down: equal numbers share all of their ranks.
    fn error(sorted: &[f64], p: f64, value: f64) -> f64 {
        let count = sorted.len() as f64;
        let wanted = libm::ceil(p * count).max(1.0);
        let first = sorted.partition_point(|number| *number < value) as f64 + 1.0;
        let last = sorted.partition_point(|number| *number <= value) as f64;
        assert!(first <= last, "{value} is none of the numbers");
        (wanted.clamp(first, last) - wanted) / count
    }

    #[derive(Clone, Copy, Debug)]
    enum Kind {
        Normal,
        /// e^(8 x) of a normal x: over sixty powers of ten.
        Wide,
        Rising,
        Falling,
        /// Seven values, 0 and −0 among them.
        Few,
        /// A sine of the number's place.
        Swinging,
        /// Each leaf about a mean of its own.
        Drifting,
    }

    fn numbers(kind: Kind, count: usize, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed, 0, 0);
        let number = |k: usize| {
            let at = k as f64;
            match kind {
                Kind::Normal => random.normal(),
                Kind::Wide => libm::exp(8.0 * random.normal()),
                Kind::Rising => at,
                Kind::Falling => -at,
                Kind::Few => libm::copysign(libm::floor(4.0 * random.uniform()), random.normal()),
                Kind::Swinging => libm::sin(0.7 * at),
                Kind::Drifting => random.normal() + libm::sin((k / 64) as f64),
            }
        };
        (0..count).map(number).collect()
    }

    fn check(kind: Kind, count: usize, seed: u64) {
        let numbers = numbers(kind, count, seed);
        let mut sorted = numbers.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let sketch = sketch(&numbers);
        assert_eq!(sketch.count(), count as u64);
        // Bounds of a rank come to lie further apart in each joining of thinned sketches, by half the distance of neighbours.
        let thinnings = libm::ceil(libm::log2(count as f64 / 1024.0)).max(0.0);
        for (p, quantile) in ASKED.into_iter().zip(sketch.quantiles(&ASKED)) {
            let Quantile { value, rank_error } = quantile;
            let error = error(&sorted, p, value).abs();
            let room = f64::EPSILON;
            assert!(
                error <= rank_error + room,
                "{kind:?} {count} {p}: {error} {rank_error}"
            );
            let apart = std::f64::consts::PI * libm::sqrt(p * (1.0 - p)) / 1024.0;
            let at_the_ends = (std::f64::consts::PI / 1024.0) * (std::f64::consts::PI / 1024.0);
            let most = (1.0 + thinnings) * (apart + at_the_ends);
            assert!(
                rank_error <= most,
                "{kind:?} {count} {p}: {rank_error} {most}"
            );
            if count < CAPACITY || p == 0.0 || p == 1.0 {
                let rank = libm::ceil(p * count as f64).max(1.0) as usize;
                assert_eq!((value, rank_error), (sorted[rank - 1], 0.0));
            }
        }
    }

    const KINDS: [Kind; 7] = [
        Kind::Normal,
        Kind::Wide,
        Kind::Rising,
        Kind::Falling,
        Kind::Few,
        Kind::Swinging,
        Kind::Drifting,
    ];

    /// Against the numbers themselves, sorted.
    #[test]
    fn quantiles_of_ten_to_a_million_numbers_are_as_near_as_they_say() {
        for count in [10, 100, 1000, 10_000, 100_000] {
            KINDS.into_iter().for_each(|kind| check(kind, count, 1));
        }
        check(Kind::Normal, 1_000_000, 1);
        assert!(Sketch::default().quantiles(&[0.5])[0].value.is_nan());
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

        #[test]
        fn quantiles_of_any_numbers_are_as_near_as_they_say(
            kind in prop::sample::select(KINDS.to_vec()),
            digits in 1.0_f64..4.6,
            seed in 0_u64..1000,
        ) {
            check(kind, libm::pow(10.0, digits) as usize, seed);
        }
    }

    /// Ranks are too high as often as too low: over forty ensembles the mean error is small beside the errors.
    #[test]
    fn quantiles_have_no_bias() {
        let asked: Vec<f64> = (1..50).map(|k| f64::from(k) / 50.0).collect();
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for seed in 0..40 {
            let numbers = numbers(Kind::Normal, 10_000 + 1237 * seed as usize, seed);
            let mut sorted = numbers.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            for (p, quantile) in asked.iter().zip(sketch(&numbers).quantiles(&asked)) {
                let error = error(&sorted, *p, quantile.value);
                (sum, squares, count) = (sum + error, squares + error * error, count + 1.0);
            }
        }
        let (mean, spread) = (sum / count, libm::sqrt(squares / count));
        // Were the 49 errors of an ensemble one and the same, their mean over forty would be within 0.16 of their spread, and
        // within three times that nearly always.
        assert!(mean.abs() < 0.5 * spread, "{mean} of {spread}");
        // A tenth of what neighbours lie apart at the median, π / 2 / 1024, at least: there is something to judge.
        assert!(spread > 1.5e-4, "{spread}");
    }
}
