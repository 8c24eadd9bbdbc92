//! A method as a step map, one trajectory a lane.

use leafwise_core::{MapProperties, SolverStatistics, StepError, StepMap, Stepper};
use nalgebra::DMatrix;

/// One thread's evaluator of a method, for fixed parameters and time step.
pub(crate) trait OneStep: Send {
    /// Φ(x) − x; returns how often the field was evaluated at all stages.
    fn increment(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError>;
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` over a system that
    /// does not count.
    fn operations(&self) -> Option<u64>;
    /// DΦ at the x of the last step, `None` where it is not offered.
    fn tangent(&mut self) -> Option<DMatrix<f64>> {
        None
    }
    /// Forgets earlier steps.
    fn restart(&mut self) {}
    /// What later steps depend on beyond the state; always of the same length.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Restores [`memory`](Self::memory).
    fn restore(&mut self, memory: &[f64]) {
        let _ = memory;
    }
}

type Make = dyn Fn(&[f64], f64) -> Box<dyn OneStep> + Send + Sync;

/// A method as a [`StepMap`].
pub(crate) struct ReferenceMap {
    pub(crate) dimension: usize,
    pub(crate) properties: MapProperties,
    pub(crate) description: String,
    /// Makes the evaluator for parameters and a time step.
    pub(crate) make: Box<Make>,
}

impl StepMap for ReferenceMap {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let methods = (0..lanes)
            .map(|lane| {
                let own: Vec<f64> = parameters
                    .iter()
                    .skip(lane)
                    .step_by(lanes)
                    .copied()
                    .collect();
                (self.make)(&own, epsilon * h)
            })
            .collect();
        Box::new(LaneStepper {
            methods,
            statistics: SolverStatistics::default(),
        })
    }
}

struct LaneStepper {
    methods: Vec<Box<dyn OneStep>>,
    statistics: SolverStatistics,
}

impl Stepper for LaneStepper {
    /// Steps from the doubles `x`: what the compensated state holds beyond them, half a unit in the
    /// last place, changes an increment by less than its own rounding.
    fn increment(
        &mut self,
        x: &[f64],
        _low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.methods.len();
        for (lane, method) in self.methods.iter_mut().enumerate() {
            let own: Vec<f64> = x.iter().skip(lane).step_by(lanes).copied().collect();
            let mut change = vec![0.0; own.len()];
            let result = method.increment(&own, &mut change).and_then(|evaluations| {
                if change.iter().all(|v| v.is_finite()) {
                    Ok(evaluations as u64)
                } else {
                    Err(StepError::NonFinite {
                        what: "the increment",
                    })
                }
            });
            self.statistics.steps += 1;
            outcome[lane] = match result {
                Ok(evaluations) => {
                    self.statistics.evaluations += evaluations;
                    self.statistics.most_evaluations =
                        self.statistics.most_evaluations.max(evaluations);
                    Ok(())
                }
                Err(error) => {
                    self.statistics.failures += 1;
                    method.restart();
                    change.fill(0.0);
                    Err(error)
                }
            };
            let places = increment.iter_mut().skip(lane).step_by(lanes);
            places
                .zip(&change)
                .for_each(|(place, value)| *place = *value);
        }
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let tangent = self.methods.get_mut(lane)?.tangent()?;
        Some(tangent.transpose().as_slice().to_vec())
    }

    fn restart(&mut self) {
        self.methods.iter_mut().for_each(|method| method.restart());
    }

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: self.methods.iter().map(|method| method.operations()).sum(),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        self.methods.iter().flat_map(|m| m.memory()).collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let expected = self.methods.iter().map(|m| m.memory().len()).sum();
        if memory.len() != expected {
            return Err(expected);
        }
        let mut rest = memory;
        for method in &mut self.methods {
            let (own, others) = rest.split_at(method.memory().len());
            method.restore(own);
            rest = others;
        }
        Ok(())
    }
}

/// |size| of a correction relative to a scale; 0 for no correction, 1 where there is no scale yet.
pub(crate) fn relative(correction: f64, scale: f64) -> f64 {
    if correction == 0.0 {
        0.0
    } else if scale == 0.0 {
        1.0
    } else {
        correction.abs() / scale
    }
}

/// max that keeps NaN.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a >= b { a } else { b }
}

/// Σ_k |m_k v_k|.
pub(crate) fn reach(row: &[f64], values: &[f64]) -> f64 {
    row.iter().zip(values).map(|(m, v)| (m * v).abs()).sum()
}
