//! The differential of an explicit step Φ(x; λ) = x + f(x; λ), f code.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Kernel, Rational, Term, Workspace};

use super::{Differential, SINGULAR, add_multiple, dot, one_step};
use crate::error::{BuildError, StepError};
use crate::{DenseFactors, Stepper};

/// The gradient of w·f by x and by the parameters: a kernel of x and w.
///
/// # Errors
/// [`BuildError::Algebra`] where a derivative has no code.
pub(crate) fn in_reverse(
    graph: &Graph,
    increment: &[Term],
    parameters: usize,
) -> Result<Kernel, BuildError> {
    let d = increment.len();
    let mut graph = graph.clone();
    let mut sum = Vec::with_capacity(d);
    for (i, component) in increment.iter().enumerate() {
        let covector = graph.input(d + i);
        sum.push((Rational::one(), graph.multiply(&covector, component)));
    }
    let sum = graph.combine(&sum);
    let gradients = graph.gradients(&sum, [d, parameters])?;
    graph.unless_refused(())?;
    Ok(Kernel::compile(
        &graph,
        &gradients.concat(),
        parameters,
        2 * d,
    ))
}

/// How covectors are pulled back through the inverse of an explicit step.
#[derive(Clone, Debug)]
pub enum Inverse {
    /// By a linear solve.
    Solved,
    /// The map is self-adjoint: through the opposite step.
    Opposite,
    /// The same by a kernel that takes the step too: of x and w the increment, the new w and the gradient by the parameters.
    Kernel(Arc<Kernel>),
}

/// The differential of an explicit map of code.
pub(crate) struct Explicit {
    stepper: Box<dyn Stepper>,
    kernel: Arc<Kernel>,
    /// Of the step, and of the opposite one.
    workspaces: [Workspace; 2],
    /// Of d lanes, made when Df is first asked for.
    wide: Option<Workspace>,
    parameters: Vec<f64>,
    step_sizes: (f64, f64),
    /// Whether Φ_{−h} is the inverse.
    is_self_adjoint: bool,
    /// The step and the pull-back at once.
    at_once: Option<(Arc<Kernel>, Workspace)>,
    /// x of the last step and its end.
    ends: [Vec<f64>; 2],
    /// x and w.
    point: Vec<f64>,
    outputs: Vec<f64>,
    /// Those of the kernel that does both.
    both: Vec<f64>,
    /// Df and ∂_λf: (d + parameters) × d, transposed.
    slopes: Vec<f64>,
    has_slopes: bool,
    operations: u64,
}

impl Explicit {
    /// Steps of a stepper of one lane, with the kernel of [`in_reverse`].
    pub(crate) fn new(
        stepper: Box<dyn Stepper>,
        kernel: Arc<Kernel>,
        parameters: &[f64],
        (epsilon, h): (f64, f64),
        inverse: Inverse,
    ) -> Self {
        let d = kernel.inputs() / 2;
        let prepared = |kernel: &Kernel, h: f64| {
            let mut workspace = kernel.workspace(1);
            kernel.prepare(&mut workspace, parameters, &[epsilon], &[h]);
            workspace
        };
        let workspaces = [h, -h].map(|h| prepared(&kernel, h));
        let is_self_adjoint = !matches!(inverse, Inverse::Solved);
        let at_once = match inverse {
            Inverse::Kernel(kernel) => {
                let workspace = prepared(&kernel, h);
                Some((kernel, workspace))
            }
            _ => None,
        };
        Self {
            stepper,
            workspaces,
            wide: None,
            parameters: parameters.to_vec(),
            step_sizes: (epsilon, h),
            is_self_adjoint,
            at_once,
            ends: [vec![0.0; d], vec![0.0; d]],
            point: vec![0.0; 2 * d],
            outputs: vec![0.0; kernel.outputs()],
            both: Vec::new(),
            slopes: Vec::new(),
            has_slopes: false,
            kernel,
            operations: 0,
        }
    }

    fn dimension(&self) -> usize {
        self.ends[0].len()
    }

    /// w ← w + Dfᵀw and g ← g + ∂_λfᵀw at the begin of the last step, or of the opposite step at its end.
    fn pull_at(&mut self, end: usize, covector: &mut [f64], gradient: &mut [f64]) {
        let d = self.dimension();
        self.point[..d].copy_from_slice(&self.ends[end]);
        self.point[d..].copy_from_slice(covector);
        let workspace = &mut self.workspaces[end];
        self.kernel
            .evaluate(workspace, &self.point, &mut self.outputs);
        self.operations += self.kernel.step_operations().work();
        let (by_state, by_parameters) = self.outputs.split_at(d);
        add_multiple(covector, 1.0, by_state);
        add_multiple(gradient, 1.0, by_parameters);
    }

