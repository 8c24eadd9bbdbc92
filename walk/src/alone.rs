//! Looks at one lane of many, at states within its last step.

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
    parameters: Vec<Vec<f64>>,
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
    /// Nothing made yet; a lane for each list of parameters.
    pub fn new(course: &'a Course, map: &'a dyn StepMap, parameters: Vec<Vec<f64>>) -> Self {
        let differ = parameters.windows(2).any(|pair| pair[0] != pair[1]);
        let count = if differ { parameters.len() } else { 1 };
        Self {
            course,
            map,
            parameters,
            slots: (0..count).map(|_| None).collect(),
        }
    }

    /// The parameters of each lane.
    pub fn parameters(&self) -> &[Vec<f64>] {
        &self.parameters
    }

    /// A lane, whose last step begins at its state of `start`.
    pub fn at(&mut self, lane: usize, start: &StepStart) -> Result<&mut Alone<'a>, BuildError> {
        let at = lane.min(self.slots.len() - 1);
        let (course, parameters) = (self.course, &self.parameters[lane]);
        let slot = &mut self.slots[at];
        if slot.is_none() {
            *slot = Some(Alone::new(course, self.map, parameters)?);
        }
        let alone = slot.as_mut().expect("it was made above");
        let lanes = self.parameters.len();
        let own = &mut alone.last.start;
        for (own, all) in [
            (&mut own.state, &start.state),
            (&mut own.compensation, &start.compensation),
        ] {
            own.clear();
            own.extend(all.iter().skip(lane).step_by(lanes));
        }
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
