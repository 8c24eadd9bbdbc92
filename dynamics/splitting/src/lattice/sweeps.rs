//! Steps of a lattice's splitting: one sweep after the other.

use std::sync::Arc;

use leafwise_core::StepError;
use leafwise_core::lattice::{
    Cells, Field, Fields, Finite, Front, LatticeProgram, LatticeSlopes, Prepared, SweptPart,
    add_from_field,
};
use leafwise_core::solver::{
    SolverStatistics, StepCheck, StepRecord, Stepper, Structure, one_by_one,
};

use crate::product::evaluations;
use crate::schedule::{Flow, passes};

/// A splitting as its steps need it.
#[derive(Clone, Debug)]
pub(crate) struct Shared {
    pub(crate) cells: Cells,
    pub(crate) proxy_cells: Cells,
    pub(crate) program: Arc<LatticeProgram>,
    /// Slopes of the state alone.
    pub(crate) slopes: Arc<LatticeSlopes>,
    pub(crate) state: Field,
    /// Φ(x) − x as it adds up.
    pub(crate) sum: Field,
    /// The pieces' stages in the order of the first half of a step, the costliest last.
    pub(crate) order: Vec<usize>,
    /// Fields that hold numbers of every coordinate throughout.
    pub(crate) constants: Arc<Vec<(Field, Vec<f64>)>>,
    /// Name and structure of the map.
    pub(crate) described: String,
    pub(crate) structure: Structure,
}

impl Shared {
    /// Fields of zeros but for the constants.
    fn empty_fields(&self) -> Fields {
        let mut fields = self.program.empty_fields();
        self.write_constants(&mut fields);
        fields
    }

    /// Writes the constants.
    pub(super) fn write_constants(&self, fields: &mut Fields) {
        for (field, numbers) in self.constants.iter() {
            fields.get_mut(*field).copy_from_slice(numbers);
        }
    }
}

/// χ and χ* over α₁h, α₂h, … in turn, flows of one piece that meet being one.
///
/// The state between flows is plain doubles; the flows' increments are added up apart from it, so
/// that the step's increment rounds in proportion to itself.
pub(super) struct Sweeps {
    shared: Arc<Shared>,
    schedule: Vec<Sweep>,
    front: Option<Front>,
    trajectories: Vec<Trajectory>,
    /// Number of evaluations that a step counts as: half as many as it has factors χ and χ*,
    /// rounded up.
    evaluations: u64,
    /// Operations of one step.
    work: u64,
    statistics: SolverStatistics,
}

/// The flow of a piece.
struct Sweep {
    stage: usize,
    /// Which of the prepared kernels.
    prepared: usize,
}

struct Trajectory {
    /// Kernels for each stage and time that occur.
    prepared: Vec<Prepared>,
    fields: Fields,
}

impl Sweeps {
    pub(super) fn new(
        shared: Arc<Shared>,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let flows = passes(&shared.order, parts);
        let mut distinct: Vec<Flow> = Vec::new();
        let schedule: Vec<Sweep> = flows
            .iter()
            .map(|flow| {
                let known = distinct.iter().position(|other| other == flow);
                let prepared = known.unwrap_or(distinct.len());
                if known.is_none() {
                    distinct.push(*flow);
                }
                Sweep {
                    stage: flow.piece,
                    prepared,
                }
            })
            .collect();
        let program = &shared.program;
        let trajectories = (0..lanes).map(|lane| {
            let own = parameters.iter().skip(lane).step_by(lanes).copied();
            let own: Vec<f64> = own.collect();
            let prepare = |flow: &Flow| program.prepare(flow.piece, &own, epsilon, flow.part * h);
            Trajectory {
                prepared: distinct.iter().map(prepare).collect(),
                fields: shared.empty_fields(),
            }
        });
        let geometry = shared.cells.sites();
        let front = match lanes == 1 && shared.cells.period() == 1 {
            true => {
                let stages = schedule.iter().map(|sweep| program.parts(sweep.stage));
                Front::of(geometry, geometry.families.len(), stages)
            }
            false => None,
        };
        Self {
            trajectories: trajectories.collect(),
            work: flows
                .iter()
                .map(|flow| program.stage_work(flow.piece))
                .sum(),
            evaluations: evaluations(parts),
            front,
            schedule,
            shared,
            statistics: SolverStatistics::default(),
        }
    }
}

impl Sweeps {
    /// The flows of one lane from x; their increments are then in the field of sums.
    fn flow(&mut self, lane: usize, x: &[f64]) -> Finite {
        self.statistics.steps += 1;
        self.statistics.evaluations += self.evaluations;
        self.statistics.most_evaluations = self.evaluations;
        let lanes = self.trajectories.len();
        let Shared {
            program,
            state,
            sum,
            ..
        } = self.shared.as_ref();
        let Trajectory { prepared, fields } = &mut self.trajectories[lane];
        // What a flow leaves behind is finite where it began at a finite state and its own
        // increments are.
        let Some(front) = &self.front else {
            (self.shared.cells).gather(x, lane, lanes, fields.get_mut(*state));
            fields.get_mut(*sum).fill(0.0);
            for sweep in &self.schedule {
                program.run_stage(sweep.stage, &mut prepared[sweep.prepared], fields);
            }
            let is_finite = |field| {
                let numbers = fields.get(field).iter();
                numbers.fold(true, |all, x| all & x.is_finite())
            };
            let flows = is_finite(*state) && is_finite(*sum);
            return Finite { flows, step: flows };
        };
        front.run(
            fields,
            [*state, *sum],
            x,
            |_, _| {},
            |SweptPart { sweep, part }, fields| {
                let Sweep {
                    stage,
                    prepared: at,
                } = self.schedule[sweep];
                program.run_part((stage, part), &mut prepared[at], fields);
            },
        )
    }
}

impl Sweeps {
    /// The increment of the first lane's last flows.
    fn sums(&self) -> &[f64] {
        self.trajectories[0].fields.get(self.shared.sum)
    }
}

impl Stepper for Sweeps {
    fn increment(
        &mut self,
        x: &[f64],
        _low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.trajectories.len();
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            *outcome = if self.flow(lane, x).flows {
                let Shared { cells, sum, .. } = self.shared.as_ref();
                let sums = self.trajectories[lane].fields.get(*sum);
                cells.scatter(sums, increment, lane, lanes);
                Ok(())
            } else {
                self.statistics.failures += 1;
                let own = increment.iter_mut().skip(lane).step_by(lanes);
                own.for_each(|value| *value = 0.0);
                Err(StepError::OF_INCREMENT)
            };
        }
    }

    /// Increments are added from the field where they are.
    fn advance(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        increment: &mut [f64],
        check: Option<&mut dyn StepCheck>,
        record: Option<&mut StepRecord<'_>>,
    ) -> (u64, Result<(), StepError>) {
        if self.front.is_none() || check.is_some() {
            return one_by_one(self, steps, [state, low, increment], check, record);
        }
        let step = |own: &mut Self, x: &[f64]| {
            let finite = own.flow(0, x);
            own.statistics.failures += u64::from(!finite.flows);
            finite.step()
        };
        add_from_field(self, steps, [state, low], record, step, Self::sums)
    }

    fn restart(&mut self) {}

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: Some(self.statistics.steps * self.work),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        if memory.is_empty() { Ok(()) } else { Err(0) }
    }
}
