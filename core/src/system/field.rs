//! Maps of a system that steppers work on: X_H, (u, w) ↦ −Π(u)w, ∇H, the invariants.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Term};
use nalgebra::DMatrix;

use super::numbers::{MakeField, OpaqueSystem, SystemEvaluator};
use super::rounding::FieldRounding;
use super::{Definition, PoissonSystem};
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::runge_kutta::SmoothMap;

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
                SmoothMap::compile(graph, &field, system.parameters().len(), x.len())
            }
        }
    }

    /// The same for methods that need no Jacobian, which long systems take long to compile.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn field_values(&self) -> Result<SmoothMap, BuildError> {
        self.field_and_rounding().map(|(field, _)| field)
    }

    /// The same with bounds on its rounding errors; of a system of numbers where these are offered.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn field_and_rounding(&self) -> Result<(SmoothMap, Option<FieldRounding>), BuildError> {
        let system = match &self.definition {
            Definition::Formulas(system) => system,
            Definition::Numbers(system) => {
                return Ok((self.field_map()?, system.numbers.rounding()?));
            }
        };
        let (mut graph, x) = inputs(system.dimension());
        let field = system.vector_field(&mut graph, &x)?;
        graph.unless_refused(())?;
        let parameters = system.parameters().len();
        let map = SmoothMap::compile_values(&graph, &field, parameters, x.len());
        Ok((map, Some(FieldRounding::of(&graph, &field))))
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
                SmoothMap::compile(graph, &applied, system.parameters().len(), 2 * d)
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
                SmoothMap::compile(graph, &gradient, system.parameters().len(), x.len())
            }
        }
    }

    /// The same for what needs no D²H, as [`field_values`](Self::field_values).
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn gradient_values(&self) -> Result<SmoothMap, BuildError> {
        match &self.definition {
            Definition::Numbers(_) => self.gradient_map(),
            Definition::Formulas(system) => {
                let (mut graph, x) = inputs(system.dimension());
                let gradient = system.gradient(&mut graph, &x)?;
                graph.unless_refused(())?;
                let parameters = system.parameters().len();
                Ok(SmoothMap::compile_values(
                    &graph,
                    &gradient,
                    parameters,
                    x.len(),
                ))
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
                SmoothMap::compile(graph, &values, system.parameters().len(), x.len())
            }
        }
    }
}

fn inputs(count: usize) -> (Graph, Vec<Term>) {
    let mut graph = Graph::compilable();
    let inputs = (0..count).map(|i| graph.input(i)).collect();
    (graph, inputs)
}

/// Map computed from a system of numbers: its field, its tensor applied to a covector, ∇H, or H with the Casimirs.
#[derive(Clone, Copy)]
enum Value {
    Field,
    Tensor,
    Gradient,
    Invariants,
}

fn map_of(system: &OpaqueSystem, value: Value) -> SmoothMap {
    let (d, casimirs) = (system.variables.len(), system.casimirs.len());
    let derivatives = system.numbers.derivatives;
    let (inputs, outputs, has_jacobian) = match value {
        Value::Field => (d, d, derivatives.of_field()),
        Value::Tensor => (2 * d, d, derivatives.tensor),
        Value::Gradient => (d, d, derivatives.hamiltonian),
        Value::Invariants => (d, 1 + casimirs, casimirs == 0 || derivatives.casimirs),
    };
    let numbers = system.numbers.clone();
    let field = match value {
        Value::Field => numbers.field(),
        Value::Tensor | Value::Gradient | Value::Invariants => None,
    };
    let side_by_side = field.clone();
    let map = SmoothMap::from_numbers(inputs, outputs, has_jacobian, move |parameters, _, _| {
        Box::new(FieldEvaluator {
            numbers: numbers.evaluator(parameters),
            side_by_side: field.clone().map(|make| BatchOfField {
                make,
                parameters: parameters.to_vec(),
                evaluators: Vec::new(),
                rows: Default::default(),
            }),
            value,
            dimension: d,
            gradients: vec![0.0; d],
            units: Vec::new(),
            columns: Vec::new(),
            images: Vec::new(),
            spread: Default::default(),
        })
    });
    match side_by_side {
        Some(make) => map.with_side_by_side(move |parameters, points| make(parameters, points)),
        None => map,
    }
}

