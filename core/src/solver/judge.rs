//! When an iteration is done: the rules that every solve shares.
//!
//! A solve ends where the remainder of its last correction is negligible, or where corrections no
//! longer shrink because they are round-off. The two are told apart by all corrections so far: a slow
//! linear iteration falls below its smallest correction again and again, round-off does not, however
//! regularly it repeats.

use crate::error::StepError;

/// The largest relative remainder that ends a solve: 1/512 of a unit roundoff. Unlike rounding it has
/// a sign, which depends on where the orbit is, and adds up in proportion to the steps. With sixteen
/// times this, and a quarter of the safety, `leafwise stress long --long` found the rigid body's
/// Casimir 1.9e-12 off after 10⁸ steps, growing like steps^0.61; with this 3.1e-13, like steps^0.47.
pub(super) const LARGEST_REMAINDER: f64 = f64::EPSILON / 1024.0;

/// A correction this small beside the whole state is round-off of its largest component.
pub(super) const NORMWISE_ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Corrections up to this size are round-off where two in a row are not the smallest so far.
pub(super) const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Corrections up to this size are round-off where one is not the smallest so far.
pub(super) const ULPS: f64 = 4.0 * f64::EPSILON;

/// Corrections that fall by this do not turn into slow ones but for round-off.
const FAST: f64 = 0.1;

/// A component that does not fall below this part of its smallest correction makes no progress.
const PROGRESS: f64 = 0.9;

/// Refuses an equation's residual and Jacobian where a number of them is not finite.
///
/// # Errors
/// [`StepError::NonFinite`].
pub fn all_finite(residual: &[f64], jacobian: &[f64], what: &'static str) -> Result<(), StepError> {
    match residual.iter().chain(jacobian).all(|v| v.is_finite()) {
        true => Ok(()),
        false => Err(StepError::NonFinite { what }),
    }
}

/// Refuses a point whose guard, the last term of a series over the first or a radius over its limit, is not
/// below 1.
///
/// # Errors
/// [`StepError::LeftChart`], [`StepError::NonFinite`] where the guard is no number.
pub fn inside_chart(ratio: f64) -> Result<(), StepError> {
    if ratio < 1.0 {
        return Ok(());
    }
    Err(if ratio.is_nan() {
        StepError::NonFinite {
            what: "the distance to the edge of the realization's chart",
        }
    } else {
        StepError::LeftChart { ratio }
    })
}

/// max that keeps NaN.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// |size|/(scale + |size|), 0 for 0: a component that has no scale yet counts as 1.
#[inline(always)]
pub fn relative(size: f64, scale: f64) -> f64 {
    let size = size.abs();
    if size == 0.0 {
        0.0
    } else {
        size / (scale + size)
    }
}

/// Σ_k |m_k v_k|: what a row of a Jacobian makes of a state's round-off.
pub fn reach(row: &[f64], values: &[f64]) -> f64 {
    row.iter().zip(values).map(|(m, v)| (m * v).abs()).sum()
}

/// max |v_k|, NaN where one is.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| larger(m, v.abs()))
}

/// How many times the size of a state what a step adds to it may be and still serve as a scale. A
/// correction that is negligible beside it is below an ulp of the state.
const MOST_GROWTH: f64 = 1024.0;

/// The size of a state and of what is added to it, as far as a solve's iterates agree on it.
///
/// Corrections are judged against the state and its change. An iterate that is far off may have a
/// change so large that every correction is small beside it: a change counts up to the size of the
/// state, of the change that a solve starts from, and of the smallest change of two iterates.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    size: f64,
    smallest: f64,
    has_begun: bool,
}

impl Allowed {
    /// For a state of this size, its change included that a solve starts from.
    #[inline(always)]
    pub const fn new(size: f64) -> Self {
        Self {
            size,
            smallest: f64::INFINITY,
            has_begun: false,
        }
    }

    /// Takes in the size of an iterate's change.
    #[inline(always)]
    pub fn take(&mut self, change: f64) {
        self.smallest = self.smallest.min(change);
        if self.has_begun {
            self.size = self.size.max(self.smallest);
        }
        self.has_begun = true;
    }

