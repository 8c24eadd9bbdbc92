//! Maps as numbers.

use crate::error::StepError;

/// Evaluator of a map F: ℝⁿ → ℝᵐ in one thread, for fixed parameters, ε and h. Such maps are a bisection y ↦ L(y), a
/// chart (x, p) ↦ z, a one-form, a vector field.
///
/// Both functions take one point or several, n contiguous numbers each, and write the results in their order.
pub trait Evaluator: Send {
    /// F(x), m numbers a point.
    ///
    /// # Errors
    /// [`StepError`] at a point outside the map's domain, or where a solve behind it does not converge; `out`
    /// is unspecified then.
    fn values(&mut self, x: &[f64], out: &mut [f64]) -> Result<(), StepError>;
    /// F(x) by one correction of the solve behind it, if there is one: a caller that iterates on x solves both
    /// together. Tells whether `out` is F(x) as [`values`](Self::values) says it. The solve `begins` once for all
    /// points that converge to x.
    ///
    /// # Errors
    /// As [`values`](Self::values).
    fn approach(&mut self, begins: bool, x: &[f64], out: &mut [f64]) -> Result<bool, StepError> {
        let _ = begins;
        self.values(x, out).map(|()| true)
    }
    /// DF(x), row-major m × n.
    ///
    /// # Errors
    /// As [`values`](Self::values); [`StepError::NoTangent`] for a map without one, of which the map knows.
    fn jacobians(&mut self, x: &[f64], out: &mut [f64]) -> Result<(), StepError>;
    /// The Hessian of x ↦ λ·G(x), row-major n × n, for a covector λ; G is F, and α̂ of a realization's ends.
    ///
    /// # Errors
    /// As [`values`](Self::values); [`StepError::NoTangent`] where it is not offered.
    fn hessian(&mut self, x: &[f64], covector: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let _ = (x, covector, out);
        Err(StepError::NoTangent)
    }
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for a map that does
    /// not count.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    fn operations(&self) -> Option<u64>;
    /// Forgets earlier evaluations: the next one starts cold.
    fn restart(&mut self) {}
    /// Memory for a checkpoint, always of the same length: the numbers that later evaluations depend on.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Restores [`memory`](Self::memory).
    fn restore(&mut self, memory: &[f64]) {
        let _ = memory;
    }
}

/// Evaluates points one by one, `inputs` numbers each.
///
/// # Errors
/// The error of the first point that fails.
///
/// # Panics
/// Unless every slice holds a whole number of points.
#[inline]
pub fn one_by_one(
    inputs: usize,
    x: &[f64],
    out: &mut [f64],
    mut evaluate: impl FnMut(&[f64], &mut [f64]) -> Result<(), StepError>,
) -> Result<(), StepError> {
    if x.len() == inputs {
        return evaluate(x, out);
    }
    let count = x.len() / inputs;
    let outputs = out.len() / count;
    let are_whole = x.len() == count * inputs && out.len() == count * outputs;
    assert!(are_whole, "whole points of {inputs} numbers");
    let mut points = x.chunks_exact(inputs).zip(out.chunks_exact_mut(outputs));
    points.try_for_each(|(x, out)| evaluate(x, out))
}

/// Whether two points are the same to the bit.
pub fn is_same(a: &[f64], b: &[f64]) -> bool {
    let mut pairs = a.iter().zip(b);
    a.len() == b.len() && pairs.all(|(a, b)| a.to_bits() == b.to_bits())
}
