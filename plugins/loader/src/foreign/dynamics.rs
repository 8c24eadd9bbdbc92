//! A dynamic approximation that a library computes.

use std::sync::Arc;

use leafwise_core::evaluator::one_by_one;
use leafwise_core::part::ParameterSetting;
use leafwise_core::runge_kutta::SmoothMap;
use leafwise_core::{
    BuildError, Correction, DynamicApproximation, DynamicsProperties, Evaluator,
    LagrangianBisection, OneForm, PartParameters, PoissonSystem, RealizationData, StepError,
};
use leafwise_plugin_abi::LwDynamics;

use super::batch::Input;
use super::callee::{Callee, Idle};
use super::function::{ForeignFunction, Named};
use super::instance::{Call, Instance};
use super::making::{HostObjects, Making};
use super::part::{ForeignPart, Properties};
use crate::host::{HostSystem, RealizationToLend};
use crate::trial_points::states;

/// A part of kind `LW_KIND_DYNAMICS` with functions.
pub(crate) struct ForeignDynamicsPart {
    part: Arc<ForeignPart>,
    table: LwDynamics,
}

impl ForeignDynamicsPart {
    pub(crate) fn new(part: ForeignPart, table: LwDynamics) -> Self {
        Self {
            part: Arc::new(part),
            table,
        }
    }

    pub(crate) fn build(
        &self,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        let settings = self.part.settings(parameters)?;
        Ok(Arc::new(ForeignDynamics {
            properties: self
                .part
                .properties(0, &settings)
                .map_err(|failure| failure.of_build(self.part.name()))?,
            part: Arc::clone(&self.part),
            table: self.table,
            settings,
        }))
    }
}

#[derive(Clone, Debug)]
struct ForeignDynamics {
    part: Arc<ForeignPart>,
    table: LwDynamics,
    settings: Vec<(String, ParameterSetting)>,
    properties: Properties,
}

impl DynamicApproximation for ForeignDynamics {
    fn properties(&self) -> DynamicsProperties {
        let Properties { order, flags, .. } = self.properties;
        DynamicsProperties {
            is_lagrangian: flags.is_symplectic(),
            correction: match flags.is_uncorrected() {
                true => Correction::None,
                false => Correction::Bisection,
            },
            ..DynamicsProperties::of_order(order, flags.self_adjoint())
        }
    }

    fn describe(&self) -> String {
        format!("{} m = {}", self.part.name(), self.properties.order)
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        self.part.check_dimension(system.dimension())?;
        let values = system.parameter_values();
        let mut points = ForeignPoints {
            dynamics: self.clone(),
            system: system.clone(),
            realization: Arc::clone(realization),
            lend: RealizationToLend::new(realization, values.len())?,
            idle: Idle::default(),
        };
        // A trial, to tell now what cannot be combined.
        let lent = lent(&points.system, &points.lend, &values)?;
        let trial = Instance::new(&self.part, points.making(), lent).map_err(|failure| {
            BuildError::Incompatible {
                dynamics: self.describe(),
                realization: realization.describe(),
                reason: failure.to_string(),
            }
        })?;
        points.dynamics.table = offered(self.table, trial, realization.as_ref());
        let of_form = points.dynamics.table.one_form.is_some();
        let map = points.map();
        match of_form {
            true => {
                let form = OneForm::Numbers(map);
                LagrangianBisection::graph(form, realization, values.len(), &self.describe())
            }
            false => Ok(LagrangianBisection::Points {
                map,
                is_near_identity: false,
            }),
        }
    }
}

/// The table without the tangents that the instance does not offer.
fn offered(
    table: LwDynamics,
    mut instance: Instance,
    realization: &dyn RealizationData,
) -> LwDynamics {
    /// The step at which functions are asked for.
    const STEP: f64 = 1e-2;
    let (d, space) = (realization.dimension(), realization.space_dimension());
    let y = states(d).swap_remove(0);
    let mut z = vec![0.0; space];
    realization.section(&y, &mut z);
    let at_y = Call::at(1, 1.0, STEP, Input::points(&y, d));
    let at_z = Call::at(1, 1.0, STEP, Input::points(&z, space));
    LwDynamics {
        one_form_jacobian: instance.offered(table.one_form_jacobian, &at_y, d * d),
        embedding_jacobian: instance.offered(table.embedding_jacobian, &at_y, space * d),
        flow_jacobian: instance.offered(table.flow_jacobian, &at_z, space * space),
        ..table
    }
}

/// y ↦ θ̂(y) or L(y) as the library computes it.
#[derive(Debug)]
struct ForeignPoints {
    dynamics: ForeignDynamics,
    system: PoissonSystem,
    realization: Arc<dyn RealizationData>,
    lend: RealizationToLend,
    idle: Idle,
}

