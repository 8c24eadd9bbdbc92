//! Steps one after the other.

use std::sync::Arc;

use leafwise_solver::{Compensated, Setting, SolverStatistics, Stepper, restore_each};

use super::StepMap;
use crate::error::StepError;

/// Stepper of a product of maps: one stepper a stage, with its own step size and its own history. The i-th stages of
/// successive steps lie on one smooth curve, so that what a stage learned serves the same stage a step later.
///
/// States between stages carry their compensation, and the stages' increments are summed with
/// theirs, so that the product rounds no more than its stages do.
pub struct ProductStepper {
    /// Each stage's part of the step.
    parts: Vec<f64>,
    stages: Vec<Box<dyn Stepper>>,
    state: Compensated,
    sum: Compensated,
    increment: Vec<f64>,
    outcome: Vec<Result<(), StepError>>,
    dimension: usize,
    steps: u64,
    failures: u64,
}

impl ProductStepper {
    /// Φ_s over the part γ_s of the step ∘ … ∘ Φ_1 over γ_1, the maps of one dimension.
    ///
    /// # Panics
    /// When there is no stage.
    pub fn new(
        stages: &[(Arc<dyn StepMap>, f64)],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Self {
        let dimension = stages.first().expect("a stage").0.dimension();
        let size = dimension * lanes;
        let steppers = stages.iter();
        let steppers =
            steppers.map(|(map, part)| map.stepper(lanes, parameters, epsilon, part * h));
        Self {
            parts: stages.iter().map(|(_, part)| *part).collect(),
            stages: steppers.collect(),
            state: Compensated::new(size),
            sum: Compensated::new(size),
            increment: vec![0.0; size],
            outcome: vec![Ok(()); lanes],
            dimension,
            steps: 0,
            failures: 0,
        }
    }
}

impl Stepper for ProductStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = outcome.len();
        outcome.fill(Ok(()));
        self.state.set(x, low);
        self.sum.clear();
        for stage in &mut self.stages {
            stage.increment(
                &self.state.high,
                &self.state.low,
                &mut self.increment,
                &mut self.outcome,
            );
            self.state.add(&self.increment);
            self.sum.add(&self.increment);
            for lane in 0..lanes {
                if let (Ok(()), Err(error)) = (&outcome[lane], &self.outcome[lane]) {
                    outcome[lane] = Err(error.clone());
                }
                if outcome[lane].is_err() {
                    // The stages after a failed one fail as well and forget, whatever the other
                    // lanes do: a lane's history does not depend on its neighbours.
                    let places = self.state.high.iter_mut().skip(lane).step_by(lanes);
                    places.for_each(|place| *place = f64::NAN);
                }
            }
        }
        self.steps += lanes as u64;
        for lane in 0..lanes {
            let places = (0..self.dimension).map(|i| i * lanes + lane);
            if outcome[lane].is_ok() {
                places.for_each(|at| increment[at] = self.sum.high[at] + self.sum.low[at]);
            } else {
                self.failures += 1;
                places.for_each(|at| increment[at] = 0.0);
            }
        }
    }

    /// DΨ = DΦ_{γ_s h} ⋯ DΦ_{γ_1 h}, each at its own stage.
    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let d = self.dimension;
        let mut product: Option<Vec<f64>> = None;
        for stage in &mut self.stages {
            let factor = stage.tangent(lane)?;
            product = Some(match product {
                None => factor,
                Some(earlier) => multiply(&factor, &earlier, d),
            });
        }
        product
    }

    fn restart(&mut self) {
        self.stages.iter_mut().for_each(|stage| stage.restart());
    }

    fn set(&mut self, setting: Setting<'_>) -> bool {
        let mut stages = self.stages.iter_mut().zip(&self.parts);
        // Stages are of one kind: the first says for all whether they can.
        let is_offered = stages.all(|(stage, part)| {
            stage.set(match setting {
                Setting::StepSize(h) => Setting::StepSize(part * h),
                other => other,
            })
        });
        if is_offered && matches!(setting, Setting::StepSize(_)) {
            (self.steps, self.failures) = (0, 0);
        }
        is_offered
    }

    /// Steps and failures are those of whole steps; evaluations are summed over the stages, and so
    /// is the largest number, which then bounds that of one step. Rounded steps are those of the stage
    /// that has most, and so is what Casimirs are held by.
    fn statistics(&self) -> SolverStatistics {
        let stages = self.stages.iter().map(|stage| stage.statistics());
        stages.fold(
            SolverStatistics {
                steps: self.steps,
                failures: self.failures,
                ..SolverStatistics::default()
            },
            |sum, stage| SolverStatistics {
                operations: sum.operations.zip(stage.operations).map(|(a, b)| a + b),
                evaluations: sum.evaluations + stage.evaluations,
                most_evaluations: sum.most_evaluations + stage.most_evaluations,
                rounded: sum.rounded.max(stage.rounded),
                held: sum.held.max(stage.held),
                ..sum
            },
        )
    }

    fn memory(&self) -> Vec<f64> {
        self.stages
            .iter()
            .flat_map(|stage| stage.memory())
            .collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        restore_each(self.stages.iter_mut().map(Box::as_mut), memory)
    }
}

/// a·b, row-major d × d.
fn multiply(a: &[f64], b: &[f64], d: usize) -> Vec<f64> {
    let entry = |at: usize| (0..d).map(|k| a[at / d * d + k] * b[k * d + at % d]).sum();
    (0..d * d).map(entry).collect()
}
