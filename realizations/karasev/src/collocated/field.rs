//! V(y, p) = Π(y) p and its derivatives as kernels.

use std::sync::Arc;

use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Graph, Kernel, Term, Workspace};

/// Compiled once a system: V; ∂V/∂y and ∂V/∂p = Π.
#[derive(Clone, Debug)]
pub(super) struct Field {
    value: Arc<Kernel>,
    slopes: Arc<Kernel>,
    pub(super) dimension: usize,
}

impl Field {
    pub(super) fn compile(system: &SystemFormulas) -> Result<Self, BuildError> {
        let d = system.dimension();
        let mut graph = Graph::new();
        let inputs: Vec<Term> = (0..2 * d).map(|i| graph.input(i)).collect();
        let v = system.apply_tensor(&mut graph, &inputs[..d], &inputs[d..])?;
        let parameters = system.parameters().len();
        let value = Kernel::compile(&graph, &v, parameters, 2 * d);
        let mut slopes = Vec::with_capacity(2 * d * d);
        for half in 0..2 {
            for row in &v {
                for j in 0..d {
                    slopes.push(graph.derivative(row, half * d + j)?);
                }
            }
        }
        let slopes = Kernel::compile(&graph, &slopes, parameters, 2 * d);
        Ok(Self {
            value: Arc::new(value),
            slopes: Arc::new(slopes),
            dimension: d,
        })
    }

    pub(super) fn worker(&self, parameters: &[f64]) -> FieldWorker {
        let prepared = |kernel: &Kernel| {
            let mut workspace = kernel.workspace(1);
            kernel.prepare(&mut workspace, parameters, &[1.0], &[1.0]);
            workspace
        };
        FieldWorker {
            value: prepared(&self.value),
            slopes: prepared(&self.slopes),
            work: [&self.value, &self.slopes].map(|kernel| kernel.step_operations().work()),
            operations: 0,
            field: self.clone(),
        }
    }
}

/// One thread's evaluator of V.
#[derive(Clone)]
pub(super) struct FieldWorker {
    field: Field,
    value: Workspace,
    slopes: Workspace,
    /// Operations of one evaluation of each kernel, and of all so far.
    work: [u64; 2],
    pub(super) operations: u64,
}

impl FieldWorker {
    pub(super) fn value(&mut self, y: &[f64], p: &[f64], v: &mut [f64]) {
        write(&mut self.value, y, p);
        self.field.value.evaluate_in_place(&mut self.value);
        self.operations += self.work[0];
        for (i, v) in v.iter_mut().enumerate() {
            *v = self.field.value.output(&self.value, i)[0];
        }
    }

    /// ∂V/∂y and ∂V/∂p, row-major d × d.
    pub(super) fn slopes(&mut self, y: &[f64], p: &[f64], by_y: &mut [f64], by_p: &mut [f64]) {
        write(&mut self.slopes, y, p);
        self.field.slopes.evaluate_in_place(&mut self.slopes);
        self.operations += self.work[1];
        for (i, slope) in by_y.iter_mut().chain(by_p.iter_mut()).enumerate() {
            *slope = self.field.slopes.output(&self.slopes, i)[0];
        }
    }
}

fn write(workspace: &mut Workspace, y: &[f64], p: &[f64]) {
    for (i, value) in y.iter().chain(p).enumerate() {
        workspace.input_mut(i)[0] = *value;
    }
}