/// X_H at points one behind the other, evaluated side by side.
struct BatchOfField {
    make: Arc<MakeField>,
    parameters: Vec<f64>,
    /// Evaluators by their numbers of points.
    evaluators: Vec<(usize, Box<dyn Evaluator>)>,
    /// Points and results in rows.
    rows: [Vec<f64>; 2],
}

impl BatchOfField {
    fn values(&mut self, dimension: usize, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let points = z.len() / dimension;
        let known = self.evaluators.iter().position(|(own, _)| *own == points);
        let at = known.unwrap_or_else(|| {
            let made = (self.make)(&self.parameters, points);
            self.evaluators.push((points, made));
            self.evaluators.len() - 1
        });
        let evaluator = &mut self.evaluators[at].1;
        if points == 1 {
            return evaluator.values(z, out);
        }
        let [rows, results] = &mut self.rows;
        rows.resize(z.len(), 0.0);
        results.resize(z.len(), 0.0);
        for (point, z) in z.chunks_exact(dimension).enumerate() {
            let own = rows[point..].iter_mut().step_by(points);
            own.zip(z).for_each(|(row, z)| *row = *z);
        }
        evaluator.values(rows, results)?;
        for (point, out) in out.chunks_exact_mut(dimension).enumerate() {
            let own = results[point..].iter().step_by(points);
            out.iter_mut().zip(own).for_each(|(out, own)| *out = *own);
        }
        Ok(())
    }

    fn operations(&self) -> u64 {
        let evaluators = self.evaluators.iter();
        let own = evaluators.filter_map(|(_, evaluator)| evaluator.operations());
        own.sum()
    }
}

struct FieldEvaluator {
    numbers: Box<dyn SystemEvaluator>,
    /// Of the field, where the system offers it as a whole.
    side_by_side: Option<BatchOfField>,
    value: Value,
    dimension: usize,
    /// ∇H of each point, contiguous.
    gradients: Vec<f64>,
    /// The unit vectors, and room for as many columns a point, twice; empty until a Jacobian is asked
    /// for, which explicit methods never do.
    units: Vec<f64>,
    columns: Vec<f64>,
    images: Vec<f64>,
    /// Of several points: y, v and the unit vectors as often as there are columns.
    spread: [Vec<f64>; 3],
}

impl FieldEvaluator {
    fn inputs(&self) -> usize {
        match self.value {
            Value::Tensor => 2 * self.dimension,
            Value::Field | Value::Gradient | Value::Invariants => self.dimension,
        }
    }
}

