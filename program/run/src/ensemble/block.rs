//! A block of members, side by side, from their initial states to the end.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use leafwise_walk::Watched;

use super::begun::{Begun, Drawer};
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

/// Tools that a thread steps one block after the other with.
#[derive(Default)]
pub(super) struct Tools<'a> {
    drawer: Option<Drawer<'a>>,
    /// For blocks of so many lanes as the last.
    lanes: Option<(Watched<'a>, MemberRecords<'a>)>,
}

impl<'a> Tools<'a> {
    /// The walk of members where they begin, and their records, still empty.
    fn begin(
        &mut self,
        ensemble: &'a ComposedEnsemble,
        directory: &'a Path,
        begun: Begun,
    ) -> Result<&mut (Watched<'a>, MemberRecords<'a>), RunError> {
        let start = (begun.parameters.as_slice(), begun.states.as_slice());
        let lanes = begun.members.len();
        let kept = self.lanes.take();
        let kept = kept.filter(|(watched, _)| watched.walk().lanes() == lanes);
        let (watched, records) = kept.unzip();
        let mut watched = match watched {
            Some(mut watched) => {
                watched.start_again(start)?;
                watched
            }
            None => Watched::new(&ensemble.course, ensemble.run.method.map(), lanes, start)?,
        };
        watched.follow(&begun.members);
        for (lane, failure) in begun.failures.iter().enumerate() {
            if failure.is_some() {
                watched.leave_out(lane);
            }
        }
        let invariants = watched.invariants().to_vec();
        let initial = [&invariants[..], watched.indicators()];
        let records = match records {
            Some(mut records) => {
                records.start_again(begun, initial)?;
                records
            }
            None => MemberRecords::new(ensemble, directory, begun, initial)?,
        };
        Ok(self.lanes.insert((watched, records)))
    }
}

/// Steps the members `first .. first + lanes`; `None` where it was told to stop.
///
/// # Errors
/// [`RunError`] where an observer cannot be made, or crossings cannot be put aside in the directory.
pub(super) fn run<'a>(
    tools: &mut Tools<'a>,
    (ensemble, directory): (&'a ComposedEnsemble, &'a Path),
    (first, lanes): (u64, usize),
    signals: &Signals,
) -> Result<Option<Record>, RunError> {
    let drawer = tools.drawer.get_or_insert_with(|| Drawer::new(ensemble));
    let begun = drawer.draw(first, lanes);
    let (watched, records) = tools.begin(ensemble, directory, begun)?;
    watched.begin(&mut |look| records.take(look))?;
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
