//! Looks at one lane of many, at states within its last step.

use leafwise_core::evaluator::is_same;
use leafwise_core::walk::column;
use leafwise_core::{BuildError, StepMap};

use crate::course::Course;
use crate::functions::FunctionValues;
use crate::pace::PaceWatch;
use crate::step::{LastStep, StepStart};

/// Looks at one lane within its last step: what is made once a lane has something to look at, one for all lanes where they have the
/// same parameters.
pub(crate) struct Alones<'a> {
    course: &'a Course,
    map: &'a dyn StepMap,
    lanes: usize,
    /// Of all lanes, a structure of arrays.
    parameters: Vec<f64>,
    slots: Vec<Option<Alone<'a>>>,
}

/// One lane's last step and functions of its state.
pub(crate) struct Alone<'a> {
    pub last: LastStep<'a>,
    pub pace: Option<PaceWatch<'a>>,
    pub stop: Option<FunctionValues>,
    pub events: Vec<FunctionValues>,
}

impl<'a> Alones<'a> {
    /// Nothing made yet, of so many lanes.
    pub fn new(
        course: &'a Course,
        map: &'a dyn StepMap,
        (lanes, parameters): (usize, &[f64]),
    ) -> Self {
        let mut alones = Self {
            course,
            map,
            lanes,
            parameters: parameters.to_vec(),
            slots: Vec::new(),
        };
        alones.make_room();
        alones
    }

    fn make_room(&mut self) {
        let mut rows = self.parameters.chunks_exact(self.lanes);
        let differ = rows.any(|row| row.iter().any(|value| *value != row[0]));
        let count = if differ { self.lanes } else { 1 };
        self.slots.clear();
        self.slots.resize_with(count, || None);
    }

    /// Takes other parameters. What was made stays where they are the same.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        if !is_same(&self.parameters, parameters) {
            self.parameters.copy_from_slice(parameters);
            self.make_room();
        }
    }

    /// The parameters of all lanes, a structure of arrays.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// A lane, whose last step begins at its state of `start`.
    pub fn at(&mut self, lane: usize, start: &StepStart) -> Result<&mut Alone<'a>, BuildError> {
        let at = lane.min(self.slots.len() - 1);
        let lanes = self.lanes;
        let slot = &mut self.slots[at];
        if slot.is_none() {
            let parameters = column(&self.parameters, lane, lanes);
            *slot = Some(Alone::new(self.course, self.map, &parameters)?);
        }
        let alone = slot.as_mut().expect("it was made above");
        let own = &mut alone.last.start;
        for (own, all) in [
            (&mut own.state, &start.state),
            (&mut own.compensation, &start.compensation),
        ] {
            own.clear();
            own.extend(all.iter().skip(lane).step_by(lanes));
        }
        own.from.clear();
        own.from.extend(start.from.get(lane));
        Ok(alone)
    }
}

impl<'a> Alone<'a> {
    fn new(
        course: &'a Course,
        map: &'a dyn StepMap,
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        let own = parameters.to_vec();
        let pace = |pace| PaceWatch::new(pace, own.clone(), course.step(), course.until);
        let stop = course.stop.as_ref();
        let events = course.events.iter();
        Ok(Self {
            last: LastStep::new(map, own.clone(), course.epsilon, course.h),
            pace: course.pace.as_ref().map(pace).transpose()?,
            stop: stop.map(|(_, of)| of.values(1, parameters)).transpose()?,
            events: events
                .map(|(_, of)| of.values(1, parameters))
                .collect::<Result<_, _>>()?,
        })
    }
}
