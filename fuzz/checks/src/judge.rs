//! Verdict on the result of a random scene: right, refused, warned of, or silently wrong.
//!
//! A result is *confirmed* when an independent solution agrees with it. It is so too when its error against that
//! solution is part of the motion only and falls as the step is halved up to six times. For an adaptive stepper the
//! tolerance is lowered instead. Where a result is not confirmed, the program must have refused, failed or warned.
//! Where the motion is too stiff for that solution, or that solution does not keep the energy, the halved steps confirm
//! the result.
//!
//! A small error from a place that the motion passes within less than a 64th of a step is *unresolved*: no halved step
//! sees it. A gross error is unresolved where such a place, a wall, is reached a little earlier or later. Whoever
//! promises a Poisson map keeps the Casimirs and, where the tensor does, the signs.

use std::panic::{AssertUnwindSafe, catch_unwind};

use leafwise::core::{Registry, StepError, Structure, Walk};
use leafwise::run::{AdviceKind, RunOptions, RunOutcome};
use leafwise::run::{Quiet, RunJob, perform};
use leafwise::scene::{ComposedRun, SceneChecks, SceneDocument, compose};

use crate::dual::Dual;
use crate::reference::{Solution, solution};
use crate::scene::{RandomScene, STEPS};

/// Outcome of a random scene, judged; each with its kind.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Refused before the first step.
    Refused(String),
    /// A step failed with a typed error.
    Failed(String),
    /// Not confirmed, and the report warns.
    Warned(String),
    /// Right.
    Confirmed,
    /// A small error from a place that is passed within less than a 64th of a step.
    Unresolved,
    /// Neither refused nor warned of, and not confirmed.
    Suspicious(String),
}

/// An error below this part of the state is the method's accuracy, whatever its order.
const ACCURATE: f64 = 1e-9;

/// An error of so many tolerances is an adaptive stepper's own: each of its substeps adds one.
const TOLERANCES: f64 = 1e3;

/// An error above this part of the motion is gross: the step says nothing of the flow.
const GROSS: f64 = 0.5;

/// Largest ratio of an error to the one two halvings before, for an error that falls: order 1, the lowest there is,
/// gives 1/4.
const FALLS: f64 = 0.4;

/// How often steps are halved.
const HALVINGS: u32 = 6;

/// The error relative to the motion below which a place passed within a fraction of a step is unresolved.
const UNRESOLVED: f64 = 1e-3;

/// The distance, relative to the motion, from the states of the last step below which a wall was met a
/// little earlier or later.
const EARLIER: f64 = 0.05;

/// Largest drift of a promised Casimir, or of the energy of an independent solution, relative to its terms.
const DRIFT: f64 = 1e-9;

/// Judges a scene; a panic is suspicious.
pub fn judge(scene: &RandomScene, registry: &Registry) -> Verdict {
    let judged = catch_unwind(AssertUnwindSafe(|| judged(scene, registry)));
    judged.unwrap_or_else(|_| Verdict::Suspicious("it panics".to_owned()))
}

fn judged(scene: &RandomScene, registry: &Registry) -> Verdict {
    let document = match SceneDocument::parse("scene.toml", &scene.text, registry) {
        Ok(document) => document,
        Err(errors) => {
            let first = errors
                .diagnostics()
                .first()
                .map(|first| kind(&first.message));
            return Verdict::Refused(first.unwrap_or_default());
        }
    };
    let composed = match compose(&document, registry) {
        Ok(composed) => composed,
        Err(refusal) => return Verdict::Refused(kind(&refusal.message)),
    };
    let checks = match SceneChecks::of(&composed.system, &composed.near) {
        Ok(checks) => checks,
        Err(error) => return Verdict::Refused(kind(&error.to_string())),
    };
    if let Some(refusal) = checks.refusal(&document, (&composed.system, &composed.near), false) {
        return Verdict::Suspicious(format!("a true tensor is refused: {}", refusal.message));
    }
    let end = match end(scene, &composed, STEPS) {
        Ok(end) => end,
        Err(error) => return Verdict::Failed(failure(&error).to_owned()),
    };
    match doubt(scene, registry, &composed, &end) {
        None => Verdict::Confirmed,
        Some(Doubt::Unresolved) => Verdict::Unresolved,
        Some(Doubt::Wrong(why)) => reported(&document, &composed, registry, why),
    }
}

/// Runs a scene whose result is in doubt, and gives the verdict by the program's own report: refused, failed, warned
/// of, or suspicious with the `doubt`.
fn reported(
    document: &SceneDocument,
    composed: &ComposedRun,
    registry: &Registry,
    doubt: String,
) -> Verdict {
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(error) => return Verdict::Refused(format!("no folder: {error}")),
    };
    let options = RunOptions::within(folder.path().join("run"));
    let job = RunJob::new(document, composed, registry, &options);
    let report = match job.and_then(|job| perform(&job, &mut Quiet)) {
        Ok(report) => report,
        Err(error) => return Verdict::Refused(kind(&error.to_string())),
    };
    if let RunOutcome::Failed(failure) = report.outcome {
        return Verdict::Failed(kind(&failure.message));
    }
    let warns = |kind: &AdviceKind| {
        matches!(
            kind,
            AdviceKind::CoarseStep
                | AdviceKind::RoundOff
                | AdviceKind::EnergyError
                | AdviceKind::Chart
                | AdviceKind::SeveralSolutions
                | AdviceKind::RealizationDefect
        )
    };
    let kinds = report.advice.iter().map(|advice| advice.kind);
    let kinds: Vec<String> = kinds
        .filter(warns)
        .map(|kind| format!("{kind:?}"))
        .collect();
    match kinds.is_empty() {
        true => Verdict::Suspicious(doubt),
        false => Verdict::Warned(kinds.join(" + ")),
    }
}

