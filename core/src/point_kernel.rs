//! A kernel at one point, or at several side by side.

use std::sync::Arc;

use leafwise_expression::{Kernel, Workspace};

/// Points that are evaluated side by side.
const LANES: usize = 16;

/// The fewest points for which that takes less time than one after the other.
const FEWEST: usize = 6;

/// One thread's evaluator of a kernel, for fixed parameters and step sizes. What it writes for a point depends on
/// that point alone, to the bit.
pub(crate) struct PointKernel {
    kernel: Arc<Kernel>,
    alone: Workspace,
    /// That of [`LANES`] points, made when it is first needed.
    wide: Option<Workspace>,
    parameters: Vec<f64>,
    epsilon: f64,
    h: f64,
    /// Operations of one evaluation, and of all so far.
    work: u64,
    operations: u64,
}

impl PointKernel {
    pub(crate) fn new(kernel: &Arc<Kernel>, parameters: &[f64], epsilon: f64, h: f64) -> Self {
        let mut alone = kernel.workspace(1);
        kernel.prepare(&mut alone, parameters, &[epsilon], &[h]);
        Self {
            kernel: Arc::clone(kernel),
            alone,
            wide: None,
            parameters: parameters.to_vec(),
            epsilon,
            h,
            work: kernel.step_operations().work(),
            operations: 0,
        }
    }

    /// The evaluator of another kernel, for the same parameters and step sizes.
    pub(crate) fn at_the_same(&self, kernel: &Arc<Kernel>) -> Self {
        Self::new(kernel, &self.parameters, self.epsilon, self.h)
    }

    /// Takes other parameters; nothing is allocated but for points side by side.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) {
        self.parameters.copy_from_slice(parameters);
        let steps = ([self.epsilon], [self.h]);
        self.kernel
            .prepare(&mut self.alone, parameters, &steps.0, &steps.1);
        self.wide = None;
    }

    /// Operations so far.
    pub(crate) fn operations(&self) -> u64 {
        self.operations
    }

    /// Evaluates at one point or at several, one after the other in `z` and in `out`.
    ///
    /// # Panics
    /// When a slice is not that of a whole number of points.
    #[inline]
    pub(crate) fn evaluate(&mut self, z: &[f64], out: &mut [f64]) {
        let inputs = self.kernel.inputs();
        if z.len() == inputs {
            self.operations += self.work;
            return self.kernel.evaluate(&mut self.alone, z, out);
        }
        assert!(z.len().is_multiple_of(inputs), "whole points");
        self.evaluate_each(|at| z[at * inputs..][..inputs].iter().copied(), out);
    }

    /// Evaluates at as many points as `out` holds results. The function `point` gives the inputs of each, as many as
    /// the kernel has.
    ///
    /// # Panics
    /// When `out` is not that of a whole number of points.
    pub(crate) fn evaluate_each<I: Iterator<Item = f64>>(
        &mut self,
        point: impl Fn(usize) -> I,
        out: &mut [f64],
    ) {
        let results = self.kernel.outputs();
        assert!(out.len().is_multiple_of(results), "whole points");
        for (chunk, out) in out.chunks_mut(LANES * results).enumerate() {
            let first = chunk * LANES;
            let count = out.len() / results;
            self.operations += count as u64 * self.work;
            if count >= FEWEST {
                self.side_by_side(|at| point(first + at.min(count - 1)), out);
                continue;
            }
            for (at, out) in out.chunks_exact_mut(results).enumerate() {
                for (i, value) in point(first + at).enumerate() {
                    self.alone.input_mut(i)[0] = value;
                }
                self.kernel.evaluate_in_place(&mut self.alone);
                for (i, out) in out.iter_mut().enumerate() {
                    *out = self.kernel.output(&self.alone, i)[0];
                }
            }
        }
    }

    /// [`LANES`] points, of which `out` takes the first.
    fn side_by_side<I: Iterator<Item = f64>>(
        &mut self,
        point: impl Fn(usize) -> I,
        out: &mut [f64],
    ) {
        let kernel = &self.kernel;
        let workspace = self.wide.get_or_insert_with(|| {
            let mut workspace = kernel.workspace(LANES);
            let own = |value: &f64| std::iter::repeat_n(*value, LANES);
            let parameters: Vec<f64> = self.parameters.iter().flat_map(own).collect();
            let (epsilon, h) = ([self.epsilon; LANES], [self.h; LANES]);
            kernel.prepare(&mut workspace, &parameters, &epsilon, &h);
            workspace
        });
        for at in 0..LANES {
            for (i, value) in point(at).enumerate() {
                workspace.input_mut(i)[at] = value;
            }
        }
        kernel.evaluate_in_place(workspace);
        let results = kernel.outputs();
        for i in 0..results {
            let values = kernel.output(workspace, i);
            for (out, value) in out[i..].iter_mut().step_by(results).zip(values) {
                *out = *value;
            }
        }
    }
}
