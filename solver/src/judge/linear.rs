//! Linearly convergent iterations.

use super::{CorrectionSize, LARGEST_REMAINDER, NORMWISE_ROUND_OFF, ROUND_OFF, ULPS, larger};
use crate::error::StepError;

/// Corrections that fall by this do not turn into slow ones but for round-off.
const FAST: f64 = 0.1;

/// A component that does not fall below this part of its smallest correction makes no progress.
const PROGRESS: f64 = 0.9;

/// Verdict after a correction: go on or stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Go on.
    Continue,
    /// Stop: further corrections would add a negligible amount.
    Converged,
}

/// The sizes of an iteration's corrections: the last four, and the smallest.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    last: f64,
    before: [f64; 3],
    smallest: f64,
    /// Corrections since the smallest.
    since_smallest: u32,
    /// Size to be undercut for progress, and corrections since the last that did.
    mark: f64,
    since_progress: u32,
}

impl Sizes {
    const NONE: Self = Self {
        last: f64::INFINITY,
        before: [f64::INFINITY; 3],
        smallest: f64::INFINITY,
        since_smallest: 0,
        mark: f64::INFINITY,
        since_progress: 0,
    };

    fn take(&mut self, size: f64) {
        self.before = [self.last, self.before[0], self.before[1]];
        self.last = size;
        self.since_smallest = if size < self.smallest {
            self.smallest = size;
            0
        } else {
            self.since_smallest + 1
        };
        self.since_progress = if size < PROGRESS * self.mark {
            self.mark = size;
            0
        } else {
            self.since_progress + 1
        };
    }

    /// Σ_{k≥1} rᵏ of the last correction for the rate r of the last ones: what further corrections would add. The
    /// rate is the larger of the last ratio and the mean of two. Without an observed rate it is the correction
    /// itself.
    fn remainder(&self) -> f64 {
        let [before, first, _] = self.before;
        if !before.is_finite() {
            return self.last;
        }
        let ratio = self.last / before;
        let rate = if first.is_finite() {
            larger(ratio, libm::sqrt(self.last / first))
        } else {
            ratio
        };
        if rate < 1.0 {
            self.last * rate / (1.0 - rate)
        } else {
            f64::INFINITY
        }
    }

    fn is_negligible(&self) -> bool {
        self.remainder() <= LARGEST_REMAINDER
    }

    /// Whether corrections are round-off: they stopped shrinking where they are small. Corrections that
    /// fell fast and suddenly do not have reached it, even where the last is a little smaller.
    fn is_round_off(&self) -> bool {
        let [before, first, second] = self.before;
        let was_fast = before <= FAST * first && first <= FAST * second;
        let stops = was_fast && self.last >= 0.5 * before;
        stops && self.last <= f64::EPSILON
            || self.since_smallest >= 1 && self.last <= ULPS
            || self.since_smallest >= 2 && self.last <= ROUND_OFF
    }
}

/// Watches the sizes of the corrections of a linearly convergent iteration.
///
/// With corrections δ, rδ, r²δ, … the last leaves rδ/(1 − r). The iteration ends where that is below 1/512 of a unit
/// roundoff, judged by the observed rates. It also ends where the corrections are round-off: component by component,
/// or as a whole where small components are the round-off of larger ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearIteration {
    components: Sizes,
    whole: Sizes,
    evaluations: usize,
    most: usize,
    rounded: bool,
}

impl LinearIteration {
    /// A fresh iteration with a budget of evaluations.
    pub fn new(most: usize) -> Self {
        Self {
            components: Sizes::NONE,
            whole: Sizes::NONE,
            evaluations: 0,
            most,
            rounded: false,
        }
    }

    /// Whether it ended as a whole alone: a component still changed.
    pub fn is_rounded(&self) -> bool {
        self.rounded
    }

    /// Evaluations so far.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Takes in a correction's size, the largest relative change of a component.
    ///
    /// # Errors
    /// [`StepError::NonFinite`] for a size that is not finite, [`StepError::NoConvergence`] when
    /// the budget is spent.
    #[cfg(test)]
    pub fn judge(&mut self, size: f64) -> Result<Verdict, StepError> {
        self.judge_beside(size, || f64::INFINITY)
    }

    /// Takes in a correction's size, the largest relative change of a component. A small component may be the round-off
    /// of larger ones. Where corrections make no progress they are judged by `beside`. That is the largest change relative
    /// to what all components put into one.
    ///
    /// # Errors
    /// [`StepError::NonFinite`] for a size that is not finite, [`StepError::NoConvergence`] when
    /// the budget is spent.
    pub fn judge_beside(
        &mut self,
        size: f64,
        beside: impl FnOnce() -> f64,
    ) -> Result<Verdict, StepError> {
        self.judge_by((size, f64::INFINITY), 1, |_| beside() <= ULPS)
    }

    /// Takes in the sizes of a correction of a state, whose components may be round-off of larger ones. Where they
    /// make no progress and the whole is at round-off, nothing more is to be had.
    ///
    /// # Errors
    /// Those of [`judge`](Self::judge).
    pub fn judge_correction(&mut self, correction: &CorrectionSize) -> Result<Verdict, StepError> {
        let norm = correction.norm();
        self.judge_by((correction.component(), norm), 2, |whole| {
            norm <= NORMWISE_ROUND_OFF && (whole.is_negligible() || whole.is_round_off())
        })
    }

