//! Equations of a closed orbit, bordered: the closing Φᴺ(x) = x, the phase, and what is held.
//!
//! The unknowns are x, the period over a unit, and a parameter over a unit where one moves.

use leafwise_core::gradient::{GradientError, Plan, Trajectory};
use leafwise_core::solver::judge::larger;
use leafwise_core::{Observer, StepMap};
use leafwise_scene::compose::ComposedRun;

use super::error::OrbitError;
use super::linear::Columns;
use super::newton::{At, length};

/// The part of a period by which its derivative is found.
const CHANGE: f64 = 1e-5;

/// The part of a coordinate or parameter by which derivatives of invariants are found.
const STEP: f64 = 1e-6;

/// The end of a turn.
pub(super) struct AfterTurn {
    /// Φᴺ(x) − x.
    pub gap: Vec<f64>,
    /// Columns of DΦᴺ.
    pub monodromy: Columns,
    /// ∂Φᴺ by the parameter that moves, over its unit.
    by_parameter: Vec<f64>,
    /// Rows of the invariants that are held, of length 1.
    rows: Vec<Vec<f64>>,
}

/// Steps of one map, so many a turn, of states in units of their coordinates.
///
/// A unit is a power of two next to how large its coordinate is: nothing here depends on the units of a scene.
#[derive(Clone)]
pub(super) struct Turns<'a> {
    map: &'a dyn StepMap,
    parameters: Vec<f64>,
    epsilon: f64,
    pub steps: u64,
    pub units: Vec<f64>,
}

impl<'a> Turns<'a> {
    pub fn of(run: &'a ComposedRun, steps: u64, units: Vec<f64>) -> Self {
        Self {
            map: run.method.map(),
            parameters: run.system.parameter_values(),
            epsilon: run.plan.epsilon,
            steps,
            units,
        }
    }

    /// In the units of the coordinates' sizes over a period from a state. That of a coordinate that stays 0 is the median of the others.
    pub fn in_units(
        run: &'a ComposedRun,
        steps: u64,
        (initial, period): (&[f64], f64),
    ) -> Result<Self, OrbitError> {
        let mut turns = Self::of(run, steps, vec![1.0; initial.len()]);
        let mut sizes = vec![0.0_f64; initial.len()];
        for state in turns.states(initial, period)?.chunks_exact(initial.len()) {
            let pairs = sizes.iter_mut().zip(state);
            pairs.for_each(|(size, x)| *size = larger(*size, x.abs()));
        }
        let mut known: Vec<f64> = sizes.iter().copied().filter(|size| *size > 0.0).collect();
        known.sort_by(f64::total_cmp);
        let median = known.get(known.len() / 2).copied().unwrap_or(1.0);
        turns.units = (sizes.iter())
            .map(|size| if *size > 0.0 { *size } else { median })
            .map(|size| libm::exp2(libm::round(libm::log2(size))))
            .collect();
        Ok(turns)
    }

    /// A state of the scene in these units.
    pub fn inside(&self, state: &[f64]) -> Vec<f64> {
        state
            .iter()
            .zip(&self.units)
            .map(|(x, unit)| x / unit)
            .collect()
    }

    /// A state in these units as the scene has it.
    pub fn outside(&self, x: &[f64]) -> Vec<f64> {
        x.iter()
            .zip(&self.units)
            .map(|(x, unit)| x * unit)
            .collect()
    }

    /// The same at another value of a parameter.
    pub fn at(&self, parameter: usize, value: f64) -> Self {
        let mut parameters = self.parameters.clone();
        parameters[parameter] = value;
        Self {
            parameters,
            ..self.clone()
        }
    }

