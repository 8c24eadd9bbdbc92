//! V(y, p) = Π(y) p and its derivatives, as kernels or as numbers of the system.

use std::sync::Arc;

use leafwise_core::system::{SystemEvaluator, SystemNumbers};
use leafwise_core::{BuildError, PoissonSystem, StepError, SystemFormulas};
use leafwise_expression::{Graph, Kernel, Term, Workspace};
use nalgebra::DMatrix;

use super::curvature::{Curvature, CurvatureEvaluator};

/// The part's name.
pub(super) const NAME: &str = "karasev-collocated";

/// V; ∂V/∂y and ∂V/∂p = Π where the system offers them.
#[derive(Clone, Debug)]
pub(super) struct Field {
    source: Source,
    pub(super) dimension: usize,
}

#[derive(Clone, Debug)]
enum Source {
    Kernels {
        value: Arc<Kernel>,
        slopes: Arc<Kernel>,
        curvature: Box<Curvature>,
    },
    Numbers(SystemNumbers),
}

impl Field {
    /// The field of a system's tensor.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an entry has no code.
    pub(super) fn of(system: &PoissonSystem) -> Result<Self, BuildError> {
        let source = match (system.expressions(), system.opaque()) {
            (None, Some(system)) => Source::Numbers(system.numbers.clone()),
            _ => compiled(system.formulas(NAME)?)?,
        };
        Ok(Self {
            source,
            dimension: system.dimension(),
        })
    }

    /// Compiled kernels of the field with their names, for reports; none of a system given by
    /// numbers.
    pub(super) fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        match &self.source {
            Source::Kernels { value, slopes, .. } => vec![
                ("tensor times momentum", value.as_ref()),
                ("its derivatives", slopes.as_ref()),
            ],
            Source::Numbers(_) => Vec::new(),
        }
    }

    /// Whether its evaluators offer slopes.
    pub(super) fn has_slopes(&self) -> bool {
        match &self.source {
            Source::Kernels { .. } => true,
            Source::Numbers(numbers) => numbers.derivatives.tensor,
        }
    }

    /// Whether its evaluators offer [curvatures](FieldEvaluator::curvatures), whose code is then there.
    pub(super) fn has_curvatures(&self) -> bool {
        match &self.source {
            Source::Kernels { curvature, .. } => curvature.is_offered(),
            Source::Numbers(_) => false,
        }
    }

    pub(super) fn evaluator(&self, parameters: &[f64]) -> FieldEvaluator {
        let d = self.dimension;
        let evaluator = match &self.source {
            Source::Kernels {
                value,
                slopes,
                curvature,
            } => Evaluator::Kernels {
                value: Box::new(Prepared::new(value, parameters)),
                slopes: Box::new(Prepared::new(slopes, parameters)),
                curvature: Box::new(curvature.evaluator(parameters)),
                operations: 0,
            },
            Source::Numbers(numbers) => Evaluator::Numbers {
                evaluator: numbers.evaluator(parameters),
                has_slopes: numbers.derivatives.tensor,
                units: DMatrix::identity(d, d).as_slice().to_vec(),
                columns: vec![0.0; d * d],
            },
        };
        FieldEvaluator {
            evaluator,
            dimension: d,
        }
    }
}

fn compiled(system: &SystemFormulas) -> Result<Source, BuildError> {
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
    Ok(Source::Kernels {
        value: Arc::new(value),
        slopes: Arc::new(slopes),
        curvature: Box::new(Curvature::new(system)),
    })
}

struct Prepared {
    kernel: Arc<Kernel>,
    workspace: Workspace,
    /// y and p.
    inputs: Vec<f64>,
    /// Operations of one evaluation.
    work: u64,
}

impl Prepared {
    fn new(kernel: &Arc<Kernel>, parameters: &[f64]) -> Self {
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, parameters, &[1.0], &[1.0]);
        Self {
            work: kernel.step_operations().work(),
            inputs: vec![0.0; kernel.inputs()],
            kernel: Arc::clone(kernel),
            workspace,
        }
    }

    fn evaluate(&mut self, y: &[f64], p: &[f64]) -> &[f64] {
        let (first, second) = self.inputs.split_at_mut(y.len());
        first.copy_from_slice(y);
        second.copy_from_slice(p);
        let inputs = self.inputs.as_chunks::<1>().0;
        let outputs = self.kernel.evaluate_rows(&mut self.workspace, inputs);
        outputs.as_flattened()
    }
}

