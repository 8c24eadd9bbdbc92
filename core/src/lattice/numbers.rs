//! A lattice as a system of numbers: field, tensor and gradient by one sweep each.

use std::sync::Arc;

use leafwise_expression::{Expression, Term};

use super::geometry::{LatticeGeometry, Proxy};
use super::locality::proxy_of;
use super::observables::LatticeObservables;
use super::program::{LatticeEvaluator, LatticeProgram};
use super::source::LatticeSource;
use super::stages::{Field, StageBuilder};
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::system::numbers::{Derivatives, SystemEvaluator, SystemFunction, vector};
use crate::system::{FieldRounding, OpaqueSystem, SystemFormulas, SystemNumbers};

/// A long lattice as a system of numbers, for steppers that take fields alone.
///
/// An evaluation of the field −Π(∇H + η) + f is one sweep over the sites.
#[derive(Debug)]
pub struct LatticeNumbers {
    /// The system.
    pub system: OpaqueSystem,
    /// The lattice.
    pub geometry: LatticeGeometry,
    /// The short lattice on which the code was written out.
    pub proxy_geometry: LatticeGeometry,
    /// The operations of one evaluation of the field, all sites together.
    pub operations: usize,
    /// The same, weighted as [`SolverStatistics::operations`](crate::SolverStatistics) is.
    pub work: u64,
    /// The numbers a coordinate that an evaluation of the field keeps.
    pub fields: usize,
}

impl LatticeNumbers {
    /// Compiles field, gradient and tensor of one site of each class.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] where the lattice looks too far; [`BuildError::Algebra`] where a formula or its derivative has no
    /// code; those of the source.
    pub fn compile(source: &dyn LatticeSource) -> Result<Self, BuildError> {
        let geometry = source.geometry().clone();
        let (proxy, width) = proxy_of(source, 1)?;
        let written = source.write_out(&proxy)?;
        let system = written.expressions().ok_or_else(|| BuildError::Lattice {
            message: "a lattice of numbers has no templates".to_owned(),
        })?;
        let at = Proxy {
            geometry: &proxy,
            width,
        };
        let sweep =
            |of: &OfField<'_>| FieldSweep::compile(&geometry, at, system.parameters().len(), of);
        let field = sweep(&|builder, x, _| system.vector_field(&mut builder.graph, x))?;
        let gradient = sweep(&|builder, x, _| system.gradient(&mut builder.graph, x))?;
        let tensor = sweep(&|builder, x, v| tensor_times(system, builder, x, v))?;
        let (operations, work) = (field.program.operations(), field.program.work());
        let fields = field.program.fields();
        let parameters = system.parameter_values();
        let energy = LatticeObservables::new(source, &parameters, 0..1)?;
        let casimirs =
            LatticeObservables::new(source, &parameters, 1..1 + system.casimirs().len())?;
        let [of_field, gradient, tensor] = [field, gradient, tensor].map(Arc::new);
        let (of_rounding, families) = (Arc::clone(&of_field), geometry.families.clone());
        let mut numbers = SystemNumbers::new(Derivatives::default(), move |parameters| {
            Box::new(LatticeValues {
                gradient: gradient.at(parameters),
                tensor: tensor.at(parameters),
                energy: energy.at(parameters),
                casimirs: casimirs.at(parameters),
                operations: 0,
            })
        })
        .with_field(move |parameters, points| {
            Box::new(FieldOfSites {
                sweep: of_field.at(parameters),
                points,
                operations: 0,
            })
        })
        .with_rounding(move || {
            let (field, families) = (Arc::clone(&of_rounding), families.clone());
            Ok(FieldRounding::new(move |parameters, x, errors, out| {
                moved_by_errors(&mut field.at(parameters), &families, (x, errors), out);
                Ok(())
            }))
        })
        .with_motion(system.forces().motion())
        .with_derived_gradient();
        if rests(system) {
            numbers = numbers.with_resting_tensor();
        }
        let variables = (0..geometry.dimension()).map(|at| geometry.name(at));
        Ok(Self {
            system: OpaqueSystem {
                name: "a long lattice".to_owned(),
                variables: variables.collect(),
                parameters: system.parameters().to_vec(),
                casimirs: system
                    .casimirs()
                    .iter()
                    .map(|own| own.name.clone())
                    .collect(),
                numbers,
            },
            geometry,
            proxy_geometry: proxy,
            operations,
            work,
            fields,
        })
    }
}

/// The field of a family may move by so many times its largest change under errors of either sign.
const UNSEEN: f64 = 8.0;

