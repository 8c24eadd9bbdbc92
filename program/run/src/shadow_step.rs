//! The longest step that keeps a shadow energy as well as asked: no reference solution is needed.
//!
//! H̃ of order p changes by C tᵖ over a time: from one step and its change follows the step with another change.

use leafwise_core::BuildError;
use leafwise_scene::compose::{ComposedRun, NoShadow, ShadowEnergy};
use thiserror::Error;

use crate::error::RunError;
use crate::shadow::ShadowVerdict;

/// Steps that are tried.
const MOST_TRIALS: usize = 40;

/// The part of the tolerance that a step may leave unused.
const NEAR: f64 = 0.25;

/// The part of it that is aimed at.
const AIM: f64 = 0.7;

/// The fewest steps to the end.
const FEWEST: f64 = 16.0;

/// The most.
const MOST: f64 = 1e7;

/// A step, and what is kept with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowStep {
    /// εh.
    pub time_step: f64,
    /// Steps to the end of the run.
    pub steps: u64,
    /// How both energies are kept.
    pub verdict: ShadowVerdict,
}

/// Why there is none.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NoShadowStep {
    /// There is no shadow Hamiltonian.
    #[error("{}", .0.message)]
    Shadow(NoShadow),
    /// Shorter steps do not keep it better.
    #[error(
        "with steps of {time_step:e} the shadow energy changes by {change:.1e}, and shorter ones do not keep it better: round-off, or a realization that is not exact"
    )]
    Floor {
        /// The shortest step that was tried.
        time_step: f64,
        /// Change of H̃ there.
        change: f64,
    },
    /// The steps are too many.
    #[error("it takes more than 1e7 steps")]
    TooShort,
    /// A formula without code.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl ShadowStep {
    /// For a run's method over its time, H̃ of the default order changing by at most `tolerance`; the step is of the sign of the
    /// run's own.
    ///
    /// # Errors
    /// [`NoShadowStep`].
    pub fn find(run: &ComposedRun, tolerance: f64) -> Result<Self, NoShadowStep> {
        let mut run = run.clone();
        let own = run.plan.epsilon * run.plan.h;
        let time = own * run.plan.steps as f64;
        let longest = time / FEWEST;
        let mut t = if own.abs() < longest.abs() {
            own
        } else {
            longest
        };
        let mut best: Option<Self> = None;
        let mut shortest_bad: Option<(f64, f64)> = None;
        for _ in 0..MOST_TRIALS {
            if time / t > MOST {
                break;
            }
            let tried = Self::tried(&mut run, t, time)?;
            let change = tried.verdict.shadow;
            let ratio = if change > 0.0 {
                AIM * tolerance / change
            } else {
                f64::INFINITY
            };
            let scale = libm::pow(ratio, 1.0 / tried.verdict.order as f64);
            let is_whole = tried.steps as f64 >= libm::floor(time / t);
            if is_whole && tried.verdict.is_in_range && change <= tolerance {
                best = Some(tried);
                let next = t * scale.min(2.0);
                let is_tried = shortest_bad.is_some_and(|(bad, _)| next.abs() >= bad.abs());
                if change >= NEAR * tolerance || next.abs() > longest.abs() || is_tried {
                    break;
                }
                t = next;
                continue;
            }
            if best.is_some() {
                break;
            }
            // A tenth shorter at least: what should fall by a good part.
            if let Some((before, largest)) = shortest_bad
                && is_whole
                && tried.verdict.is_in_range
                && change > 0.5 * largest
                && t.abs() < 0.8 * before.abs()
            {
                return Err(NoShadowStep::Floor {
                    time_step: t,
                    change,
                });
            }
            shortest_bad = Some((t, if is_whole { change } else { f64::INFINITY }));
            let scale = if scale.is_finite() { scale } else { 0.5 };
            t *= scale.clamp(0.1, 0.75);
        }
        best.ok_or(NoShadowStep::TooShort)
    }

    fn tried(run: &mut ComposedRun, t: f64, time: f64) -> Result<Self, NoShadowStep> {
        run.plan.h = t / run.plan.epsilon;
        let shadow = ShadowEnergy::of(&run.system, run.method.map(), t, None);
        let shadow = shadow.map_err(NoShadowStep::Shadow)?;
        let asked = libm::ceil(time / t) as u64;
        let (verdict, steps, _) = ShadowVerdict::measured(run, &shadow, asked)?;
        Ok(Self {
            time_step: t,
            steps,
            verdict,
        })
    }
}

impl From<BuildError> for NoShadowStep {
    fn from(error: BuildError) -> Self {
        Self::Run(error.into())
    }
}
