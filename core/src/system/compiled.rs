//! The values of a system of formulas, by kernels.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Kernel, Term};

use super::formulas::SystemFormulas;
use super::numbers::{Derivatives, SystemEvaluator, SystemFunction, SystemNumbers, vector};
use crate::error::{BuildError, StepError};
use crate::point_kernel::PointKernel;
use leafwise_solver::check_variables;

/// Kernels of Π(y)v, H, ∇H, the Casimirs and their derivatives.
#[derive(Clone, Debug)]
pub struct CompiledNumbers {
    kernels: [Arc<Kernel>; KERNELS],
    dimension: usize,
}

const KERNELS: usize = 7;
const TENSOR: usize = 0;
const HAMILTONIAN: usize = 1;
const GRADIENT: usize = 2;
const CASIMIRS: usize = 3;
const TENSOR_TANGENT: usize = 4;
const HESSIAN: usize = 5;
const CASIMIR_GRADIENTS: usize = 6;

impl CompiledNumbers {
    /// Compiles every value and derivative of a system.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or a derivative has no code,
    /// [`BuildError::TooManyVariables`] for too long a system.
    pub fn compile(system: &SystemFormulas) -> Result<Self, BuildError> {
        let d = system.dimension();
        check_variables(d)?;
        let parameters = system.parameters().len();
        let mut graph = Graph::compilable();
        let inputs: Vec<Term> = (0..3 * d).map(|i| graph.input(i)).collect();
        let (y, v, w) = (&inputs[..d], &inputs[d..2 * d], &inputs[2 * d..]);
        let graph = &mut graph;
        let applied = system.apply_tensor(graph, y, v)?;
        let gradient = system.gradient(graph, y)?;
        let energy = system
            .hamiltonian()
            .evaluate_in(graph, &mut |_, at| Ok(y[at].clone()))?;
        let mut casimirs = Vec::with_capacity(system.casimirs().len());
        for casimir in system.casimirs() {
            let value = &casimir.expression;
            casimirs.push(value.evaluate_in(graph, &mut |_, at| Ok(y[at].clone()))?);
        }
        let mut casimir_gradients = Vec::with_capacity(casimirs.len() * d);
        for casimir in &casimirs {
            for k in 0..d {
                casimir_gradients.push(graph.derivative(casimir, k)?);
            }
        }
        let tensor_tangent = along(graph, &applied, w)?;
        let hessian = along(graph, &gradient, v)?;
        graph.unless_refused(())?;
        let kernel = |outputs: &[Term], vectors: usize| {
            Arc::new(Kernel::compile(graph, outputs, parameters, vectors * d))
        };
        Ok(Self {
            kernels: [
                kernel(&applied, 2),
                kernel(&[energy], 1),
                kernel(&gradient, 1),
                kernel(&casimirs, 1),
                kernel(&tensor_tangent, 3),
                kernel(&hessian, 2),
                kernel(&casimir_gradients, 1),
            ],
            dimension: d,
        })
    }
}

/// The derivative of each value along the graph's first inputs in a direction.
fn along(graph: &mut Graph, values: &[Term], direction: &[Term]) -> Result<Vec<Term>, BuildError> {
    let one = leafwise_expression::Rational::one();
    let mut derivatives = Vec::with_capacity(values.len());
    for value in values {
        let mut terms = Vec::with_capacity(direction.len());
        for (k, component) in direction.iter().enumerate() {
            let slope = graph.derivative(value, k)?;
            terms.push((one.clone(), graph.multiply(&slope, component)));
        }
        derivatives.push(graph.combine(&terms));
    }
    Ok(derivatives)
}

impl From<CompiledNumbers> for SystemNumbers {
    fn from(compiled: CompiledNumbers) -> Self {
        let all = Derivatives {
            tensor: true,
            hamiltonian: true,
            casimirs: true,
        };
        Self::new(all, move |parameters| {
            let kernel = |kernel: &Arc<Kernel>| PointKernel::new(kernel, parameters, 1.0, 1.0);
            Box::new(CompiledEvaluator {
                kernels: compiled.kernels.each_ref().map(kernel),
                dimension: compiled.dimension,
            })
        })
    }
}

struct CompiledEvaluator {
    kernels: [PointKernel; KERNELS],
    dimension: usize,
}

impl SystemEvaluator for CompiledEvaluator {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        let (which, vectors) = match function {
            SystemFunction::Tensor(_) => (TENSOR, 1),
            SystemFunction::Hamiltonian => (HAMILTONIAN, 0),
            SystemFunction::Gradient => (GRADIENT, 0),
            SystemFunction::Casimirs => (CASIMIRS, 0),
            SystemFunction::TensorTangent(..) => (TENSOR_TANGENT, 2),
            SystemFunction::Hessian(_) => (HESSIAN, 1),
            SystemFunction::CasimirGradients => (CASIMIR_GRADIENTS, 0),
        };
        let (d, [v, w]) = (self.dimension, function.vectors());
        let inputs = &[y, v, w][..1 + vectors];
        let point = |at| inputs.iter().flat_map(move |values| vector(values, d, at));
        if !out.is_empty() {
            self.kernels[which].evaluate_each(|at| point(at).copied(), out);
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        Some(self.kernels.iter().map(PointKernel::operations).sum())
    }
}
