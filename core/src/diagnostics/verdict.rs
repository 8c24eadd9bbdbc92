//! Verdicts on an identity, and the states where it is sampled.

use serde::Serialize;

/// Verdict on an identity f = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The normal form is 0: it holds identically.
    Proved,
    /// Holds by construction: the object that the identity is about is made so.
    #[serde(rename = "by construction")]
    ByConstruction,
    /// The algebra could not decide; it holds to round-off at every sample.
    #[serde(rename = "numerically zero")]
    NumericallyZero,
    /// It fails.
    Violated,
    /// The algebra could not decide and no sample had a finite value.
    Undecided,
}

/// The outcome of a check, with its worst component.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentityCheck {
    /// The verdict.
    pub verdict: Verdict,
    /// The largest |Σ terms| / Σ |terms| over components and samples; 0 when proved.
    pub residual: f64,
    /// The indices of the worst component: a triple (i, j, k) for Jacobi, (i) for a Casimir; empty
    /// where it is not traced to coordinates.
    pub worst: Vec<usize>,
    /// The state where it was found; empty when proved.
    pub at: Vec<f64>,
    /// Where derivatives are differences, the part of the residual that may be their error; `None`
    /// where they are exact.
    pub floor: Option<f64>,
}

impl IdentityCheck {
    /// An identity that holds in exact algebra.
    pub(super) fn proved() -> Self {
        Self {
            verdict: Verdict::Proved,
            residual: 0.0,
            worst: Vec::new(),
            at: Vec::new(),
            floor: None,
        }
    }
}

/// Normalized residuals below this are round-off: sums of a few hundred products at most.
pub(super) const ROUND_OFF: f64 = 1e-11;

/// Samples of an identity that the algebra does not decide.
const SAMPLES: usize = 8;

/// Deterministic states around `near`: up to 20 % away in each coordinate, signs kept.
pub(super) fn sample_states(near: &[f64]) -> Vec<Vec<f64>> {
    let mut phase = 0.5_f64;
    let mut next = move || {
        phase = (phase + 0.618_033_988_749_894_9) % 1.0;
        0.4 * phase - 0.2
    };
    let mut states = vec![near.to_vec()];
    for _ in 1..SAMPLES {
        states.push(
            near.iter()
                .map(|v| {
                    if *v == 0.0 {
                        next()
                    } else {
                        v * (1.0 + next())
                    }
                })
                .collect(),
        );
    }
    states
}