    /// Df and ∂_λf at the begin of the last step: the kernel at the d unit covectors.
    fn find_slopes(&mut self) {
        if self.has_slopes {
            return;
        }
        let d = self.dimension();
        let kernel = &self.kernel;
        let (parameters, (epsilon, h)) = (&self.parameters, self.step_sizes);
        let workspace = self.wide.get_or_insert_with(|| {
            let mut workspace = kernel.workspace(d);
            let each = |value: &f64| std::iter::repeat_n(*value, d);
            let parameters: Vec<f64> = parameters.iter().flat_map(each).collect();
            kernel.prepare(&mut workspace, &parameters, &vec![epsilon; d], &vec![h; d]);
            workspace
        });
        for i in 0..d {
            workspace.input_mut(i).fill(self.ends[0][i]);
            let lanes = workspace.input_mut(d + i);
            lanes.fill(0.0);
            lanes[i] = 1.0;
        }
        kernel.evaluate_in_place(workspace);
        self.operations += d as u64 * kernel.step_operations().work();
        self.slopes.clear();
        for at in 0..kernel.outputs() {
            self.slopes.extend_from_slice(kernel.output(workspace, at));
        }
        self.has_slopes = true;
    }
}

impl Differential for Explicit {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.has_slopes = false;
        one_step(self.stepper.as_mut(), x, low, increment)?;
        let [begin, end] = &mut self.ends;
        begin.copy_from_slice(x);
        for (end, (x, change)) in end.iter_mut().zip(x.iter().zip(&*increment)) {
            *end = x + change;
        }
        Ok(())
    }

    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        self.find_slopes();
        let d = self.dimension();
        let (by_state, by_parameters) = self.slopes.split_at(d * d);
        let count = by_parameters.len() / d;
        let mut change = vec![0.0; d];
        for (at, tangent) in tangents.chunks_exact_mut(d).enumerate() {
            change.fill(0.0);
            for (v, slopes) in tangent.iter().zip(by_state.chunks_exact(d)) {
                add_multiple(&mut change, *v, slopes);
            }
            if !parameters.is_empty() {
                let own = &parameters[at * count..][..count];
                for (mu, slopes) in own.iter().zip(by_parameters.chunks_exact(d)) {
                    add_multiple(&mut change, *mu, slopes);
                }
            }
            add_multiple(tangent, 1.0, &change);
        }
        Ok(())
    }

    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        self.pull_at(0, covector, gradient);
        Ok(())
    }

    /// The inverse of a self-adjoint step is the opposite one; elsewhere (1 + Dfᵀ)w = w'.
    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        if self.is_self_adjoint {
            self.pull_at(1, covector, gradient);
            return Ok(());
        }
        self.find_slopes();
        let d = self.dimension();
        let (by_state, by_parameters) = self.slopes.split_at(d * d);
        let mut matrix = by_state.to_vec();
        (0..d).for_each(|i| matrix[i * d + i] += 1.0);
        let mut factors = DenseFactors::new(d);
        if !factors.factor(&matrix) {
            return Err(SINGULAR);
        }
        factors.solve(covector);
        for (g, slopes) in gradient.iter_mut().zip(by_parameters.chunks_exact(d)) {
            *g -= dot(covector, slopes);
        }
        Ok(())
    }

    fn step_and_pull_inverse(
        &mut self,
        [x, low]: [&[f64]; 2],
        increment: &mut [f64],
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        let Some((kernel, workspace)) = &mut self.at_once else {
            self.step(x, low, increment)?;
            return self.pull_inverse(covector, gradient);
        };
        let d = x.len();
        self.point[..d].copy_from_slice(x);
        self.point[d..].copy_from_slice(covector);
        self.both.resize(kernel.outputs(), 0.0);
        kernel.evaluate(workspace, &self.point, &mut self.both);
        self.operations += kernel.step_operations().work();
        let (own, rest) = self.both.split_at(d);
        let (by_state, by_parameters) = rest.split_at(d);
        if !own.iter().all(|value| value.is_finite()) {
            return Err(StepError::OF_INCREMENT);
        }
        increment.copy_from_slice(own);
        covector.copy_from_slice(by_state);
        add_multiple(gradient, 1.0, by_parameters);
        Ok(())
    }

    fn knows_parameters(&self) -> bool {
        true
    }

    fn operations(&self) -> Option<u64> {
        Some(self.stepper.statistics().operations? + self.operations)
    }
}
