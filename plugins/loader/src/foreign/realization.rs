//! A realization whose maps a library computes.

use std::sync::{Arc, Mutex, PoisonError};

use leafwise_core::part::ParameterSetting;
use leafwise_core::runge_kutta::SmoothMap;
use leafwise_core::{
    Abilities, Accuracy, BuildError, EndMaps, EndNumbers, Evaluator, PartParameters, PoissonSystem,
    RealizationData, Space, SpaceChart, StepError,
};
use leafwise_plugin_abi::LwRealization;

use super::batch::{Input, Output};
use super::callee::{Callee, Idle};
use super::failure::CallFailure;
use super::function::{ForeignFunction, Named};
use super::instance::{Call, Instance};
use super::making::{HostObjects, Making};
use super::part::{ForeignPart, Properties};
use crate::trial_points::states;

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

    pub(crate) fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        let (name, d) = (self.part.name(), system.dimension());
        let settings = self.part.settings(parameters)?;
        self.part.check_dimension(d)?;
        let of_build = |failure: CallFailure| failure.of_build(name);
        let properties = self.part.properties(d, &settings).map_err(of_build)?;
        let making = Making {
            dimension: d,
            settings: &settings,
        };
        let lent = || HostObjects::of_system(system, &system.parameter_values());
        let trial = Instance::new(&self.part, making, lent()?).map_err(of_build)?;
        let space = self.table.space_dimension.map_or(0, |space_dimension| {
            // SAFETY: a function of the instance's own table.
            trial.ask(|instance| unsafe { space_dimension(instance) })
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
        // Of an instance of its own: what is asked of it may break it.
        let asked = Instance::new(&self.part, making, lent()?).map_err(of_build)?;
        Ok(Arc::new(ForeignRealization {
            part: Arc::clone(&self.part),
            table: offered(self.table, asked, d, space),
            system: system.clone(),
            settings,
            properties,
            space,
            for_section: Mutex::new(trial),
            idle: Idle::default(),
        }))
    }
}

