//! Maps of a system that steppers work on: X_H, (u, w) ↦ −Π(u)w, ∇H, the invariants.

use leafwise_expression::{Arithmetic, Graph, Term};
use nalgebra::DMatrix;

use super::numbers::{NumbersWorker, OpaqueSystem};
use super::{Definition, PoissonSystem};
use crate::error::{BuildError, StepError};
use crate::runge_kutta::{MapWorker, SmoothMap};

impl PoissonSystem {
    /// x ↦ X_H(x) = −Π(x)∇H(x), with its Jacobian where the system offers the derivatives of Π and ∇H.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or a derivative has no code.
    pub fn field_map(&self) -> Result<SmoothMap, BuildError> {
        match &self.definition {
            Definition::Numbers(system) => Ok(map_of(system, Value::Field)),
            Definition::Formulas(system) => {
                let (mut graph, x) = inputs(system.dimension());
                let field = system.vector_field(&mut graph, &x)?;
                SmoothMap::compile(&mut graph, &field, system.parameters().len(), x.len())
            }
        }
    }

    /// The same for methods that need no Jacobian, which long systems take long to compile.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn field_values(&self) -> Result<SmoothMap, BuildError> {
        match &self.definition {
            Definition::Numbers(_) => self.field_map(),
            Definition::Formulas(system) => {
                let (mut graph, x) = inputs(system.dimension());
                let field = system.vector_field(&mut graph, &x)?;
                let parameters = system.parameters().len();
                Ok(SmoothMap::compile_values(
                    &graph,
                    &field,
                    parameters,
                    x.len(),
                ))
            }
        }
    }

    /// (u, w) ↦ −Π(u)w, with its Jacobian where the system offers the derivative of Π.
    ///
    /// # Errors
    /// As [`field_map`](Self::field_map).
    pub fn tensor_map(&self) -> Result<SmoothMap, BuildError> {
        match &self.definition {
            Definition::Numbers(system) => Ok(map_of(system, Value::Tensor)),
            Definition::Formulas(system) => {
                let d = system.dimension();
                let (mut graph, uw) = inputs(2 * d);
                let applied = system.apply_tensor(&mut graph, &uw[..d], &uw[d..])?;
                let applied: Vec<Term> = applied.iter().map(|f| graph.negate(f)).collect();
                SmoothMap::compile(&mut graph, &applied, system.parameters().len(), 2 * d)
            }
        }
    }

    /// x ↦ ∇H(x), with its Jacobian where the system offers D²H.
    ///
    /// # Errors
    /// As [`field_map`](Self::field_map).
    pub fn gradient_map(&self) -> Result<SmoothMap, BuildError> {
        match &self.definition {
            Definition::Numbers(system) => Ok(map_of(system, Value::Gradient)),
            Definition::Formulas(system) => {
                let (mut graph, x) = inputs(system.dimension());
                let gradient = system.gradient(&mut graph, &x)?;
                SmoothMap::compile(&mut graph, &gradient, system.parameters().len(), x.len())
            }
        }
    }

    /// x ↦ (H(x), C_1(x), …), with its Jacobian unless there are Casimirs without gradients.
    ///
    /// # Errors
    /// As [`field_map`](Self::field_map).
    pub fn invariants_map(&self) -> Result<SmoothMap, BuildError> {
        match &self.definition {
            Definition::Numbers(system) => Ok(map_of(system, Value::Invariants)),
            Definition::Formulas(system) => {
                let (mut graph, x) = inputs(system.dimension());
                let casimirs = system.casimirs().iter().map(|c| &c.expression);
                let mut values = Vec::new();
                for formula in std::iter::once(system.hamiltonian()).chain(casimirs) {
                    values.push(formula.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?);
                }
                SmoothMap::compile(&mut graph, &values, system.parameters().len(), x.len())
            }
        }
    }
}

fn inputs(count: usize) -> (Graph, Vec<Term>) {
    let mut graph = Graph::new();
    let inputs = (0..count).map(|i| graph.input(i)).collect();
    (graph, inputs)
}

/// What is computed of a system of numbers.
#[derive(Clone, Copy)]
enum Value {
    Field,
    Tensor,
    Gradient,
    Invariants,
}