    /// The size itself.
    #[inline(always)]
    pub fn size(&self) -> f64 {
        self.size
    }

    /// |change|, as far as it serves as a scale.
    #[inline(always)]
    pub fn scale(&self, change: f64) -> f64 {
        change.abs().min(MOST_GROWTH * self.size)
    }
}

/// Whether y and the increment Δ are of one step from x: |y − x − Δ/2| ≤ |Δ|, but for round-off.
/// β̂(L(y)) and α̂(L(y)) lie to both sides of y, or the first at y, but for an even part of second
/// order: a solution farther off is not the one that begins at y = x.
pub fn is_between(x: &[f64], y: &[f64], increment: &[f64]) -> bool {
    let (mut away, mut moved, mut state) = (0.0, 0.0, 0.0);
    for ((x, y), change) in x.iter().zip(y).zip(increment) {
        away = larger(away, (y - x - 0.5 * change).abs());
        moved = larger(moved, change.abs());
        state = larger(state, x.abs());
    }
    away <= moved + ROUND_OFF * state
}

/// The size of a correction, component by component and as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CorrectionSize {
    component: f64,
    largest: f64,
    state: f64,
    way: f64,
}

impl CorrectionSize {
    /// Takes in a component's correction and the scale it is judged against, the size of the state
    /// there and of what is added to it.
    pub fn take(&mut self, correction: f64, scale: f64) {
        self.component = larger(self.component, relative(correction, scale));
        self.largest = larger(self.largest, correction.abs());
        self.state = larger(self.state, scale);
    }

    /// Takes in how far a component moved so far, against the same scale.
    pub fn take_way(&mut self, way: f64, scale: f64) {
        self.way = larger(self.way, relative(way, scale));
    }

    /// The largest relative way of a component, at most 1.
    pub fn way(&self) -> f64 {
        self.way
    }

    /// The largest relative correction of a component, at most 1; NaN where one is not finite.
    pub fn component(&self) -> f64 {
        self.component
    }

    /// The largest correction over the largest scale.
    pub fn norm(&self) -> f64 {
        if self.largest == 0.0 {
            0.0
        } else {
            self.largest / self.state
        }
    }
}

/// Corrections that do not halve while they are larger than this leave open to which solution they lead.
pub(super) const WANDERING: f64 = 1e-6;

/// So many steps after one that was not plain are not taken as plain either: a solution of another branch
/// may look like that of a small step by itself, but hardly its neighbours.
const WATCHED: u32 = 64;

/// Whether it is plain that a solve is on the branch that begins at the state.
///
/// It is where Jacobians are near the identity, corrections halve and the start, extrapolated from the
/// steps before, met the solution up to half of the way from the state: in small steps but the first.
/// Elsewhere a [`Branch`](super::Branch) is to be followed.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    wanders: bool,
    steps: u32,
    /// The first correction and the last one.
    first: f64,
    last: f64,
}

impl Watch {
    /// Nothing seen.
    pub const NEW: Self = Self {
        wanders: false,
        steps: 0,
        first: f64::INFINITY,
        last: f64::INFINITY,
    };

    /// Begins a step.
    #[inline(always)]
    pub fn begin(&mut self) {
        self.wanders = self.steps > 0;
        self.steps = self.steps.saturating_sub(1);
        (self.first, self.last) = (f64::INFINITY, f64::INFINITY);
    }

    /// Takes in whether something is not plain.
    #[inline(always)]
    pub fn take(&mut self, wanders: bool) {
        if wanders {
            self.wanders = true;
            self.steps = WATCHED;
        }
    }

    /// Takes in a correction. It leaves open to which solution it leads where it is no round-off, and
    /// not half of the one before in its largest component.
    pub fn take_correction(&mut self, correction: &CorrectionSize) {
        let size = correction.component;
        let falls = size < 0.5 * self.last || size <= WANDERING || correction.norm() <= WANDERING;
        self.take(!falls);
        if self.first.is_infinite() {
            self.first = size;
        }
        self.last = size;
    }

