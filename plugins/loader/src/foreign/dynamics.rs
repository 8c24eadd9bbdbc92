//! A dynamic approximation that a library computes.

use std::sync::Arc;

use leafwise_core::part::{ParameterSetting, PartInfo};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::{
    BisectionWorker, BuildError, ChartWorker, Correction, DynamicApproximation, GraphOfOneForm,
    LagrangianBisection, OneFormWorker, PartParameters, PoissonSystem, RealizationData, StepError,
};
use leafwise_plugin_abi::LwDynamics;

use super::batch::{Input, Output};
use super::callee::Callee;
use super::failure::CallFailure;
use super::instance::{Call, Instance, Lent, Making};
use super::part::{ForeignPart, Properties};
use crate::host::{HostSystem, RealizationToLend};

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
}

impl DynamicsPart for ForeignDynamicsPart {
    fn info(&self) -> &'static PartInfo {
        self.part.info
    }

    fn build(
        &self,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        let settings = self.part.settings(parameters)?;
        Ok(Arc::new(ForeignDynamics {
            properties: self.part.properties(0, &settings)?,
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
        let bisection = ForeignBisection {
            dynamics: self.clone(),
            system: system.clone(),
            realization: Arc::clone(realization),
            lend: RealizationToLend::new(realization, &values)?,
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
        let lent = bisection.lent(&values)?;
        Instance::new(&self.part, bisection.making(), lent).map_err(|failure| {
            BuildError::Incompatible {
                dynamics: self.describe(),
                realization: realization.describe(),
                reason: failure.to_string(),
            }
        })?;
        Ok(Arc::new(bisection))
    }
}

#[derive(Debug)]
struct ForeignBisection {
    dynamics: ForeignDynamics,
    system: PoissonSystem,
    realization: Arc<dyn RealizationData>,
    lend: RealizationToLend,
}

impl ForeignBisection {
    fn making(&self) -> Making<'_> {
        Making {
            dimension: self.system.dimension(),
            settings: &self.dynamics.settings,
        }
    }

    fn lent(&self, parameters: &[f64]) -> Result<Lent, BuildError> {
        Ok(Lent {
            system: Some(HostSystem::new(&self.system, parameters)?),
            realization: Some(self.lend.lend(parameters)),
        })
    }

    fn chart(&self, parameters: &[f64], epsilon: f64) -> Option<Box<dyn ChartWorker>> {
        Some(self.lend.chart()?.worker(parameters, epsilon))
    }
}

impl ForeignBisection {
    /// An instance for one worker.
    fn caller(&self, parameters: &[f64], epsilon: f64, h: f64) -> Caller {
        let lent = self
            .lent(parameters)
            .map_err(|error| CallFailure::Unsupported {
                message: error.to_string(),
            });
        Caller {
            callee: Callee::new(&self.dynamics.part, self.making(), lent),
            table: self.dynamics.table,
            epsilon,
            h,
        }
    }

    fn form(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn OneFormWorker> {
        Box::new(OneForm {
            caller: self.caller(parameters, epsilon, h),
            y: vec![0.0; self.system.dimension()],
        })
    }
}

impl LagrangianBisection for ForeignBisection {
    fn one_form(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn OneFormWorker>> {
        self.dynamics.table.one_form?;
        Some(self.form(parameters, epsilon, h))
    }

    fn worker(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn BisectionWorker>> {
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
                y: vec![0.0; d],
            }));
        }
        Some(Box::new(Flow {
            caller,
            realization: Arc::clone(&self.realization),
            chart: self.chart(parameters, epsilon),
            y: vec![0.0; d],
            zero: vec![0.0; d],
            start: vec![0.0; space],
            of_flow: vec![0.0; space * space],
            of_section: vec![0.0; space * 2 * d],
        }))
    }
}

/// The instance of one worker, with its step sizes.
struct Caller {
    callee: Callee,
    table: LwDynamics,
    epsilon: f64,
    h: f64,
}

impl Caller {
    fn call<'a>(&self, point: &'a [f64]) -> Call<'a> {
        Call::at(1, self.epsilon, self.h, Input::points(point, point.len()))
    }
}

