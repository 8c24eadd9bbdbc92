//! Invariants along an orbit: the largest deviation over every step, and whether it grows.

use crate::error::StepError;
use crate::integrator::Integrator;
use crate::observe::Observe;
use crate::solver::judge::larger;

/// How far an invariant moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvariantDrift {
    /// I(x_0).
    pub initial: f64,
    /// max_k |I(x_k) − I(x_0)| over every step.
    pub largest: f64,
    /// The maximum over the last tenth of the steps over that of the first: near 1 for a bounded
    /// error, √10 for a random walk, 10 and more for a secular drift. `None` where the first is 0.
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

/// Steps `integrator` and watches every observable at every step.
///
/// # Errors
/// The map's [`StepError`].
pub fn measure_drift(
    integrator: &mut Integrator,
    observer: &mut dyn Observe,
    steps: usize,
) -> Result<Vec<InvariantDrift>, StepError> {
    let count = observer.observables();
    let (mut initial, mut now) = (vec![0.0; count], vec![0.0; count]);
    observer.evaluate(integrator.state(), &mut initial);
    let tenth = steps.div_ceil(10);
    let mut largest = vec![[0.0_f64; 3]; count];
    for step in 0..steps {
        integrator.step()?;
        observer.evaluate(integrator.state(), &mut now);
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
