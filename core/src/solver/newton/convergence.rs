//! When a solve is done, and which of its two kernels comes next.

use crate::solver::LARGEST_REMAINDER;
use crate::solver::iteration::NORMWISE_ROUND_OFF;

/// How much larger than the observed convergence constant the true one may be: the increment's own
/// remainder is up to three times the solution's, and along the orbit the constant changes.
const SAFETY: f64 = 16.0;

/// Below this a correction is too much round-off to observe the constant by.
const OBSERVABLE: f64 = 16.0 * f64::EPSILON;

/// What comes after a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// What another correction would add is negligible.
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
    last: f64,
    /// (2D + δ)δ of the last correction.
    spread: f64,
    /// How many corrections in a row did not shrink.
    stuck: u32,
    pub(super) evaluations: u32,
}

impl Convergence {
    /// Nothing observed.
    pub(super) fn new() -> Self {
        Self {
            constant: f64::INFINITY,
            first: f64::INFINITY,
            distance: f64::INFINITY,
            last: f64::INFINITY,
            spread: f64::INFINITY,
            stuck: 0,
            evaluations: 0,
        }
    }

    /// Starts a step at `distance` from where the present Jacobian was taken, if there is one: by it
    /// if `most_chords` corrections will do, an evaluation with a new one costing more.
    #[inline(always)]
    pub(super) fn start(&mut self, distance: Option<f64>, most_chords: u32) -> Next {
        self.last = f64::INFINITY;
        self.spread = f64::INFINITY;
        self.stuck = 0;
        self.evaluations = 0;
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
        if self.spread.is_finite() && self.spread > 0.0 && size > OBSERVABLE {
            let observed = size / self.spread;
            // Only a fresh observation may lower the constant, and slowly.
            self.constant = if self.constant.is_finite() {
                observed.max(0.9 * self.constant)
            } else {
                observed
            };
        }
        let is_stuck = size >= 0.5 * self.last;
        self.stuck = if is_stuck { self.stuck + 1 } else { 0 };
        self.last = size;
        self.spread = (2.0 * self.distance + size) * size;
        let remainder = self.constant * self.spread;
        let stagnates = is_stuck && size <= 64.0 * f64::EPSILON;
        if size <= LARGEST_REMAINDER
            || SAFETY * remainder <= LARGEST_REMAINDER
            || stagnates
            || self.stuck >= 2 && norm() <= NORMWISE_ROUND_OFF
        {
            return Next::Done;
        }
        self.distance += size;
        if !is_stuck && self.chords(self.distance, remainder, most_chords + 1) {
            Next::Chord
        } else {
            Next::Newton
        }
    }

    /// Whether `most` corrections by a Jacobian taken at `distance` reduce `error` to nothing. Each
    /// multiplies it by 2CD.
    #[inline(always)]
    fn chords(&self, distance: f64, error: f64, most: u32) -> bool {
        let rate = 2.0 * self.constant * distance;
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
        (lane.constant, lane.first) = (1.0, 0.0);
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

    /// Corrections that stop to shrink at round-off are noise, whatever the estimate says.
    #[test]
    fn corrections_that_stagnate_at_round_off_end_a_solve() {
        let mut lane = away(0.1);
        let size = 4.0 * f64::EPSILON;
        assert_ne!(lane.judge(size, || f64::INFINITY, false, 4), Next::Done);
        assert_eq!(lane.judge(size, || f64::INFINITY, false, 4), Next::Done);
    }
}
