//! The equation of a step, β̂(L(y)) = x, at one state: its solutions and their place in the chart.

use crate::code_evaluators::ChartRatio;
use crate::dynamics::Correction;
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::method::{Method, MethodEvaluators};
use crate::realization::Ends;
use crate::solver::{CorrectionMethod, Progress, Solve};

/// Newton iterations from one start.
const ITERATIONS: usize = 40;

/// Solutions nearer than this part of the state's size are one.
const SAME: f64 = 1e-6;

/// β̂(L(y)) = x for one method and one step size, by Newton's method from any start.
pub struct StepEquation {
    maps: Box<dyn Evaluator>,
    points: Box<dyn Evaluator>,
    chart: Option<ChartRatio>,
    correction: Correction,
    dimension: usize,
    space: usize,
}

/// One solution y.
#[derive(Clone, Debug, PartialEq)]
pub struct StepSolution {
    /// y.
    pub y: Vec<f64>,
    /// z = L(y), a point of S.
    pub point: Vec<f64>,
    /// (α̂ − β̂)(z): where the step goes.
    pub increment: Vec<f64>,
    /// How far z reaches into the chart, 1 at its edge; `None` where there is no edge.
    pub chart_ratio: Option<f64>,
}

impl StepEquation {
    /// The equation of a method's steps.
    ///
    /// # Errors
    /// [`BuildError`] where the method's maps cannot be evaluated by themselves.
    pub fn new(
        method: &Method,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Result<Self, BuildError> {
        let MethodEvaluators {
            maps,
            points,
            chart,
        } = method.evaluators(parameters, epsilon, h)?;
        Ok(Self {
            maps,
            points,
            chart,
            correction: method.dynamics().properties().correction,
            dimension: method.realization().dimension(),
            space: method.realization().space_dimension(),
        })
    }

    /// Weighted operations of all solves so far; `None` where the maps do not count them.
    pub fn operations(&self) -> Option<u64> {
        Some(self.maps.operations()? + self.points.operations()?)
    }

    /// Solves β̂(L(y)) = x for y by Newton's method from `start`. Returns y = x for a method that solves no equation.
    ///
    /// # Errors
    /// [`StepError`]: an iterate left the chart, or the iteration does not converge.
    pub fn solve(&mut self, x: &[f64], start: &[f64]) -> Result<StepSolution, StepError> {
        let (d, space) = (self.dimension, self.space);
        let mut is_solved = self.correction == Correction::None;
        let mut solve = Solve::new(CorrectionMethod::Newton, d);
        solve.begin_at(x, if is_solved { x } else { start }, ITERATIONS);
        let low = vec![0.0; d];
        let mut point = vec![0.0; space];
        let mut values = vec![0.0; 3 * d];
        let mut tangent = vec![0.0; space * d];
        let mut tangents = vec![0.0; 2 * d * space];
        let mut matrix = vec![0.0; d * d];
        loop {
            self.points.values(&solve.y, &mut point)?;
            values.fill(f64::NAN);
            let outcome = self.maps.values(&point, &mut values);
            let ends = Ends::of(&values);
            match outcome {
                // As in a step, only the solution has to lie inside the chart, where the maps have
                // values outside it too.
                Err(StepError::LeftChart { .. })
                    if !is_solved && ends.increment.iter().all(|i| i.is_finite()) => {}
                other => other?,
            }
            if is_solved {
                let chart = self.chart.as_mut();
                return Ok(StepSolution {
                    y: solve.y,
                    increment: ends.increment.to_vec(),
                    chart_ratio: chart.and_then(|chart| chart.at(&point)),
                    point,
                });
            }
            self.points.jacobians(&solve.y, &mut tangent)?;
            self.maps.jacobians(&point, &mut tangents)?;
            for i in 0..d {
                for j in 0..d {
                    matrix[i * d + j] = (0..space)
                        .map(|k| tangents[i * space + k] * tangent[k * d + j])
                        .sum();
                }
            }
            let progress = solve.take((x, &low), (&values, true), &matrix)?;
            is_solved = progress == Progress::Solved;
        }
    }

    /// Further solutions inside the chart, beside the one that Newton's method finds from x. The method starts from
    /// `starts` states around x, up to the state's own size away. The farther the solution is from unique, the more
    /// it depends on the start where a step goes. A method that solves no equation has none. No start is tried once
    /// all solves together took `most` operations, where these are counted.
    ///
    /// # Errors
    /// [`StepError`] where there is no solution from x itself.
    pub fn others(
        &mut self,
        x: &[f64],
        starts: usize,
        most: u64,
    ) -> Result<Vec<StepSolution>, StepError> {
        let first = self.solve(x, x)?;
        if self.correction == Correction::None {
            return Ok(Vec::new());
        }
        let reach = size(x);
        let mut phase = 0.5_f64;
        // The golden ratio's multiples: spread evenly, the same at every call.
        let mut next = move || {
            phase = (phase + 0.618_033_988_749_894_9) % 1.0;
            2.0 * phase - 1.0
        };
        let mut others: Vec<StepSolution> = Vec::new();
        for _ in 0..starts {
            if self.operations() > Some(most) {
                break;
            }
            let start: Vec<f64> = x.iter().map(|x| x + reach * next()).collect();
            let Ok(found) = self.solve(x, &start) else {
                continue;
            };
            let is_known = |known: &StepSolution| distance(&known.y, &found.y) <= SAME * reach;
            if !is_known(&first) && !others.iter().any(is_known) {
                others.push(found);
            }
        }
        Ok(others)
    }
}

/// max |v_i|.
fn size(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

/// max |a_i − b_i|.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .fold(0.0, |largest, (a, b)| (a - b).abs().max(largest))
}
