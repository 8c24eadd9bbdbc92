//! Maps that are products of flows, each one sweep over the same fields.

use std::sync::Arc;

use super::fields::Fields;
use super::program::{LatticeProgram, Prepared};
use super::stages::Field;
use super::wavefront::Finite;
use crate::error::StepError;
use crate::solver::{StepRecord, Stepper, add_finite};

/// A product of flows by sweeps: each stage of the program adds the change that its flow makes to the state, and to the sum of
/// all changes.
#[derive(Clone, Debug)]
pub struct Swept {
    /// The sweeps, a stage for each flow.
    pub program: Arc<LatticeProgram>,
    /// The state.
    pub state: Field,
    /// The sum of the changes.
    pub sum: Field,
    /// Fields that hold numbers of every coordinate throughout.
    pub constants: Arc<Vec<(Field, Vec<f64>)>>,
    /// The stages in the order of the first half of a step.
    pub order: Vec<usize>,
}

/// Kernels of a [`Swept`] map for one part of a step.
#[derive(Clone, Debug)]
pub struct SweptKernels(Vec<Prepared>);

impl Swept {
    /// Fields on which all of these maps work in turn; `None` where one would write what another keeps there.
    pub fn fields(maps: &[&Self]) -> Option<Fields> {
        let (first, _) = maps.split_first()?;
        let is_alike = |map: &&Self| {
            let place = |map: &Self| (map.state, map.sum);
            map.program.geometry() == first.program.geometry() && place(map) == place(first)
        };
        let keeps = |map: &&&Self| !map.constants.is_empty();
        let keeper = maps.iter().find(keeps).copied();
        let is_kept = |map: &&Self| {
            keeper.is_none_or(|keeper| {
                let kept = keeper.constants.iter().map(|(field, _)| field.0).min();
                Arc::ptr_eq(&map.program, &keeper.program)
                    || map.constants.is_empty() && map.program.fields() <= kept.unwrap_or(0)
            })
        };
        if !maps.iter().all(|map| is_alike(map) && is_kept(map)) {
            return None;
        }
        let most = maps.iter().map(|map| map.program.fields()).max()?;
        let mut fields = Fields::zeros(most, first.program.geometry().dimension());
        for (field, numbers) in keeper.iter().flat_map(|map| map.constants.iter()) {
            fields.get_mut(*field).copy_from_slice(numbers);
        }
        Some(fields)
    }

    /// Kernels for flows over `part` of a step.
    pub fn prepare(&self, part: f64, parameters: &[f64], (epsilon, h): (f64, f64)) -> SweptKernels {
        let stages = 0..self.program.stages();
        let prepare = |stage| self.program.prepare(stage, parameters, epsilon, part * h);
        SweptKernels(stages.map(prepare).collect())
    }

    /// The flow of one stage at all sites.
    pub fn run_stage(&self, stage: usize, kernels: &mut SweptKernels, fields: &mut Fields) {
        self.program.run_stage(stage, &mut kernels.0[stage], fields);
    }

    /// The same at the sites of one part, where the stage has [parts](LatticeProgram::parts).
    pub fn run_part(
        &self,
        (stage, part): (usize, usize),
        kernels: &mut SweptKernels,
        fields: &mut Fields,
    ) {
        let kernels = &mut kernels.0[stage];
        self.program.run_part((stage, part), kernels, fields);
    }

    /// The operations of all flows, weighted.
    pub fn work(&self) -> u64 {
        self.program.work()
    }
}

impl Finite {
    /// Whether a step is one.
    ///
    /// # Errors
    /// Increments, or a state, that are not finite.
    pub fn step(self) -> Result<(), StepError> {
        match self {
            Self { flows: false, .. } => Err(StepError::OF_INCREMENT),
            Self { step: false, .. } => Err(StepError::OF_STATE),
            Self { .. } => Ok(()),
        }
    }
}

/// [`Stepper::advance`] of a stepper of one lane that nothing checks. `step` makes the flows of a step, `sums` is the field with its
/// increment: it is added from there.
pub fn add_from_field<S: Stepper>(
    stepper: &mut S,
    steps: u64,
    [state, low]: [&mut [f64]; 2],
    mut record: Option<&mut StepRecord<'_>>,
    step: fn(&mut S, &[f64]) -> Result<(), StepError>,
    sums: for<'a> fn(&'a S) -> &'a [f64],
) -> (u64, Result<(), StepError>) {
    for made in 0..steps {
        if let Err(error) = step(stepper, state) {
            return (made, Err(error));
        }
        add_finite(state, low, sums(stepper));
        if let Some(record) = &mut record {
            record.take(state, stepper.statistics().evaluations);
        }
    }
    (steps, Ok(()))
}
