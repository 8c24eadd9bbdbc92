//! Π(x) as a matrix.

use leafwise_expression::{Kernel, Workspace};
use nalgebra::DMatrix;

use super::formula_kernel::kernel;
use super::numbers::SystemEvaluator;
use super::{Definition, PoissonSystem};
use crate::error::{BuildError, StepError};

/// Π_ij by columns j, each with its rows i.
pub(crate) type Entries = Vec<Vec<(usize, f64)>>;

/// x ↦ (Π_ij(x)) for one set of parameters: for instruments, not for steps.
pub(crate) struct TensorMatrix {
    dimension: usize,
    source: Source,
}

enum Source {
    Formulas {
        kernel: Box<Kernel>,
        workspace: Box<Workspace>,
        entries: Vec<(usize, usize)>,
    },
    Numbers(Box<dyn SystemEvaluator>),
}

impl TensorMatrix {
    /// The tensor of a system.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an entry has no code.
    pub(crate) fn new(system: &PoissonSystem, parameters: &[f64]) -> Result<Self, BuildError> {
        let dimension = system.dimension();
        let source = match &system.definition {
            Definition::Numbers(system) => Source::Numbers(system.numbers.evaluator(parameters)),
            Definition::Formulas(system) => {
                let formulas: Vec<_> = system.tensor().values().collect();
                let kernel = kernel(&formulas, dimension, parameters.len())?;
                let mut workspace = kernel.workspace(1);
                kernel.prepare(&mut workspace, parameters, &[1.0], &[1.0]);
                Source::Formulas {
                    kernel: Box::new(kernel),
                    workspace: Box::new(workspace),
                    entries: system.tensor().keys().copied().collect(),
                }
            }
        };
        Ok(Self { dimension, source })
    }

    /// Π(x).
    ///
    /// # Errors
    /// The [`StepError`] of a system of numbers.
    pub(crate) fn at(&mut self, x: &[f64]) -> Result<DMatrix<f64>, StepError> {
        let d = self.dimension;
        match &mut self.source {
            Source::Formulas {
                kernel,
                workspace,
                entries,
            } => {
                let mut values = vec![0.0; entries.len()];
                kernel.evaluate(workspace, x, &mut values);
                let mut matrix = DMatrix::zeros(d, d);
                for (&(i, j), value) in entries.iter().zip(values) {
                    matrix[(i, j)] = value;
                    matrix[(j, i)] = -value;
                }
                Ok(matrix)
            }
            // Point j of the batch is x with the unit vector e_j: column j of Π.
            Source::Numbers(evaluator) => {
                let units = DMatrix::identity(d, d);
                let mut columns = vec![0.0; d * d];
                evaluator.tensor(x, units.as_slice(), &mut columns)?;
                Ok(DMatrix::from_vec(d, d, columns))
            }
        }
    }

    /// The entries of Π(x) that are not 0, row by row of its transpose.
    ///
    /// # Errors
    /// The [`StepError`] of a system of numbers.
    pub(crate) fn entries_at(&mut self, x: &[f64]) -> Result<Entries, StepError> {
        let d = self.dimension;
        let mut entries = vec![Vec::new(); d];
        match &mut self.source {
            Source::Formulas {
                kernel,
                workspace,
                entries: places,
            } => {
                let mut values = vec![0.0; places.len()];
                kernel.evaluate(workspace, x, &mut values);
                for (&(i, j), value) in places.iter().zip(values) {
                    entries[j].push((i, value));
                    entries[i].push((j, -value));
                }
            }
            Source::Numbers(evaluator) => {
                let (mut unit, mut column) = (vec![0.0; d], vec![0.0; d]);
                for (j, own) in entries.iter_mut().enumerate() {
                    unit[j] = 1.0;
                    evaluator.tensor(x, &unit, &mut column)?;
                    unit[j] = 0.0;
                    let held = column.iter().enumerate().filter(|(_, v)| **v != 0.0);
                    own.extend(held.map(|(i, v)| (i, *v)));
                }
            }
        }
        Ok(entries)
    }

    /// Π(x)a for covectors a of d numbers each, one after the other.
    ///
    /// # Errors
    /// The [`StepError`] of a system of numbers.
    pub(crate) fn times(
        &mut self,
        x: &[f64],
        covectors: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        let d = self.dimension;
        let mut pairs = out.chunks_exact_mut(d).zip(covectors.chunks_exact(d));
        if let Source::Numbers(evaluator) = &mut self.source {
            return pairs.try_for_each(|(vector, a)| evaluator.tensor(x, a, vector));
        }
        let entries = self.entries_at(x)?;
        for (vector, a) in pairs {
            vector.fill(0.0);
            for (rows, a) in entries.iter().zip(a) {
                for (i, entry) in rows {
                    vector[*i] += entry * a;
                }
            }
        }
        Ok(())
    }

    /// |Π_ij(x)| + Σ_k |∂_k Π_ij| s_k, for coordinates of these sizes: u times it is what round-off of the
    /// arguments may put into an entry. Derivatives by differences, away from 0; where the tensor has no
    /// value there, they count nothing.
    ///
    /// # Errors
    /// The [`StepError`] of a system of numbers at `x`.
    pub(crate) fn sizes(&mut self, x: &[f64], sizes: &[f64]) -> Result<DMatrix<f64>, StepError> {
        /// A step of 2⁻¹⁰ of a size tells a derivative to three digits, and stays in any domain.
        const STEP: f64 = 1.0 / 1024.0;
        let here = self.at(x)?;
        let mut sum = here.abs();
        let mut point = x.to_vec();
        for (k, size) in sizes.iter().enumerate() {
            point[k] = x[k] + (STEP * size).copysign(x[k]);
            if let Ok(there) = self.at(&point) {
                let change = (there - &here).abs() / STEP;
                sum.zip_apply(&change, |sum, change| {
                    if change.is_finite() {
                        *sum += change;
                    }
                });
            }
            point[k] = x[k];
        }
        Ok(sum)
    }
}