/// The state after the scene's time in so many steps, in the units of its meaning.
fn end(scene: &RandomScene, run: &ComposedRun, steps: usize) -> Result<Vec<f64>, StepError> {
    let values = run.system.parameter_values();
    let (plan, map) = (&run.plan, run.method.map());
    let h = plan.h * STEPS as f64 / steps as f64;
    let mut walk = Walk::new(map, &values, plan.epsilon, h, &plan.initial);
    for _ in 0..steps {
        walk.step()?;
    }
    let own = walk.state().iter().zip(&scene.units);
    Ok(own.map(|(x, unit)| x / unit).collect())
}

/// Why a result is not confirmed.
enum Doubt {
    Wrong(String),
    Unresolved,
}

/// The scene with a tolerance of 10⁻²ⁿ times its own.
fn tightened(scene: &RandomScene, registry: &Registry, n: u32) -> Option<ComposedRun> {
    let tolerance = (scene.tolerance * libm::pow(1e-2, f64::from(n))).max(1e-14);
    let written = |tolerance: f64| format!("tolerance = {tolerance:?}");
    let text = scene
        .text
        .replace(&written(scene.tolerance), &written(tolerance));
    let document = SceneDocument::parse("scene.toml", &text, registry).ok()?;
    compose(&document, registry).ok()
}

/// Why a result is not confirmed, if it is not.
fn doubt(
    scene: &RandomScene,
    registry: &Registry,
    run: &ComposedRun,
    end_state: &[f64],
) -> Option<Doubt> {
    if let Some(broken) = broken_promise(scene, run, end_state) {
        return Some(Doubt::Wrong(broken));
    }
    let mut widest: Vec<f64> = scene.initial.iter().map(|x| x.abs()).collect();
    let field = |x: &[f64]| scene.field(x);
    let solution = solution(&field, &scene.initial, scene.time_step, STEPS, &mut widest);
    let solution = solution.filter(|solution| keeps_energy(scene, &solution.states));
    if solution.is_none() {
        for (widest, x) in widest.iter_mut().zip(end_state) {
            *widest = widest.max(x.abs());
        }
    }
    let least = 1e-6 * widest.iter().fold(0.0_f64, |m, x| m.max(*x));
    let largest = |a: &[f64], b: &[f64]| {
        let apart = (0..a.len()).map(|i| (a[i] - b[i]).abs() / widest[i].max(least));
        apart.fold(0.0_f64, |m, e| if e > m || e.is_nan() { e } else { m })
    };
    // Steps halved; of an adaptive stepper, whose step is its own, tolerances of a hundredth.
    let refined = |times: u32| match scene.tolerance > 0.0 {
        true => tightened(scene, registry, times).and_then(|run| end(scene, &run, STEPS).ok()),
        false => end(scene, run, STEPS << times).ok(),
    };
    let Some(Solution {
        states,
        shortest,
        ends,
    }) = solution
    else {
        // Too stiff for the independent solution: the refined ones are to confirm it.
        let (Some(half), Some(quarter)) = (refined(1), refined(2)) else {
            // Nor can tolerances be tightened: two of half a step are to agree.
            let half = end(scene, run, STEPS << 1).ok();
            let is_near = half.is_some_and(|half| largest(end_state, &half) <= UNRESOLVED);
            return Some(match is_near {
                true => Doubt::Unresolved,
                false => Doubt::Wrong("the motion cannot be followed to the end".to_owned()),
            });
        };
        let (whole, rest) = (largest(end_state, &half), largest(&half, &quarter));
        let own = TOLERANCES * scene.tolerance;
        let is_confirmed = rest <= ACCURATE.max(own) || whole <= GROSS && rest <= FALLS * whole;
        return (!is_confirmed).then(|| {
            Doubt::Wrong(format!("the motion cannot be followed to the end: refined ones differ by {whole:.1e}, {rest:.1e}"))
        });
    };
    let last = &states[STEPS];
    let motion = states
        .iter()
        .map(|x| largest(x, &scene.initial))
        .fold(0.0, f64::max);
    let error = largest(end_state, last);
    if error <= TOLERANCES * scene.tolerance
        || error <= ACCURATE * motion.max(1e-3)
        || error <= 64.0 * f64::EPSILON
        || error <= projected(scene, end_state)
    {
        return None;
    }
    let mut errors = vec![error];
    if error <= GROSS * motion {
        for times in 1..=HALVINGS {
            let error = refined(times).map_or(f64::NAN, |end| largest(&end, last));
            errors.push(error);
            if falls(&errors) {
                return None;
            }
        }
        if errors[1..].iter().all(|error| error.is_nan()) {
            // Shorter steps are refused, as those that end beside 0/0: longer ones are to show the order.
            let longer = end(scene, run, STEPS / 2).map_or(f64::NAN, |end| largest(&end, last));
            if error <= FALLS * longer {
                return None;
            }
            errors.push(longer);
        }
    }
    let nearest = ends.iter().map(|x| largest(end_state, x));
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    let is_near = error <= UNRESOLVED * motion || nearest <= EARLIER * motion;
    if is_near && shortest < 1.0 / f64::from(1_u32 << HALVINGS) {
        return Some(Doubt::Unresolved);
    }
    let history: Vec<String> = errors.iter().map(|error| format!("{error:.1e}")).collect();
    let history = format!("errors {} of a motion of {motion:.1e}", history.join(", "));
    Some(Doubt::Wrong(match errors.len() {
        1 => format!("a gross error: {history}"),
        _ => format!("an error that does not fall: {history}"),
    }))
}

