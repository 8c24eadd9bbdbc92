//! When a solve is done, and which of its two kernels comes next.

use crate::judge::{LARGEST_REMAINDER, NORMWISE_ROUND_OFF, ROUND_OFF, ULPS, larger};

/// Safety factor: how much larger than the observed convergence constant the true one may be. The increment's own
/// remainder is up to three times the solution's, and along the orbit the constant changes.
const SAFETY: f64 = 16.0;

/// Below this a correction is too much round-off to observe the constant by: it bounds it.
const OBSERVABLE: f64 = ULPS;

/// The smallest constant that a decision relies on. A solve that ends after its first correction observes nothing.
/// However small the constant was where it was last observed, such a correction is at most 5e-10. It leaves C times
/// 1/512 of a unit roundoff where C has grown to be larger than 1.
const LEAST_CONSTANT: f64 = 1.0 / 16.0;

/// Largest growth of a first correction's (2D + δ)δ since the constant was last observed. A correction beyond it,
/// about four times as large, is followed by another: to observe the constant again.
const OUTGROWN: f64 = 16.0;

/// Next evaluation after a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// No evaluation: another correction would add a negligible amount.
    Done,
    /// An evaluation with the Jacobian.
    Newton,
    /// One without: the Jacobian that is there will do.
    Chord,
}

/// One lane's corrections, as sizes relative to the state.
///
/// A correction δ by a Jacobian that was taken at the distance D leaves an error of C(2D + δ)δ: for
/// D = 0 Newton's C δ². The constant C is observed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convergence {
    /// C; infinite before it was observed.
    pub(super) constant: f64,
    /// The first correction of the last step: what an extrapolated start is off by.
    pub(super) first: f64,
    /// D.
    distance: f64,
    pub(super) last: f64,
    /// (2D + δ)δ of the last correction, and of the first of the last step that made two.
    spread: f64,
    pub(super) seen: f64,
    /// How many corrections in a row did not shrink.
    stuck: u32,
    pub(super) evaluations: u32,
    /// Whether the solve ended as a whole alone.
    pub(super) rounded: bool,
}

impl Convergence {
    /// Nothing observed.
    pub(super) const fn new() -> Self {
        Self {
            constant: f64::INFINITY,
            first: f64::INFINITY,
            distance: f64::INFINITY,
            last: f64::INFINITY,
            spread: f64::INFINITY,
            seen: 0.0,
            stuck: 0,
            evaluations: 0,
            rounded: false,
        }
    }

    /// Starts a step at `distance` from where the present Jacobian was taken, if there is one. The step begins by it
    /// if `most_chords` corrections will do, an evaluation with a new one costing more.
    #[inline(always)]
    pub(super) fn start(&mut self, distance: Option<f64>, most_chords: u32) -> Next {
        self.last = f64::INFINITY;
        self.spread = f64::INFINITY;
        self.stuck = 0;
        self.evaluations = 0;
        self.rounded = false;
        match distance {
            Some(distance) if self.chords(distance, self.first, most_chords) => {
                self.distance = distance;
                Next::Chord
            }
            _ => Next::Newton,
        }
    }

    /// Takes in a correction of the relative size `size`, by a Jacobian taken where it was found
    /// (`is_newton`) or earlier; `norm` is its size beside the whole state. One more evaluation with
    /// a Jacobian costs what `most_chords` evaluations without it do.
    #[inline(always)]
    pub(super) fn judge(
        &mut self,
        size: f64,
        norm: impl FnOnce() -> f64,
        is_newton: bool,
        most_chords: u32,
    ) -> Next {
        if self.evaluations == 0 {
            self.first = size;
        }
        self.evaluations += 1;
        if is_newton {
            self.distance = 0.0;
        }
        if self.spread.is_finite() && self.spread > 0.0 {
            self.observe(size);
        }
        let is_stuck = size >= 0.5 * self.last;
        self.stuck = if is_stuck { self.stuck + 1 } else { 0 };
        self.last = size;
        self.spread = (2.0 * self.distance + size) * size;
        let remainder = self.remainder(self.spread);
        let is_observed = self.evaluations > 1 || self.is_observed(self.spread);
        // By an old Jacobian corrections may shrink slowly; by a new one they do not.
        let noise = if is_newton { ROUND_OFF } else { ULPS };
        let is_done = size <= LARGEST_REMAINDER
            || is_observed && SAFETY * remainder <= LARGEST_REMAINDER
            || is_stuck && size <= noise;
        if is_done {
            return Next::Done;
        }
        // A small component may be the round-off of larger ones.
        if self.stuck >= 2 && norm() <= NORMWISE_ROUND_OFF {
            self.rounded = true;
            return Next::Done;
        }
        self.distance += size;
        if !is_stuck && self.chords(self.distance, remainder, most_chords + 1) {
            Next::Chord
        } else {
            Next::Newton
        }
    }

    /// Whether the next step, if it begins with a Jacobian of its own, is taken to need a second evaluation. This is
    /// judged by the growth of first corrections from `before`, the step before this one, to this one.
    #[inline(always)]
    pub(super) fn foresees_two(&self, before: f64) -> bool {
        let size = self.first * (self.first / before);
        let spread = size * size;
        let is_done =
            self.is_observed(spread) && SAFETY * self.remainder(spread) <= LARGEST_REMAINDER;
        !is_done && size > LARGEST_REMAINDER
    }

