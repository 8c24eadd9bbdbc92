//! Equations that have no coordinate in common.

use std::sync::Arc;

use leafwise_expression::{Graph, Kernel, Term};

use super::kernel::{NewtonKernel, StartCode};
use super::stepper::{NewtonStepper, Standing};
use crate::SourceTarget;
use crate::error::{BuildError, StepError};
use crate::{Setting, SolverStatistics, StepCheck, StepRecord, Stepper, one_by_one, restore_each};

/// A step β̂(L(y)) = x that is several, each of coordinates of its own: the step of a direct sum whose Hamiltonian is a sum of
/// functions of the summands. D(β̂∘L) is block diagonal, in whatever order the coordinates stand.
///
/// Every part has its own code, start, Jacobians and stop, as if it were alone, so that a step takes the sum of what its parts do.
#[derive(Clone, Debug)]
pub struct Uncoupled {
    parts: Arc<[Part]>,
    dimension: usize,
}

/// The coordinates of a part, and the code of its iteration.
#[derive(Debug)]
struct Part {
    places: Vec<usize>,
    kernel: NewtonKernel,
}

impl Uncoupled {
    /// Compiles the parts of source and target code over the inputs y_0 … y_{d−1}, each starting by its share of
    /// `start`. Returns `None` where all coordinates belong together.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a derivative has no code.
    pub fn compile(
        graph: &mut Graph,
        ends: &SourceTarget,
        start: Option<&StartCode>,
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let d = ends.base.len();
        let mut groups: Vec<Vec<Term>> = (0..d)
            .map(|i| {
                let [base, offset, increment] =
                    [&ends.base, &ends.offset, &ends.increment].map(|end| end[i].clone());
                vec![graph.input(i), base, offset, increment]
            })
            .collect();
        let (first, last) = ends.guard.clone().unwrap_or_default();
        let pairs = first.iter().zip(&last);
        groups.extend(pairs.map(|(first, last)| vec![first.clone(), last.clone()]));
        let sets = graph.coupled(&groups);
        let parts = sets.iter().filter(|set| set[0] < d);
        // A constant pair of the guard, a set without coordinates, is of the first part.
        let constant: Vec<usize> = sets
            .iter()
            .filter(|set| set[0] >= d)
            .flatten()
            .copied()
            .collect();
        let parts: Vec<(Vec<usize>, Vec<usize>)> = parts
            .enumerate()
            .map(|(at, set)| {
                let (places, mut pairs): (Vec<usize>, Vec<usize>) =
                    set.iter().partition(|at| **at < d);
                if at == 0 {
                    pairs.extend(&constant);
                }
                (places, pairs)
            })
            .collect();
        let shares: Option<Vec<Option<Kernel>>> = parts
            .iter()
            .map(|(places, _)| match start {
                None => Some(None),
                Some(start) => start.share(places, parameters).map(Some),
            })
            .collect();
        let Some(shares) = shares.filter(|_| parts.len() > 1) else {
            return Ok(None);
        };
        let of = |all: &[Term], places: &[usize]| -> Vec<Term> {
            places.iter().map(|at| all[*at].clone()).collect()
        };
        let parts = parts
            .into_iter()
            .zip(shares)
            .map(|((places, pairs), share)| {
                let pairs: Vec<usize> = pairs.iter().map(|at| at - d).collect();
                let own = SourceTarget {
                    base: of(&ends.base, &places),
                    offset: of(&ends.offset, &places),
                    increment: of(&ends.increment, &places),
                    guard: (!pairs.is_empty()).then(|| (of(&first, &pairs), of(&last, &pairs))),
                };
                let kernel = NewtonKernel::compile_from(graph, &own, parameters, &places)?;
                let kernel = kernel.starting_from(share);
                Ok(Part { places, kernel })
            });
        let parts: Vec<Part> = parts.collect::<Result<_, BuildError>>()?;
        Ok(Some(Self {
            parts: parts.into(),
            dimension: d,
        }))
    }

    /// The same where guards may be of series.
    pub fn guarding_series(self, guards_series: bool) -> Self {
        let parts = self.parts.iter().map(|part| Part {
            places: part.places.clone(),
            kernel: part.kernel.clone().guarding_series(guards_series),
        });
        Self {
            parts: parts.collect(),
            ..self
        }
    }