/// Whether the energy is kept along an independent solution: its slopes may overflow or vanish on the way,
/// and its steps miss what is narrow.
fn keeps_energy(scene: &RandomScene, states: &[Vec<f64>]) -> bool {
    let energies: Vec<Dual> = states.iter().map(|x| scene.hamiltonian.dual(x)).collect();
    let size = |(dual, x): (&Dual, &Vec<f64>)| terms(dual, x);
    let size = energies.iter().zip(states).map(size).fold(0.0, f64::max);
    let first = energies.first().map_or(0.0, Dual::value);
    let mut drifts = energies.iter().map(|dual| (dual.value() - first).abs());
    drifts.all(|drift| drift <= DRIFT * size)
}

/// Change of a coordinate by a projection onto the energy of `scene` where the energy has its round-off, relative to
/// the coordinate: δH over Σ |x_i ∂H/∂x_i|. It is large where a constant outweighs what moves.
fn projected(scene: &RandomScene, x: &[f64]) -> f64 {
    if !scene.text.contains("name = \"projection\"") {
        return 0.0;
    }
    let energy = scene.hamiltonian.dual(x);
    let whole = terms(&energy, x);
    (16.0 * f64::EPSILON * whole / (whole - energy.value().abs())).min(UNRESOLVED * UNRESOLVED)
}

/// |f| + Σ |x_i ∂f/∂x_i|.
fn terms(dual: &Dual, x: &[f64]) -> f64 {
    let terms = x.iter().enumerate();
    let terms = terms.map(|(i, x)| (dual.slope(i) * x).abs());
    terms.sum::<f64>() + dual.value().abs()
}

/// Whether the errors of steps halved again and again fall. The last one is small, or has fallen over four halvings; or
/// it has fallen over two and below the first, which may happen to be small.
fn falls(errors: &[f64]) -> bool {
    if let Some([before, .., last]) = errors.last_chunk::<5>()
        && *last <= FALLS * FALLS * before
    {
        return true;
    }
    let Some([before, _, last]) = errors.last_chunk() else {
        return false;
    };
    *last <= ACCURATE || *last <= FALLS * before && *last <= FALLS * errors[0]
}

/// A Casimir or a sign that an exact Poisson map has not kept.
fn broken_promise(scene: &RandomScene, run: &ComposedRun, end: &[f64]) -> Option<String> {
    let map = run.method.map();
    if map.properties().structure != Structure::Exact {
        return None;
    }
    let tensor = &scene.tensor;
    if tensor.is_positive && end.iter().any(|x| *x <= 0.0) {
        return Some(format!("a sign is lost by a map that keeps it: {end:?}"));
    }
    for casimir in &tensor.casimirs {
        let (before, after) = (casimir.dual(&scene.initial), casimir.dual(end));
        let size = terms(&before, &scene.initial) + terms(&after, end);
        let drift = (before.value() - after.value()).abs();
        let is_kept = drift <= DRIFT * size;
        if !is_kept {
            return Some(format!(
                "a Casimir drifts by {:.1e} of its terms",
                drift / size
            ));
        }
    }
    None
}

fn failure(error: &StepError) -> &'static str {
    match error {
        StepError::NoConvergence { .. } => "no convergence",
        StepError::LeftChart { .. } => "left the chart",
        StepError::OtherBranch { .. } => "another branch",
        StepError::LostSign { .. } => "lost sign",
        StepError::Pole { .. } => "pole",
        StepError::Singularity { .. } => "singularity",
        StepError::NonFinite { .. } => "not finite",
        _ => "another failure",
    }
}

/// The message's first words, without what is quoted and without numbers: messages of one kind are one.
fn kind(message: &str) -> String {
    let outside: String = message.split('`').step_by(2).collect::<Vec<_>>().join("…");
    let words = outside.split_whitespace().take(7);
    let plain = words.map(|word| {
        let has_digit = word.chars().any(|c| c.is_ascii_digit());
        if has_digit { "#" } else { word }
    });
    plain.collect::<Vec<_>>().join(" ")
}
