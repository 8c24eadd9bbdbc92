//! What happens to members between two steps: where they end, and where they cross a section.

use leafwise_core::{BuildError, SideBySide};
use leafwise_scene::compose::{Section, Stop, is_same_time};

use super::observers::{Functions, ObservableEvaluator};
use super::plan::{Column, ComposedEnsemble};
use crate::Failure;
use crate::events::{Lost, Side, crossing, end};
use crate::last_step::{Between, LastStep, StepEnd};
use crate::paced::{Paced, PacedSteps};

/// Where a condition has ended a member.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MemberStop {
    /// Its mark on the way: that of the step, or of the time; 0 where it holds at the initial state.
    pub mark: f64,
    /// The time.
    pub time: f64,
    /// The state.
    pub state: Vec<f64>,
    /// The observables there.
    pub row: Vec<f64>,
}

/// A member at a time that is asked for.
pub(super) struct MemberSample {
    /// The state.
    pub state: Vec<f64>,
    /// The observables there.
    pub row: Vec<f64>,
}

/// The members of a block between two steps.
pub(super) struct Watch<'a> {
    ensemble: &'a ComposedEnsemble,
    parameters: Vec<Vec<f64>>,
    stop: Option<(&'a Stop, ObservableEvaluator<'a>)>,
    section: Option<(&'a Section, ObservableEvaluator<'a>)>,
    /// Where each lane stands beside the section.
    sides: Vec<Side>,
    /// The states before the last step, and what they hold beyond a double.
    states: Vec<f64>,
    low: Vec<f64>,
    /// How the pace of each lane has gone; empty where steps are of the time itself.
    paced: Vec<PacedSteps>,
    /// −H at the initial state of each lane, beside a pace.
    origins: Vec<f64>,
    /// What looks at a member alone: one for all where they have the same parameters.
    alone: Vec<Option<Alone<'a>>>,
}

/// One member's last step and functions of its state.
struct Alone<'a> {
    last: LastStep<'a>,
    paced: Option<Paced<'a>>,
    stop: Option<ObservableEvaluator<'a>>,
    section: Option<ObservableEvaluator<'a>>,
    invariants: ObservableEvaluator<'a>,
    formulas: ObservableEvaluator<'a>,
}

/// A lane and what has become of it.
pub(super) type Found<T> = Vec<(usize, Result<T, Failure>)>;

impl<'a> Watch<'a> {
    /// The members with these parameters; `values` are the same as a structure of arrays. `origins` are −H at their initial
    /// states, beside a pace.
    pub fn new(
        ensemble: &'a ComposedEnsemble,
        parameters: &[Vec<f64>],
        values: &[f64],
        origins: &[f64],
    ) -> Result<Self, BuildError> {
        let lanes = parameters.len();
        let watched = &ensemble.watched;
        let stop = watched.stop.as_ref().map(|(stop, code)| {
            let evaluator = code.evaluator(lanes, values)?;
            Ok::<_, BuildError>((stop, evaluator))
        });
        let section = watched.section.as_ref().map(|(section, code)| {
            let evaluator = code.evaluator(lanes, values)?;
            Ok::<_, BuildError>((section, evaluator))
        });
        let differ = !ensemble.population.varied().is_empty();
        Ok(Self {
            ensemble,
            parameters: parameters.to_vec(),
            stop: stop.transpose()?,
            section: section.transpose()?,
            sides: vec![Side::default(); lanes],
            states: Vec::new(),
            low: Vec::new(),
            paced: vec![PacedSteps::default(); origins.len()],
            origins: origins.to_vec(),
            alone: (0..if differ { lanes } else { 1 }).map(|_| None).collect(),
        })
    }

    /// Whether there is nothing to look at.
    pub fn is_blind(&self) -> bool {
        let clock = &self.ensemble.clock;
        self.stop.is_none() && self.section.is_none() && !clock.is_of_time
    }