/// How far errors of the coordinates move the field: by family, from one evaluation with errors of scattered signs.
fn moved_by_errors(
    field: &mut SweepAt,
    families: &[(String, usize)],
    (x, errors): (&[f64], &[f64]),
    out: &mut [f64],
) {
    let signs = (0..x.len()).map(|at| {
        let scattered = (at as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        if scattered >> 63 == 0 { 1.0 } else { -1.0 }
    });
    let moved = x.iter().zip(errors).zip(signs);
    let moved = moved.map(|((x, error), sign)| x + sign * error);
    out.copy_from_slice(field.evaluate(moved, None));
    let here = field.evaluate(x.iter().copied(), None);
    let (mut out, mut here) = (out, here);
    for (_, sites) in families {
        let (own, rest) = std::mem::take(&mut out).split_at_mut(*sites);
        let (at, beyond) = here.split_at(*sites);
        let bound = own.iter().zip(at).fold(0.0_f64, |most, (moved, here)| {
            most.max((moved - here).abs() + f64::EPSILON * here.abs())
        });
        own.fill(UNSEEN * bound);
        (out, here) = (rest, beyond);
    }
}

/// Π v as code.
fn tensor_times(
    system: &SystemFormulas,
    builder: &mut StageBuilder,
    x: &[Term],
    v: &[Term],
) -> Result<Vec<Term>, BuildError> {
    let graph = &mut builder.graph;
    Ok(system.apply_tensor(graph, x, v)?)
}

/// Whether the entries of the tensor depend on coordinates alone that rest.
fn rests(system: &SystemFormulas) -> bool {
    let friction = system.forces().friction.iter().enumerate();
    let mut moves = vec![false; system.dimension()];
    for (at, own) in friction {
        moves[at] |= *own != Expression::from(0);
    }
    for &(i, j) in system.tensor().keys() {
        (moves[i], moves[j]) = (true, true);
    }
    let mut entries = system.tensor().values();
    entries.all(|entry| entry.variables().into_iter().all(|at| !moves[at]))
}

/// Writes a field of the lattice as code of the state and of a covector.
type OfField<'a> =
    dyn Fn(&mut StageBuilder, &[Term], &[Term]) -> Result<Vec<Term>, BuildError> + 'a;

/// A field of the lattice as code of the state and of a covector.
struct FieldSweep {
    program: LatticeProgram,
    state: Field,
    covector: Field,
    result: Field,
    dimension: usize,
}

impl FieldSweep {
    fn compile(
        geometry: &LatticeGeometry,
        proxy: Proxy<'_>,
        parameters: usize,
        of: &OfField<'_>,
    ) -> Result<Self, BuildError> {
        let mut builder = StageBuilder::new(proxy.geometry.dimension());
        let (state, x) = builder.unwritten();
        let (covector, v) = builder.unwritten();
        let values = of(&mut builder, &x, &v)?;
        let result = builder.output(values);
        builder.finish_stage();
        Ok(Self {
            program: LatticeProgram::compile(geometry, proxy, &builder, parameters)?,
            state,
            covector,
            result,
            dimension: geometry.dimension(),
        })
    }

    fn at(self: &Arc<Self>, parameters: &[f64]) -> SweepAt {
        SweepAt {
            evaluator: self.program.evaluator(parameters, 1.0, 1.0),
            sweep: Arc::clone(self),
        }
    }
}

/// A sweep with its fields, at values of the parameters.
struct SweepAt {
    sweep: Arc<FieldSweep>,
    evaluator: LatticeEvaluator,
}

impl SweepAt {
    /// The field at a state and a covector.
    fn evaluate(&mut self, state: impl Iterator<Item = f64>, covector: Option<&[f64]>) -> &[f64] {
        let Self { sweep, evaluator } = self;
        let to = evaluator.field_mut(sweep.state).iter_mut();
        to.zip(state).for_each(|(to, value)| *to = value);
        if let Some(covector) = covector {
            evaluator
                .field_mut(sweep.covector)
                .copy_from_slice(covector);
        }
        sweep.program.run(evaluator);
        evaluator.field(sweep.result)
    }

    fn work(&self) -> u64 {
        self.sweep.program.work()
    }
}

/// The field at points side by side.
struct FieldOfSites {
    sweep: SweepAt,
    points: usize,
    operations: u64,
}

impl Evaluator for FieldOfSites {
    fn values(&mut self, points: &[f64], field: &mut [f64]) -> Result<(), StepError> {
        let count = self.points;
        for at in 0..count {
            let state = points[at..].iter().step_by(count).copied();
            let own = self.sweep.evaluate(state, None);
            let to = field[at..].iter_mut().step_by(count);
            to.zip(own).for_each(|(to, value)| *to = *value);
            self.operations += self.sweep.work();
        }
        Ok(())
    }

    fn jacobians(&mut self, _points: &[f64], _out: &mut [f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}

/// One thread's evaluator, point by point.
struct LatticeValues {
    gradient: SweepAt,
    tensor: SweepAt,
    energy: LatticeObservables,
    casimirs: LatticeObservables,
    operations: u64,
}

impl SystemEvaluator for LatticeValues {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        let d = self.gradient.sweep.dimension;
        let results = match function {
            SystemFunction::Tensor(_) | SystemFunction::Gradient => d,
            SystemFunction::Hamiltonian => 1,
            SystemFunction::Casimirs => self.casimirs.observables(),
            SystemFunction::TensorTangent(..)
            | SystemFunction::Hessian(_)
            | SystemFunction::CasimirGradients => return Err(StepError::NoTangent),
        };
        for (at, out) in out.chunks_exact_mut(results.max(1)).enumerate() {
            let y = vector(y, d, at);
            let values = || y.iter().copied();
            match function {
                SystemFunction::Tensor(v) => {
                    let v = vector(v, d, at);
                    out.copy_from_slice(self.tensor.evaluate(values(), Some(v)));
                    self.operations += self.tensor.work();
                }
                SystemFunction::Gradient => {
                    out.copy_from_slice(self.gradient.evaluate(values(), None));
                    self.operations += self.gradient.work();
                }
                SystemFunction::Hamiltonian => self.energy.evaluate(y, out),
                _ => self.casimirs.evaluate(y, out),
            }
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}
