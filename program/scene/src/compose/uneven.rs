//! Runs as functions of the initial state: samples after equal numbers of equal steps.

use thiserror::Error;

use super::part_choice::PartChoice;
use super::run::ComposedRun;

/// Why the samples of a run are no differentiable function of the initial state: they are not those after equal numbers of
/// equal steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "derivatives are of samples after equal numbers of equal steps, and this scene has {found}; take it out, \
     and record every so many steps"
)]
pub struct Uneven {
    /// The part of the scene that makes them uneven.
    pub found: &'static str,
}

/// Events of a scene that change the state, where the method's steps are made alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "an integrator makes the steps of the method alone, and events of this scene change the state: take a run, or remove `set` \
     from the section"
)]
pub struct ActingEvents;

impl ComposedRun {
    /// Checks that samples are those after equal numbers of equal steps, so that they have derivatives.
    ///
    /// # Errors
    /// [`Uneven`].
    pub fn has_equal_steps(&self) -> Result<(), Uneven> {
        let odd = [
            (self.pace().is_some(), "a pace"),
            (
                self.method.noise().is_some(),
                "noise, which every pass would draw anew",
            ),
            (self.plan.events.stop.is_some(), "a condition that stops it"),
            (
                self.plan.events.act.is_some(),
                "events that change the state",
            ),
            (!self.plan.samples.are_steps(), "samples at times"),
        ];
        match odd.into_iter().find(|(is_there, _)| *is_there) {
            None => Ok(()),
            Some((_, found)) => Err(Uneven { found }),
        }
    }

    /// Checks that the method's steps alone are the motion: no event of the scene changes the state.
    ///
    /// # Errors
    /// [`ActingEvents`].
    pub fn has_no_acts(&self) -> Result<(), ActingEvents> {
        match self.plan.events.act {
            None => Ok(()),
            Some(_) => Err(ActingEvents),
        }
    }

    /// The length of the only steps that the scene's generating function holds for, where it is a table of many steps.
    pub fn table_step(&self) -> Option<f64> {
        self.plan.parts.iter().find_map(PartChoice::time_step)
    }

    /// The state that is stepped from the scene's own coordinates: the time and its energy are those of the initial state.
    pub fn whole(&self, own: &[f64]) -> Vec<f64> {
        let mut whole = self.plan.initial.clone();
        whole[self.plan.layout.own()].copy_from_slice(own);
        whole
    }

    /// Rows of tangents or covectors of the scene's own coordinates, with zeros for what is stepped beside these.
    pub fn whole_rows(&self, rows: &[f64]) -> Vec<f64> {
        let beside = vec![0.0; self.plan.layout.beside().len()];
        let whole = |own: &[f64]| [own, &beside].concat();
        rows.chunks_exact(self.plan.layout.coordinates())
            .flat_map(whole)
            .collect()
    }

    /// The scene's own coordinates of rows of states that are stepped.
    pub fn own_rows(&self, rows: &[f64]) -> Vec<f64> {
        rows.chunks_exact(self.plan.layout.dimension())
            .flat_map(|row| self.own(row).iter().copied())
            .collect()
    }
}
