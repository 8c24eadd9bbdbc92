//! One run of one method: what it costs and what it keeps.

use leafwise_core::solver::judge::larger;
use std::mem::discriminant;
use std::time::Instant;

use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::{BuildError, SolverStatistics, StepError};
use leafwise_scene::ComposedRun;
use leafwise_scene::compose::Stepping;
use serde::Serialize;

use super::arrival::{arrive, walk};
use super::candidate::Bench;
use super::curve::Curve;

/// Why a run did not reach its end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrialFailure {
    /// The method does not fit the scene.
    #[error("{reason}")]
    DoesNotFit {
        /// Why, in words.
        reason: String,
    },
    /// A step could not be taken.
    #[error("step {step}: {error}")]
    Step {
        /// The steps before it.
        step: u64,
        /// The solver's error.
        error: StepError,
    },
    /// An invariant has no finite value.
    #[error("step {step}: an invariant is not finite")]
    NotFinite {
        /// The steps before it.
        step: u64,
    },
    /// The run costs more than it was allowed to.
    #[error("it takes more than {budget:.1e} operations: stopped at step {step} of {steps}")]
    OverBudget {
        /// Budget of the run, in operations.
        budget: f64,
        /// The steps taken.
        step: u64,
        /// The steps asked for.
        steps: u64,
    },
}

impl TrialFailure {
    /// Whether the run was stopped for its cost alone.
    pub fn is_over_budget(&self) -> bool {
        matches!(self, Self::OverBudget { .. })
    }

    /// Key that failures of one kind share: the variant, and that of the solver's error.
    pub fn kind(&self) -> impl PartialEq + use<> {
        let error = match self {
            Self::Step { error, .. } => Some(discriminant(error)),
            _ => None,
        };
        (discriminant(self), error)
    }
}

/// Result of a run: its end state, its work, its drifts and its largest error.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// x at the end.
    pub state: Vec<f64>,
    /// State that the map has stepped to: x, and the time with its energy where H names it.
    pub(super) stepped: Vec<f64>,
    /// The solver's work.
    pub statistics: SolverStatistics,
    /// max |I(x_k) − I(x_0)| over every step, the energy's first.
    pub drift: Vec<f64>,
    /// max ‖x_k − x*(t_k)‖ over every step, where the run was compared with a reference at every one.
    pub largest_error: Option<f64>,
}

impl Trial {
    /// The cost by which runs are compared: counted operations, or evaluations where a part does
    /// not count its own.
    pub fn cost(&self) -> u64 {
        self.statistics.cost()
    }
}

/// A run stops early when this fraction of it foresees twice its budget.
const FORESEEN: u64 = 8;

/// Takes `steps` steps of εh and watches the invariants at every one; stops once `budget`
/// operations are spent, or clearly will be.
///
/// # Errors
/// [`TrialFailure`], with the step.
pub fn run_trial(
    bench: &Bench<'_>,
    run: &ComposedRun,
    sizes: [f64; 2],
    steps: u64,
    budget: u64,
) -> Result<Trial, TrialFailure> {
    run_counted(bench, run, sizes, steps, budget, None, &mut 0)
}

