//! A realization whose maps a library computes.

use std::sync::{Arc, Mutex, PoisonError};

use leafwise_core::part::{ParameterSetting, PartInfo};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    Accuracy, BuildError, ChartWorker, Ends, PartParameters, PoissonSystem, RealizationData,
    RealizationWorker, StepError,
};
use leafwise_plugin_abi::LwRealization;

use super::batch::{Input, Output};
use super::callee::Callee;
use super::failure::CallFailure;
use super::instance::{Call, Instance, Lent, Making};
use super::part::{ForeignPart, Properties};
use crate::host::HostSystem;

/// A part of kind `LW_KIND_REALIZATION` with functions.
pub(crate) struct ForeignRealizationPart {
    part: Arc<ForeignPart>,
    table: LwRealization,
}

impl ForeignRealizationPart {
    pub(crate) fn new(part: ForeignPart, table: LwRealization) -> Self {
        Self {
            part: Arc::new(part),
            table,
        }
    }
}

impl RealizationPart for ForeignRealizationPart {
    fn info(&self) -> &'static PartInfo {
        self.part.info
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        let (name, d) = (self.part.name(), system.dimension());
        let settings = self.part.settings(parameters)?;
        self.part.check_dimension(d)?;
        let properties = self.part.properties(d, &settings)?;
        let making = Making {
            dimension: d,
            settings: &settings,
        };
        let lent = Lent {
            system: Some(HostSystem::new(system, &system.parameter_values())?),
            ..Lent::default()
        };
        let trial =
            Instance::new(&self.part, making, lent).map_err(|failure| failure.of_build(name))?;
        let space = self.table.space_dimension.map_or(0, |space_dimension| {
            // SAFETY: a function of the instance's own table.
            unsafe { space_dimension(trial.pointer()) }
        });
        let least = if properties.flags.has_cotangent_chart() {
            (2 * d, 2 * d)
        } else {
            (2 * d, 1 << 20)
        };
        if space < least.0 || space > least.1 {
            return Err(BuildError::DoesNotFit {
                part: name,
                reason: format!("its space_dimension is {space}, for a system of dimension {d}"),
            });
        }
        Ok(Arc::new(ForeignRealization {
            part: Arc::clone(&self.part),
            table: self.table,
            system: system.clone(),
            settings,
            properties,
            space,
            for_section: Mutex::new(trial),
        }))
    }
}

/// Realization data by calls.
struct ForeignRealization {
    part: Arc<ForeignPart>,
    table: LwRealization,
    system: PoissonSystem,
    settings: Vec<(String, ParameterSetting)>,
    properties: Properties,
    space: usize,
    for_section: Mutex<Instance>,
}

impl std::fmt::Debug for ForeignRealization {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ForeignRealization")
            .field("part", &self.part.name())
            .field("settings", &self.settings)
            .field("space", &self.space)
            .finish_non_exhaustive()
    }
}

impl ForeignRealization {
    fn callee(&self, parameters: &[f64]) -> Callee {
        let making = Making {
            dimension: self.system.dimension(),
            settings: &self.settings,
        };
        let system = HostSystem::new(&self.system, parameters);
        let lent = system.map(|system| Lent {
            system: Some(system),
            ..Lent::default()
        });
        let lent = lent.map_err(|error| CallFailure::Unsupported {
            message: error.to_string(),
        });
        Callee::new(&self.part, making, lent)
    }
}

impl RealizationData for ForeignRealization {
    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    fn space_dimension(&self) -> usize {
        self.space
    }

    fn accuracy(&self) -> Accuracy {
        if self.properties.flags.is_exact() {
            Accuracy::Exact
        } else {
            Accuracy::Order(self.properties.order)
        }
    }

    fn describe(&self) -> String {
        match self.accuracy() {
            Accuracy::Exact => self.part.name().to_owned(),
            Accuracy::Order(n) => format!("{} n = {n}", self.part.name()),
        }
    }

    /// Not a number where the library's section fails.
    fn section(&self, x: &[f64], z: &mut [f64]) {
        if self.table.sigma.is_none() {
            z.fill(0.0);
            z[..x.len()].copy_from_slice(x);
            return;
        }
        let mut instance = self
            .for_section
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let call = Call::at(1, 1.0, 0.0, Input::points(x, x.len()));
        let output = Output::points(z, self.space);
        if instance.evaluate(self.table.sigma, &call, output).is_err() {
            z.fill(f64::NAN);
        }
    }

    fn worker(&self, parameters: &[f64], epsilon: f64) -> Option<Box<dyn RealizationWorker>> {
        let d = self.dimension();
        Some(Box::new(Worker {
            callee: self.callee(parameters),
            table: self.table,
            dimension: d,
            epsilon,
            z: vec![0.0; self.space],
            values: vec![0.0; 3 * d],
            with_jacobian: vec![0.0; d + d * self.space],
            jacobians: vec![0.0; 2 * d * self.space],
        }))
    }

