//! Room for the states of many steps of one lane.

use leafwise_core::BuildError;
use leafwise_core::solver::StepRecord;

use crate::course::Course;
use crate::functions::FunctionValues;

/// Steps that are made before they are looked at, at most, and at least where any are.
const MOST: usize = 64;
const LEAST: usize = 8;

/// Coordinates of all their states, at most: they stay in the nearest cache.
const COORDINATES: usize = 2048;

/// The same parameters in so many lanes.
fn spread(parameters: &[f64], lanes: usize) -> Vec<f64> {
    let rows = parameters.iter();
    rows.flat_map(|x| std::iter::repeat_n(*x, lanes)).collect()
}

/// Room for the states of many steps.
pub(crate) struct Batch {
    /// Steps at most.
    pub most: usize,
    /// The states, one after the other, and the evaluations up to each.
    states: Vec<f64>,
    pub evaluations: Vec<u64>,
    /// The states as a structure of arrays, and the invariants in as many lanes.
    columns: Vec<f64>,
    invariants: FunctionValues,
}

impl Batch {
    /// Room where one lane is stepped, nobody looks between steps, and the invariants are code that is evaluated at each state; `None`
    /// elsewhere.
    pub fn of(
        course: &Course,
        dimension: usize,
        (lanes, parameters): (usize, &[f64]),
    ) -> Result<Option<Self>, BuildError> {
        let most = (COORDINATES / dimension.max(1)).min(MOST);
        let is_watched = course.looks_between() || course.indicators.is_some();
        if lanes > 1 || is_watched || most < LEAST || !course.invariants.is_code() {
            return Ok(None);
        }
        let invariants = course.invariants.values(most, &spread(parameters, most))?;
        Ok(Some(Self {
            most,
            states: vec![0.0; dimension * most],
            evaluations: vec![0; most],
            columns: vec![0.0; dimension * most],
            invariants,
        }))
    }

    /// Takes other parameters.
    ///
    /// # Errors
    /// Those of [`FunctionValues::set_parameters`].
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), BuildError> {
        self.invariants
            .set_parameters(&spread(parameters, self.most))
    }

    /// Takes in the states of so many steps, which `steps` makes.
    pub fn record<T>(&mut self, count: usize, steps: impl FnOnce(&mut StepRecord<'_>) -> T) -> T {
        let dimension = self.states.len() / self.most;
        let states = &mut self.states[..count * dimension];
        let evaluations = &mut self.evaluations[..count];
        steps(&mut StepRecord::new(states, evaluations, dimension))
    }

    /// Evaluates the invariants at the states of so many steps, which came after so many evaluations.
    pub fn evaluate(&mut self, made: usize, evaluations: u64) {
        let own = self.evaluations[..made].iter_mut();
        own.for_each(|own| *own += evaluations);
        let dimension = self.states.len() / self.most;
        for (coordinate, row) in self.columns.chunks_exact_mut(self.most).enumerate() {
            let states = self.states[coordinate..].iter().step_by(dimension);
            row[..made]
                .iter_mut()
                .zip(states)
                .for_each(|(x, state)| *x = *state);
            // Lanes without a state repeat the last one.
            let last = row[made - 1];
            row[made..].fill(last);
        }
        self.invariants.at(&self.columns);
    }

    /// The state after a step, counted from 0.
    pub fn state(&self, at: usize) -> &[f64] {
        let dimension = self.states.len() / self.most;
        &self.states[at * dimension..][..dimension]
    }

    /// One coordinate after each step.
    pub fn column(&self, coordinate: usize) -> &[f64] {
        &self.columns[coordinate * self.most..][..self.most]
    }

    /// One of the invariants after each step.
    pub fn invariant(&self, invariant: usize) -> &[f64] {
        &self.invariants.last()[invariant * self.most..][..self.most]
    }

    /// Whether all invariants are finite after each of so many steps.
    pub fn are_finite(&self, made: usize) -> bool {
        let rows = self.invariants.last().chunks_exact(self.most);
        // 0·v is 0 where v is finite, and no number elsewhere.
        let sum = |row: &[f64]| row[..made].iter().fold(0.0, |sum, v| sum + 0.0 * v);
        rows.map(sum).sum::<f64>() == 0.0
    }

    /// Whether all invariants are finite after a step, counted from 0.
    pub fn is_finite(&self, at: usize) -> bool {
        let mut own = self.invariants.last().iter().skip(at).step_by(self.most);
        own.all(|value| value.is_finite())
    }
}