    fn trajectory(&self, period: f64) -> Trajectory<'_> {
        Trajectory {
            map: self.map,
            parameters: &self.parameters,
            epsilon: self.epsilon,
            h: period / (self.steps as f64 * self.epsilon),
            goes_on: &|| true,
        }
    }

    /// Φᴺ(x) − x, the columns of DΦᴺ, and ∂Φᴺ by a parameter, where one is named.
    fn turn(
        &self,
        x: &[f64],
        period: f64,
        by: Option<usize>,
    ) -> Result<(Vec<f64>, Columns, Vec<f64>), GradientError> {
        let d = x.len();
        let count = d + usize::from(by.is_some());
        let mut tangents = vec![0.0; count * d];
        (0..d).for_each(|i| tangents[i * d + i] = self.units[i]);
        let mut by_parameters = Vec::new();
        if let Some(parameter) = by {
            by_parameters = vec![0.0; count * self.parameters.len()];
            by_parameters[d * self.parameters.len() + parameter] = 1.0;
        }
        let plan = Plan {
            steps: self.steps,
            every: self.steps,
        };
        let end =
            self.trajectory(period)
                .push(&self.outside(x), (&tangents, &by_parameters), plan)?;
        let ends = self.inside(&end.samples[d..]).into_iter().zip(x);
        let gap = ends.map(|(end, x)| end - x).collect();
        let columns = end.tangents[count * d..].chunks_exact(d);
        let mut columns: Columns = columns.map(|column| self.inside(column)).collect();
        let by_parameter = columns.split_off(d).pop().unwrap_or_default();
        Ok((gap, columns, by_parameter))
    }

    /// x_k − x_0 after so many steps of a period.
    fn gap(&self, x: &[f64], period: f64, steps: u64) -> Result<Vec<f64>, GradientError> {
        let plan = Plan {
            steps,
            every: steps,
        };
        let state = self.outside(x);
        let end = self.trajectory(period).push(&state, (&[], &[]), plan)?;
        let ends = self.inside(&end.samples[x.len()..]).into_iter().zip(x);
        Ok(ends.map(|(end, x)| end - x).collect())
    }

    /// max |x_k − x_0| after so many steps of a period.
    pub fn gap_after(&self, x: &[f64], period: f64, steps: u64) -> Result<f64, GradientError> {
        Ok(largest(&self.gap(x, period, steps)?))
    }

    /// max |x_k − x_0| over a turn.
    pub fn moved(&self, x: &[f64], period: f64) -> Result<f64, GradientError> {
        let states = self.states(&self.outside(x), period)?;
        let states = states.chunks_exact(x.len()).map(|state| self.inside(state));
        let gaps = states.map(|state| distance(&state, x));
        Ok(gaps.fold(0.0, f64::max))
    }

    /// The states of a turn from a state of the scene.
    fn states(&self, state: &[f64], period: f64) -> Result<Vec<f64>, GradientError> {
        let every = Plan {
            steps: self.steps,
            every: 1,
        };
        let turn = self.trajectory(period).push(state, (&[], &[]), every)?;
        Ok(turn.samples)
    }

    /// ∂Φᴺ/∂T.
    fn by_period(&self, x: &[f64], period: f64) -> Result<Vec<f64>, GradientError> {
        let at = |part: f64| self.gap(x, period * part, self.steps);
        let (ahead, behind) = (at(1.0 + CHANGE)?, at(1.0 - CHANGE)?);
        let change = 2.0 * CHANGE * period;
        let pairs = ahead.iter().zip(behind);
        Ok(pairs.map(|(a, b)| (a - b) / change).collect())
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |most, (a, b)| larger(most, (a - b).abs()))
}

/// The largest size of an entry.
pub(super) fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |most, x| larger(most, x.abs()))
}

/// Energy and Casimirs, with their gradients.
pub(super) struct Invariants<'a>(pub &'a ComposedRun);

impl Invariants<'_> {
    /// At values of the parameters: compiled once.
    fn observer(&self, parameters: &[f64]) -> Result<Observer, OrbitError> {
        let functions = self.0.invariant_functions();
        let values = functions.and_then(|functions| functions.values(1, parameters));
        Ok(values.map_err(|_| no_code())?.into())
    }

    pub fn values(&self, x: &[f64], turns: &Turns<'_>) -> Result<Vec<f64>, OrbitError> {
        let mut observer = self.observer(&turns.parameters)?;
        Ok(values(&mut observer, &turns.outside(x)))
    }

    /// By differences: they direct Newton's method, and its end depends on values alone.
    pub fn gradients(&self, x: &[f64], turns: &Turns<'_>) -> Result<Columns, OrbitError> {
        let mut observer = self.observer(&turns.parameters)?;
        let mut gradients = vec![vec![0.0; x.len()]; observer.observables()];
        let mut moved = x.to_vec();
        for i in 0..x.len() {
            let change = STEP * x[i].abs().max(1.0);
            moved[i] = x[i] + change;
            let ahead = values(&mut observer, &turns.outside(&moved));
            moved[i] = x[i] - change;
            let behind = values(&mut observer, &turns.outside(&moved));
            moved[i] = x[i];
            for ((gradient, a), b) in gradients.iter_mut().zip(ahead).zip(behind) {
                gradient[i] = (a - b) / (2.0 * change);
            }
        }
        Ok(gradients)
    }

    /// Derivatives by a parameter, over its unit.
    fn by_parameter(
        &self,
        x: &[f64],
        turns: &Turns<'_>,
        moving: Moving,
    ) -> Result<Vec<f64>, OrbitError> {
        let value = turns.parameters[moving.parameter];
        let change = STEP * moving.unit;
        let ahead = self.values(x, &turns.at(moving.parameter, value + change))?;
        let behind = self.values(x, &turns.at(moving.parameter, value - change))?;
        let pairs = ahead.iter().zip(behind);
        Ok(pairs.map(|(a, b)| (a - b) / (2.0 * STEP)).collect())
    }
}

