//! A step map that a library computes.

use std::sync::Arc;

use leafwise_core::part::ParameterSetting;
use leafwise_core::{
    BuildError, MapProperties, PartParameters, PoissonSystem, SolverStatistics, StepError, StepMap,
    Stepper, Structure,
};
use leafwise_plugin_abi::{LW_STRUCTURE_EXACT, LwStepMap};

use super::batch::{Input, Output};
use super::callee::{Callee, Idle};
use super::failure::CallFailure;
use super::instance::{Call, Instance};
use super::making::{HostObjects, Making};
use super::part::{ForeignPart, Properties};
use crate::trial_points::states;

/// A part of kind `LW_KIND_STEP_MAP` with functions.
pub(crate) struct ForeignStepMapPart {
    part: Arc<ForeignPart>,
    table: LwStepMap,
}

impl ForeignStepMapPart {
    pub(crate) fn new(part: ForeignPart, table: LwStepMap) -> Self {
        Self {
            part: Arc::new(part),
            table,
        }
    }

    pub(crate) fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        let d = system.dimension();
        let settings = self.part.settings(parameters)?;
        self.part.check_dimension(d)?;
        let of_build = |failure: CallFailure| failure.of_build(self.part.name());
        let properties = self.part.properties(d, &settings).map_err(of_build)?;
        // A trial, to tell now what the part does not serve.
        let making = Making {
            dimension: d,
            settings: &settings,
        };
        let lent = HostObjects::of_system(system, &system.parameter_values())?;
        let mut trial = Instance::new(&self.part, making, lent).map_err(of_build)?;
        let x = &states(d)[0];
        let call = Call::at(1, 1.0, TRIAL_STEP, Input::points(x, d));
        let table = LwStepMap {
            tangent: trial.offered(self.table.tangent, &call, d * d),
            ..self.table
        };
        Ok(Arc::new(ForeignStepMap {
            properties,
            part: Arc::clone(&self.part),
            table,
            system: system.clone(),
            settings,
            idle: Idle::default(),
        }))
    }
}

/// The step at which functions are asked for.
const TRIAL_STEP: f64 = 1e-2;

struct ForeignStepMap {
    part: Arc<ForeignPart>,
    table: LwStepMap,
    system: PoissonSystem,
    settings: Vec<(String, ParameterSetting)>,
    properties: Properties,
    idle: Idle,
}

impl ForeignStepMap {
    /// An instance for one evaluator.
    fn callee(&self, parameters: &[f64]) -> Callee {
        let (system, values) = (self.system.clone(), parameters.to_vec());
        let making = (system.dimension(), self.settings.clone());
        Callee::new(&self.part, &self.idle, parameters, making, move || {
            HostObjects::of_system(&system, &values)
        })
    }
}

/// Properties of a step map by its declaration: order, structure, self-adjointness.
pub(crate) fn promises(order: usize, structure: i32, self_adjoint: Option<bool>) -> MapProperties {
    MapProperties {
        order,
        structure: match structure {
            LW_STRUCTURE_EXACT => Structure::Exact,
            n => match usize::try_from(n) {
                Ok(n) if n > 0 => Structure::Order(n),
                _ => Structure::None,
            },
        },
        self_adjoint,
    }
}

impl StepMap for ForeignStepMap {
    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    fn properties(&self) -> MapProperties {
        let Properties {
            order,
            structure,
            flags,
        } = self.properties;
        promises(order, structure, flags.self_adjoint())
    }

    fn describe(&self) -> String {
        self.part.name().to_owned()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let own = |lane: usize| -> Vec<f64> {
            parameters
                .iter()
                .skip(lane)
                .step_by(lanes)
                .copied()
                .collect()
        };
        // Neighbouring lanes with the same parameters share an instance and a call.
        let mut groups: Vec<Group> = Vec::new();
        let mut last = Vec::new();
        for lane in 0..lanes {
            let values = own(lane);
            match groups.last_mut() {
                Some(group) if values == last => group.lanes += 1,
                _ => {
                    groups.push(Group {
                        callee: self.callee(&values),
                        first: lane,
                        lanes: 1,
                    });
                    last = values;
                }
            }
        }
        Box::new(ForeignStepper {
            groups,
            table: self.table,
            dimension: self.dimension(),
            lanes,
            step_sizes: (epsilon, h),
            last: vec![0.0; self.dimension() * lanes],
            statistics: SolverStatistics {
                operations: None,
                ..SolverStatistics::default()
            },
        })
    }
}

/// Neighbouring lanes that one instance steps.
struct Group {
    callee: Callee,
    first: usize,
    lanes: usize,
}

struct ForeignStepper {
    groups: Vec<Group>,
    table: LwStepMap,
    dimension: usize,
    lanes: usize,
    step_sizes: (f64, f64),
    /// The states of the last step.
    last: Vec<f64>,
    statistics: SolverStatistics,
}

/// Steps the lanes from `first` on, `count` of them, in one call.
fn step(
    callee: &mut Callee,
    table: &LwStepMap,
    (epsilon, h): (f64, f64),
    (first, count, lanes, d): (usize, usize, usize, usize),
    (x, low): (&[f64], &[f64]),
    increment: &mut [f64],
) -> Result<(), StepError> {
    let call = Call {
        v: Input::strided(&low[first..], d, 1, lanes),
        ..Call::at(count, epsilon, h, Input::strided(&x[first..], d, 1, lanes))
    };
    let output = Output::strided(&mut increment[first..], d, 1, lanes);
    callee.evaluate("increment", table.increment, &call, output)
}

impl Stepper for ForeignStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let (d, lanes, sizes) = (self.dimension, self.lanes, self.step_sizes);
        self.last.copy_from_slice(x);
        for group in &mut self.groups {
            let (first, count) = (group.first, group.lanes);
            let callee = &mut group.callee;
            let mut run = |first: usize, count: usize, increment: &mut [f64]| {
                let place = (first, count, lanes, d);
                step(callee, &self.table, sizes, place, (x, low), increment)
            };
            let whole = run(first, count, increment);
            for lane in first..first + count {
                // A batch that fails is taken again lane by lane, to tell which ones do.
                outcome[lane] = match &whole {
                    Ok(()) => Ok(()),
                    Err(error) if count == 1 => Err(error.clone()),
                    Err(_) => run(lane, 1, increment),
                };
                if outcome[lane].is_err() {
                    self.statistics.failures += 1;
                    (0..d).for_each(|i| increment[i * lanes + lane] = 0.0);
                }
            }
        }
        self.statistics.steps += lanes as u64;
        self.statistics.evaluations += lanes as u64;
        self.statistics.most_evaluations = 1;
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        self.table.tangent?;
        let (d, lanes, (epsilon, h)) = (self.dimension, self.lanes, self.step_sizes);
        let holds = |group: &&mut Group| (group.first..group.first + group.lanes).contains(&lane);
        let group = self.groups.iter_mut().find(holds)?;
        let mut tangent = vec![0.0; d * d];
        let call = Call::at(
            1,
            epsilon,
            h,
            Input::strided(&self.last[lane..], d, 1, lanes),
        );
        let output = Output::points(&mut tangent, d * d);
        let evaluated = group
            .callee
            .evaluate("tangent", self.table.tangent, &call, output);
        evaluated.ok().map(|()| tangent)
    }

    fn restart(&mut self) {}

    fn statistics(&self) -> SolverStatistics {
        self.statistics
    }

    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        if memory.is_empty() { Ok(()) } else { Err(0) }
    }
}
