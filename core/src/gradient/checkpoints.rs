//! The states of a run in reverse order, from few that are kept.
//!
//! From s checkpoints, the first state among them, C(s + t, s) steps are reversed by taking none of them more than t
//! times forwards. No schedule reverses more (A. Griewank, A. Walther, *Algorithm 799: revolve*, ACM Transactions on
//! Mathematical Software 26 (2000)).

use super::error::GradientError;
use crate::error::StepError;
use crate::walk::{Checkpoint, Walk};

/// Checkpoints for a run of so many steps: four times its binary logarithm.
pub(super) fn checkpoints(steps: u64) -> u64 {
    4 * u64::from(u64::BITS - steps.leading_zeros()).max(1)
}

/// C(s + t, s), at most 2⁶³.
fn reach(checkpoints: u64, times: u64) -> u64 {
    let mut product: u128 = 1;
    for k in 1..=u128::from(times) {
        product = product * (u128::from(checkpoints) + k) / k;
        if product > u128::from(u64::MAX / 2) {
            return u64::MAX / 2;
        }
    }
    product as u64
}

/// After how many of `steps` the next checkpoint stands: the rest is reversed with one fewer.
fn split(steps: u64, checkpoints: u64) -> u64 {
    let mut times = 1;
    while reach(checkpoints, times) < steps {
        times += 1;
    }
    // With more, one part or the other would be taken once more often than the whole.
    reach(checkpoints, times - 1).min(steps - reach(checkpoints - 1, times - 1))
}

/// Visits the `steps` states that follow `from`, the last first; the end of the run is none of them.
///
/// # Errors
/// Those of steps taken again, and of `visit`.
pub(super) fn visit_in_reverse(
    walk: &mut Walk,
    from: &Checkpoint,
    steps: u64,
    checkpoints: u64,
    visit: &mut dyn FnMut(&Checkpoint) -> Result<(), GradientError>,
) -> Result<(), GradientError> {
    if steps <= 1 {
        return if steps == 1 { visit(from) } else { Ok(()) };
    }
    let first = split(steps, checkpoints);
    let restored = walk.restore(from);
    debug_assert!(restored.is_ok(), "a checkpoint of this walk");
    let at = |error: StepError, step: u64| GradientError::Step { step, error };
    let advanced = walk.advance(first);
    advanced.map_err(|error| at(error, walk.steps()))?;
    let middle = walk.checkpoint();
    visit_in_reverse(walk, &middle, steps - first, checkpoints - 1, visit)?;
    visit_in_reverse(walk, from, first, checkpoints, visit)
}

#[cfg(test)]
mod tests {
    use super::{checkpoints, reach, split};

    /// Steps taken forwards while `steps` are reversed, and the most checkpoints held at once.
    fn cost(steps: u64, checkpoints: u64, held: u64) -> (u64, u64) {
        if steps <= 1 {
            return (0, held);
        }
        let first = split(steps, checkpoints);
        assert!(first >= 1 && first < steps);
        let (right, most) = cost(steps - first, checkpoints - 1, held + 1);
        let (left, other) = cost(first, checkpoints, held);
        (first + right + left, most.max(other))
    }

    /// Griewank and Walther's least number, t l − C(s + t, t − 1) for l steps, t the least with C(s + t, s) ≥ l.
    #[test]
    fn no_schedule_takes_fewer_steps() {
        for slots in 1..6 {
            for steps in 2..200 {
                let times = (1..).find(|t| reach(slots, *t) >= steps).expect("it grows");
                let below: u64 = reach(slots + 1, times - 1);
                let (forwards, held) = cost(steps, slots, 0);
                assert_eq!(forwards, times * steps - below, "{steps} steps, {slots}");
                assert!(held <= slots);
            }
        }
    }

    #[test]
    fn a_million_steps_are_taken_four_times_with_eighty_checkpoints() {
        let slots = checkpoints(1_000_000);
        assert_eq!(slots, 80);
        let (forwards, held) = cost(1_000_000, slots, 0);
        assert!(
            forwards < 4 * 1_000_000 && held <= slots,
            "{forwards} {held}"
        );
    }
}