    /// Takes in that a solve is done, by its last correction.
    pub fn take_end(&mut self, correction: &CorrectionSize) {
        self.take_start(self.first, correction.way);
    }

    /// Takes in how far a solve's start was off, and how far from the state its solution is. A start
    /// that missed half of the way may have met a solution by chance: y = x itself may nearly be one
    /// where terms of different orders in the step cancel.
    #[inline(always)]
    pub fn take_start(&mut self, off: f64, way: f64) {
        let is_foreseen = off <= 0.5 * way || off <= WANDERING;
        self.wanders |= !is_foreseen;
    }

    /// Whether the step is not plain.
    #[inline(always)]
    pub fn wanders(&self) -> bool {
        self.wanders
    }

    /// What the next step depends on.
    pub fn memory(&self) -> f64 {
        f64::from(self.steps)
    }

    /// Restores [`memory`](Self::memory).
    pub fn restore(&mut self, memory: f64) {
        self.steps = memory.clamp(0.0, f64::from(WATCHED)) as u32;
    }
}

/// What to do after a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Go on.
    Continue,
    /// What further corrections would add is negligible.
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
    /// What has to be undercut for progress, and corrections since the last that did.
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

    /// Σ_{k≥1} rᵏ of the last correction for the rate r of the last ones, the larger of the last
    /// ratio and the mean of two; without an observed rate the correction itself.
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
/// With corrections δ, rδ, r²δ, … the last leaves rδ/(1 − r). The iteration ends where that is below
/// 1/512 of a unit roundoff, judged by the observed rates, or where the corrections are round-off:
/// component by component, or as a whole where small components are the round-off of larger ones.
#[derive(Clone, Copy, Debug)]
pub struct LinearIteration {
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
    pub fn judge(&mut self, size: f64) -> Result<Verdict, StepError> {
        self.judge_state(size, f64::INFINITY)
    }

    /// Takes in the sizes of a correction of a state, whose components may be round-off of larger
    /// ones: where they make no progress and the whole is at round-off, nothing more is to be had.
    ///
    /// # Errors
    /// Those of [`judge`](Self::judge).
    pub fn judge_correction(&mut self, correction: &CorrectionSize) -> Result<Verdict, StepError> {
        self.judge_state(correction.component, correction.norm())
    }

    fn judge_state(&mut self, size: f64, norm: f64) -> Result<Verdict, StepError> {
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
        let rest_is_round_off = components.since_progress >= 2
            && norm <= NORMWISE_ROUND_OFF
            && (whole.is_negligible() || whole.is_round_off());
        self.rounded = rest_is_round_off && !is_done;
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
    use super::{Allowed, CorrectionSize, LARGEST_REMAINDER, LinearIteration, Verdict, is_between};

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

    /// Beside an iterate's change of 1e30 a correction of 1e10 is not small.
    #[test]
    fn the_change_of_an_iterate_far_off_is_no_scale() {
        let mut allowed = Allowed::new(2.0);
        for change in [0.5, 1e30, 1e25] {
            allowed.take(change);
            assert!(allowed.scale(change) <= 2048.0, "{}", allowed.scale(change));
        }
        // Where two iterates agree on a change that is larger than the state, it is the scale.
        let mut allowed = Allowed::new(1e-20);
        allowed.take(0.1);
        allowed.take(0.1);
        assert_eq!(allowed.scale(0.1), 0.1);
    }

    #[test]
    fn a_solution_far_from_state_and_increment_is_told() {
        let x = [1.0, -2.0];
        assert!(is_between(&x, &[1.1, -2.0], &[0.2, 0.0]));
        assert!(is_between(&x, &x, &[0.2, 0.0]));
        assert!(is_between(&x, &x, &[0.0, 0.0]));
        assert!(!is_between(&x, &[3.0, -2.0], &[0.2, 0.0]));
        assert!(!is_between(&x, &[f64::NAN, -2.0], &[0.2, 0.0]));
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
