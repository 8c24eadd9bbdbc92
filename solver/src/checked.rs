//! Steps that are looked at before they are handed out.

use super::{Setting, SolverStatistics, StepCheck, StepRecord, Stepper};
use crate::error::StepError;

/// A stepper that refuses steps by a check.
pub struct Checked {
    stepper: Box<dyn Stepper>,
    check: Box<dyn StepCheck>,
    failures: u64,
}

impl Checked {
    /// The stepper with the check.
    pub fn boxed(stepper: Box<dyn Stepper>, check: Box<dyn StepCheck>) -> Box<dyn Stepper> {
        Box::new(Self {
            stepper,
            check,
            failures: 0,
        })
    }

    fn failed(outcome: &[Result<(), StepError>]) -> usize {
        outcome.iter().filter(|outcome| outcome.is_err()).count()
    }
}

impl Stepper for Checked {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        self.stepper.increment(x, low, increment, outcome);
        let before = Self::failed(outcome);
        self.check.check(x, increment, outcome);
        let refused = Self::failed(outcome) - before;
        if refused == 0 {
            return;
        }
        self.failures += refused as u64;
        for row in increment.chunks_exact_mut(outcome.len()) {
            let lanes = row.iter_mut().zip(outcome.iter());
            lanes
                .filter(|(_, outcome)| outcome.is_err())
                .for_each(|(value, _)| *value = 0.0);
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
        let mut both = InTurn {
            first: self.check.as_mut(),
            is_refused: false,
            then: check,
        };
        let (made, ended) =
            self.stepper
                .advance(steps, state, low, increment, Some(&mut both), record);
        self.failures += u64::from(both.is_refused);
        // A step that failed by itself may not have been looked at.
        let mut outcome = [ended];
        if outcome[0].is_err() && !both.is_refused {
            self.check.check(state, increment, &mut outcome);
        }
        let [ended] = outcome;
        (made, ended)
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.stepper.solution(lane)
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        self.stepper.tangent(lane)
    }

    fn restart(&mut self) {
        self.stepper.restart();
    }

    fn set(&mut self, setting: Setting<'_>) -> bool {
        if let Setting::Parameters(parameters) = setting {
            self.check.set_parameters(parameters);
        }
        let is_offered = self.stepper.set(setting);
        if is_offered && matches!(setting, Setting::StepSize(_)) {
            self.failures = 0;
        }
        is_offered
    }

    fn statistics(&self) -> SolverStatistics {
        let statistics = self.stepper.statistics();
        SolverStatistics {
            failures: statistics.failures + self.failures,
            ..statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        self.stepper.memory()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        self.stepper.restore(memory)
    }
}

/// A check, and another of what it lets pass; of a lane alone.
struct InTurn<'own, 'then> {
    first: &'own mut dyn StepCheck,
    /// Whether the first refused what it saw last.
    is_refused: bool,
    then: Option<&'then mut dyn StepCheck>,
}

impl StepCheck for InTurn<'_, '_> {
    fn reads(&self, coordinate: usize) -> bool {
        let then = self.then.as_ref();
        self.first.reads(coordinate) || then.is_some_and(|then| then.reads(coordinate))
    }

    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        let [lane] = outcome else {
            unreachable!("of a lane alone")
        };
        let before = lane.is_err();
        self.first.check(x, increment, outcome);
        self.is_refused = !before && outcome[0].is_err();
        if let Some(then) = &mut self.then {
            then.check(x, increment, outcome);
        }
    }
}