    /// The code of each part's iteration.
    pub fn kernels(&self) -> impl Iterator<Item = &NewtonKernel> {
        self.parts.iter().map(|part| &part.kernel)
    }

    /// A stepper for `lanes` trajectories.
    pub fn stepper(
        &self,
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper> {
        let parts = self.parts.iter().map(|part| {
            let rows = part.places.iter();
            let room = || vec![0.0; part.places.len() * lanes];
            let stepper = NewtonStepper::new(&part.kernel, lanes, parameters, epsilon, h);
            let mut standing = Standing::default();
            // All the room that it takes.
            stepper.note(&mut standing);
            PartStepper {
                rows: rows.map(|at| at * lanes).collect(),
                stepper,
                x: room(),
                low: room(),
                increment: room(),
                standing,
            }
        });
        Box::new(UncoupledStepper {
            parts: parts.collect(),
            lanes,
            dimension: self.dimension,
            room: vec![0.0; self.dimension],
            outcome: vec![Ok(()); lanes],
            steps: 0,
            failures: 0,
        })
    }
}

/// One part's solver, and room for its share of the state.
struct PartStepper {
    /// Where the rows of its coordinates begin.
    rows: Vec<usize>,
    stepper: NewtonStepper,
    x: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    /// Where the solver stood before many steps of a lane alone.
    standing: Standing,
}

impl PartStepper {
    /// Takes its share of a state.
    fn take(&mut self, x: &[f64], low: &[f64], lanes: usize) {
        for (k, row) in self.rows.iter().enumerate() {
            let own = k * lanes..(k + 1) * lanes;
            self.x[own.clone()].copy_from_slice(&x[*row..][..lanes]);
            self.low[own].copy_from_slice(&low[*row..][..lanes]);
        }
    }

    /// Up to so many steps of a lane alone; returns how many were made. `whole` holds a state and changes of 0, in which a
    /// check sees the part move.
    fn advance(
        &mut self,
        steps: u64,
        whole: [&mut [f64]; 2],
        check: &mut Option<&mut dyn StepCheck>,
        record: Option<&mut StepRecord<'_>>,
    ) -> u64 {
        let (x, low, increment) = (&mut self.x, &mut self.low, &mut self.increment);
        let mut record = record.map(|record| record.of_part(&self.rows));
        let record = record.as_mut();
        let concerns =
            |check: &&mut &mut dyn StepCheck| self.rows.iter().any(|at| check.reads(*at));
        let Some(check) = check.as_mut().filter(concerns) else {
            let stepper = &mut self.stepper;
            return stepper.advance(steps, x, low, increment, None, record).0;
        };
        let mut alone = Alone {
            rows: &self.rows,
            whole,
            check: &mut **check,
        };
        let check: Option<&mut dyn StepCheck> = Some(&mut alone);
        let stepper = &mut self.stepper;
        let (made, _) = stepper.advance(steps, x, low, increment, check, record);
        for row in alone.rows {
            alone.whole[1][*row] = 0.0;
        }
        made
    }
}

/// Check of the whole step, called for the coordinates of one part: the others are where they were. Each quantity
/// that it looks at depends on one part alone.
struct Alone<'a> {
    rows: &'a [usize],
    whole: [&'a mut [f64]; 2],
    check: &'a mut dyn StepCheck,
}

impl StepCheck for Alone<'_> {
    fn reads(&self, coordinate: usize) -> bool {
        let row = self.rows.get(coordinate);
        row.is_some_and(|row| self.check.reads(*row))
    }

    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        let [state, changes] = &mut self.whole;
        for (row, (x, change)) in self.rows.iter().zip(x.iter().zip(increment)) {
            (state[*row], changes[*row]) = (*x, *change);
        }
        self.check.check(state, changes, outcome);
    }
}

/// The solvers of the parts, one after the other.
struct UncoupledStepper {
    parts: Vec<PartStepper>,
    lanes: usize,
    dimension: usize,
    /// A state of a lane alone, in which checks see a part move.
    room: Vec<f64>,
    outcome: Vec<Result<(), StepError>>,
    steps: u64,
    failures: u64,
}

