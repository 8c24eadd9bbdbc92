//! Tolerances that a run has to meet.

use super::candidate::Bench;
use super::error::TradeError;
use super::reference::Reference;
use super::trial::Trial;

/// Tolerances that a run has to meet, each optional.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerances {
    /// The largest ‖x − x*‖ where runs are judged: at every step, or at the end.
    pub error: Option<f64>,
    /// The largest |H(x_k) − H(x_0)| over every step.
    pub energy: Option<f64>,
    /// The largest |C(x_k) − C(x_0)| of every Casimir over every step.
    pub casimirs: Option<f64>,
    /// Whether all three are relative, to the largest ‖x*‖ there and to |I(x_0)|; an invariant that starts at 0 is
    /// judged absolutely.
    pub relative: bool,
}

/// Tolerances in the units of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Limits {
    /// Of the state; infinite where none is asked for.
    pub error: f64,
    /// Of each invariant.
    drift: Vec<f64>,
    /// The size of the state, and of each invariant.
    norm: f64,
    sizes: Vec<f64>,
}

/// By how much a run misses what is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Violation {
    /// The largest ratio of what was measured to what is allowed: at most 1 where all is met.
    pub ratio: f64,
    /// Place of the invariant that has this ratio; `None` for the state.
    pub invariant: Option<usize>,
    /// Measured error or drift, relative to the size of the state or invariant.
    pub relative: f64,
}

impl Tolerances {
    /// Whether anything is asked.
    pub fn is_empty(&self) -> bool {
        self.error.or(self.energy).or(self.casimirs).is_none()
    }

    /// Refuses what a scene has nothing for.
    ///
    /// # Errors
    /// [`TradeError::NoCasimirs`].
    pub fn check(&self, bench: &Bench<'_>) -> Result<(), TradeError> {
        if self.casimirs.is_some() && bench.invariants().len() < 2 {
            return Err(TradeError::NoCasimirs);
        }
        Ok(())
    }

    /// In the units of the scene; `initial` are the invariants' first values.
    pub(super) fn limits(&self, reference: &Reference, initial: &[f64]) -> Limits {
        let size = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
        let limit = |asked: Option<f64>, value: f64| {
            let unit = if self.relative { size(value) } else { 1.0 };
            asked.map_or(f64::INFINITY, |tolerance| tolerance * unit)
        };
        let drift = initial.iter().enumerate().map(|(at, value)| {
            let asked = if at == 0 { self.energy } else { self.casimirs };
            limit(asked, *value)
        });
        Limits {
            error: limit(self.error, reference.norm()),
            drift: drift.collect(),
            norm: size(reference.norm()),
            sizes: initial.iter().map(|value| size(*value)).collect(),
        }
    }
}

impl Limits {
    /// By how much a run misses them; the reference's own error counts against it.
    pub fn excess(&self, trial: &Trial, reference: &Reference) -> Violation {
        let error = reference.error_of(trial) + reference.error;
        let mut worst = Violation {
            ratio: error / self.error,
            invariant: None,
            relative: error / self.norm,
        };
        for (at, drift) in trial.drift.iter().enumerate() {
            let ratio = drift / self.drift[at];
            if ratio > worst.ratio {
                worst = Violation {
                    ratio,
                    invariant: Some(at),
                    relative: drift / self.sizes[at],
                };
            }
        }
        worst
    }
}