/// θ̂ as the library computes it.
struct OneForm {
    caller: Caller,
    y: Vec<f64>,
}

impl OneFormWorker for OneForm {
    fn value(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError> {
        self.y.copy_from_slice(y);
        let (call, d) = (self.caller.call(y), p.len());
        let output = Output::points(p, d);
        let function = self.caller.table.one_form;
        self.caller
            .callee
            .evaluate("one_form", function, &call, output)
    }

    fn jacobian(&mut self, jacobian: &mut [f64]) -> Result<(), StepError> {
        if !self.has_jacobian() {
            return Err(StepError::NoTangent);
        }
        let (call, entries) = (self.caller.call(&self.y), jacobian.len());
        let output = Output::points(jacobian, entries);
        let function = self.caller.table.one_form_jacobian;
        self.caller
            .callee
            .evaluate("one_form_jacobian", function, &call, output)
    }

    fn has_jacobian(&self) -> bool {
        self.caller.table.one_form_jacobian.is_some()
    }
}

/// L as the library computes it.
struct Embedding {
    caller: Caller,
    y: Vec<f64>,
}

impl BisectionWorker for Embedding {
    fn point(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.y.copy_from_slice(y);
        let (call, space) = (self.caller.call(y), z.len());
        let output = Output::points(z, space);
        let function = self.caller.table.embedding;
        self.caller
            .callee
            .evaluate("embedding", function, &call, output)
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        if !self.has_tangent() {
            return Err(StepError::NoTangent);
        }
        let (call, entries) = (self.caller.call(&self.y), tangent.len());
        let output = Output::points(tangent, entries);
        let function = self.caller.table.embedding_jacobian;
        self.caller
            .callee
            .evaluate("embedding_jacobian", function, &call, output)
    }

    fn has_tangent(&self) -> bool {
        self.caller.table.embedding_jacobian.is_some()
    }
}

/// Σ∘σ, Σ as the library computes it.
struct Flow {
    caller: Caller,
    realization: Arc<dyn RealizationData>,
    /// χ, for Dσ = Dχ(·, 0) on vectors of M.
    chart: Option<Box<dyn ChartWorker>>,
    y: Vec<f64>,
    /// p on the section.
    zero: Vec<f64>,
    /// σ(y).
    start: Vec<f64>,
    of_flow: Vec<f64>,
    of_section: Vec<f64>,
}

impl BisectionWorker for Flow {
    fn point(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.y.copy_from_slice(y);
        self.realization.section(y, &mut self.start);
        let (call, space) = (self.caller.call(&self.start), z.len());
        let output = Output::points(z, space);
        let function = self.caller.table.flow;
        self.caller.callee.evaluate("flow", function, &call, output)
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        let Some(chart) = self.chart.as_mut().filter(|chart| chart.has_tangent()) else {
            return Err(StepError::NoTangent);
        };
        let (d, space) = (self.y.len(), self.start.len());
        chart.point(&self.y, &self.zero, &mut self.start)?;
        chart.tangent(&mut self.of_section)?;
        let call = self.caller.call(&self.start);
        let output = Output::points(&mut self.of_flow, space * space);
        let function = self.caller.table.flow_jacobian;
        self.caller
            .callee
            .evaluate("flow_jacobian", function, &call, output)?;
        for i in 0..space {
            for j in 0..d {
                let row = &self.of_flow[i * space..][..space];
                let column = (0..space).map(|k| self.of_section[k * 2 * d + j]);
                tangent[i * d + j] = row.iter().zip(column).map(|(a, b)| a * b).sum();
            }
        }
        Ok(())
    }

    fn has_tangent(&self) -> bool {
        let chart = self.chart.as_ref().is_some_and(|chart| chart.has_tangent());
        chart && self.caller.table.flow_jacobian.is_some()
    }
}
