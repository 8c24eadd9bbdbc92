//! Maps that are products of flows, each one sweep over the same fields.

use std::sync::Arc;

use super::fields::Fields;
use super::program::{LatticeProgram, Prepared};
use super::stages::Field;

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

    /// The flows in their order, or in the opposite one.
    pub fn run(&self, kernels: &mut SweptKernels, fields: &mut Fields, is_backwards: bool) {
        let count = self.order.len();
        for at in 0..count {
            let stage = self.order[if is_backwards { count - 1 - at } else { at }];
            self.program.run_stage(stage, &mut kernels.0[stage], fields);
        }
    }

    /// The operations of all flows, weighted.
    pub fn work(&self) -> u64 {
        self.program.work()
    }
}
