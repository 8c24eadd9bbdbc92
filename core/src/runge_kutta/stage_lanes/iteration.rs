//! Corrections of the stages until they are negligible, and their judgement.

use leafwise_expression::vector::{Register, RegisterWork};

use super::lanes::{From, Lanes};
use super::solution::{FixedPoint, Start, Unsettled};

/// Budget of one solve.
const MOST_EVALUATIONS: u64 = 60;

/// A stage is known where its correction is below this part of its coordinate.
const SETTLED: f64 = f64::EPSILON;

/// Corrections below this part that fall by less than [`SLOW`] twice are round-off.
const ROUND_OFF: f64 = 64.0 * SETTLED;

/// Corrections that fall by less on the average, from the first on, do not certify the solution. A map that contracts
/// by 1/2 about z, where the step begins, has one fixed point near. So has each map that takes a part of the step.
/// The fixed point is thus the one that is connected with z.
const SLOW: f64 = 0.5;

/// Corrections sway by so much about their average fall.
const SWAY: f64 = 8.0;

/// A start that is off by more than this part of the way from z may lead to another solution.
const FAR: f64 = 0.5;

/// Part of a coordinate below which what later corrections would add is forgotten: 1/8 of a unit roundoff. Energies
/// drift as they do with 1/1024 of it.
const NEGLIGIBLE: f64 = f64::EPSILON / 16.0;

/// One solve from one start.
pub(super) struct Solve<'own, const W: usize> {
    pub(super) lanes: &'own mut Lanes<W>,
    pub(super) at: usize,
    pub(super) from: From,
    pub(super) start: Start<'own>,
    pub(super) change: &'own mut [f64],
    pub(super) outcome: &'own mut Result<FixedPoint, Unsettled>,
}

/// How the corrections of a solve ended.
#[derive(Clone, Copy)]
enum Ending {
    /// The rest is negligible, and so is its effect on slopes.
    Negligible,
    /// The stages are known to their own digits.
    Settled,
    /// Corrections go up and down.
    Rounded,
    /// Nothing certifies a solution.
    Unsettled,
}

impl<const W: usize> RegisterWork for Solve<'_, W> {
    #[inline(always)]
    fn run<R: Register>(self) {
        let Self {
            lanes,
            at,
            from,
            start,
            change,
            outcome,
        } = self;
        lanes.begin::<R>(at, from, start);
        let is_cold = from == From::State;
        let mut is_zero = true;
        for z in start.point {
            is_zero &= *z == 0.0;
        }
        // The last two corrections, how many as small as round-off did not fall, and what the next one may be.
        let [mut before, mut last] = [f64::NAN; 2];
        let mut stalled = 0;
        let mut most = f64::INFINITY;
        let mut evaluations = 0;
        let (ending, correction) = loop {
            evaluations += 1;
            lanes.evaluate();
            let is_measured = match evaluations {
                1 | 16 => true,
                2..=4 => is_cold,
                _ => false,
            };
            let mut way = 0.0;
            let size = match (is_measured, is_zero) {
                (false, true) => lanes.correct::<R, true>(start.point),
                (false, false) => lanes.correct::<R, false>(start.point),
                (true, true) => lanes.correct_measuring::<R, true>(start, &mut way),
                (true, false) => lanes.correct_measuring::<R, false>(start, &mut way),
            };
            // With δ_k = r δ_{k−1} and r ≤ 1/2 the rest is δ_k r/(1 − r) ≤ 2 δ_k²/δ_{k−1}. Rates alternate where
            // eigenvalues are pairs.
            if size * size <= 0.5 * NEGLIGIBLE * last && size * last <= 0.5 * NEGLIGIBLE * before {
                break (Ending::Negligible, size);
            }
            if size <= SETTLED {
                break (Ending::Settled, size);
            }
            // Round-off goes up and down.
            stalled += u32::from(size <= ROUND_OFF && size > SLOW * last);
            if stalled >= 2 || stalled == 1 && size <= 4.0 * SETTLED {
                break (Ending::Rounded, size);
            }
            let is_far = evaluations == 1 && !is_cold && size > FAR * way;
            if is_far || size > most || !size.is_finite() || evaluations == MOST_EVALUATIONS {
                break (Ending::Unsettled, size);
            }
            most = match evaluations {
                1 => SWAY * SLOW * size,
                _ => SLOW * most,
            };
            [before, last] = [last, size];
        };
        let is_found = match ending {
            Ending::Unsettled => false,
            // The slopes are those of the stages before the last correction: off by what the next one would be.
            Ending::Negligible => lanes.end(at, change),
            Ending::Settled | Ending::Rounded => {
                evaluations += 1;
                lanes.evaluate();
                lanes.end(at, change)
            }
        };
        *outcome = match (is_found, ending) {
            (true, _) => Ok(FixedPoint {
                evaluations,
                is_rounded: matches!(ending, Ending::Rounded),
            }),
            (false, Ending::Unsettled) => Err(Unsettled {
                evaluations,
                correction,
            }),
            (false, _) => Err(Unsettled {
                evaluations,
                correction: f64::NAN,
            }),
        };
    }
}