/// One thread's evaluator of V.
pub(super) struct FieldEvaluator {
    evaluator: Evaluator,
    dimension: usize,
}

enum Evaluator {
    Kernels {
        value: Box<Prepared>,
        slopes: Box<Prepared>,
        curvature: Box<CurvatureEvaluator>,
        operations: u64,
    },
    Numbers {
        evaluator: Box<dyn SystemEvaluator>,
        has_slopes: bool,
        /// The unit vectors, and room for as many columns.
        units: Vec<f64>,
        columns: Vec<f64>,
    },
}

impl FieldEvaluator {
    /// V at every node, with one p.
    pub(super) fn values(
        &mut self,
        nodes: &[f64],
        p: &[f64],
        values: &mut [f64],
    ) -> Result<(), StepError> {
        let d = self.dimension;
        match &mut self.evaluator {
            Evaluator::Kernels {
                value, operations, ..
            } => {
                for (y, v) in nodes.chunks_exact(d).zip(values.chunks_exact_mut(d)) {
                    v.copy_from_slice(value.evaluate(y, p));
                    *operations += value.work;
                }
                Ok(())
            }
            Evaluator::Numbers { evaluator, .. } => evaluator.tensor(nodes, p, values),
        }
    }

    /// Whether values are calls into another library, dearer than what an iteration adds to them.
    pub(super) fn is_foreign(&self) -> bool {
        matches!(self.evaluator, Evaluator::Numbers { .. })
    }

    /// Whether [`slopes`](Self::slopes) are offered.
    pub(super) fn has_slopes(&self) -> bool {
        match &self.evaluator {
            Evaluator::Kernels { .. } => true,
            Evaluator::Numbers { has_slopes, .. } => *has_slopes,
        }
    }

    /// ∂V/∂y and ∂V/∂p, row-major d × d.
    pub(super) fn slopes(
        &mut self,
        y: &[f64],
        p: &[f64],
        by_y: &mut [f64],
        by_p: &mut [f64],
    ) -> Result<(), StepError> {
        match &mut self.evaluator {
            Evaluator::Kernels {
                slopes, operations, ..
            } => {
                let (first, second) = slopes.evaluate(y, p).split_at(by_y.len());
                by_y.copy_from_slice(first);
                by_p.copy_from_slice(second);
                *operations += slopes.work;
                Ok(())
            }
            Evaluator::Numbers {
                evaluator,
                units,
                columns,
                ..
            } => {
                evaluator.tensor_tangent(y, p, units, columns)?;
                transpose(columns, by_y, self.dimension);
                evaluator.tensor(y, units, columns)?;
                transpose(columns, by_p, self.dimension);
                Ok(())
            }
        }
    }

    /// ν·∂²V/∂y∂y and ν·∂²V/∂y∂p at (y, p, ν), row-major d × d.
    pub(super) fn curvatures(
        &mut self,
        at: (&[f64], &[f64], &[f64]),
        by_yy: &mut [f64],
        by_yp: &mut [f64],
    ) -> Result<(), StepError> {
        match &mut self.evaluator {
            Evaluator::Kernels { curvature, .. } => curvature.evaluate(at, by_yy, by_yp),
            Evaluator::Numbers { .. } => Err(StepError::NoTangent),
        }
    }

    /// Weighted operations so far; `None` for a system that does not count.
    pub(super) fn operations(&self) -> Option<u64> {
        match &self.evaluator {
            Evaluator::Kernels {
                operations,
                curvature,
                ..
            } => Some(operations + curvature.operations),
            Evaluator::Numbers { evaluator, .. } => evaluator.operations(),
        }
    }
}

fn transpose(columns: &[f64], rows: &mut [f64], d: usize) {
    for (i, row) in rows.chunks_exact_mut(d).enumerate() {
        for (k, entry) in row.iter_mut().enumerate() {
            *entry = columns[k * d + i];
        }
    }
}