fn values(observer: &mut Observer, x: &[f64]) -> Vec<f64> {
    let mut values = vec![0.0; observer.observables()];
    observer.evaluate(x, &mut values);
    values
}

fn no_code() -> OrbitError {
    OrbitError::NotOffered {
        message: "the invariants have no code",
        help: "declare others".into(),
    }
}

/// A parameter among the unknowns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    /// Its place among those of the system.
    pub parameter: usize,
    /// A size of its changes.
    pub unit: f64,
}

/// The equations, and what is free in them.
pub(super) struct Equations<'a> {
    pub turns: Turns<'a>,
    pub invariants: Invariants<'a>,
    /// The values of energy and Casimirs that are held.
    pub held: Vec<f64>,
    /// Whether the energy is held.
    pub holds_energy: bool,
    /// Whether the period is an unknown.
    pub finds_period: bool,
    /// A size of periods.
    pub period_unit: f64,
    pub moving: Option<Moving>,
    /// One more equation, r·u = c.
    pub border: Option<(Vec<f64>, f64)>,
}

impl Equations<'_> {
    /// The state, the period and the turns of unknowns.
    pub fn parts<'u>(&self, unknowns: &'u [f64]) -> (&'u [f64], f64, Turns<'_>) {
        let d = unknowns.len() - 1 - usize::from(self.moving.is_some());
        let turns = match self.moving {
            Some(moving) => self
                .turns
                .at(moving.parameter, unknowns[d + 1] * moving.unit),
            None => self.turns.clone(),
        };
        (&unknowns[..d], unknowns[d] * self.period_unit, turns)
    }

    /// The equations' values.
    pub fn at(&self, unknowns: &[f64]) -> Result<At<AfterTurn>, OrbitError> {
        let (x, period, turns) = self.parts(unknowns);
        if !(period > 0.0 && period.is_finite()) {
            return Err(OrbitError::NotClosed {
                iterations: 0,
                closure: f64::NAN,
            });
        }
        let by = self.moving.map(|moving| moving.parameter);
        let (gap, monodromy, mut by_parameter) = turns.turn(x, period, by)?;
        let now = self.invariants.values(x, &turns)?;
        let mut rows = self.invariants.gradients(x, &turns)?;
        rows.iter_mut().for_each(|row| row.push(0.0));
        if let Some(moving) = self.moving {
            by_parameter.iter_mut().for_each(|v| *v *= moving.unit);
            let own = self.invariants.by_parameter(x, &turns, moving)?;
            rows.iter_mut()
                .zip(own)
                .for_each(|(row, own)| row.push(own));
        }
        let free = usize::from(!self.holds_energy);
        let mut right: Vec<f64> = gap.iter().map(|gap| -gap).collect();
        // The phase.
        right.push(0.0);
        let mut own = Vec::new();
        let off = self.held.iter().zip(now).map(|(held, now)| held - now);
        for (row, off) in rows.into_iter().zip(off).skip(free) {
            let (row, off) = unit(row, off);
            own.push(row);
            right.push(off);
        }
        if let Some((row, value)) = &self.border {
            right.push(value - row.iter().zip(unknowns).map(|(r, u)| r * u).sum::<f64>());
        }
        let found = AfterTurn {
            gap,
            monodromy,
            by_parameter,
            rows: own,
        };
        Ok(At { found, right })
    }

    /// Columns of their derivatives.
    pub fn columns(&self, unknowns: &[f64], at: &At<AfterTurn>) -> Result<Columns, OrbitError> {
        let (x, period, turns) = self.parts(unknowns);
        let (d, found) = (x.len(), &at.found);
        let mut along = turns.by_period(x, period)?;
        let (phase, _) = unit(along.clone(), 0.0);
        // A column of zeros takes the period out of the unknowns: the least step does not change it.
        let free = if self.finds_period {
            self.period_unit
        } else {
            0.0
        };
        along.iter_mut().for_each(|v| *v *= free);
        let column = |j: usize| {
            let closing = |i: usize| match j {
                _ if j < d => found.monodromy[j][i] - f64::from(u8::from(i == j)),
                _ if j == d => along[i],
                _ => found.by_parameter[i],
            };
            let held = found.rows.iter().map(|row| row[j]);
            let border = self.border.iter().map(|(row, _)| row[j]);
            (0..d)
                .map(closing)
                .chain([phase.get(j).copied().unwrap_or(0.0)])
                .chain(held)
                .chain(border)
                .collect()
        };
        Ok((0..unknowns.len()).map(column).collect())
    }
}

/// An equation over the length of its row.
fn unit(mut row: Vec<f64>, right: f64) -> (Vec<f64>, f64) {
    let size = length(&row);
    let inverse = if size > 0.0 { 1.0 / size } else { 0.0 };
    row.iter_mut().for_each(|entry| *entry *= inverse);
    (row, right * inverse)
}
