//! Any number of trajectories.

use super::block::Block;
use super::kernel::NewtonKernel;
use crate::error::StepError;
use crate::solver::{SolverStatistics, Stepper, tangent_of_map};

/// The lanes of a wide block, as many as a kernel evaluates at once.
const WIDE: usize = 8;

/// Solves β̂(L(y)) = x by Newton's method with the exact Jacobian, any number of trajectories at once.
///
/// *Start*: extrapolation of earlier solutions. *Evaluations*: with the Jacobian, or without where the
/// one that is there contracts fast enough to save operations. *Stop*: when what the next correction
/// would add, C(2D + δ)δ by the constant C observed so far and the distance D from where the Jacobian
/// was taken, is below a small part of an ulp; the last correction then enters the increment to first
/// order, without another evaluation. A lane stops on its own test, so its result does not depend on
/// its neighbours.
pub struct NewtonStepper {
    wide: Vec<Block<WIDE>>,
    single: Vec<Block<1>>,
    lanes: usize,
    kernel: NewtonKernel,
    statistics: SolverStatistics,
    /// How many of the evaluations were with Jacobians.
    jacobians: u64,
}

impl NewtonStepper {
    /// A worker for `lanes` trajectories.
    pub fn new(
        kernel: &NewtonKernel,
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let wide = (0..lanes / WIDE).map(|block| {
            let own = columns(parameters, lanes, block * WIDE, WIDE);
            Block::new(kernel, &own, epsilon, h)
        });
        let single = (lanes / WIDE * WIDE..lanes).map(|lane| {
            let own = columns(parameters, lanes, lane, 1);
            Block::new(kernel, &own, epsilon, h)
        });
        Self {
            wide: wide.collect(),
            single: single.collect(),
            lanes,
            kernel: kernel.clone(),
            statistics: SolverStatistics::default(),
            jacobians: 0,
        }
    }

    /// How many numbers a lane's memory takes.
    fn memory_of_each(&self) -> usize {
        let wide = self.wide.first().map(Block::memory_len);
        let single = self.single.first().map(Block::memory_len);
        wide.or(single).unwrap_or(0)
    }
}

/// The columns `from .. from + count` of a structure of arrays over `lanes` lanes.
fn columns(values: &[f64], lanes: usize, from: usize, count: usize) -> Vec<f64> {
    let rows = values.chunks_exact(lanes);
    rows.flat_map(|row| &row[from..from + count])
        .copied()
        .collect()
}

/// A structure of arrays over all lanes, from one lane on.
#[derive(Clone, Copy)]
struct Columns {
    lane: usize,
    lanes: usize,
}

impl Columns {
    /// A row's numbers for W lanes.
    fn row<const W: usize>(self, i: usize) -> std::ops::Range<usize> {
        let start = i * self.lanes + self.lane;
        start..start + W
    }
}

/// Steps the lanes of a block.
fn advance<const W: usize>(
    block: &mut Block<W>,
    from: Columns,
    x: &[f64],
    low: &[f64],
    increment: &mut [f64],
) {
    let rows = block.x.iter_mut().zip(&mut block.low);
    for (i, (own_x, own_low)) in rows.enumerate() {
        own_x.copy_from_slice(&x[from.row::<W>(i)]);
        own_low.copy_from_slice(&low[from.row::<W>(i)]);
    }
    block.step();
    for (i, own) in block.increment.iter().enumerate() {
        increment[from.row::<W>(i)].copy_from_slice(own);
    }
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
            advance(block, from, x, low, increment);
            *jacobians += block.report(&mut outcome[from.lane..][..WIDE], statistics);
            from.lane += WIDE;
        }
        for block in &mut self.single {
            advance(block, from, x, low, increment);
            *jacobians += block.report(&mut outcome[from.lane..][..1], statistics);
            from.lane += 1;
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        let (block, place) = (lane / WIDE, lane % WIDE);
        if let Some(block) = self.wide.get(block) {
            return Some(block.y.iter().map(|row| row[place]).collect());
        }
        let block = self.single.get(lane - self.wide.len() * WIDE)?;
        Some(block.y.iter().map(|row| row[0]).collect())
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
        self.wide.iter_mut().for_each(Block::restart);
        self.single.iter_mut().for_each(Block::restart);
    }

    fn statistics(&self) -> SolverStatistics {
        let chords = self.statistics.evaluations - self.jacobians;
        let operations = self.jacobians * self.kernel.work() + chords * self.kernel.chord_work();
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
