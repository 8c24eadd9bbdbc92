//! Blocks of any dimension, and what they hand over.

use super::masks::Row;
use super::{Block, Lane};
use crate::elimination::{ANY, Rows, dimension};
use crate::error::StepError;
use crate::judge::Watch;
use crate::newton::convergence::Convergence;
use crate::newton::kernel::NewtonKernel;
use crate::{SolverStatistics, StepCheck, StepRecord, add};

/// Block of lanes as a stepper uses it, whatever its dimension.
pub(in crate::newton) trait LaneBlock: Send {
    /// Steps from x + low, `from` telling which columns of these structures of arrays are the
    /// block's.
    fn advance(&mut self, from: Columns, x: &[f64], low: &[f64], increment: &mut [f64]);
    /// Up to `steps` steps of a lane alone, as [`Stepper::advance`](crate::Stepper::advance) makes them, each counted
    /// in `work`; returns also how many evaluations were with Jacobians.
    fn run(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        work: &mut SolverStatistics,
        check: Option<&mut dyn StepCheck>,
        record: Option<&mut StepRecord<'_>>,
    ) -> (u64, u64, Result<(), StepError>);
    /// Hands over the outcomes of a step and counts it; returns how many evaluations were with
    /// Jacobians.
    fn report(
        &mut self,
        outcome: &mut [Result<(), StepError>],
        statistics: &mut SolverStatistics,
    ) -> u64;
    /// The solution of a lane's last step.
    fn solution(&self, lane: usize) -> Vec<f64>;
    /// Both Jacobians at the solution of a lane's last step, row-major.
    fn jacobians(&mut self, lane: usize) -> (Vec<f64>, Vec<f64>);
    /// Forgets a lane's solution and its Jacobians, after a step that failed.
    fn forget(&mut self, lane: usize);
    /// Forgets earlier steps.
    fn restart(&mut self);
    /// Takes another step size, and forgets earlier steps.
    fn resize(&mut self, h: f64);
    /// Takes other parameters, `from` telling which columns of this structure of arrays are the block's: forgets earlier
    /// solutions and, where they change a coefficient, Jacobians.
    fn set_parameters(&mut self, from: Columns, parameters: &[f64]);
    /// Writes the memory of a lane, on which its next step depends. The Jacobians are evaluated again where they were
    /// taken.
    fn memory(&self, lane: usize, into: &mut Vec<f64>);
    /// How many numbers [`memory`](Self::memory) writes.
    fn memory_len(&self) -> usize;
    /// Restores a lane's [`memory`](Self::memory).
    fn restore(&mut self, lane: usize, memory: &[f64]);
}

impl<const W: usize, const D: usize, V: Rows<W>, M: Rows<W>> LaneBlock for Block<W, D, V, M> {
    fn advance(&mut self, from: Columns, x: &[f64], low: &[f64], increment: &mut [f64]) {
        let d = dimension::<D>(self.dimension);
        let (own_x, own_low) = (&mut self.x.as_mut()[..d], &mut self.low.as_mut()[..d]);
        for i in 0..d {
            own_x[i].copy_from_slice(&x[from.row::<W>(i)]);
            own_low[i].copy_from_slice(&low[from.row::<W>(i)]);
        }
        if W > 1 || !self.increment_at_once() {
            self.step();
        }
        for (i, own) in self.increment.as_ref()[..d].iter().enumerate() {
            increment[from.row::<W>(i)].copy_from_slice(own);
        }
    }

    fn run(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        work: &mut SolverStatistics,
        mut check: Option<&mut dyn StepCheck>,
        mut record: Option<&mut StepRecord<'_>>,
    ) -> (u64, u64, Result<(), StepError>) {
        let d = dimension::<D>(self.dimension);
        for i in 0..d {
            self.x.as_mut()[i][0] = state[i];
            self.low.as_mut()[i][0] = low[i];
        }
        let (mut made, mut jacobians, mut outcome) = (0, 0, Ok(()));
        while made < steps {
            let (more, ended) = self.run_at_once(steps - made, work, &mut check, &mut record);
            made += more;
            jacobians += more + u64::from(ended.is_err());
            outcome = ended;
            if outcome.is_err() || made == steps {
                break;
            }
            self.step();
            jacobians += self.report(std::slice::from_mut(&mut outcome), work);
            if let Some(check) = check.as_mut().filter(|_| outcome.is_ok()) {
                let (x, increment) = (self.x.as_ref(), self.increment.as_ref());
                let outcome = std::slice::from_mut(&mut outcome);
                check.check(x.as_flattened(), increment.as_flattened(), outcome);
            }
            if outcome.is_ok() {
                let (x, low) = (&mut self.x.as_mut()[..d], &mut self.low.as_mut()[..d]);
                let increment = self.increment.as_ref()[..d].as_flattened();
                outcome = add(x.as_flattened_mut(), low.as_flattened_mut(), increment);
            }
            if outcome.is_err() {
                break;
            }
            made += 1;
            if let Some(record) = &mut record {
                record.take(self.x.as_ref()[..d].as_flattened(), work.evaluations);
            }
        }
        for i in 0..d {
            state[i] = self.x.as_ref()[i][0];
            low[i] = self.low.as_ref()[i][0];
        }
        (made, jacobians, outcome)
    }

    fn solution(&self, lane: usize) -> Vec<f64> {
        self.y.as_ref().iter().map(|row| row[lane]).collect()
    }

