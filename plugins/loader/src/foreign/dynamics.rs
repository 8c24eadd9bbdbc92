//! A dynamic approximation that a library computes.

use std::sync::Arc;

use leafwise_core::evaluator::one_by_one;
use leafwise_core::part::ParameterSetting;
use leafwise_core::{
    BuildError, Correction, DynamicApproximation, Evaluator, GraphOfOneForm, LagrangianBisection,
    PartParameters, PoissonSystem, RealizationData, StepError,
};
use leafwise_plugin_abi::{LwDynamics, LwMapFn};

use super::batch::{Input, Output};
use super::callee::{Callee, Idle};
use super::failure::CallFailure;
use super::instance::{Call, Instance};
use super::making::{HostObjects, Making};
use super::part::{ForeignPart, Properties};
use crate::host::{HostSystem, RealizationToLend};
use crate::smoke::states;

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
    fn order(&self) -> usize {
        self.properties.order
    }

    fn self_adjoint(&self) -> Option<bool> {
        self.properties.flags.self_adjoint()
    }

    fn is_lagrangian(&self) -> bool {
        self.properties.flags.is_symplectic()
    }

    fn correction(&self) -> Correction {
        if self.properties.flags.is_uncorrected() {
            Correction::None
        } else {
            Correction::Bisection
        }
    }

    fn describe(&self) -> String {
        format!("{} m = {}", self.part.name(), self.order())
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<Arc<dyn LagrangianBisection>, BuildError> {
        self.part.check_dimension(system.dimension())?;
        let values = system.parameter_values();
        let mut bisection = ForeignBisection {
            dynamics: self.clone(),
            system: system.clone(),
            realization: Arc::clone(realization),
            lend: RealizationToLend::new(realization, &values)?,
            idle: Idle::default(),
        };
        if self.table.one_form.is_some() && bisection.lend.chart().is_none() {
            return Err(BuildError::Incompatible {
                dynamics: self.describe(),
                realization: realization.describe(),
                reason: "it has no symplectic chart about its section, which a one-form needs"
                    .to_owned(),
            });
        }
        // A trial, to tell now what cannot be combined.
        let lent = lent(&bisection.system, &bisection.lend, &values)?;
        let trial = Instance::new(&self.part, bisection.making(), lent).map_err(|failure| {
            BuildError::Incompatible {
                dynamics: self.describe(),
                realization: realization.describe(),
                reason: failure.to_string(),
            }
        })?;
        bisection.dynamics.table = offered(self.table, trial, realization.as_ref());
        Ok(Arc::new(bisection))
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

#[derive(Debug)]
struct ForeignBisection {
    dynamics: ForeignDynamics,
    system: PoissonSystem,
    realization: Arc<dyn RealizationData>,
    lend: RealizationToLend,
    idle: Idle,
}

impl ForeignBisection {
    fn making(&self) -> Making<'_> {
        Making {
            dimension: self.system.dimension(),
            settings: &self.dynamics.settings,
        }
    }

    fn chart(&self, parameters: &[f64], epsilon: f64) -> Option<Box<dyn Evaluator>> {
        Some(self.lend.chart()?.evaluator(parameters, epsilon))
    }
}

impl ForeignBisection {
    /// An instance for one evaluator.
    fn caller(&self, parameters: &[f64], epsilon: f64, h: f64) -> Caller {
        let (part, values) = (Arc::clone(&self.dynamics.part), parameters.to_vec());
        let (system, lend) = (self.system.clone(), self.lend.clone());
        let settings = self.dynamics.settings.clone();
        let make = move || {
            let making = Making {
                dimension: system.dimension(),
                settings: &settings,
            };
            let lent = lent(&system, &lend, &values);
            let lent = lent.map_err(|error| CallFailure::Unsupported {
                message: error.to_string(),
            })?;
            Instance::new(&part, making, lent)
        };
        Caller {
            callee: Callee::new(&self.dynamics.part, &self.idle, parameters, make),
            table: self.dynamics.table,
            epsilon,
            h,
        }
    }

    fn form(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Evaluator> {
        Box::new(OneForm {
            caller: self.caller(parameters, epsilon, h),
            dimension: self.system.dimension(),
        })
    }
}

impl LagrangianBisection for ForeignBisection {
    fn one_form(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        self.dynamics.table.one_form?;
        Some(self.form(parameters, epsilon, h))
    }

    fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        let (d, space) = (self.system.dimension(), self.realization.space_dimension());
        let table = self.dynamics.table;
        if table.one_form.is_some() {
            let form = self.form(parameters, epsilon, h);
            let chart = self.chart(parameters, epsilon)?;
            return Some(Box::new(GraphOfOneForm::new(form, chart, d, space)));
        }
        let caller = self.caller(parameters, epsilon, h);
        if table.embedding.is_some() {
            return Some(Box::new(Embedding {
                caller,
                dimension: d,
                space,
            }));
        }
        Some(Box::new(Flow {
            caller,
            realization: Arc::clone(&self.realization),
            chart: self.chart(parameters, epsilon),
            pair: vec![0.0; 2 * d],
            start: vec![0.0; space],
            of_flow: vec![0.0; space * space],
            of_section: vec![0.0; space * 2 * d],
        }))
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

/// The instance of one evaluator, with its step sizes.
struct Caller {
    callee: Callee,
    table: LwDynamics,
    epsilon: f64,
    h: f64,
}

impl Caller {
    /// Evaluates a function at points of `inputs` coordinates, with `outputs` numbers each.
    fn evaluate(
        &mut self,
        (name, function): (&str, LwMapFn),
        (points, inputs): (&[f64], usize),
        (out, outputs): (&mut [f64], usize),
    ) -> Result<(), StepError> {
        let count = points.len() / inputs;
        let input = Input::points(points, inputs);
        let call = Call::at(count, self.epsilon, self.h, input);
        let output = Output::points(out, outputs);
        self.callee.evaluate(name, function, &call, output)
    }
}

/// θ̂ as the library computes it.
struct OneForm {
    caller: Caller,
    dimension: usize,
}

impl Evaluator for OneForm {
    fn values(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError> {
        let (d, function) = (self.dimension, self.caller.table.one_form);
        self.caller.evaluate(("one_form", function), (y, d), (p, d))
    }

    fn jacobians(&mut self, y: &[f64], jacobians: &mut [f64]) -> Result<(), StepError> {
        if !self.has_jacobian() {
            return Err(StepError::NoTangent);
        }
        let (d, function) = (self.dimension, self.caller.table.one_form_jacobian);
        let function = ("one_form_jacobian", function);
        self.caller.evaluate(function, (y, d), (jacobians, d * d))
    }

    fn has_jacobian(&self) -> bool {
        self.caller.table.one_form_jacobian.is_some()
    }
}

/// L as the library computes it.
struct Embedding {
    caller: Caller,
    dimension: usize,
    space: usize,
}

impl Evaluator for Embedding {
    fn values(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        let (d, function) = (self.dimension, self.caller.table.embedding);
        let function = ("embedding", function);
        self.caller.evaluate(function, (y, d), (z, self.space))
    }

    fn jacobians(&mut self, y: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        if !self.has_jacobian() {
            return Err(StepError::NoTangent);
        }
        let (d, space) = (self.dimension, self.space);
        let function = ("embedding_jacobian", self.caller.table.embedding_jacobian);
        self.caller
            .evaluate(function, (y, d), (tangents, space * d))
    }

    fn has_jacobian(&self) -> bool {
        self.caller.table.embedding_jacobian.is_some()
    }
}

/// Σ∘σ, Σ as the library computes it.
struct Flow {
    caller: Caller,
    realization: Arc<dyn RealizationData>,
    /// χ, for Dσ = Dχ(·, 0) on vectors of M.
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
        let Some(chart) = self.chart.as_mut().filter(|chart| chart.has_jacobian()) else {
            return Err(StepError::NoTangent);
        };
        let (d, space) = (y.len(), self.start.len());
        self.pair[..d].copy_from_slice(y);
        chart.values(&self.pair, &mut self.start)?;
        chart.jacobians(&self.pair, &mut self.of_section)?;
        let function = ("flow_jacobian", self.caller.table.flow_jacobian);
        let out = (&mut self.of_flow[..], space * space);
        self.caller.evaluate(function, (&self.start, space), out)?;
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
            let (function, space) = (self.caller.table.flow, z.len());
            self.caller
                .evaluate(("flow", function), (&self.start, space), (z, space))
        })
    }

    fn jacobians(&mut self, y: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        let d = self.pair.len() / 2;
        one_by_one(d, y, tangents, |y, tangent| self.tangent(y, tangent))
    }

    fn has_jacobian(&self) -> bool {
        let chart = self
            .chart
            .as_ref()
            .is_some_and(|chart| chart.has_jacobian());
        chart && self.caller.table.flow_jacobian.is_some()
    }

    /// The integrator behind it may start from its last stages.
    fn is_pointwise(&self) -> bool {
        false
    }
}
