//! Global errors over a fixed time.

use leafwise_core::{MapProperties, StepError, StepMap, Walk};

use super::floor::Floor;
use super::judgement::Judgement;
use super::order::MeasuredOrder;
use super::problem::Problem;

/// Global errors (t, error) at a sequence of steps, and the order fitted to them.
pub(super) struct Convergence {
    pub errors: Vec<(f64, f64)>,
    /// Steps that fail, with the reason.
    failures: Vec<(f64, StepError)>,
    pub order: MeasuredOrder,
    round_off: f64,
}

/// Numbers of steps over the horizon, about a quarter more each time: orders from 1 to 10 find
/// errors between their pre-asymptotic range and round-off somewhere among them.
pub(super) const STEPS: [u32; 22] = [
    2, 3, 4, 5, 6, 8, 10, 12, 15, 19, 24, 30, 38, 48, 60, 75, 94, 118, 148, 185, 231, 289,
];

/// Round-off of a global error relative to the state, at least and at most: compensated steps keep
/// it at a few units; a flow may stretch it.
pub(super) const ROUND_OFF: [f64; 2] = [8.0 * f64::EPSILON, 4096.0 * f64::EPSILON];

/// Errors above a tenth are not asymptotic.
pub(super) const LARGEST_ERROR: f64 = 0.1;

impl Convergence {
    /// Runs `map` over `horizon` at every step size, against the state `flow` there. Steps so large that the map fails
    /// are left out. Nothing is run after two errors at round-off. Steps are of one length alone where `only_step` is given.
    ///
    /// # Errors
    /// The map's [`StepError`] when no step size succeeds.
    pub fn measure(
        problem: &Problem,
        map: &dyn StepMap,
        (flow, horizon): (&[f64], f64),
        only_step: Option<f64>,
    ) -> Result<Self, StepError> {
        let values = problem.system.parameter_values();
        let mut errors: Vec<(f64, f64)> = Vec::new();
        let mut failures: Vec<(f64, StepError)> = Vec::new();
        let mut floor = Floor::new(ROUND_OFF[0], ROUND_OFF[1]);
        let counts = match only_step {
            None => STEPS.to_vec(),
            Some(length) => vec![libm::round((horizon / length).abs()) as u32],
        };
        for steps in counts {
            let t = horizon / f64::from(steps);
            let mut walk = Walk::new(map, &values, 1.0, t, &problem.initial);
            match walk.advance(u64::from(steps)) {
                Ok(()) => {
                    let error = distance(walk.state(), flow);
                    errors.push((t, error));
                    floor.take(t, error);
                }
                Err(error) => failures.push((t, error)),
            }
            if floor.touched() >= 2 {
                break;
            }
        }
        if let (true, Some((_, error))) = (errors.is_empty(), failures.last()) {
            return Err(error.clone());
        }
        // Errors of a self-adjoint map are even in t beside their leading term.
        let gap = match map.properties().self_adjoint {
            Some(true) => 2.0,
            Some(false) | None => 1.0,
        };
        let asymptotic: Vec<_> = errors
            .iter()
            .copied()
            .filter(|e| e.1 < LARGEST_ERROR)
            .collect();
        let round_off = floor.round_off;
        // Where no step is small enough, that errors do not fall is all there is to see.
        let seen = if asymptotic.is_empty() {
            &errors
        } else {
            &asymptotic
        };
        Ok(Self {
            order: MeasuredOrder::of(seen, round_off, gap),
            errors,
            failures,
            round_off,
        })
    }

    /// A solve that fails at a step no larger than `usual`, where a larger step succeeds: a step that is too
    /// large fails for its size, this one does not.
    pub fn broken_solve(&self, usual: f64) -> Option<String> {
        let is_solve = |error: &StepError| matches!(error, StepError::NoConvergence { .. });
        let mut failing = self
            .failures
            .iter()
            .filter(|(t, error)| *t <= usual && is_solve(error));
        failing.find_map(|(t, error)| {
            let (larger, _) = self.errors.iter().rev().find(|(larger, _)| larger > t)?;
            Some(format!(
                "a step of {t:.2e} fails where one of {larger:.2e} succeeds: {error}"
            ))
        })
    }

    /// Whether no error is above round-off.
    pub fn is_round_off(&self) -> bool {
        let noise = 4.0 * self.round_off;
        !self.errors.is_empty() && self.errors.iter().all(|e| e.1 <= noise)
    }

    /// The declared order in t against it. No order is better than errors that are round-off at every
    /// step.
    pub fn judge(&self, declared: MapProperties) -> Judgement {
        if self.is_round_off() {
            return Judgement::Met;
        }
        self.order.judge(declared.order)
    }
}

/// ‖a − b‖/‖b‖.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    let size: f64 = b.iter().map(|v| v * v).sum();
    libm::sqrt(difference) / libm::sqrt(size).max(f64::MIN_POSITIVE)
}
