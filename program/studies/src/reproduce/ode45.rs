//! The rigid body with Dormand–Prince 5(4) (paper, Figure 4).

use leafwise_core::Registry;

use super::drift::{EPSILON, H, STEPS, panels};
use super::error::ReproduceError;
use super::figure::Reproduced;
use super::order::{ErrorCurve, finding, geometric};
use super::paper::PaperFigure;
use super::scene::{History, composed, run_table};

/// Tolerances that are shown.
const TOLERANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];

/// The time over which the order is fitted, and the largest step.
const FIT_TIME: f64 = 6.4;
const FIT_STEP: f64 = 0.1;

/// A tolerance that no step of the fit comes near: each is taken whole.
const LOOSE: f64 = 0.1;

/// Roundings of an invariant along a run.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

fn scene(tolerance: f64, time_step: f64, steps: u64) -> String {
    format!(
        "[system]\nlibrary = \"rigid-body\"\n\n[method]\n\
         stepper   = {{ name = \"dormand-prince45\", tolerance = {tolerance:?} }}\n\
         time-step = {time_step:?}\n\n[run]\n{}",
        run_table(steps)
    )
}

/// Measures Figure 4.
pub(super) fn reproduce(
    paper: &'static PaperFigure,
    registry: &Registry,
) -> Result<Reproduced, ReproduceError> {
    let run = |text: &str| -> Result<History, ReproduceError> {
        History::of(&composed(text, registry)?, paper.number, |_| true)
    };
    let mut histories = Vec::new();
    for tolerance in TOLERANCES {
        let history = run(&scene(tolerance, EPSILON * H, STEPS))?;
        histories.push((format!("tolerance {tolerance:e}"), history));
    }
    let (mut of_energy, mut of_casimir) = (Vec::new(), Vec::new());
    let mut initial = (0.0, 0.0);
    for step in geometric(FIT_STEP, 4, 2) {
        let steps = libm::round(FIT_TIME / step);
        let history = run(&scene(LOOSE, FIT_TIME / steps, steps as u64))?;
        initial = history.initial;
        let (energy, casimir) = history.largest();
        of_energy.push((FIT_TIME / steps, energy));
        of_casimir.push((FIT_TIME / steps, casimir));
    }
    let explanation = "Nothing ties the Casimir to its value: both errors have the method's order, \
                       and both grow with time, where K-HJ keeps the Casimir to round-off and the \
                       energy within a bound.";
    let orders = [(of_casimir, initial.1), (of_energy, initial.0)];
    let mut findings = Vec::new();
    for (claim, (points, size)) in paper.claims.iter().zip(orders) {
        let curve = ErrorCurve {
            points,
            round_off: ROUND_OFF * size,
        };
        let fitted = curve.order(paper.number, 1.0)?;
        findings.push(finding(claim, fitted, 5.0, 0.5, explanation.to_owned()));
    }
    Ok(Reproduced {
        paper,
        panels: panels("Dormand-Prince 5(4)", &histories),
        findings,
        scene: Some(scene(TOLERANCES[1], EPSILON * H, STEPS)),
    })
}
