//! The residual of a step's equation, by a kernel apart from the solver's, and steps judged by it.

use leafwise_core::{Method, PoissonSystem};
use leafwise_expression::{Arithmetic, Graph, Kernel, StepSize, Term};

use super::attempt::{Attempt, attempt};
use super::case::{Outcome, StressError, Tally};
use super::setup::{UNIT_ROUNDOFF, distance, largest};
use crate::verify::Problem;

/// β̂∘L of a method, compiled apart from its solver.
pub(super) struct Target {
    kernel: Kernel,
}

impl Target {
    /// Of a method whose parts are code; `None` for others.
    pub fn new(system: &PoissonSystem, method: &Method) -> Result<Option<Self>, StressError> {
        let d = system.dimension();
        let (Some(bisection), Some(realization)) = (
            method.bisection().code(),
            method.realization().abilities().code(),
        ) else {
            return Ok(None);
        };
        let mut graph = Graph::new();
        let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let h = graph.step_size(StepSize::H);
        let z = bisection(&mut graph, &epsilon, &h, &y)?;
        let ends = realization(&mut graph, &epsilon, &z)?;
        let target: Vec<Term> = (0..d)
            .map(|i| graph.add(&ends.base[i], &ends.offset[i]))
            .collect();
        let outputs = [target, ends.offset].concat();
        Ok(Some(Self {
            kernel: Kernel::compile(&graph, &outputs, system.parameters().len(), d),
        }))
    }

    /// |β̂(L(y)) − x| relative to |x| + |y| + |β̂ − base|.
    pub fn residual(
        &self,
        parameters: &[f64],
        (epsilon, h): (f64, f64),
        x: &[f64],
        y: &[f64],
    ) -> f64 {
        let mut workspace = self.kernel.workspace(1);
        self.kernel
            .prepare(&mut workspace, parameters, &[epsilon], &[h]);
        let mut values = vec![0.0; 2 * x.len()];
        self.kernel.evaluate(&mut workspace, y, &mut values);
        let (target, offset) = values.split_at(x.len());
        distance(target, x) / (largest(x) + largest(y) + largest(offset))
    }
}

/// Cold steps, each solved to 1e3 u or refused with a reason.
#[derive(Default)]
pub(super) struct Answers {
    tally: Tally,
    solved: usize,
    refused: usize,
}

impl Answers {
    /// Takes in the step of size t.
    pub fn take(&mut self, target: &Target, method: &Method, problem: &Problem, t: f64) {
        let (parameters, x) = (problem.system.parameter_values(), &problem.initial);
        let (name, tally) = (&problem.name, &mut self.tally);
        match attempt(method, &parameters, (1.0, t), x) {
            Attempt::Solved { solution, .. } => {
                self.solved += 1;
                let residual = solution.map(|y| target.residual(&parameters, (1.0, t), x, &y));
                tally.take(residual.is_some_and(|r| r <= 1e3 * UNIT_ROUNDOFF), || {
                    format!("{name}, t = {t:.1e}: a residual of {residual:?}")
                });
            }
            Attempt::Refused(_) => {
                self.refused += 1;
                tally.take(true, String::new);
            }
            Attempt::Garbage(what) => tally.take(false, || format!("{name}: {what}")),
        }
    }

    /// The outcome, where both are to occur.
    pub fn outcome(self) -> Outcome {
        let Self {
            mut tally,
            solved,
            refused,
        } = self;
        tally.take(solved > 0 && refused > 0, || {
            format!("{solved} solved and {refused} refused: one of the two does not occur")
        });
        tally.outcome(|_| format!("{solved} solved to round-off, {refused} refused with a reason"))
    }
}