fn map_of(system: &OpaqueSystem, value: Value) -> SmoothMap {
    let (d, casimirs) = (system.variables.len(), system.casimirs.len());
    let derivatives = system.numbers.derivatives();
    let (inputs, outputs, has_jacobian) = match value {
        Value::Field => (d, d, derivatives.of_field()),
        Value::Tensor => (2 * d, d, derivatives.tensor),
        Value::Gradient => (d, d, derivatives.hamiltonian),
        Value::Invariants => (d, 1 + casimirs, casimirs == 0 || derivatives.casimirs),
    };
    let numbers = system.numbers.clone();
    SmoothMap::from_numbers(inputs, outputs, has_jacobian, move |parameters, _, _| {
        Box::new(Worker {
            numbers: numbers.worker(parameters),
            value,
            gradient: vec![0.0; d],
            units: DMatrix::identity(d, d).as_slice().to_vec(),
            columns: vec![0.0; d * d],
            images: vec![0.0; d * d],
        })
    })
}

struct Worker {
    numbers: Box<dyn NumbersWorker>,
    value: Value,
    gradient: Vec<f64>,
    /// The unit vectors, and room for as many columns, twice.
    units: Vec<f64>,
    columns: Vec<f64>,
    images: Vec<f64>,
}

impl MapWorker for Worker {
    fn value(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let d = self.gradient.len();
        match self.value {
            Value::Field => {
                self.numbers.gradient(z, &mut self.gradient)?;
                self.numbers.tensor(z, &self.gradient, out)?;
                negate(out);
            }
            Value::Tensor => {
                self.numbers.tensor(&z[..d], &z[d..], out)?;
                negate(out);
            }
            Value::Gradient => self.numbers.gradient(z, out)?,
            Value::Invariants => {
                let (energy, casimirs) = out.split_at_mut(1);
                self.numbers.hamiltonian(z, energy)?;
                if !casimirs.is_empty() {
                    self.numbers.casimirs(z, casimirs)?;
                }
            }
        }
        Ok(())
    }

    fn jacobian(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let d = self.gradient.len();
        match self.value {
            // Column k of DX is −D(Π(x)∇H(x₀))e_k − Π D²H e_k, x₀ = x held fixed.
            Value::Field => {
                self.numbers.gradient(z, &mut self.gradient)?;
                self.numbers
                    .tensor_tangent(z, &self.gradient, &self.units, &mut self.columns)?;
                transposed(&self.columns, -1.0, out, d, 0);
                self.numbers.hessian(z, &self.units, &mut self.columns)?;
                self.numbers.tensor(z, &self.columns, &mut self.images)?;
                for (i, row) in out.chunks_exact_mut(d).enumerate() {
                    for (k, entry) in row.iter_mut().enumerate() {
                        *entry -= self.images[k * d + i];
                    }
                }
            }
            Value::Tensor => {
                let (u, w) = z.split_at(d);
                self.numbers
                    .tensor_tangent(u, w, &self.units, &mut self.columns)?;
                transposed(&self.columns, -1.0, out, 2 * d, 0);
                self.numbers.tensor(u, &self.units, &mut self.columns)?;
                transposed(&self.columns, -1.0, out, 2 * d, d);
            }
            Value::Gradient => {
                self.numbers.hessian(z, &self.units, &mut self.columns)?;
                transposed(&self.columns, 1.0, out, d, 0);
            }
            Value::Invariants => {
                let (energy, casimirs) = out.split_at_mut(d);
                self.numbers.gradient(z, energy)?;
                if !casimirs.is_empty() {
                    self.numbers.casimir_gradients(z, casimirs)?;
                }
            }
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        self.numbers.operations()
    }
}

fn negate(values: &mut [f64]) {
    values.iter_mut().for_each(|v| *v = -*v);
}

/// Writes columns, d numbers each, times a sign into rows of `width` entries from entry `first` on.
fn transposed(columns: &[f64], sign: f64, rows: &mut [f64], width: usize, first: usize) {
    let d = columns.len().isqrt();
    for (i, row) in rows.chunks_exact_mut(width).enumerate() {
        for (k, entry) in row[first..first + d].iter_mut().enumerate() {
            *entry = sign * columns[k * d + i];
        }
    }
}