    /// Looks at the pace after the last step: why members cannot go on from there.
    pub fn paces(
        &mut self,
        integrator: &SideBySide,
        steps: u64,
    ) -> Result<Vec<(usize, Failure)>, BuildError> {
        let mut failed = Vec::new();
        for lane in 0..self.paced.len() {
            if !integrator.lives(lane) {
                continue;
            }
            let [state, compensation] = [integrator.state(), integrator.compensation()]
                .map(|all| column(all, lane, self.sides.len()));
            let end = StepEnd {
                state: &state,
                compensation: &compensation,
            };
            let mut own = std::mem::take(&mut self.paced[lane]);
            let Alone { last, paced, .. } = self.alone(lane)?;
            if let Some(paced) = paced {
                std::mem::swap(&mut paced.steps, &mut own);
                let failure = paced.take(last, end, steps);
                std::mem::swap(&mut paced.steps, &mut own);
                failed.extend(failure.map(|failure| (lane, failure)));
            }
            self.paced[lane] = own;
        }
        Ok(failed)
    }

    /// A member's state at a time within its last step, and the observables there.
    pub fn sample(
        &mut self,
        integrator: &SideBySide,
        lane: usize,
        (steps, time): (u64, f64),
    ) -> Result<Result<MemberSample, Failure>, BuildError> {
        let [state, compensation] = [integrator.state(), integrator.compensation()]
            .map(|all| column(all, lane, self.sides.len()));
        let ensemble = self.ensemble;
        let Alone { last, paced, .. } = self.alone(lane)?;
        let present = ensemble.time(steps, &state);
        let end = StepEnd {
            state: &state,
            compensation: &compensation,
        };
        let found = match paced {
            Some(paced) => paced.state_at(last, end, time),
            None if is_same_time(present, time) => Ok(state.clone()),
            None => last.state_at(steps, time),
        };
        Ok(match found {
            Ok(found) => {
                let row = self.row(lane, &found)?;
                Ok(MemberSample { state: found, row })
            }
            Err(error) => Err(failure(ensemble, Lost::Step(error), steps, &state)),
        })
    }

    /// Keeps the states that the next step begins at.
    pub fn keep(&mut self, integrator: &SideBySide) {
        self.states.clear();
        self.states.extend_from_slice(integrator.state());
        self.low.clear();
        self.low.extend_from_slice(integrator.compensation());
    }

    /// Looks at the initial states: the members that end there, and the sides of the section that they begin on.
    pub fn begin(&mut self, integrator: &SideBySide) -> Result<Found<MemberStop>, BuildError> {
        let mut found = Vec::new();
        self.keep(integrator);
        if let Some((section, evaluator)) = &mut self.section {
            for (lane, value) in evaluator.at(integrator.state()).iter().enumerate() {
                self.sides[lane] = Side::begin(*value);
                if value.is_nan() && integrator.lives(lane) {
                    let lost = Lost::Undefined(&section.text);
                    found.push((
                        lane,
                        Err(failure(self.ensemble, lost, 0, &integrator.last(lane).1)),
                    ));
                }
            }
        }
        let Some((stop, evaluator)) = &mut self.stop else {
            return Ok(found);
        };
        let stop = *stop;
        let values = evaluator.at(integrator.state()).to_vec();
        for (lane, value) in values.into_iter().enumerate() {
            if !integrator.lives(lane) || !(stop.holds(value) || value.is_nan()) {
                continue;
            }
            let state = integrator.last(lane).1;
            let ended = match value.is_nan() {
                true => Err(failure(
                    self.ensemble,
                    Lost::Undefined(&stop.text),
                    0,
                    &state,
                )),
                false => {
                    let row = self.row(lane, &state)?;
                    Ok(MemberStop {
                        mark: 0.0,
                        time: 0.0,
                        state,
                        row,
                    })
                }
            };
            found.push((lane, ended));
        }
        Ok(found)
    }

