//! A method followed by projection onto energy and Casimirs: the part `projection`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMapEvaluator, Tableau};
use leafwise_core::solver::LinearIteration;
use leafwise_core::solver::iteration::Verdict;
use leafwise_core::{BuildError, MapProperties, PoissonSystem, StepError, StepMap, Structure};
use nalgebra::{DMatrix, DVector};

use crate::gauss::{STAGES, stages};
use crate::implicit::ImplicitRungeKutta;
use crate::one_step::{OneStep, ReferenceMap, larger, reach, relative};
use crate::rk4::Rk4;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "projection",
    kind: PartKind::Stepper,
    summary: "a Runge-Kutta step, then the nearest state with the energy and Casimirs of before",
    declares: "the order of its base, 4 or 2s; keeps H and the Casimirs; not a Poisson map; not \
               self-adjoint",
    domain: "any system whose Casimirs have gradients, of formulas or of numbers",
    literature: "Hairer, Lubich, Wanner, Geometric Numerical Integration, section IV.4",
    parameters: &[
        ParameterInfo {
            name: "base",
            summary: "the method that is projected: rk4 or gauss",
            default: ParameterDefault::Text("rk4"),
        },
        STAGES,
    ],
};

/// Budget of one projection.
const MOST_EVALUATIONS: usize = 50;

/// y = x̃ + Dg(x̃)ᵀλ with g(y) = g(x), g = (H, C_1, …) and x̃ the base's next state.
struct Projection {
    base: Box<dyn OneStep>,
    invariants: SmoothMapEvaluator,
    /// Operations of the normal equations.
    linear: u64,
}

impl Projection {
    fn invariants_at(&mut self, x: &[f64]) -> Result<(DVector<f64>, Vec<f64>), StepError> {
        let count = self.invariants.map().outputs();
        let mut values = DVector::zeros(count);
        let mut rows = vec![0.0; count * x.len()];
        self.invariants.value(x, values.as_mut_slice())?;
        self.invariants.jacobian(x, &mut rows)?;
        Ok((values, rows))
    }
}

impl OneStep for Projection {
    fn increment(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        let d = x.len();
        let mut evaluations = self.base.increment(x, increment)?;
        let (kept, _) = self.invariants_at(x)?;
        let count = kept.len();
        let next: Vec<f64> = x.iter().zip(&*increment).map(|(x, i)| x + i).collect();
        let mut normals = DMatrix::from_row_slice(count, d, &self.invariants_at(&next)?.1);
        // Each invariant in units of its slope, so that their sizes do not enter the rank below.
        let units = DVector::from_fn(count, |k, _| {
            let slope = libm::sqrt(normals.row(k).iter().map(|v| v * v).sum());
            if slope > 0.0 { 1.0 / slope } else { 0.0 }
        });
        let units = DMatrix::from_diagonal(&units);
        normals = &units * normals;
        let mut iteration = LinearIteration::new(MOST_EVALUATIONS);
        loop {
            let y: Vec<f64> = x.iter().zip(&*increment).map(|(x, i)| x + i).collect();
            let (values, rows) = self.invariants_at(&y)?;
            let residual = &kept - values;
            // The invariants' gradients may be parallel, at an equilibrium or for dependent Casimirs:
            // the smallest multipliers then.
            let gram = &units * DMatrix::from_row_slice(count, d, &rows) * normals.transpose();
            let scaled = &units * &residual;
            if !gram.iter().chain(scaled.iter()).all(|v| v.is_finite()) {
                return Err(StepError::NonFinite {
                    what: "the invariants of a projection",
                });
            }
            // The normal matrix, some ten products of its size, the change.
            self.linear += (2 * count * count * (d + 10 * count) + 2 * count * d) as u64;
            let decomposition = gram.svd(true, true);
            let largest = decomposition
                .singular_values
                .iter()
                .fold(0.0_f64, |m, v| m.max(*v));
            let multipliers = decomposition.solve(&scaled, 1e-12 * largest).map_err(|_| {
                StepError::NonFinite {
                    what: "the multipliers of a projection",
                }
            })?;
            let change = normals.transpose() * multipliers;
            increment
                .iter_mut()
                .zip(change.iter())
                .for_each(|(i, c)| *i += c);
            let mut size = 0.0;
            for k in 0..count {
                let scale = kept[k].abs() + reach(&rows[k * d..][..d], &y);
                size = larger(relative(residual[k], scale), size);
            }
            if iteration.judge(size)? == Verdict::Converged {
                break;
            }
        }
        evaluations += iteration.evaluations();
        Ok(evaluations)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.base.operations()? + self.invariants.operations()? + self.linear)
    }

    fn restart(&mut self) {
        self.base.restart();
    }

    fn memory(&self) -> Vec<f64> {
        self.base.memory()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.base.restore(memory);
    }
}

struct Part;

impl StepperPart for Part {
    fn info(&self) -> &'static PartInfo {
        &INFO
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        let base = parameters.word(&INFO, "base", &["rk4", "gauss"])?;
        let stages = stages(&INFO, parameters)?;
        let (order, tableau) = match base {
            "gauss" => (2 * stages, Some(Tableau::gauss(stages))),
            _ => (4, None),
        };
        let (field, invariants) = (system.field_map()?, system.invariants_map()?);
        if let (false, Some(system)) = (invariants.has_jacobian(), system.opaque()) {
            return Err(system.not_offered(INFO.name, "the gradients of the Casimirs"));
        }
        Ok(Arc::new(ReferenceMap {
            dimension: system.dimension(),
            properties: MapProperties {
                order,
                structure: Structure::None,
                self_adjoint: Some(false),
            },
            description: match tableau {
                None => format!("{} of {base}", INFO.name),
                Some(_) => format!("{} of {base} s = {stages}", INFO.name),
            },
            make: Box::new(move |parameters, time_step| {
                let base: Box<dyn OneStep> = match tableau.clone() {
                    None => Box::new(Rk4::new(&field, parameters, time_step)),
                    Some(tableau) => Box::new(ImplicitRungeKutta::new(
                        &field, tableau, parameters, time_step,
                    )),
                };
                Box::new(Projection {
                    base,
                    invariants: invariants.evaluator(parameters, 1.0, 1.0),
                    linear: 0,
                })
            }),
        }))
    }
}

leafwise_core::built_in!(Stepper, Part);
