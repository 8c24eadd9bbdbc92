//! The starts of a solve: the polynomial of the last step, z, parts of the step.

use leafwise_expression::vector::run_on_registers;

use super::iteration::Solve;
use super::lanes::{From, Lanes};
use super::solution::{FixedPoint, StageLanes, Start, Unsettled};

/// Stages from which on they show how smooth the motion is over a step. Those of fewer say nothing of it: a step of theirs is
/// followed by parts, or left to another solver.
pub(super) const SMOOTH: usize = 3;

/// Parts of a step that is followed from z are no shorter.
const LEAST_PART: f64 = 1.0 / 64.0;

impl<const W: usize> Lanes<W> {
    /// [`StageLanes::solve`], each attempt by `run`.
    pub(super) fn solve_by(
        &mut self,
        at: usize,
        start: Start<'_>,
        change: &mut [f64],
        run: impl Fn(Solve<'_, W>),
    ) -> Result<FixedPoint, Unsettled> {
        let mut spent = 0;
        let mut attempt = |lanes: &mut Self, from: From| {
            let mut outcome = Err(Unsettled {
                evaluations: 0,
                correction: f64::NAN,
            });
            run(Solve {
                lanes,
                at,
                from,
                start,
                change,
                outcome: &mut outcome,
            });
            let evaluations = match &mut outcome {
                Ok(solved) => &mut solved.evaluations,
                Err(unsettled) => &mut unsettled.evaluations,
            };
            spent += *evaluations;
            *evaluations = spent;
            outcome
        };
        let mut outcome = Err(Unsettled {
            evaluations: 0,
            correction: f64::NAN,
        });
        if self.is_known[at] && self.stages >= SMOOTH {
            outcome = attempt(self, From::Polynomial);
        }
        if outcome.is_err() && self.stages >= SMOOTH {
            outcome = attempt(self, From::State);
        }
        if outcome.is_err() && self.follows {
            outcome = self.follow(at, start.point, attempt);
        }
        self.is_known[at] = outcome.is_ok();
        self.evaluations += spent;
        outcome
    }

    /// Follows the solutions of parts s of the step from s = 0 to 1, each from the one before. The way from one part to
    /// the next is at first a quarter, and halved where a part is too far from the last.
    #[cold]
    fn follow(
        &mut self,
        at: usize,
        z: &[f64],
        mut attempt: impl FnMut(&mut Self, From) -> Result<FixedPoint, Unsettled>,
    ) -> Result<FixedPoint, Unsettled> {
        let (mut done, mut part) = (0.0, 0.25);
        let outcome = loop {
            let to = if done + part > 1.0 { 1.0 } else { done + part };
            for (own, full) in self.matrix.0.iter_mut().zip(&self.full.0) {
                *own = full.map(|entry| to * entry);
            }
            if done > 0.0 {
                // Where the last part has come to, farther in proportion.
                let (stages, _) = self.field.rows_mut();
                for ((stage, kept), z) in stages.iter_mut().zip(&self.ways).zip(z) {
                    *stage = kept.map(|way| z + to / done * way);
                }
            }
            let from = if done > 0.0 {
                From::Standing
            } else {
                From::State
            };
            let outcome = attempt(self, from);
            if outcome.is_ok() {
                if to == 1.0 {
                    break outcome;
                }
                done = to;
                let slopes = &self.slopes[at * z.len()..][..z.len()];
                for (kept, slopes) in self.ways.iter_mut().zip(slopes) {
                    *kept = [0.0; W];
                    for (column, slope) in self.matrix.0.iter().zip(slopes) {
                        for (way, entry) in kept.iter_mut().zip(column) {
                            *way += entry * slope;
                        }
                    }
                }
                continue;
            }
            part *= 0.5;
            if part < LEAST_PART {
                break outcome;
            }
        };
        self.matrix.0 = self.full.0;
        outcome
    }
}

impl<const W: usize> StageLanes for Lanes<W> {
    fn solve(
        &mut self,
        at: usize,
        start: Start<'_>,
        change: &mut [f64],
    ) -> Result<FixedPoint, Unsettled> {
        self.solve_by(at, start, change, |solve| run_on_registers(W, solve))
    }

    fn displacements(&self, at: usize, out: &mut [f64]) {
        let n = self.inverse_sizes.len();
        for (c, slopes) in self.slopes[at * n..][..n].iter().enumerate() {
            for (lane, stage) in out.chunks_exact_mut(n).enumerate() {
                let columns = self.matrix.0.iter().zip(slopes);
                stage[c] = columns.map(|(column, slope)| column[lane] * slope).sum();
            }
        }
    }

    fn clear(&mut self, at: usize) {
        self.is_known[at] = false;
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        let (n, s) = (self.inverse_sizes.len(), self.stages);
        let is_known = f64::from(u8::from(self.is_known[at]));
        let slopes = self.slopes[at * n..][..n].iter();
        let slopes = slopes.flat_map(|row| row[..s].iter().copied());
        std::iter::once(is_known).chain(slopes).collect()
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        let (n, s) = (self.inverse_sizes.len(), self.stages);
        self.is_known[at] = memory[0] != 0.0;
        let rows = self.slopes[at * n..][..n].iter_mut();
        for (row, kept) in rows.zip(memory[1..].chunks_exact(s)) {
            row[..s].copy_from_slice(kept);
        }
    }

    fn operations(&self) -> u64 {
        self.evaluations * self.work + self.field.operations()
    }
}
