//! Steps of one length alone.

use leafwise_solver::{Setting, SolverStatistics, StepCheck, StepRecord, Stepper};

use crate::error::StepError;

/// The part of a length that round-off may change of it.
const ROUNDED: f64 = 1e-12;

/// The stepper of a map that holds for steps |εh| of one length: it refuses every other one.
pub fn of_one_length(
    stepper: Box<dyn Stepper>,
    part: &'static str,
    length: f64,
    step: f64,
) -> Box<dyn Stepper> {
    let is_other = (step.abs() - length).abs() > ROUNDED * length || step.is_nan();
    let refused = is_other.then_some(StepError::OtherLength { part, length, step });
    Box::new(OfOneLength {
        stepper,
        refused,
        failures: 0,
    })
}

struct OfOneLength {
    stepper: Box<dyn Stepper>,
    /// Why no step is made.
    refused: Option<StepError>,
    failures: u64,
}

impl Stepper for OfOneLength {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let Some(refused) = &self.refused else {
            return self.stepper.increment(x, low, increment, outcome);
        };
        self.failures += outcome.len() as u64;
        increment.fill(0.0);
        outcome.fill(Err(refused.clone()));
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
        match &self.refused {
            Some(refused) if steps > 0 => {
                self.failures += 1;
                (0, Err(refused.clone()))
            }
            _ => self
                .stepper
                .advance(steps, state, low, increment, check, record),
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        match self.refused {
            None => self.stepper.solution(lane),
            Some(_) => None,
        }
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        match self.refused {
            None => self.stepper.tangent(lane),
            Some(_) => None,
        }
    }

    fn restart(&mut self) {
        self.stepper.restart();
    }

    fn set(&mut self, setting: Setting<'_>) -> bool {
        match setting {
            // Another length asks for another stepper.
            Setting::StepSize(_) => false,
            setting => self.stepper.set(setting),
        }
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
