//! The differential of a step that solves β̂(L(y; λ); λ) = x and returns x' = α̂(L(y; λ); λ), both code.
//!
//! With B = D(β̂∘L) and A = D(α̂∘L) at the solution,
//!
//!   DΦ = A B⁻¹,   ∂_λΦ = ∂_λ(α̂∘L) − A B⁻¹ ∂_λ(β̂∘L).
//!
//! For covectors w' at x' and w at x let G(y, λ) = w'·α̂(L(y; λ)) − w·β̂(L(y; λ)). Then w = DΦᵀw' is ∂_y G = 0,
//! Bᵀw = Aᵀw'. The part of the parameters, ∂_λΦᵀ w', is ∂_λ G. Both take one transposed solve, and one gradient in
//! reverse mode. Everything is formed from C = A − B, of the size of a step, and from differences of covectors.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Kernel, Rational, Workspace};

use super::foreseen::Foreseen;
use super::{Differential, SINGULAR, add_multiple, dot, one_step};
use crate::SourceTarget;
use crate::error::{BuildError, StepError};
use crate::{DenseFactors, NewtonKernel, Stepper, elimination_operations, substitution_operations};

/// Derivatives of a·β̂ + b·(α̂ − β̂) along L by the parameters: a kernel of y, a and b.
///
/// # Errors
/// [`BuildError::Algebra`] where a derivative has no code.
pub fn by_parameters(
    graph: &mut Graph,
    ends: &SourceTarget,
    parameters: usize,
) -> Result<Kernel, BuildError> {
    let d = ends.base.len();
    let mut sum = Vec::with_capacity(3 * d);
    for i in 0..d {
        let [target, change] = [d + i, 2 * d + i].map(|at| graph.input(at));
        for (covector, value) in [
            (&target, &ends.base[i]),
            (&target, &ends.offset[i]),
            (&change, &ends.increment[i]),
        ] {
            sum.push((Rational::one(), graph.multiply(covector, value)));
        }
    }
    let sum = graph.combine(&sum);
    let [_, gradient] = graph.gradients(&sum, [0, parameters])?;
    graph.unless_refused(())?;
    Ok(Kernel::compile(graph, &gradient, parameters, 3 * d))
}

/// The differential of a method whose two parts are code.
pub struct Solved {
    stepper: Box<dyn Stepper>,
    newton: NewtonKernel,
    full: Workspace,
    /// [`by_parameters`], of one lane and of 2d.
    by_parameters: Option<[(Arc<Kernel>, Workspace); 2]>,
    dimension: usize,
    /// y, a, b.
    point: Vec<f64>,
    outputs: Vec<f64>,
    /// B and C.
    target: Vec<f64>,
    change: Vec<f64>,
    factors: DenseFactors,
    factored: FactorsOf,
    matrix: Vec<f64>,
    room: Vec<f64>,
    slopes: Vec<f64>,
    operations: u64,
    /// Solver by foreseen Jacobians of steps with their gradient, in few dimensions.
    foreseen: Option<Foreseen>,
    /// Whether the stepper took the last step.
    is_stepped: bool,
}

/// The most dimensions in which Jacobians are foreseen: ten differences of d² entries are kept.
const MOST_FORESEEN: usize = 64;

/// Which matrix there are factors of.
#[derive(Clone, Copy, PartialEq)]
enum FactorsOf {
    /// None: B and C are of an earlier step.
    Nothing,
    /// None yet, B and C are there.
    Evaluated,
    /// B.
    Target,
    /// Bᵀ.
    TargetTransposed,
    /// Aᵀ.
    SourceTransposed,
}