    fn chart_worker(&self, parameters: &[f64], epsilon: f64) -> Option<Box<dyn ChartWorker>> {
        self.table.chart?;
        let d = self.dimension();
        Some(Box::new(Chart {
            callee: self.callee(parameters),
            table: self.table,
            epsilon,
            x: vec![0.0; d],
            p: vec![0.0; d],
        }))
    }

    fn points_are_pairs(&self) -> bool {
        self.properties.flags.has_cotangent_chart()
    }

    fn is_reversible(&self) -> bool {
        self.properties.flags.is_reversible()
    }
}

struct Worker {
    callee: Callee,
    table: LwRealization,
    dimension: usize,
    epsilon: f64,
    /// The point of the last call.
    z: Vec<f64>,
    values: Vec<f64>,
    with_jacobian: Vec<f64>,
    jacobians: Vec<f64>,
}

impl RealizationWorker for Worker {
    fn ends(&mut self, z: &[f64], ends: &mut Ends) -> Result<(), StepError> {
        let (d, epsilon) = (self.dimension, self.epsilon);
        self.z.copy_from_slice(z);
        let call = Call::at(1, epsilon, 0.0, Input::points(z, z.len()));
        let values = &mut self.values;
        if self.table.ends.is_some() {
            let output = Output::points(values, 3 * d);
            self.callee
                .evaluate("ends", self.table.ends, &call, output)?;
            ends.base.copy_from_slice(&values[..d]);
            ends.offset.copy_from_slice(&values[d..2 * d]);
            ends.increment.copy_from_slice(&values[2 * d..]);
            return Ok(());
        }
        let (beta, rest) = values.split_at_mut(d);
        let alpha = &mut rest[..d];
        let (table, callee) = (&self.table, &mut self.callee);
        callee.evaluate("beta", table.beta, &call, Output::points(beta, d))?;
        callee.evaluate("alpha", table.alpha, &call, Output::points(alpha, d))?;
        for i in 0..d {
            ends.base[i] = beta[i];
            ends.offset[i] = 0.0;
            ends.increment[i] = alpha[i] - beta[i];
        }
        Ok(())
    }

    fn tangents(&mut self, target: &mut [f64], increment: &mut [f64]) -> Result<(), StepError> {
        if !self.has_tangents() {
            return Err(StepError::NoTangent);
        }
        let (d, entries) = (self.dimension, target.len());
        let call = Call::at(1, self.epsilon, 0.0, Input::points(&self.z, self.z.len()));
        let (table, callee) = (&self.table, &mut self.callee);
        if table.ends_jacobian.is_some() {
            let output = Output::points(&mut self.jacobians, 2 * entries);
            callee.evaluate("ends_jacobian", table.ends_jacobian, &call, output)?;
            target.copy_from_slice(&self.jacobians[..entries]);
            increment.copy_from_slice(&self.jacobians[entries..]);
            return Ok(());
        }
        let output = Output::points(&mut self.with_jacobian, d + entries);
        callee.evaluate(
            "beta_with_jacobian",
            table.beta_with_jacobian,
            &call,
            output,
        )?;
        target.copy_from_slice(&self.with_jacobian[d..]);
        let output = Output::points(increment, entries);
        callee.evaluate("alpha_jacobian", table.alpha_jacobian, &call, output)?;
        increment
            .iter_mut()
            .zip(target.iter())
            .for_each(|(i, t)| *i -= t);
        Ok(())
    }

    fn has_tangents(&self) -> bool {
        let separately =
            self.table.alpha_jacobian.is_some() && self.table.beta_with_jacobian.is_some();
        self.table.ends_jacobian.is_some() || separately
    }
}

struct Chart {
    callee: Callee,
    table: LwRealization,
    epsilon: f64,
    /// The point of the last call.
    x: Vec<f64>,
    p: Vec<f64>,
}

impl Chart {
    fn call<'a>(epsilon: f64, x: &'a [f64], p: &'a [f64]) -> Call<'a> {
        Call {
            v: Input::points(p, p.len()),
            ..Call::at(1, epsilon, 0.0, Input::points(x, x.len()))
        }
    }
}

impl ChartWorker for Chart {
    fn point(&mut self, x: &[f64], p: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        self.x.copy_from_slice(x);
        self.p.copy_from_slice(p);
        let space = z.len();
        let call = Self::call(self.epsilon, x, p);
        let output = Output::points(z, space);
        self.callee
            .evaluate("chart", self.table.chart, &call, output)
    }

    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError> {
        if !self.has_tangent() {
            return Err(StepError::NoTangent);
        }
        let entries = tangent.len();
        let call = Self::call(self.epsilon, &self.x, &self.p);
        let output = Output::points(tangent, entries);
        let function = self.table.chart_jacobian;
        self.callee
            .evaluate("chart_jacobian", function, &call, output)
    }

    fn has_tangent(&self) -> bool {
        self.table.chart_jacobian.is_some()
    }
}
