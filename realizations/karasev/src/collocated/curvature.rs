//! Second derivatives of V(y, p) = Π(y) p along a covector, as code.

use std::sync::{Arc, OnceLock};

use leafwise_core::{BuildError, StepError, SystemFormulas};
use leafwise_expression::{Arithmetic, Graph, Kernel, Rational, Term, Workspace};

/// (y, p, ν) ↦ ν·∂²V/∂y∂y, ν·∂²V/∂y∂p, compiled when it is first asked for: d² second derivatives
/// cost more than all else that collocation compiles, and few methods need them.
#[derive(Clone, Debug)]
pub(super) struct Curvature {
    system: SystemFormulas,
    kernel: Arc<OnceLock<Option<Arc<Kernel>>>>,
}

impl Curvature {
    pub(super) fn new(system: &SystemFormulas) -> Self {
        Self {
            system: system.clone(),
            kernel: Arc::default(),
        }
    }

    /// `None` where a derivative has no code.
    fn kernel(&self) -> Option<&Arc<Kernel>> {
        let compiled = || compile(&self.system).ok().map(Arc::new);
        self.kernel.get_or_init(compiled).as_ref()
    }

    /// Whether it has code.
    pub(super) fn is_offered(&self) -> bool {
        self.kernel().is_some()
    }

    pub(super) fn evaluator(&self, parameters: &[f64]) -> CurvatureEvaluator {
        CurvatureEvaluator {
            curvature: self.clone(),
            parameters: parameters.to_vec(),
            workspace: None,
            inputs: vec![[0.0]; 3 * self.system.dimension()],
            operations: 0,
        }
    }
}

/// One thread's evaluator of a [`Curvature`].
pub(super) struct CurvatureEvaluator {
    curvature: Curvature,
    parameters: Vec<f64>,
    workspace: Option<Workspace>,
    /// y, p and ν.
    inputs: Vec<[f64; 1]>,
    pub(super) operations: u64,
}

impl CurvatureEvaluator {
    /// ν·∂²V/∂y∂y and ν·∂²V/∂y∂p, row-major d × d.
    pub(super) fn evaluate(
        &mut self,
        (y, p, covector): (&[f64], &[f64], &[f64]),
        by_yy: &mut [f64],
        by_yp: &mut [f64],
    ) -> Result<(), StepError> {
        let kernel = self.curvature.kernel().ok_or(StepError::NoTangent)?;
        let workspace = self.workspace.get_or_insert_with(|| {
            let mut workspace = kernel.workspace(1);
            kernel.prepare(&mut workspace, &self.parameters, &[1.0], &[1.0]);
            workspace
        });
        let inputs = self.inputs.iter_mut();
        for (input, value) in inputs.zip([y, p, covector].into_iter().flatten()) {
            *input = [*value];
        }
        let rows = kernel.evaluate_rows(workspace, &self.inputs).as_flattened();
        self.operations += kernel.step_operations().work();
        let (first, second) = rows.split_at(by_yy.len());
        by_yy.copy_from_slice(first);
        by_yp.copy_from_slice(second);
        Ok(())
    }
}

fn compile(system: &SystemFormulas) -> Result<Kernel, BuildError> {
    let d = system.dimension();
    let mut graph = Graph::new();
    let inputs: Vec<Term> = (0..3 * d).map(|i| graph.input(i)).collect();
    let v = system.apply_tensor(&mut graph, &inputs[..d], &inputs[d..2 * d])?;
    let along: Vec<_> = v
        .iter()
        .zip(&inputs[2 * d..])
        .map(|(v, covector)| (Rational::one(), graph.multiply(v, covector)))
        .collect();
    let along = graph.combine(&along);
    let mut outputs = Vec::with_capacity(2 * d * d);
    for half in 0..2 {
        for i in 0..d {
            let slope = graph.derivative(&along, i)?;
            for j in 0..d {
                outputs.push(graph.derivative(&slope, half * d + j)?);
            }
        }
    }
    let parameters = system.parameters().len();
    Ok(Kernel::compile(&graph, &outputs, parameters, 3 * d))
}