    #[inline]
    fn report(
        &mut self,
        outcome: &mut [Result<(), StepError>],
        statistics: &mut SolverStatistics,
    ) -> u64 {
        let mut jacobians = 0;
        for (w, outcome) in outcome.iter_mut().enumerate() {
            if self.outcome[w].is_err() || outcome.is_err() {
                *outcome = std::mem::replace(&mut self.outcome[w], Ok(()));
            }
            let lane = &self.lanes[w];
            statistics.count(lane.convergence.evaluations.into(), outcome.is_ok());
            statistics.rounded += u64::from(lane.convergence.rounded && outcome.is_ok());
            jacobians += u64::from(lane.jacobians);
        }
        jacobians
    }

    fn jacobians(&mut self, lane: usize) -> (Vec<f64>, Vec<f64>) {
        let d = self.dimension;
        let kernel = &self.kernel.full;
        let values = kernel.evaluate_rows(&mut self.full, self.y.as_ref());
        let matrix = |from: usize| {
            let rows = values[from..from + d * d].iter();
            rows.map(|row| row[lane]).collect()
        };
        let ends = self.kernel.bases + 2 * d;
        (matrix(ends), matrix(ends + d * d))
    }

    #[inline(always)]
    fn forget(&mut self, lane: usize) {
        self.start.clear(lane);
        self.lanes[lane].anchored = false;
    }

    fn restart(&mut self) {
        for (w, lane) in self.lanes.iter_mut().enumerate() {
            lane.convergence = Convergence::new();
            lane.watch = Watch::NEW;
            lane.anchored = false;
            self.start.clear(w);
        }
    }

    fn resize(&mut self, h: f64) {
        self.h = h;
        self.prepare();
        self.restart();
    }

    fn set_parameters(&mut self, from: Columns, parameters: &[f64]) {
        for (i, own) in self.parameters.chunks_exact_mut(W).enumerate() {
            own.copy_from_slice(&parameters[from.row::<W>(i)]);
        }
        let changes = self.prepare();
        for (w, lane) in self.lanes.iter_mut().enumerate() {
            self.start.clear(w);
            if changes {
                lane.convergence = Convergence::new();
                lane.anchored = false;
            }
        }
    }

    fn memory(&self, lane: usize, into: &mut Vec<f64>) {
        let Lane {
            convergence,
            watch,
            anchored,
            ..
        } = &self.lanes[lane];
        into.extend([
            convergence.constant,
            convergence.first,
            convergence.seen,
            watch.memory(),
            if *anchored { 1.0 } else { 0.0 },
        ]);
        for rows in [self.anchor.as_ref(), self.scale.as_ref()] {
            into.extend(
                rows.iter()
                    .map(|row| if *anchored { row[lane] } else { 0.0 }),
            );
        }
        self.start.memory(lane, into);
    }

    fn memory_len(&self) -> usize {
        5 + 2 * self.dimension + self.start.memory_len()
    }

    fn restore(&mut self, lane: usize, memory: &[f64]) {
        let d = self.dimension;
        let (own, memory) = memory.split_at(5);
        let (anchor, memory) = memory.split_at(d);
        let (scale, history) = memory.split_at(d);
        let convergence = &mut self.lanes[lane].convergence;
        *convergence = Convergence::new();
        (convergence.constant, convergence.first) = (own[0], own[1]);
        convergence.seen = own[2];
        let steps = own[3];
        for i in 0..d {
            self.y.as_mut()[i][lane] = anchor[i];
            self.scale.as_mut()[i][lane] = scale[i];
        }
        self.start.restore(lane, history);
        if own[4] != 0.0 && self.kernel.at_once.is_none() {
            let only = std::array::from_fn(|w| w == lane);
            let (y, mut residual) = (self.y.take(), self.correction.take());
            let mut increment = self.increment.take();
            self.evaluate_full(y.as_ref(), [residual.as_mut(), increment.as_mut()], &only);
            (self.y, self.correction, self.increment) = (y, residual, increment);
        } else {
            self.lanes[lane].anchored = false;
            for (y, last) in self.y.as_mut().iter_mut().zip(self.start.last()) {
                y[lane] = last[lane];
            }
        }
        // The Jacobian's own evaluation is no step.
        self.lanes[lane].watch = Watch::NEW;
        self.lanes[lane].watch.restore(steps);
    }
}

/// Where a block's lanes stand in structures of arrays over all lanes.
#[derive(Clone, Copy)]
pub(in crate::newton) struct Columns {
    /// The first.
    pub(in crate::newton) lane: usize,
    /// Of so many.
    pub(in crate::newton) lanes: usize,
}

impl Columns {
    /// A row's numbers for W lanes.
    #[inline(always)]
    fn row<const W: usize>(self, i: usize) -> std::ops::Range<usize> {
        let start = i * self.lanes + self.lane;
        start..start + W
    }
}

/// W trajectories; `parameters` is a structure of arrays over them.
pub(in crate::newton) fn lane_block<const W: usize>(
    kernel: &NewtonKernel,
    parameters: &[f64],
    epsilon: f64,
    h: f64,
) -> Box<dyn LaneBlock> {
    macro_rules! block {
        ($dimension:expr, $vector:ty, $matrix:ty) => {
            Box::new(Block::<W, $dimension, $vector, $matrix>::new(
                kernel, parameters, epsilon, h,
            ))
        };
    }
    match kernel.dimension {
        2 => block!(2, [Row<W>; 2], [Row<W>; 4]),
        3 => block!(3, [Row<W>; 3], [Row<W>; 9]),
        4 => block!(4, [Row<W>; 4], [Row<W>; 16]),
        6 => block!(6, [Row<W>; 6], [Row<W>; 36]),
        _ => block!(ANY, Vec<Row<W>>, Vec<Row<W>>),
    }
}