/// The table without the optional functions that the instance does not offer.
fn offered(table: LwRealization, mut instance: Instance, d: usize, space: usize) -> LwRealization {
    let x = states(d).swap_remove(0);
    let p = vec![0.0; d];
    let mut z = [&x[..], &vec![0.0; space - d]].concat();
    if table.sigma.is_some() {
        let at_x = Call::at(1, 1.0, 0.0, Input::points(&x, d));
        // Where the section has no value here, any point of S will do.
        let _ = instance.evaluate(table.sigma, &at_x, Output::points(&mut z, space));
        z.iter_mut()
            .filter(|z| !z.is_finite())
            .for_each(|z| *z = 0.0);
    }
    let at_z = Call::at(1, 1.0, 0.0, Input::points(&z, space));
    let in_chart = Call {
        v: Input::points(&p, d),
        ..Call::at(1, 1.0, 0.0, Input::points(&x, d))
    };
    let entries = d * space;
    LwRealization {
        ends: instance.offered(table.ends, &at_z, 3 * d),
        alpha_jacobian: instance.offered(table.alpha_jacobian, &at_z, entries),
        beta_with_jacobian: instance.offered(table.beta_with_jacobian, &at_z, d + entries),
        ends_jacobian: instance.offered(table.ends_jacobian, &at_z, 2 * entries),
        chart: instance.offered(table.chart, &in_chart, space),
        chart_jacobian: instance.offered(table.chart_jacobian, &in_chart, 2 * entries),
        ..table
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
    idle: Idle,
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

impl RealizationData for ForeignRealization {
    fn dimension(&self) -> usize {
        self.system.dimension()
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

    fn abilities(&self) -> Abilities<'_> {
        let (flags, table) = (self.properties.flags, self.table);
        let (d, space) = (self.dimension(), self.space);
        let callee = self.callees();
        let ends = move |parameters: &[f64], epsilon: f64| -> Box<dyn Evaluator> {
            Box::new(ForeignEnds {
                function: ForeignFunction {
                    callee: callee(parameters),
                    step_sizes: (epsilon, 0.0),
                    values: ("ends", table.ends),
                    jacobians: ("ends_jacobian", table.ends_jacobian),
                    inputs: space,
                    outputs: 3 * d,
                    is_of_pairs: false,
                },
                table,
                dimension: d,
                first: Vec::with_capacity(d + d * space),
                second: Vec::with_capacity(d * space),
            })
        };
        let callee = self.callees();
        let chart = move |parameters: &[f64], epsilon: f64, _: f64| -> Box<dyn Evaluator> {
            Box::new(ForeignFunction {
                callee: callee(parameters),
                step_sizes: (epsilon, 0.0),
                values: ("chart", table.chart),
                jacobians: ("chart_jacobian", table.chart_jacobian),
                inputs: 2 * d,
                outputs: space,
                is_of_pairs: true,
            })
        };
        let has_tangent = table.chart_jacobian.is_some();
        let chart = SmoothMap::from_numbers(2 * d, space, has_tangent, chart);
        Abilities {
            space: match flags.has_cotangent_chart() {
                true => Space::Pairs,
                false => Space::Points {
                    coordinates: space,
                    chart: table.chart.map(|_| SpaceChart::Numbers(chart)),
                },
            },
            is_reversible: flags.is_reversible(),
            ends: Some(EndMaps::Numbers(EndNumbers::new(
                has_jacobian(&table),
                ends,
            ))),
            ..Abilities::default()
        }
    }
}

impl ForeignRealization {
    /// A callee for each values of the parameters.
    fn callees(&self) -> impl Fn(&[f64]) -> Callee + Send + Sync + use<> {
        let (part, idle) = (Arc::clone(&self.part), self.idle.clone());
        let (system, settings) = (self.system.clone(), self.settings.clone());
        move |parameters| {
            let (system, values) = (system.clone(), parameters.to_vec());
            let making = (system.dimension(), settings.clone());
            Callee::new(&part, &idle, parameters, making, move || {
                HostObjects::of_system(&system, &values)
            })
        }
    }
}

/// Whether the library has Dβ̂ and Dα̂, at once or apart.
fn has_jacobian(table: &LwRealization) -> bool {
    let is_apart = table.alpha_jacobian.is_some() && table.beta_with_jacobian.is_some();
    table.ends_jacobian.is_some() || is_apart
}

/// β̂, its offset and α̂ − β̂ by calls: of functions for all at once where the library has these, else of β̂ and α̂.
struct ForeignEnds {
    function: ForeignFunction,
    table: LwRealization,
    dimension: usize,
    /// Scratch space for ends and their derivatives that are put together here.
    first: Vec<f64>,
    second: Vec<f64>,
}

impl ForeignEnds {
    /// Calls a function for each end at all points, with so many numbers each.
    fn call_both(
        &mut self,
        functions: [Named; 2],
        z: &[f64],
        outputs: [usize; 2],
    ) -> Result<(), StepError> {
        let count = z.len() / self.function.inputs;
        let rooms = [&mut self.first, &mut self.second].into_iter().zip(outputs);
        for ((room, outputs), function) in rooms.zip(functions) {
            room.resize(count * outputs, 0.0);
            self.function.call(function, z, (room, outputs))?;
        }
        Ok(())
    }
}

impl Evaluator for ForeignEnds {
    fn values(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        let (d, table) = (self.dimension, self.table);
        if table.ends.is_some() {
            return self.function.values(z, ends);
        }
        let functions = [("beta", table.beta), ("alpha", table.alpha)];
        self.call_both(functions, z, [d, d])?;
        let both = (self.first.chunks_exact(d)).zip(self.second.chunks_exact(d));
        for (ends, (beta, alpha)) in ends.chunks_exact_mut(3 * d).zip(both) {
            for i in 0..d {
                ends[i] = beta[i];
                ends[d + i] = 0.0;
                ends[2 * d + i] = alpha[i] - beta[i];
            }
        }
        Ok(())
    }

    fn jacobians(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        if !has_jacobian(&self.table) {
            return Err(StepError::NoTangent);
        }
        let (d, table) = (self.dimension, self.table);
        let entries = d * self.function.inputs;
        if table.ends_jacobian.is_some() {
            let both = self.function.jacobians;
            return self.function.call(both, z, (tangents, 2 * entries));
        }
        let functions = [
            ("beta_with_jacobian", table.beta_with_jacobian),
            ("alpha_jacobian", table.alpha_jacobian),
        ];
        self.call_both(functions, z, [d + entries, entries])?;
        let beta = self.first.chunks_exact(d + entries);
        let both = beta.zip(self.second.chunks_exact(entries));
        for (tangents, (beta, alpha)) in tangents.chunks_exact_mut(2 * entries).zip(both) {
            let (target, increment) = tangents.split_at_mut(entries);
            target.copy_from_slice(&beta[d..]);
            for i in 0..entries {
                increment[i] = alpha[i] - target[i];
            }
        }
        Ok(())
    }

    /// The library does not count them.
    fn operations(&self) -> Option<u64> {
        None
    }
}