    /// Takes in the sizes of a correction; `is_round_off` is asked where so many have made no progress.
    fn judge_by(
        &mut self,
        (size, norm): (f64, f64),
        without_progress: u32,
        is_round_off: impl FnOnce(&Sizes) -> bool,
    ) -> Result<Verdict, StepError> {
        self.evaluations += 1;
        if !size.is_finite() {
            return Err(StepError::NonFinite {
                what: "a correction",
            });
        }
        self.components.take(size);
        self.whole.take(norm);
        let Self {
            components, whole, ..
        } = self;
        let is_done = components.is_negligible() || components.is_round_off();
        let rest_is_round_off =
            !is_done && components.since_progress >= without_progress && is_round_off(whole);
        self.rounded = rest_is_round_off;
        if is_done || rest_is_round_off {
            return Ok(Verdict::Converged);
        }
        if self.evaluations >= self.most {
            // Slow, as near a fold, but within round-off by now.
            if larger(size, components.remainder()) <= ULPS {
                return Ok(Verdict::Converged);
            }
            return Err(StepError::NoConvergence {
                evaluations: self.evaluations,
                correction: size,
            });
        }
        Ok(Verdict::Continue)
    }
}

#[cfg(test)]
mod tests {
    use super::super::LARGEST_REMAINDER;
    use super::{CorrectionSize, LinearIteration, Verdict};

    /// The size that ends an iteration of these sizes, and how many were taken.
    fn end(sizes: impl IntoIterator<Item = f64>) -> Option<(usize, f64)> {
        let mut iteration = LinearIteration::new(usize::MAX);
        let mut sizes = sizes.into_iter().enumerate();
        sizes.find(|(_, size)| iteration.judge(*size) == Ok(Verdict::Converged))
    }

    fn powers(rate: f64) -> impl Iterator<Item = f64> {
        std::iter::successors(Some(1.0), move |size| Some(size * rate))
    }

    /// The corrections rᵏ leave rᵏ⁺¹/(1 − r).
    #[test]
    fn slow_linear_convergence_is_no_stagnation() {
        for rate in [0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99] {
            let (_, size) = end(powers(rate)).expect("it converges");
            let remainder = size * rate / (1.0 - rate);
            // The rate is observed with the rounding of two sizes, magnified by 1/(1 − r).
            let bound = LARGEST_REMAINDER * (1.0 + 8.0 * f64::EPSILON / (1.0 - rate));
            assert!(remainder <= bound, "rate {rate}: {remainder:e}");
        }
    }

    /// Where the budget is spent, what is left counts: a rate of 1/2 comes to round-off, one of 9/10 not.
    #[test]
    fn a_spent_budget_is_no_failure_within_round_off() {
        for (rate, ends) in [(0.45, true), (0.9, false)] {
            let mut iteration = LinearIteration::new(50);
            let judged: Vec<_> = powers(rate)
                .take(50)
                .map(|size| iteration.judge(size))
                .collect();
            let (last, before) = judged.split_last().expect("fifty");
            assert!(
                before
                    .iter()
                    .all(|verdict| *verdict == Ok(Verdict::Continue)),
                "{rate}"
            );
            assert_eq!(*last == Ok(Verdict::Converged), ends, "{rate}: {last:?}");
        }
    }

    /// A rate that alternates between two values leaves the sum of both.
    #[test]
    fn an_alternating_rate_is_not_judged_by_its_better_half() {
        let mut sizes = vec![1.0];
        for k in 0..400 {
            sizes.push(sizes[k] * if k % 2 == 0 { 0.9 } else { 0.1 });
        }
        let (at, _) = end(sizes.iter().copied()).expect("it converges");
        let remainder: f64 = sizes[at + 1..].iter().sum();
        // The mean rate is 0.3: a size may be followed by three times itself beyond what that says.
        assert!(remainder <= 4.0 * LARGEST_REMAINDER, "{remainder:e}");
    }

    /// Round-off that repeats, as the solve of a lattice of sixteen particles did.
    #[test]
    fn round_off_in_a_cycle_ends_an_iteration() {
        let falling = powers(0.05).take(10);
        let cycle = [2.441e-14, 1.057e-16].into_iter().cycle().take(20);
        let (at, _) = end(falling.chain(cycle)).expect("it ends");
        assert!(at <= 14, "after {at}");
    }

    /// Components that are the round-off of larger ones may change by their whole size for ever.
    #[test]
    fn small_components_without_progress_do_not_hold_up_a_whole_at_round_off() {
        for cycle in [[0.25, 0.027], [1.0, 1.0], [0.027, 0.25]] {
            let mut iteration = LinearIteration::new(60);
            let mut ended = None;
            for k in 0..60 {
                let mut size = CorrectionSize::default();
                // The largest component converges at a rate of 1/10 down to half an ulp.
                let whole = libm::pow(0.1, f64::from(k));
                size.take(whole.max(f64::EPSILON / 4.0), 1.0);
                size.take(cycle[k as usize % 2] * 1e-20, 1e-20);
                assert!(!iteration.is_rounded());
                if iteration.judge_correction(&size) == Ok(Verdict::Converged) {
                    ended = Some(k);
                    break;
                }
            }
            let ended = ended.expect("it ends");
            assert!((16..=20).contains(&ended), "after {ended}");
            assert!(iteration.is_rounded());
        }
    }

    /// They do not end it while the whole still converges, however small its corrections are.
    #[test]
    fn a_whole_that_still_converges_is_not_at_round_off() {
        let mut iteration = LinearIteration::new(1000);
        for k in 0.. {
            let mut size = CorrectionSize::default();
            let whole = libm::pow(0.8, f64::from(k));
            size.take(whole, 1.0);
            size.take(1e-20, 1e-20);
            if iteration.judge_correction(&size) == Ok(Verdict::Converged) {
                assert!(4.0 * whole <= 1.001 * LARGEST_REMAINDER, "{whole:e}");
                assert!(iteration.is_rounded());
                break;
            }
        }
    }
}
