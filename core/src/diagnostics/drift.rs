//! Invariants along an orbit: the largest deviation over every step, and whether it grows.

use crate::error::{BuildError, StepError};
use crate::observer::Observer;
use crate::solver::judge::larger;
use crate::system::PoissonSystem;
use crate::walk::Walk;

/// How far an invariant moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvariantDrift {
    /// I(x_0).
    pub initial: f64,
    /// max_k |I(x_k) − I(x_0)| over every step.
    pub largest: f64,
    /// Growth of the error: its maximum over the last tenth of the steps over that of the first tenth. Near 1 for a
    /// bounded error, √10 for a random walk, 10 and more for a secular drift; `None` where the first is 0.
    pub growth: Option<f64>,
}

impl InvariantDrift {
    /// The deviation relative to the initial value; absolute where that is 0.
    pub fn relative(&self) -> f64 {
        if self.initial == 0.0 {
            self.largest
        } else {
            self.largest / self.initial.abs()
        }
    }
}

/// Steps `walk` and watches every observable at every step.
///
/// # Errors
/// The map's [`StepError`].
pub fn measure_drift(
    walk: &mut Walk,
    observer: impl Into<Observer>,
    steps: usize,
) -> Result<Vec<InvariantDrift>, StepError> {
    let mut observer = observer.into();
    let count = observer.observables();
    let (mut initial, mut now) = (vec![0.0; count], vec![0.0; count]);
    observer.evaluate(walk.state(), &mut initial);
    let tenth = steps.div_ceil(10);
    let mut largest = vec![[0.0_f64; 3]; count];
    for step in 0..steps {
        walk.step()?;
        observer.evaluate(walk.state(), &mut now);
        for ((largest, now), initial) in largest.iter_mut().zip(&now).zip(&initial) {
            let change = (now - initial).abs();
            let windows = [true, step < tenth, step + tenth >= steps];
            for (maximum, _) in largest
                .iter_mut()
                .zip(windows)
                .filter(|(_, inside)| *inside)
            {
                // Keeps a NaN: a value that is lost is not a small deviation.
                *maximum = larger(*maximum, change);
            }
        }
    }
    let drift = |(initial, [largest, first, last]): (f64, [f64; 3])| InvariantDrift {
        initial,
        largest,
        growth: (first > 0.0).then(|| last / first),
    };
    Ok(initial.into_iter().zip(largest).map(drift).collect())
}

/// Roundings of a Casimir's terms that a step may add to it, all of one sign.
const OF_A_STEP: f64 = 64.0;

/// Steps whose round-off the first ones may have at once.
const FIRST: f64 = 16.0;

/// The most that round-off moves a Casimir, whose terms have this size, in so many steps of a map that keeps it.
pub fn casimir_round_off(size: f64, steps: u64) -> f64 {
    OF_A_STEP * f64::EPSILON * (steps as f64 + FIRST) * size
}

/// The size of each Casimir's terms along `states`: the largest |C| + Σ_i |x_i ∂C/∂x_i|, of which its round-off is a part. Of
/// numbers that offer no gradients it is |C|.
///
/// # Errors
/// [`BuildError`] where a formula has no code.
pub fn casimir_sizes(
    system: &PoissonSystem,
    parameters: &[f64],
    states: &[Vec<f64>],
) -> Result<Vec<f64>, BuildError> {
    let count = system.casimir_names().len();
    let mut sizes = vec![0.0_f64; count];
    if count == 0 {
        return Ok(sizes);
    }
    let mut evaluator = system.numbers()?.evaluator(parameters);
    for x in states {
        let (mut values, mut slopes) = (vec![0.0; count], vec![0.0; count * x.len()]);
        if evaluator.casimirs(x, &mut values).is_err() {
            continue;
        }
        if evaluator.casimir_gradients(x, &mut slopes).is_err() {
            slopes.fill(0.0);
        }
        let rows = slopes.chunks_exact(x.len());
        for (size, (value, row)) in sizes.iter_mut().zip(values.iter().zip(rows)) {
            let terms = row.iter().zip(x).map(|(slope, x)| (slope * x).abs());
            let sum = value.abs() + terms.sum::<f64>();
            // What has no value bounds nothing.
            *size = if sum.is_finite() {
                size.max(sum)
            } else {
                *size
            };
        }
    }
    Ok(sizes)
}
