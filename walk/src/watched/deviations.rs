//! Vectors that indicators of chaos follow, carried over each step.

use leafwise_core::walk::column;

use super::Watched;
use crate::fault::Fault;
use crate::indicators::Deviations;

impl Watched<'_> {
    /// The course's indicators of chaos after the last step: indicator i of lane w at `[i*lanes + w]`.
    pub fn indicators(&self) -> &[f64] {
        let own = self.deviations.as_ref();
        own.map_or(&[], Deviations::values)
    }

    /// Ends the lanes whose leaf has too few dimensions.
    pub(super) fn end_flat(&mut self) {
        for lane in std::mem::take(&mut self.flat) {
            if self.walk.lives(lane) {
                self.fail(lane, Fault::Leaf, 0);
            }
        }
    }

    /// Carries the vectors of every lane that goes on over the last step.
    pub(super) fn follow_deviations(&mut self) {
        let Some(mut deviations) = self.deviations.take() else {
            return;
        };
        let lanes = self.walk.lanes();
        for lane in 0..lanes {
            if self.walk.lives(lane) {
                let (tangent, time) = (self.walk.tangent(lane), self.time(lane));
                // Made anew for each step: a walk that is continued has the bits of a whole one.
                let again = || {
                    let parameters = column(self.alones.parameters(), lane, lanes);
                    let (epsilon, h) = (self.course.epsilon, self.course.h);
                    self.map.differential(&parameters, epsilon, h)
                };
                if let Err(fault) = deviations.follow(lane, tangent, again, time) {
                    self.fail(lane, fault, self.walk.steps());
                }
            }
        }
        self.deviations = Some(deviations);
    }
}