impl ForeignPoints {
    fn making(&self) -> Making<'_> {
        Making {
            dimension: self.system.dimension(),
            settings: &self.dynamics.settings,
        }
    }

    /// A function of `inputs` coordinates with `outputs` numbers a point, by an instance of its own.
    fn function(
        &self,
        [values, jacobians]: [Named; 2],
        (inputs, outputs): (usize, usize),
        parameters: &[f64],
        step_sizes: (f64, f64),
    ) -> ForeignFunction {
        let (system, lend) = (self.system.clone(), self.lend.clone());
        let own = parameters.to_vec();
        let making = (system.dimension(), self.dynamics.settings.clone());
        let part = &self.dynamics.part;
        ForeignFunction {
            callee: Callee::new(part, &self.idle, parameters, making, move || {
                lent(&system, &lend, &own)
            }),
            step_sizes,
            values,
            jacobians,
            inputs,
            outputs,
            is_of_pairs: false,
        }
    }

    /// As the library offers it: a one-form, an embedding or the flow of the section.
    fn map(self) -> SmoothMap {
        let (d, space) = (self.system.dimension(), self.realization.space_dimension());
        let table = self.dynamics.table;
        if table.one_form.is_some() || table.embedding.is_some() {
            let (functions, outputs) = match table.one_form {
                Some(_) => (
                    [
                        ("one_form", table.one_form),
                        ("one_form_jacobian", table.one_form_jacobian),
                    ],
                    d,
                ),
                None => (
                    [
                        ("embedding", table.embedding),
                        ("embedding_jacobian", table.embedding_jacobian),
                    ],
                    space,
                ),
            };
            let has_jacobian = functions[1].1.is_some();
            return SmoothMap::from_numbers(
                d,
                outputs,
                has_jacobian,
                move |parameters, epsilon, h| {
                    Box::new(self.function(functions, (d, outputs), parameters, (epsilon, h)))
                },
            );
        }
        let functions = [("flow", table.flow), ("flow_jacobian", table.flow_jacobian)];
        let chart = self.lend.chart().filter(|chart| chart.has_jacobian());
        let chart = chart.cloned();
        let has_jacobian = table.flow_jacobian.is_some() && chart.is_some();
        SmoothMap::from_numbers(d, space, has_jacobian, move |parameters, epsilon, h| {
            let chart = chart.as_ref();
            Box::new(Flow {
                flow: self.function(functions, (space, space), parameters, (epsilon, h)),
                realization: Arc::clone(&self.realization),
                chart: chart.map(|chart| chart.evaluator(parameters, epsilon)),
                pair: vec![0.0; 2 * d],
                start: vec![0.0; space],
                of_flow: vec![0.0; space * space],
                of_section: vec![0.0; space * 2 * d],
            })
        })
        // The integrator behind it may start from its last stages.
        .for_one_trajectory()
    }
}

/// The host's system and realization, lent to an instance.
fn lent(
    system: &PoissonSystem,
    realization: &RealizationToLend,
    parameters: &[f64],
) -> Result<HostObjects, BuildError> {
    Ok(HostObjects {
        system: Some(HostSystem::new(system, parameters)?),
        realization: Some(realization.lend(parameters)),
    })
}

/// Σ∘σ, Σ as the library computes it.
struct Flow {
    flow: ForeignFunction,
    realization: Arc<dyn RealizationData>,
    /// χ, for Dσ = Dχ(·, 0) on vectors of M, where Dχ is offered.
    chart: Option<Box<dyn Evaluator>>,
    /// (y, 0).
    pair: Vec<f64>,
    /// σ(y).
    start: Vec<f64>,
    of_flow: Vec<f64>,
    of_section: Vec<f64>,
}

impl Flow {
    fn tangent(&mut self, y: &[f64], tangent: &mut [f64]) -> Result<(), StepError> {
        let Some(chart) = &mut self.chart else {
            return Err(StepError::NoTangent);
        };
        let (d, space) = (y.len(), self.start.len());
        self.pair[..d].copy_from_slice(y);
        chart.values(&self.pair, &mut self.start)?;
        chart.jacobians(&self.pair, &mut self.of_section)?;
        self.flow.jacobians(&self.start, &mut self.of_flow)?;
        for i in 0..space {
            for j in 0..d {
                let row = &self.of_flow[i * space..][..space];
                let column = (0..space).map(|k| self.of_section[k * 2 * d + j]);
                tangent[i * d + j] = row.iter().zip(column).map(|(a, b)| a * b).sum();
            }
        }
        Ok(())
    }
}

impl Evaluator for Flow {
    fn values(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        one_by_one(self.pair.len() / 2, y, z, |y, z| {
            self.realization.section(y, &mut self.start);
            self.flow.values(&self.start, z)
        })
    }

    fn jacobians(&mut self, y: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        let d = self.pair.len() / 2;
        one_by_one(d, y, tangents, |y, tangent| self.tangent(y, tangent))
    }

    /// The library does not count them.
    fn operations(&self) -> Option<u64> {
        None
    }
}
