//! A function of a batch of points and its derivative, by calls of a library.

use leafwise_core::{Evaluator, StepError};
use leafwise_plugin_abi::LwMapFn;

use super::batch::{Input, Output};
use super::callee::Callee;
use super::instance::Call;

/// A function of the interface behind its name.
pub(super) type Named = (&'static str, LwMapFn);

/// F: ℝⁿ → ℝᵐ and DF at fixed ε and h; DF as m rows of n entries.
pub(super) struct ForeignFunction {
    /// Instance that is called.
    pub callee: Callee,
    /// ε and h.
    pub step_sizes: (f64, f64),
    /// F.
    pub values: Named,
    /// DF, where the library has it.
    pub jacobians: Named,
    /// n.
    pub inputs: usize,
    /// m.
    pub outputs: usize,
    /// Whether a point is two vectors of n/2 numbers, as (x, p) is.
    pub is_of_pairs: bool,
}

impl ForeignFunction {
    /// Evaluates a function of the same points at all of them, with `outputs` numbers each.
    pub fn call(
        &mut self,
        (name, function): Named,
        points: &[f64],
        (out, outputs): (&mut [f64], usize),
    ) -> Result<(), StepError> {
        let (n, (epsilon, h)) = (self.inputs, self.step_sizes);
        let count = points.len() / n;
        let call = match self.is_of_pairs {
            false => Call::at(count, epsilon, h, Input::points(points, n)),
            true => {
                let half = |from: usize| Input::strided(&points[from..], n / 2, n, 1);
                Call {
                    v: half(n / 2),
                    ..Call::at(count, epsilon, h, half(0))
                }
            }
        };
        let output = Output::points(out, outputs);
        self.callee.evaluate(name, function, &call, output)
    }
}

impl Evaluator for ForeignFunction {
    fn values(&mut self, points: &[f64], values: &mut [f64]) -> Result<(), StepError> {
        self.call(self.values, points, (values, self.outputs))
    }

    fn jacobians(&mut self, points: &[f64], jacobians: &mut [f64]) -> Result<(), StepError> {
        if self.jacobians.1.is_none() {
            return Err(StepError::NoTangent);
        }
        let entries = self.outputs * self.inputs;
        self.call(self.jacobians, points, (jacobians, entries))
    }

    /// The library does not count them.
    fn operations(&self) -> Option<u64> {
        None
    }
}