    /// The members that the condition ends in the last step.
    pub fn stops(
        &mut self,
        integrator: &SideBySide,
        steps: u64,
    ) -> Result<Found<MemberStop>, BuildError> {
        let mut found = Vec::new();
        let Some((stop, evaluator)) = &mut self.stop else {
            return Ok(found);
        };
        let stop = *stop;
        let values = evaluator.at(integrator.state());
        // Most steps end no member.
        if !values
            .iter()
            .any(|value| stop.holds(*value) || value.is_nan())
        {
            return Ok(found);
        }
        let values = values.to_vec();
        for (lane, value) in values.into_iter().enumerate() {
            if !integrator.lives(lane) || !(stop.holds(value) || value.is_nan()) {
                continue;
            }
            let after = integrator.last(lane).1;
            let ensemble = self.ensemble;
            let alone = self.alone(lane)?;
            let Alone {
                last, stop: own, ..
            } = alone;
            let mut difference =
                |state: &[f64]| own.as_mut().map_or(f64::NAN, |own| own.at(state)[0]);
            let ended = match end(stop, &mut difference, last, &after, value) {
                Err(lost) => Err(failure(ensemble, lost, steps, &after)),
                Ok(None) => continue,
                Ok(Some(between)) => {
                    let time = time_of(ensemble, last, steps, &between);
                    let mark = ensemble.clock.mark(steps, time);
                    if mark > ensemble.clock.end() {
                        continue;
                    }
                    let row = self.row(lane, &between.state)?;
                    Ok(MemberStop {
                        mark,
                        time,
                        state: between.state,
                        row,
                    })
                }
            };
            found.push((lane, ended));
        }
        Ok(found)
    }

    /// Where members cross the section in the last step: the time, and the columns of a row. Those that `ended` in it cross
    /// nothing behind their end.
    pub fn crossings(
        &mut self,
        integrator: &SideBySide,
        steps: u64,
        takes_part: impl Fn(usize) -> bool,
        ended: impl Fn(usize) -> Option<f64>,
    ) -> Result<Found<(f64, Vec<f64>)>, BuildError> {
        let mut found = Vec::new();
        let Some((section, evaluator)) = &mut self.section else {
            return Ok(found);
        };
        let section = *section;
        let values = evaluator.at(integrator.state());
        let lanes = self.sides.len();
        let values = values.to_vec();
        for (lane, value) in values.into_iter().enumerate() {
            if !takes_part(lane) {
                continue;
            }
            let side = self.sides[lane];
            if let Some(side) = side.stays(value) {
                self.sides[lane] = side;
                continue;
            }
            let after = column(integrator.state(), lane, lanes);
            let ensemble = self.ensemble;
            let alone = self.alone(lane)?;
            let Alone {
                last, section: own, ..
            } = alone;
            let mut difference =
                |state: &[f64]| own.as_mut().map_or(f64::NAN, |own| own.at(state)[0]);
            let (other, between) =
                match crossing(section, &mut difference, last, &after, (side, value, steps)) {
                    Ok(found) => found,
                    Err(lost) => {
                        found.push((lane, Err(failure(ensemble, lost, steps, &after))));
                        continue;
                    }
                };
            let Some(between) = between else {
                self.sides[lane] = other;
                continue;
            };
            let time = time_of(ensemble, &self.alone(lane)?.last, steps, &between);
            let state = between.state;
            if ensemble.clock.mark(steps, time) > ensemble.clock.end() {
                continue;
            }
            let forward = ensemble.run.plan.epsilon * ensemble.run.plan.h;
            if ended(lane).is_some_and(|end| (end - time) * forward < 0.0) {
                continue;
            }
            self.sides[lane] = other;
            let recorded = ensemble.run.plan.states.coordinates();
            let mut row: Vec<f64> = recorded.map(|at| state[at]).collect();
            row.extend(self.row(lane, &state)?);
            found.push((lane, Ok((time, row))));
        }
        Ok(found)
    }

