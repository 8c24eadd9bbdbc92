//! Memory of a walk of one lane: taken where it is interrupted, and what it continues from.

use leafwise_core::walk::Checkpoint;

use super::Watched;
use crate::events::Side;
use crate::fault::StopPlace;
use crate::indicators::{Deviation, Deviations};
use crate::pace::PacedSteps;
use crate::step::StepStart;
use crate::turns::Past;

/// Everything that later steps and looks of one lane depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// x_k, its compensation and the solver's memory.
    pub walk: Checkpoint,
    /// Where the last step begins.
    pub start: StepStart,
    /// How the pace has gone.
    pub paced: PacedSteps,
    /// Values of the condition's difference.
    pub stop: Past,
    /// Where the condition has ended the walk between two steps.
    pub stopped: Option<StopPlace>,
    /// Where it stands beside the surface of each event, and how often it has crossed that.
    pub events: Vec<(Side, u64)>,
    /// Values of the corners of the condition's difference, then of those of each event.
    pub corners: Vec<Past>,
    /// Samples taken at times.
    pub samples: u64,
    /// Vectors of indicators of chaos; empty without one.
    pub deviation: Deviation,
}

impl Watched<'_> {
    /// Everything that later steps and looks of a walk of one lane depend on.
    pub fn memory(&self) -> Memory {
        Memory {
            walk: self.walk.checkpoint(),
            start: self.start.clone(),
            paced: self.paced[0].clone(),
            stop: (self.stop.as_ref()).map_or_else(Past::default, |stop| stop.pasts[0]),
            stopped: self.ended(0).and_then(StopPlace::of),
            events: (self.events.iter())
                .map(|event| (event.sides[0], event.counts[0]))
                .collect(),
            corners: (self.stop.iter().map(|stop| &stop.corners))
                .chain(self.events.iter().map(|event| &event.corners))
                .flat_map(|corners| corners.of(0).iter().copied())
                .collect(),
            samples: self.next[0],
            deviation: (self.deviations.as_ref())
                .map_or_else(Deviation::default, Deviations::memory),
        }
    }

    /// Continues a walk of one lane from its memory, to the same bits as without interruption.
    ///
    /// # Errors
    /// Returns the expected length of the list that belongs to another walk.
    pub fn restore(&mut self, memory: &Memory) -> Result<(), usize> {
        let (own, events) = (self.start.state.len(), self.events.len());
        if memory.start.state.len() != own || memory.start.compensation.len() != own {
            return Err(own);
        }
        if memory.events.len() != events {
            return Err(events);
        }
        self.restore_corners(&memory.corners)?;
        self.walk.restore(&memory.walk)?;
        let time = self.time(0);
        match &mut self.deviations {
            Some(deviations) => deviations.restore(&memory.deviation, time)?,
            None if memory.deviation == Deviation::default() => {}
            None => return Err(0),
        }
        self.mark_moved();
        self.start.clone_from(&memory.start);
        self.paced[0].clone_from(&memory.paced);
        if let Some(stop) = &mut self.stop {
            stop.pasts[0] = memory.stop;
        }
        if let Some(stopped) = &memory.stopped {
            if stopped.state.len() != own {
                return Err(own);
            }
            self.end(0, stopped.clone().into());
        }
        self.next[0] = memory.samples;
        for (event, (side, count)) in self.events.iter_mut().zip(&memory.events) {
            (event.sides[0], event.counts[0]) = (*side, *count);
        }
        Ok(())
    }

    fn restore_corners(&mut self, memory: &[Past]) -> Result<(), usize> {
        let of_stop = self.stop.iter_mut().map(|stop| &mut stop.corners);
        let of_events = self.events.iter_mut().map(|event| &mut event.corners);
        let (mut left, mut count) = (memory, 0);
        for corners in of_stop.chain(of_events) {
            count += corners.of(0).len();
            left = corners.restore(left).ok_or(count)?;
        }
        if left.is_empty() { Ok(()) } else { Err(count) }
    }
}