impl Stepper for UncoupledStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.lanes;
        for part in &mut self.parts {
            part.take(x, low, lanes);
            let stepper = &mut part.stepper;
            stepper.increment(&part.x, &part.low, &mut part.increment, &mut self.outcome);
            for (k, row) in part.rows.iter().enumerate() {
                increment[*row..][..lanes].copy_from_slice(&part.increment[k * lanes..][..lanes]);
            }
            for (all, own) in outcome.iter_mut().zip(&mut self.outcome) {
                if own.is_err() {
                    let own = std::mem::replace(own, Ok(()));
                    *all = std::mem::replace(all, Ok(())).and(own);
                }
            }
        }
        self.steps += lanes as u64;
        for lane in (0..lanes).filter(|lane| outcome[*lane].is_err()) {
            self.failures += 1;
            let places = increment.iter_mut().skip(lane).step_by(lanes);
            places.for_each(|change| *change = 0.0);
            let parts = self.parts.iter_mut();
            parts.for_each(|part| part.stepper.forget(lane));
        }
    }

    /// Each part goes its whole way alone. Where one fails, all go back and on to the step that fails, which tells why.
    fn advance(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        increment: &mut [f64],
        mut check: Option<&mut dyn StepCheck>,
        mut record: Option<&mut StepRecord<'_>>,
    ) -> (u64, Result<(), StepError>) {
        if steps == 1 {
            return one_by_one(self, steps, [state, low, increment], check, record);
        }
        self.room.copy_from_slice(state);
        increment.fill(0.0);
        let mut made = steps;
        for part in &mut self.parts {
            part.take(state, low, 1);
            part.stepper.note(&mut part.standing);
            let whole = [&mut self.room[..], &mut *increment];
            let record = record.as_deref_mut();
            made = made.min(part.advance(steps, whole, &mut check, record));
        }
        if made < steps {
            if let Some(record) = &mut record {
                record.forget();
            }
            for part in &mut self.parts {
                part.take(state, low, 1);
                part.stepper.return_to(&part.standing);
                let whole = [&mut self.room[..], &mut *increment];
                part.advance(made, whole, &mut check, record.as_deref_mut());
            }
        }
        for part in &self.parts {
            for (row, (x, own)) in part.rows.iter().zip(part.x.iter().zip(&part.low)) {
                (state[*row], low[*row]) = (*x, *own);
            }
        }
        self.steps += made;
        if let Some(record) = &mut record {
            record.end_of_parts(made);
        }
        let (more, outcome) =
            one_by_one(self, steps - made, [state, low, increment], check, record);
        (made + more, outcome)
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        let mut solution = vec![0.0; self.dimension];
        for part in &self.parts {
            let own = part.stepper.solution(lane)?;
            for (row, y) in part.rows.iter().zip(own) {
                solution[row / self.lanes] = y;
            }
        }
        Some(solution)
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let (d, lanes) = (self.dimension, self.lanes);
        let mut tangent = vec![0.0; d * d];
        for part in &mut self.parts {
            let own = part.stepper.tangent(lane)?;
            for (i, entries) in part.rows.iter().zip(own.chunks_exact(part.rows.len())) {
                for (j, entry) in part.rows.iter().zip(entries) {
                    tangent[i / lanes * d + j / lanes] = *entry;
                }
            }
        }
        Some(tangent)
    }

    fn restart(&mut self) {
        let parts = self.parts.iter_mut();
        parts.for_each(|part| part.stepper.restart());
    }

    fn set(&mut self, setting: Setting<'_>) -> bool {
        if let Setting::StepSize(_) = setting {
            (self.steps, self.failures) = (0, 0);
        }
        let mut parts = self.parts.iter_mut();
        parts.all(|part| part.stepper.set(setting))
    }

    /// Evaluations are those of the part that takes most, operations those of all.
    fn statistics(&self) -> SolverStatistics {
        let own = self.parts.iter().map(|part| part.stepper.statistics());
        own.fold(
            SolverStatistics {
                steps: self.steps,
                failures: self.failures,
                ..SolverStatistics::default()
            },
            |all, own| SolverStatistics {
                operations: all.operations.zip(own.operations).map(|(a, b)| a + b),
                evaluations: all.evaluations.max(own.evaluations),
                most_evaluations: all.most_evaluations.max(own.most_evaluations),
                rounded: all.rounded.max(own.rounded),
                held: all.held.max(own.held),
                ..all
            },
        )
    }

    fn memory(&self) -> Vec<f64> {
        let parts = self.parts.iter();
        parts.flat_map(|part| part.stepper.memory()).collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        restore_each(self.parts.iter_mut().map(|part| &mut part.stepper), memory)
    }
}