    /// The columns of a row where a member ends on the section, which it crosses there.
    pub fn end_on_section(
        &mut self,
        lane: usize,
        steps: u64,
        state: &[f64],
    ) -> Result<Option<Vec<f64>>, BuildError> {
        let Some((section, _)) = &self.section else {
            return Ok(None);
        };
        let (section, side) = (*section, self.sides[lane]);
        let own = self.alone(lane)?.section.as_mut();
        let value = own.map_or(f64::NAN, |own| own.at(state)[0]);
        if !side.ends_there(section, value, steps) {
            return Ok(None);
        }
        let recorded = self.ensemble.run.plan.states.coordinates();
        let mut row: Vec<f64> = recorded.map(|at| state[at]).collect();
        row.extend(self.row(lane, state)?);
        Ok(Some(row))
    }

    /// The observables of a member at a state.
    fn row(&mut self, lane: usize, state: &[f64]) -> Result<Vec<f64>, BuildError> {
        let ensemble = self.ensemble;
        let alone = self.alone(lane)?;
        let invariants = alone.invariants.at(state);
        let formulas = alone.formulas.at(state);
        let value = |column: &Column| match *column {
            Column::Invariant(at) => invariants[at],
            Column::Formula(at) => formulas[at],
        };
        Ok(ensemble.columns.iter().map(value).collect())
    }

    /// What looks at a lane alone, at its last step.
    fn alone(&mut self, lane: usize) -> Result<&mut Alone<'a>, BuildError> {
        let ensemble = self.ensemble;
        let lanes = self.sides.len();
        let (parameters, slot) = (&self.parameters[lane], lane.min(self.alone.len() - 1));
        let slot = &mut self.alone[slot];
        if slot.is_none() {
            let watched = &ensemble.watched;
            let code = |of: &'a Functions| of.evaluator(1, parameters);
            *slot = Some(Alone {
                last: LastStep::with(&ensemble.run, parameters.clone()),
                paced: match &watched.pace {
                    Some(of) => {
                        let observer = Box::new(code(of)?);
                        Paced::with(&ensemble.run, parameters.clone(), observer)
                    }
                    None => None,
                },
                stop: watched.stop.as_ref().map(|(_, of)| code(of)).transpose()?,
                section: watched
                    .section
                    .as_ref()
                    .map(|(_, of)| code(of))
                    .transpose()?,
                invariants: code(&ensemble.invariants)?,
                formulas: code(&ensemble.formulas)?,
            });
        }
        let alone = slot.as_mut().expect("it was made above");
        let origin = self.origins.get(lane..=lane).unwrap_or_default();
        alone.invariants.measure_from(origin);
        let start = &mut alone.last.start;
        for (own, all) in [
            (&mut start.state, &self.states),
            (&mut start.compensation, &self.low),
        ] {
            let before = all.iter().skip(lane).step_by(lanes);
            own.iter_mut().zip(before).for_each(|(own, x)| *own = *x);
        }
        Ok(alone)
    }
}

/// One lane of a structure of arrays.
pub(super) fn column(all: &[f64], lane: usize, lanes: usize) -> Vec<f64> {
    all.iter().skip(lane).step_by(lanes).copied().collect()
}

/// The time of a state within a member's last step.
fn time_of(ensemble: &ComposedEnsemble, last: &LastStep<'_>, steps: u64, between: &Between) -> f64 {
    match ensemble.run.pace() {
        Some(_) => ensemble.time(steps, &between.state),
        None => last.time(steps, between.part),
    }
}

/// Why a member cannot go on after so many steps.
fn failure(ensemble: &ComposedEnsemble, lost: Lost<'_>, steps: u64, state: &[f64]) -> Failure {
    let (time, state) = (ensemble.time(steps, state), ensemble.run.own(state));
    match lost {
        Lost::Undefined(text) => Failure::of_observable(&format!("`{text}`"), steps, time, state),
        Lost::Step(error) => Failure::of_step(&error, steps, time, state),
    }
}