impl Solved {
    /// Steps of a stepper of one lane that solves the kernel's equation; `by_parameters` is the kernel of
    /// ∂_λ(w'·α̂ − w·β̂).
    pub fn new(
        stepper: Box<dyn Stepper>,
        newton: &NewtonKernel,
        by_parameters: Option<Arc<Kernel>>,
        parameters: &[f64],
        (epsilon, h): (f64, f64),
    ) -> Self {
        let d = newton.kernel().inputs();
        let prepared = |kernel: &Kernel, lanes: usize| {
            let mut workspace = kernel.workspace(lanes);
            let each = |value: &f64| std::iter::repeat_n(*value, lanes);
            let parameters: Vec<f64> = parameters.iter().flat_map(each).collect();
            let (epsilon, h) = (vec![epsilon; lanes], vec![h; lanes]);
            kernel.prepare(&mut workspace, &parameters, &epsilon, &h);
            workspace
        };
        let count = parameters.len();
        Self {
            full: prepared(newton.kernel(), 1),
            foreseen: (d <= MOST_FORESEEN)
                .then(|| Foreseen::new(newton, prepared(newton.residual_kernel(), 1))),
            is_stepped: true,
            by_parameters: by_parameters.map(|kernel| {
                [1, 2 * d].map(|lanes| (Arc::clone(&kernel), prepared(&kernel, lanes)))
            }),
            newton: newton.clone(),
            stepper,
            dimension: d,
            point: vec![0.0; 3 * d],
            outputs: vec![0.0; newton.kernel().outputs()],
            target: vec![0.0; d * d],
            change: vec![0.0; d * d],
            factors: DenseFactors::new(d),
            factored: FactorsOf::Nothing,
            matrix: vec![0.0; d * d],
            room: vec![0.0; d],
            slopes: vec![0.0; 2 * d * count],
            operations: 0,
        }
    }

    /// B and C at the solution of the last step.
    fn evaluate(&mut self) -> Result<(), StepError> {
        if self.factored != FactorsOf::Nothing {
            return Ok(());
        }
        let solution = self.stepper.solution(0).ok_or(StepError::NoTangent)?;
        self.evaluate_at(&solution);
        Ok(())
    }

    /// B and C at y.
    fn evaluate_at(&mut self, y: &[f64]) {
        let d = self.dimension;
        let kernel = self.newton.kernel();
        kernel.evaluate(&mut self.full, y, &mut self.outputs);
        self.operations += kernel.step_operations().work();
        let ends = if self.newton.base_is_point() {
            2 * d
        } else {
            3 * d
        };
        let (target, rest) = self.outputs[ends..].split_at(d * d);
        self.target.copy_from_slice(target);
        self.change.copy_from_slice(&rest[..d * d]);
        self.point[..d].copy_from_slice(y);
        self.factored = FactorsOf::Evaluated;
    }

    /// A step with B and C at its solution: by foreseen ones where that is good to round-off, by the stepper elsewhere.
    fn step_evaluated(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
    ) -> Result<(), StepError> {
        let Some(mut foreseen) = self.foreseen.take() else {
            self.step(x, low, increment)?;
            return self.evaluate();
        };
        let mut is_found = foreseen.solve(&self.newton, [x, low]);
        if is_found {
            self.evaluate_at(foreseen.solution());
            is_found = foreseen.finish(&self.newton, &self.outputs, [x, low], increment);
        }
        if !is_found {
            if !self.is_stepped {
                self.stepper.restart();
            }
            self.step(x, low, increment)?;
            self.evaluate()?;
        }
        self.is_stepped = !is_found;
        foreseen.record(x, &self.point[..self.dimension], &self.target);
        self.foreseen = Some(foreseen);
        Ok(())
    }

    /// Factors of one of the matrices.
    fn factor(&mut self, which: FactorsOf) -> Result<(), StepError> {
        self.evaluate()?;
        if self.factored == which {
            return Ok(());
        }
        let d = self.dimension;
        for i in 0..d {
            for j in 0..d {
                let at = i * d + j;
                let (place, entry) = match which {
                    FactorsOf::SourceTransposed => (j * d + i, self.target[at] + self.change[at]),
                    FactorsOf::TargetTransposed => (j * d + i, self.target[at]),
                    _ => (at, self.target[at]),
                };
                self.matrix[place] = entry;
            }
        }
        self.operations += elimination_operations(d);
        if !self.factors.factor(&self.matrix) {
            self.factored = FactorsOf::Evaluated;
            return Err(SINGULAR);
        }
        self.factored = which;
        Ok(())
    }

    /// M⁻ᵀCᵀw in the room, M the matrix whose transpose is factored.
    fn pulled(&mut self, which: FactorsOf, covector: &[f64]) -> Result<(), StepError> {
        self.factor(which)?;
        let d = self.dimension;
        self.room.fill(0.0);
        for (w, row) in covector.iter().zip(self.change.chunks_exact(d)) {
            add_multiple(&mut self.room, *w, row);
        }
        self.factors.solve(&mut self.room);
        self.operations += 2 * (d * d) as u64 + substitution_operations(d);
        Ok(())
    }