    /// C(2D + δ)δ, the remainder of a correction of this (2D + δ)δ, C being at least `LEAST_CONSTANT`.
    #[inline(always)]
    fn remainder(&self, spread: f64) -> f64 {
        larger(self.constant, LEAST_CONSTANT) * spread
    }

    /// Whether the constant was observed at a correction that was about as large.
    #[inline(always)]
    fn is_observed(&self, spread: f64) -> bool {
        spread <= OUTGROWN * self.seen
    }

    /// Takes in what a correction left, the size of the next: C, or a bound of it where that is
    /// round-off. Only a fresh observation may lower the constant, and slowly.
    #[inline(always)]
    fn observe(&mut self, size: f64) {
        if self.evaluations == 2 {
            self.seen = self.spread;
        }
        let observed = larger(size, OBSERVABLE) / self.spread;
        let lowered = larger(observed, 0.9 * self.constant);
        self.constant = if self.constant.is_infinite() {
            observed
        } else if size > OBSERVABLE || lowered < self.constant {
            lowered
        } else {
            self.constant
        };
    }

    /// Whether `most` corrections by a Jacobian taken at `distance` reduce `error` to nothing. Each
    /// multiplies it by 2CD.
    #[inline(always)]
    fn chords(&self, distance: f64, error: f64, most: u32) -> bool {
        let rate = 2.0 * larger(self.constant, LEAST_CONSTANT) * distance;
        let mut error = SAFETY * error;
        for _ in 0..most {
            error *= rate;
            if error <= LARGEST_REMAINDER {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::{Convergence, LARGEST_REMAINDER, Next};

    /// A lane whose Jacobian is a distance D off, with C = 1: a correction δ leaves 2Dδ.
    fn away(distance: f64) -> Convergence {
        let mut lane = Convergence::new();
        (lane.constant, lane.first, lane.seen) = (1.0, 0.0, f64::INFINITY);
        assert_eq!(lane.start(Some(distance), 4), Next::Chord);
        lane
    }

    /// A remainder has a sign: a correction of an ulp by a Jacobian that is far off leaves one that
    /// adds up over many steps, and does not end the solve; by one that is near, it does.
    #[test]
    fn a_correction_of_an_ulp_ends_a_solve_only_where_what_it_leaves_is_negligible() {
        let judge = |distance: f64| {
            let size = f64::EPSILON;
            away(distance).judge(size, || f64::INFINITY, false, 4)
        };
        assert_ne!(judge(0.1), Next::Done);
        let near = LARGEST_REMAINDER / f64::EPSILON / 64.0;
        assert_eq!(judge(near), Next::Done);
    }

    /// Corrections that stop shrinking at round-off are noise, whatever the estimate says.
    #[test]
    fn corrections_that_stagnate_at_round_off_end_a_solve() {
        let mut lane = away(0.1);
        let size = 4.0 * f64::EPSILON;
        assert_ne!(lane.judge(size, || f64::INFINITY, false, 4), Next::Done);
        assert_eq!(lane.judge(size, || f64::INFINITY, false, 4), Next::Done);
    }

    /// First corrections that grow by a fifth a step and fall again: the two before it tell whether a step takes a second
    /// evaluation. With C = 1 those above √(ε/1024/16) = 1.2e-10 do.
    #[test]
    fn a_second_evaluation_is_foreseen_by_the_growth_of_first_corrections() {
        let mut lane = Convergence::new();
        (lane.constant, lane.seen) = (1.0, f64::INFINITY);
        let up: Vec<f64> = (0..20)
            .map(|at| 1e-11 * libm::pow(1.2, f64::from(at)))
            .collect();
        let sizes = up.iter().chain(up.iter().rev());
        let (mut seen, mut missed) = (Vec::new(), 0);
        let mut foreseen = false;
        for size in sizes {
            let before = lane.first;
            lane.start(None, 4);
            let needs_two = lane.judge(*size, || f64::INFINITY, true, 4) != Next::Done;
            missed += u32::from(needs_two != foreseen);
            seen.push(needs_two);
            foreseen = lane.foresees_two(before);
        }
        assert!(seen.contains(&true) && seen.contains(&false));
        assert_eq!(missed, 0);
    }

    /// A constant observed where the map is nearly linear says nothing of where it is not: a first
    /// correction that outgrows the last one observed is followed by another.
    #[test]
    fn a_stale_constant_does_not_end_a_solve() {
        let mut lane = Convergence::new();
        let judge = |lane: &mut Convergence, sizes: &[f64]| {
            lane.start(None, 4);
            let mut sizes = sizes.iter();
            sizes.position(|size| lane.judge(*size, || f64::INFINITY, true, 4) == Next::Done)
        };
        // Nearly linear: 1e-4, then nothing but round-off.
        assert_eq!(judge(&mut lane, &[1e-4, 1e-17, 1e-18, 0.0]), Some(1));
        assert!(lane.constant <= 1e-7, "{:e}", lane.constant);
        // The same again needs no second correction to be small, but one to be seen.
        assert_eq!(judge(&mut lane, &[1e-10]), Some(0));
        // It grows, and what it leaves with it: C = 100.
        assert_eq!(judge(&mut lane, &[1e-6, 1e-10, 1e-18, 0.0]), Some(2));
        assert!(lane.constant >= 50.0, "{:e}", lane.constant);
        assert_eq!(judge(&mut lane, &[1e-9, 1e-16, 0.0]), Some(1));
    }
}
