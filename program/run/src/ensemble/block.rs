//! A block of members, side by side, from their initial states to the end.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use leafwise_walk::Watched;

use super::begun::Begun;
use super::member_records::MemberRecords;
use super::plan::ComposedEnsemble;
use super::record::Record;
use crate::RunError;

/// Coordinates stepped between two looks at the flag: about a millisecond's work.
const COORDINATES_A_LOOK: usize = 4096;

/// Signals to and from blocks while they run: a count of steps, and a flag to stop.
#[derive(Debug, Default)]
pub(super) struct Signals {
    /// Steps of all members.
    pub steps: AtomicU64,
    /// Whether blocks are to stop where they are.
    pub stop: AtomicBool,
}

/// Steps the members `first .. first + lanes`; `None` where it was told to stop.
///
/// # Errors
/// [`RunError`] where an observer cannot be made, or crossings cannot be put aside in the directory.
pub(super) fn run(
    ensemble: &ComposedEnsemble,
    directory: &Path,
    (first, lanes): (u64, usize),
    signals: &Signals,
) -> Result<Option<Record>, RunError> {
    let begun = Begun::draw(ensemble, first, lanes);
    let (map, parameters) = (ensemble.run.method.map(), begun.parameters.clone());
    let mut watched = Watched::new(&ensemble.course, map, parameters, &begun.states)?;
    let members: Vec<u64> = (first..first + lanes as u64).collect();
    watched.follow(&members);
    for (lane, failure) in begun.failures.iter().enumerate() {
        if failure.is_some() {
            watched.leave_out(lane);
        }
    }
    let mut records = MemberRecords::new(ensemble, directory, begun, watched.invariants())?;
    watched.begin(&mut |look| records.take(look))?;
    records.take_sample(watched.walk().state());
    let total = ensemble.run.plan.steps;
    let stride = (COORDINATES_A_LOOK / (lanes * ensemble.population.dimension())).max(1) as u64;
    let (mut steps, mut shown) = (0_u64, 0);
    while watched.walk().living() > 0 {
        if signals.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let until = total.min(steps.saturating_add(stride));
        watched.advance(until - steps, &mut |look| records.take(look))?;
        steps = until;
        // Members that have ended count as those that go on; where steps are not counted, each is one.
        let is_over = watched.walk().living() == 0;
        let made = match ensemble.steps() {
            Some(all) if is_over => all,
            Some(_) => steps,
            None => u64::from(is_over),
        };
        signals
            .steps
            .fetch_add((made - shown) * lanes as u64, Ordering::Relaxed);
        shown = made;
    }
    watched.end_on_events(&mut |look| records.take(look))?;
    Ok(Some(records.finish(watched.statistics())))
}