impl Evaluator for FieldEvaluator {
    fn values(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let d = self.dimension;
        let count = z.len() / self.inputs();
        if let Some(batch) = &mut self.side_by_side {
            return batch.values(d, z, out);
        }
        match self.value {
            Value::Field => {
                self.gradients.resize(count * d, 0.0);
                self.numbers.gradient(z, &mut self.gradients)?;
                self.numbers.tensor(z, &self.gradients, out)?;
                negate(out);
            }
            Value::Tensor => {
                for (uw, out) in z.chunks_exact(2 * d).zip(out.chunks_exact_mut(d)) {
                    self.numbers.tensor(&uw[..d], &uw[d..], out)?;
                }
                negate(out);
            }
            Value::Gradient => self.numbers.gradient(z, out)?,
            Value::Invariants => {
                let results = out.len() / count;
                for (y, out) in z.chunks_exact(d).zip(out.chunks_exact_mut(results)) {
                    let (energy, casimirs) = out.split_at_mut(1);
                    self.numbers.hamiltonian(y, energy)?;
                    if !casimirs.is_empty() {
                        self.numbers.casimirs(y, casimirs)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn jacobians(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let d = self.dimension;
        let count = z.len() / self.inputs();
        if self.units.is_empty() {
            self.units = DMatrix::identity(d, d).as_slice().to_vec();
            self.columns.resize(d * d, 0.0);
            self.images.resize(d * d, 0.0);
        }
        match self.value {
            // Column k of DX is −D(Π(x)∇H(x₀))e_k − Π D²H e_k, x₀ = x held fixed.
            Value::Field => {
                self.gradients.resize(count * d, 0.0);
                self.numbers.gradient(z, &mut self.gradients)?;
                self.columns.resize(count * d * d, 0.0);
                self.images.resize(count * d * d, 0.0);
                let [y, v, units] = &mut self.spread;
                let (y, v, units) = if count == 1 {
                    (z, &self.gradients[..], &self.units[..])
                } else {
                    spread(z, d, y);
                    spread(&self.gradients, d, v);
                    (&y[..], &v[..], repeat(&self.units, count, units))
                };
                let (columns, images) = (&mut self.columns[..], &mut self.images[..]);
                self.numbers.tensor_tangent(y, v, units, columns)?;
                for (columns, out) in columns.chunks_exact(d * d).zip(out.chunks_exact_mut(d * d)) {
                    transposed(columns, -1.0, out, d, 0);
                }
                self.numbers.hessian(y, units, columns)?;
                self.numbers.tensor(y, columns, images)?;
                for (images, out) in images.chunks_exact(d * d).zip(out.chunks_exact_mut(d * d)) {
                    for (i, row) in out.chunks_exact_mut(d).enumerate() {
                        for (k, entry) in row.iter_mut().enumerate() {
                            *entry -= images[k * d + i];
                        }
                    }
                }
            }
            Value::Tensor => {
                for (uw, out) in z.chunks_exact(2 * d).zip(out.chunks_exact_mut(2 * d * d)) {
                    let (u, w) = uw.split_at(d);
                    let columns = &mut self.columns[..d * d];
                    self.numbers.tensor_tangent(u, w, &self.units, columns)?;
                    transposed(columns, -1.0, out, 2 * d, 0);
                    self.numbers.tensor(u, &self.units, columns)?;
                    transposed(columns, -1.0, out, 2 * d, d);
                }
            }
            Value::Gradient => {
                self.columns.resize(count * d * d, 0.0);
                let [y, _, units] = &mut self.spread;
                let (y, units) = if count == 1 {
                    (z, &self.units[..])
                } else {
                    spread(z, d, y);
                    (&y[..], repeat(&self.units, count, units))
                };
                self.numbers.hessian(y, units, &mut self.columns)?;
                let columns = self.columns.chunks_exact(d * d);
                for (columns, out) in columns.zip(out.chunks_exact_mut(d * d)) {
                    transposed(columns, 1.0, out, d, 0);
                }
            }
            Value::Invariants => {
                let entries = out.len() / count;
                for (y, out) in z.chunks_exact(d).zip(out.chunks_exact_mut(entries)) {
                    let (energy, casimirs) = out.split_at_mut(d);
                    self.numbers.gradient(y, energy)?;
                    if !casimirs.is_empty() {
                        self.numbers.casimir_gradients(y, casimirs)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        let beside = self
            .side_by_side
            .as_ref()
            .map_or(0, BatchOfField::operations);
        Some(self.numbers.operations()? + beside)
    }
}

/// Each vector of `values` as often as it has coordinates.
fn spread(values: &[f64], dimension: usize, into: &mut Vec<f64>) {
    into.clear();
    for vector in values.chunks_exact(dimension) {
        (0..dimension).for_each(|_| into.extend_from_slice(vector));
    }
}

/// `values` so many times; `kept` grows by them as is needed.
fn repeat<'a>(values: &[f64], count: usize, kept: &'a mut Vec<f64>) -> &'a [f64] {
    while kept.len() < count * values.len() {
        kept.extend_from_slice(values);
    }
    &kept[..count * values.len()]
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
