//! Any number of trajectories.

use super::block::{Columns, LaneBlock, lane_block};
use super::kernel::NewtonKernel;
use crate::error::StepError;
use crate::{Setting, SolverStatistics, StepCheck, StepRecord, Stepper, tangent_of_map};

/// The lanes of a wide block, as many as a kernel evaluates at once.
const WIDE: usize = 8;

/// Solves β̂(L(y)) = x by Newton's method with the exact Jacobian, any number of trajectories at once.
///
/// The *start* is the solution before and the odd part of the solution's series in the step, where that is short.
/// Elsewhere it is the extrapolation of earlier solutions. The *evaluations* are with the Jacobian, or without where
/// the one that is there contracts fast enough to save operations. The *stop* comes when what the next correction
/// would add, C(2D + δ)δ, is below a small part of an ulp. Here C is the constant observed so far, and D the distance
/// from where the Jacobian was taken. The last correction then enters the increment to first order, without another
/// evaluation. A lane stops on its own test, so its result does not depend on its neighbours.
pub struct NewtonStepper {
    wide: Vec<Box<dyn LaneBlock>>,
    single: Vec<Box<dyn LaneBlock>>,
    lanes: usize,
    kernel: NewtonKernel,
    /// Work of an evaluation with Jacobians, of one without, and of a start.
    work: [u64; 3],
    statistics: SolverStatistics,
    /// How many of the evaluations were with Jacobians.
    jacobians: u64,
}

/// Where a stepper of one lane stood.
#[derive(Default)]
pub(super) struct Standing {
    memory: Vec<f64>,
    statistics: SolverStatistics,
    jacobians: u64,
}

impl NewtonStepper {
    /// A stepper for `lanes` trajectories.
    pub fn new(
        kernel: &NewtonKernel,
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let wide = (0..lanes / WIDE).map(|block| {
            let own = columns(parameters, lanes, block * WIDE, WIDE);
            lane_block::<WIDE>(kernel, &own, epsilon, h)
        });
        let single = (lanes / WIDE * WIDE..lanes).map(|lane| {
            let own = columns(parameters, lanes, lane, 1);
            lane_block::<1>(kernel, &own, epsilon, h)
        });
        Self {
            wide: wide.collect(),
            single: single.collect(),
            lanes,
            kernel: kernel.clone(),
            work: [kernel.work(), kernel.chord_work(), kernel.start_work()],
            statistics: SolverStatistics::default(),
            jacobians: 0,
        }
    }

    /// Makes a lane forget its solution and its Jacobians, as after a step that failed.
    pub(super) fn forget(&mut self, lane: usize) {
        let (block, place) = (lane / WIDE, lane % WIDE);
        let rest = self.wide.len() * WIDE;
        match self.wide.get_mut(block) {
            Some(block) => block.forget(place),
            None => self.single[lane - rest].forget(0),
        }
    }

    /// Writes down where a stepper of one lane stands, with its work.
    pub(super) fn note(&self, standing: &mut Standing) {
        standing.memory.clear();
        for block in &self.single {
            block.memory(0, &mut standing.memory);
        }
        (standing.statistics, standing.jacobians) = (self.statistics, self.jacobians);
    }

    /// Goes back to where it stood.
    pub(super) fn return_to(&mut self, standing: &Standing) {
        let is_own = self.restore(&standing.memory);
        debug_assert!(is_own.is_ok(), "the memory of this stepper");
        (self.statistics, self.jacobians) = (standing.statistics, standing.jacobians);
    }

    /// How many numbers a lane's memory takes.
    fn memory_of_each(&self) -> usize {
        let mut blocks = self.wide.iter().chain(&self.single);
        blocks.next().map_or(0, |block| block.memory_len())
    }
}

/// The columns `from .. from + count` of a structure of arrays over `lanes` lanes.
fn columns(values: &[f64], lanes: usize, from: usize, count: usize) -> Vec<f64> {
    let rows = values.chunks_exact(lanes);
    rows.flat_map(|row| &row[from..from + count])
        .copied()
        .collect()
}

impl Stepper for NewtonStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let Self {
            lanes,
            statistics,
            jacobians,
            ..
        } = self;
        let mut from = Columns {
            lane: 0,
            lanes: *lanes,
        };
        for block in &mut self.wide {
            block.advance(from, x, low, increment);
            *jacobians += block.report(&mut outcome[from.lane..][..WIDE], statistics);
            from.lane += WIDE;
        }
        for block in &mut self.single {
            block.advance(from, x, low, increment);
            *jacobians += block.report(&mut outcome[from.lane..][..1], statistics);
            from.lane += 1;
        }
    }

    fn advance(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        increment: &mut [f64],
        check: Option<&mut dyn StepCheck>,
        record: Option<&mut StepRecord<'_>>,
    ) -> (u64, Result<(), StepError>) {
        let _ = increment;
        let Self {
            single,
            statistics,
            jacobians,
            ..
        } = self;
        let [block] = &mut single[..] else {
            unreachable!("a stepper of one lane")
        };
        let (made, taken, outcome) = block.run(steps, state, low, statistics, check, record);
        *jacobians += taken;
        (made, outcome)
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        let (block, place) = (lane / WIDE, lane % WIDE);
        match self.wide.get(block) {
            Some(block) => Some(block.solution(place)),
            None => Some(self.single.get(lane - self.wide.len() * WIDE)?.solution(0)),
        }
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let (block, place) = (lane / WIDE, lane % WIDE);
        let rest = self.wide.len() * WIDE;
        let (target, change) = match self.wide.get_mut(block) {
            Some(block) => block.jacobians(place),
            None => self.single.get_mut(lane - rest)?.jacobians(0),
        };
        tangent_of_map(&target, &change, self.kernel.dimension)
    }

    fn restart(&mut self) {
        let blocks = self.wide.iter_mut().chain(&mut self.single);
        blocks.for_each(|block| block.restart());
    }

    fn set(&mut self, setting: Setting<'_>) -> bool {
        let mut from = Columns {
            lane: 0,
            lanes: self.lanes,
        };
        match setting {
            Setting::StepSize(h) => {
                let blocks = self.wide.iter_mut().chain(&mut self.single);
                blocks.for_each(|block| block.resize(h));
                (self.statistics, self.jacobians) = (SolverStatistics::default(), 0);
            }
            Setting::Parameters(parameters) => {
                for block in &mut self.wide {
                    block.set_parameters(from, parameters);
                    from.lane += WIDE;
                }
                for block in &mut self.single {
                    block.set_parameters(from, parameters);
                    from.lane += 1;
                }
            }
            Setting::Members(_) => return false,
        }
        true
    }

    fn statistics(&self) -> SolverStatistics {
        let chords = self.statistics.evaluations - self.jacobians;
        let [with_jacobian, without, start] = self.work;
        let operations =
            self.jacobians * with_jacobian + chords * without + self.statistics.steps * start;
        SolverStatistics {
            operations: Some(operations),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = Vec::with_capacity(self.lanes * self.memory_of_each());
        for block in &self.wide {
            (0..WIDE).for_each(|lane| block.memory(lane, &mut memory));
        }
        for block in &self.single {
            block.memory(0, &mut memory);
        }
        memory
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let each = self.memory_of_each();
        if memory.len() != each * self.lanes {
            return Err(each * self.lanes);
        }
        let mut parts = memory.chunks_exact(each);
        for block in &mut self.wide {
            for (lane, part) in (0..WIDE).zip(&mut parts) {
                block.restore(lane, part);
            }
        }
        for (block, part) in self.single.iter_mut().zip(parts) {
            block.restore(0, part);
        }
        Ok(())
    }
}