/// [`run_trial`], compared with a curve at every step, and with its cost added to `spent` whether it comes to its
/// end or not.
pub(super) fn run_counted(
    bench: &Bench<'_>,
    run: &ComposedRun,
    [epsilon, h]: [f64; 2],
    steps: u64,
    budget: u64,
    curve: Option<&Curve>,
    spent: &mut u64,
) -> Result<Trial, TrialFailure> {
    let unfit = |error: BuildError| TrialFailure::DoesNotFit {
        reason: error.to_string(),
    };
    let mut observer = run.invariants().map_err(unfit)?;
    let mut walk = walk(run, epsilon, h);
    let place = run.time_place();
    let count = observer.observables();
    let (mut initial, mut now) = (vec![0.0; count], vec![0.0; count]);
    observer.evaluate(walk.state(), &mut initial);
    let mut drift = vec![0.0_f64; count];
    let before = *spent;
    let own = run.plan.layout.coordinates();
    let (mut largest_error, mut buffer) = (0.0, vec![0.0; own + 1]);
    let ended = walk.watch_until(steps, |walk| {
        let (taken, own) = (walk.steps(), walk.statistics().cost());
        let foreseen = own as f64 * (steps as f64 / taken as f64);
        let is_hopeless = taken >= steps / FORESEEN && foreseen > 2.0 * budget as f64;
        if own > budget || is_hopeless {
            return Some(TrialFailure::OverBudget {
                budget: budget as f64,
                step: taken,
                steps,
            });
        }
        observer.evaluate(walk.state(), &mut now);
        for ((drift, now), initial) in drift.iter_mut().zip(&now).zip(&initial) {
            let change = (now - initial).abs();
            if !change.is_finite() {
                return Some(TrialFailure::NotFinite { step: taken });
            }
            *drift = drift.max(change);
        }
        if let Some(curve) = curve {
            let part = taken as f64 / steps as f64;
            let state = walk.state();
            let time = place.map(|place| state[place]);
            let error = curve.distance(part, (run.own(state), time), &mut buffer);
            // A NaN is no small error.
            largest_error = larger(largest_error, error);
        }
        None
    });
    *spent = before + walk.statistics().cost();
    let step = walk.steps();
    let failure = ended.map_err(|error| TrialFailure::Step { step, error })?;
    if let Some(failure) = failure {
        return Err(failure);
    }
    // With a pace every method is at another time then.
    let failed = |error| TrialFailure::Step { step: steps, error };
    let (_, stepped) = match place {
        Some(_) => arrive(run, epsilon, walk.state(), bench.time()).map_err(failed)?,
        None => (0.0, walk.state().to_vec()),
    };
    Ok(Trial {
        largest_error: curve.map(|_| largest_error),
        state: run.own(&stepped).to_vec(),
        stepped,
        statistics: walk.statistics(),
        drift,
    })
}

/// How long a run took, without observers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Wall {
    /// The median of the repetitions, in seconds.
    #[serde(rename = "median")]
    pub seconds: f64,
    /// The largest less the smallest, in seconds.
    pub spread: f64,
    /// How often it was measured.
    pub repetitions: usize,
}

/// Takes `steps` steps of εh without observers, `repetitions` times.
///
/// # Errors
/// [`TrialFailure::Step`].
pub fn time_run(
    run: &ComposedRun,
    epsilon: f64,
    h: f64,
    steps: u64,
    repetitions: usize,
) -> Result<Wall, TrialFailure> {
    let mut seconds = Vec::with_capacity(repetitions.max(1));
    for _ in 0..repetitions.max(1) {
        let mut walk = walk(run, epsilon, h);
        let started = Instant::now();
        let outcome = walk.advance(steps);
        let step = walk.steps();
        outcome.map_err(|error| TrialFailure::Step { step, error })?;
        seconds.push(started.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    let (first, last) = (seconds[0], seconds[seconds.len() - 1]);
    Ok(Wall {
        seconds: seconds[seconds.len() / 2],
        spread: last - first,
        repetitions: seconds.len(),
    })
}

/// The largest dimension of a dense tangent map.
const LARGEST_TANGENT: usize = 128;

/// ‖DΦ Π DΦᵀ − Π∘Φ‖, the tensor defect of one cold step, relative to the tensor and the stretch of DΦ: the largest over
/// the states. Returns `None` where the map offers no tangent or a step fails, in contact scenes, on a lattice, and above dimension 128.
pub fn tensor_defect(run: &ComposedRun, time_step: f64, states: &[&[f64]]) -> Option<f64> {
    let is_dense = !matches!(run.method, Stepping::Lattice(_));
    // The tensor of a contact scene is that of its homogeneous system.
    if !is_dense || run.contact.is_some() || run.dimension() > LARGEST_TANGENT {
        return None;
    }
    let values = run.system.parameter_values();
    let map = run.method.map();
    let mut instrument = TensorDefect::new(&run.system, map, &values, 1.0, time_step).ok()?;
    let mut largest = 0.0;
    for state in states {
        let defect = instrument.measure(state).ok()?.relative()?;
        // A NaN is no small defect.
        largest = larger(largest, defect);
    }
    Some(largest)
}