    /// g ← g + ∂_λ(a·β̂ + b·(α̂ − β̂)), a and b as they stand in `point`.
    fn add_slopes(&mut self, gradient: &mut [f64]) {
        let Some([(kernel, workspace), _]) = &mut self.by_parameters else {
            return;
        };
        let slopes = &mut self.slopes[..gradient.len()];
        kernel.evaluate(workspace, &self.point, slopes);
        self.operations += kernel.step_operations().work();
        add_multiple(gradient, 1.0, slopes);
    }

    /// ∂_λβ̂ and ∂_λ(α̂ − β̂), parameters × 2d: the kernel at the 2d unit covectors.
    fn all_slopes(&mut self) {
        let Some([_, (kernel, workspace)]) = &mut self.by_parameters else {
            return;
        };
        let d = self.dimension;
        for i in 0..d {
            workspace.input_mut(i).fill(self.point[i]);
        }
        for k in 0..2 * d {
            let lanes = workspace.input_mut(d + k);
            lanes.fill(0.0);
            lanes[k] = 1.0;
        }
        kernel.evaluate_in_place(workspace);
        self.operations += 2 * d as u64 * kernel.step_operations().work();
        for (at, slopes) in self.slopes.chunks_exact_mut(2 * d).enumerate() {
            slopes.copy_from_slice(kernel.output(workspace, at));
        }
    }
}

impl Differential for Solved {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        self.factored = FactorsOf::Nothing;
        one_step(self.stepper.as_mut(), x, low, increment)
    }

    /// v' = v + ∂_λ(α̂ − β̂) μ + C u, u = B⁻¹(v − ∂_λβ̂ μ).
    fn push(&mut self, tangents: &mut [f64], parameters: &[f64]) -> Result<(), StepError> {
        self.factor(FactorsOf::Target)?;
        let d = self.dimension;
        if !parameters.is_empty() {
            self.all_slopes();
        }
        let count = self.slopes.len() / (2 * d);
        for (at, tangent) in tangents.chunks_exact_mut(d).enumerate() {
            let room = &mut self.room;
            room.copy_from_slice(tangent);
            if !parameters.is_empty() {
                let own = &parameters[at * count..][..count];
                for (mu, slopes) in own.iter().zip(self.slopes.chunks_exact(2 * d)) {
                    let (target, change) = slopes.split_at(d);
                    add_multiple(room, -mu, target);
                    add_multiple(tangent, *mu, change);
                }
            }
            self.factors.solve(room);
            for (out, row) in tangent.iter_mut().zip(self.change.chunks_exact(d)) {
                *out += dot(row, room);
            }
            self.operations += 2 * (d * d) as u64 + substitution_operations(d);
        }
        Ok(())
    }

    /// w = w' + B⁻ᵀCᵀw'; g ← g + w'·∂_λ(α̂ − β̂) + (w' − w)·∂_λβ̂.
    fn pull(&mut self, covector: &mut [f64], gradient: &mut [f64]) -> Result<(), StepError> {
        self.pulled(FactorsOf::TargetTransposed, covector)?;
        let d = self.dimension;
        if !gradient.is_empty() {
            for i in 0..d {
                self.point[d + i] = -self.room[i];
                self.point[2 * d + i] = covector[i];
            }
            self.add_slopes(gradient);
        }
        add_multiple(covector, 1.0, &self.room);
        Ok(())
    }

    /// w = w' − A⁻ᵀCᵀw'; g ← g + (w' − w)·∂_λβ̂ − w·∂_λ(α̂ − β̂).
    fn pull_inverse(
        &mut self,
        covector: &mut [f64],
        gradient: &mut [f64],
    ) -> Result<(), StepError> {
        self.pulled(FactorsOf::SourceTransposed, covector)?;
        add_multiple(covector, -1.0, &self.room);
        let d = self.dimension;
        if !gradient.is_empty() {
            for i in 0..d {
                self.point[d + i] = self.room[i];
                self.point[2 * d + i] = -covector[i];
            }
            self.add_slopes(gradient);
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
        self.step_evaluated(x, low, increment)?;
        self.pull_inverse(covector, gradient)
    }

    fn knows_parameters(&self) -> bool {
        self.by_parameters.is_some() || self.slopes.is_empty()
    }

    fn operations(&self) -> Option<u64> {
        let foreseen = self.foreseen.as_ref().map_or(0, |foreseen| {
            let [evaluations, factorizations] = foreseen.work();
            let d = self.dimension;
            let each = elimination_operations(d) + substitution_operations(d);
            evaluations * self.newton.chord_work() + factorizations * each
        });
        Some(self.stepper.statistics().operations? + self.operations + foreseen)
    }
}
