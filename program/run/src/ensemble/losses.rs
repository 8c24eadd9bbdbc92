//! How many members the scene's condition has ended, against time.

use super::plan::ComposedEnsemble;
use super::statistics::Reductions;

/// Times at which members are counted, at most, beside the first.
const MOST_TIMES: u64 = 200;

/// The interval holds the probability of a loss in 95 of 100 ensembles: the standard normal distribution leaves 0.025 behind
/// this quantile.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// The members that have ended by a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// The time.
    pub time: f64,
    /// How many the condition has ended by then.
    pub stopped: u64,
    /// How many there are, those that failed left out.
    pub members: u64,
    /// The part of them.
    pub fraction: f64,
    /// A 95 % confidence interval of the probability.
    pub interval: [f64; 2],
}

impl Loss {
    /// So many of the members by this time.
    pub(super) fn new(time: f64, stopped: u64, members: u64) -> Self {
        Self {
            time,
            stopped,
            members,
            fraction: stopped as f64 / members.max(1) as f64,
            interval: interval(stopped, members),
        }
    }
}

/// The probabilities p with |k/n − p| ≤ z √(p (1 − p)/n), which lie in [0, 1]: E. B. Wilson, Journal of the American
/// Statistical Association 22 (1927) 209.
fn interval(count: u64, members: u64) -> [f64; 2] {
    if members == 0 {
        return [0.0, 1.0];
    }
    let (k, n, square) = (count as f64, members as f64, QUANTILE * QUANTILE);
    let middle = k + 0.5 * square;
    let half = QUANTILE * libm::sqrt(k * (1.0 - k / n) + 0.25 * square);
    let end = |numerator: f64| (numerator / (n + square)).clamp(0.0, 1.0);
    [
        if count == 0 { 0.0 } else { end(middle - half) },
        if count == members {
            1.0
        } else {
            end(middle + half)
        },
    ]
}

impl ComposedEnsemble {
    /// The marks at which the members that have ended are counted: the first is the beginning, the last the end.
    pub(super) fn loss_ends(&self) -> Vec<f64> {
        let mut ends = self.clock.windows(MOST_TIMES);
        ends.insert(0, 0.0);
        ends
    }

    /// The members that have ended by each time; none without a condition.
    pub fn losses(&self, reductions: &Reductions) -> Vec<Loss> {
        let members = reductions.members - reductions.failed;
        let mut stopped = 0;
        let ends = self.loss_ends().into_iter();
        let counted = ends.zip(&reductions.losses).map(|(mark, count)| {
            stopped += count;
            Loss::new(self.clock.time(mark), stopped, members)
        });
        counted.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ends are where k successes lie z standard deviations from the mean.
    #[test]
    fn an_interval_ends_at_its_quantile() {
        for (count, members) in [(1, 10), (5, 10), (312, 4000), (3999, 4000)] {
            let (k, n) = (count as f64, members as f64);
            for p in interval(count, members) {
                let deviations = (k - n * p) / libm::sqrt(n * p * (1.0 - p));
                assert!(
                    (deviations.abs() / QUANTILE - 1.0).abs() < 1e-11,
                    "{count} of {members}: {deviations}"
                );
            }
        }
        assert_eq!(interval(0, 0), [0.0, 1.0]);
        // p^n = (1 + z²/n)^(−n) at the upper end where none is lost.
        let [low, high] = interval(0, 100);
        let square = QUANTILE * QUANTILE;
        assert!(low == 0.0 && (high - square / (100.0 + square)).abs() < 1e-16);
        let [low, high] = interval(100, 100);
        assert!(high == 1.0 && (low - 100.0 / (100.0 + square)).abs() < 1e-15);
    }
}
