//! Maps and their Jacobians as kernels.

use std::sync::Arc;

use leafwise_expression::{Graph, Kernel, Term, Workspace};

use crate::error::BuildError;

/// A map z ↦ F(z) and z ↦ DF(z), compiled.
#[derive(Clone, Debug)]
pub struct SmoothMap {
    value: Arc<Kernel>,
    jacobian: Arc<Kernel>,
}

impl SmoothMap {
    /// Compiles `outputs` over the graph's first `inputs` inputs and their derivatives.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a derivative does not exist.
    pub fn compile(
        graph: &mut Graph,
        outputs: &[Term],
        parameters: usize,
        inputs: usize,
    ) -> Result<Self, BuildError> {
        let value = Kernel::compile(graph, outputs, parameters, inputs);
        let mut entries = Vec::with_capacity(outputs.len() * inputs);
        for output in outputs {
            for k in 0..inputs {
                entries.push(graph.derivative(output, k)?);
            }
        }
        let jacobian = Kernel::compile(graph, &entries, parameters, inputs);
        Ok(Self {
            value: Arc::new(value),
            jacobian: Arc::new(jacobian),
        })
    }

    /// The number of coordinates of z.
    pub fn inputs(&self) -> usize {
        self.value.inputs()
    }

    /// The number of components of F.
    pub fn outputs(&self) -> usize {
        self.value.outputs()
    }

    /// An evaluator for fixed parameters, ε and h.
    pub fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> SmoothMapEvaluator {
        let prepared = |kernel: &Kernel| {
            let mut workspace = kernel.workspace(1);
            kernel.prepare(&mut workspace, parameters, &[epsilon], &[h]);
            workspace
        };
        SmoothMapEvaluator {
            value: prepared(&self.value),
            jacobian: prepared(&self.jacobian),
            map: self.clone(),
            work: [&self.value, &self.jacobian].map(|kernel| kernel.step_operations().work()),
            operations: 0,
        }
    }
}

/// One thread's evaluator of a [`SmoothMap`].
#[derive(Clone, Debug)]
pub struct SmoothMapEvaluator {
    map: SmoothMap,
    value: Workspace,
    jacobian: Workspace,
    /// Operations of one value and of one Jacobian, and of all so far.
    work: [u64; 2],
    operations: u64,
}

impl SmoothMapEvaluator {
    /// The map.
    pub fn map(&self) -> &SmoothMap {
        &self.map
    }

    /// F(z).
    ///
    /// # Panics
    /// When a slice has another length than the map's inputs or outputs.
    pub fn value(&mut self, z: &[f64], out: &mut [f64]) {
        self.map.value.evaluate(&mut self.value, z, out);
        self.operations += self.work[0];
    }

    /// DF(z), row-major outputs × inputs.
    ///
    /// # Panics
    /// When a slice has another length than the map's inputs or Jacobian.
    pub fn jacobian(&mut self, z: &[f64], out: &mut [f64]) {
        self.map.jacobian.evaluate(&mut self.jacobian, z, out);
        self.operations += self.work[1];
    }

    /// Weighted operations of all evaluations so far.
    pub fn operations(&self) -> u64 {
        self.operations
    }
}
