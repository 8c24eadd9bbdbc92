//! One step map on one problem.

use std::time::Instant;

use leafwise_core::diagnostics::{
    InvariantDrift, Slope, TensorDefect, fit_slope, measure_drift, self_adjointness_defect,
};
use leafwise_core::system::SystemInvariants;
use leafwise_core::{Integrator, MapProperties, StepError, StepMap, Structure};
use serde::Serialize;

use super::problem::Problem;

/// Whether a declaration is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// The measurement agrees.
    Met,
    /// It does not.
    NotMet,
    /// Nothing was declared, or nothing could be measured.
    Open,
}

/// What was measured of a step map.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The order in t, fitted to global errors over a fixed time; `None` where every error is
    /// round-off or too few are above it.
    pub order: Option<f64>,
    /// Its standard error.
    pub order_error: Option<f64>,
    /// The smallest error seen.
    pub smallest_error: f64,
    /// The order n of the tensor defect O(tⁿ⁺¹) of one step; `None` where it is round-off.
    pub structure_order: Option<f64>,
    /// The tensor defect of a step of the problem's size, relative to the tensor; `None` where the
    /// map offers no tangent.
    pub tensor_defect: Option<f64>,
    /// ‖Φ_{−h}(Φ_h(x)) − x‖ relative to x.
    pub self_adjointness: f64,
    /// The largest |C(x_k) − C(x_0)| over all Casimirs and steps, relative.
    pub casimir_drift: f64,
    /// The same of the energy.
    pub energy_drift: f64,
    /// The energy's largest deviation over the last tenth of the steps over that of the first.
    pub energy_growth: Option<f64>,
    /// Solver evaluations a step.
    pub evaluations_per_step: f64,
    /// Nanoseconds a step, interpreter and observers apart.
    pub nanoseconds_per_step: f64,
    /// Order as declared, structure as declared, symmetry as declared.
    pub judgements: [Judgement; 3],
}

/// The number of steps over which drift and cost are measured.
const DRIFT_STEPS: usize = 1000;

/// Round-off of a defect in units of u: products of up to a dozen factors, a few dozen of them, and
/// the solve.
const ROUND_OFF: f64 = 256.0;

/// Measures a step map on a problem; `flow` is the state after `horizon` by another method.
///
/// # Errors
/// The map's [`StepError`] when not even small steps succeed.
pub fn measure(
    problem: &Problem,
    map: &dyn StepMap,
    flow: &[f64],
    horizon: f64,
) -> Result<Measured, StepError> {
    let declared = map.properties();
    let Convergence { errors, order } = global_order(problem, map, flow, horizon)?;
    let smallest_error = errors.iter().map(|e| e.1).fold(f64::INFINITY, f64::min);
    let defects = defects(problem, map);
    let values = problem.system.parameter_values();
    let (t, start) = (problem.time_step, &problem.initial);
    let self_adjointness = self_adjointness_defect(map, &values, 1.0, t, start)?;
    let run = drift(problem, map)?;
    let structure_order = defects.slope.map(|slope| slope.exponent - 1.0);
    let judgements = [
        judge_order(declared, order, &errors),
        judge_structure(declared, &defects),
        judge_symmetry(declared, self_adjointness),
    ];
    Ok(Measured {
        order: order.map(|slope| slope.exponent),
        order_error: order.map(|slope| slope.standard_error),
        smallest_error,
        structure_order,
        tensor_defect: defects.at_step,
        self_adjointness,
        casimir_drift: run.casimirs,
        energy_drift: run.energy,
        energy_growth: run.growth,
        evaluations_per_step: run.evaluations,
        nanoseconds_per_step: run.nanoseconds,
        judgements,
    })
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    a.iter()
        .zip(b)
        .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()))
        / size
}

/// Global errors (t, error) and the order fitted to them.
struct Convergence {
    errors: Vec<(f64, f64)>,
    order: Option<Slope>,
}

/// Global errors over `horizon` at a geometric sequence of steps, and the fitted order.
fn global_order(
    problem: &Problem,
    map: &dyn StepMap,
    flow: &[f64],
    horizon: f64,
) -> Result<Convergence, StepError> {
    let values = problem.system.parameter_values();
    let mut errors = Vec::new();
    let mut failure = None;
    for steps in [8_u32, 12, 18, 27, 40, 60, 90, 135, 200, 300] {
        let t = horizon / f64::from(steps);
        let mut integrator = Integrator::new(map, &values, 1.0, t, &problem.initial);
        let outcome = (0..steps).try_for_each(|_| integrator.step());
        match outcome {
            Ok(()) => errors.push((t, distance(integrator.state(), flow))),
            // Large steps may leave a chart; the smaller ones count.
            Err(error) => failure = Some(error),
        }
    }
    if let (true, Some(error)) = (errors.is_empty(), failure) {
        return Err(error);
    }
    // The asymptotic regime: errors below a hundredth.
    let asymptotic: Vec<_> = errors.iter().copied().filter(|e| e.1 < 1e-2).collect();
    let order = fit_slope(&asymptotic, 64.0 * f64::EPSILON);
    Ok(Convergence { errors, order })
}

/// The order is a lower bound; the next term of the error may hide a quarter of an order in the
/// range of steps that is measured.
fn judge_order(declared: MapProperties, order: Option<Slope>, errors: &[(f64, f64)]) -> Judgement {
    let round_off = errors.iter().filter(|e| e.1 < 64.0 * f64::EPSILON).count();
    match order {
        Some(slope) => {
            let tolerance = 0.25 + 3.0 * slope.standard_error;
            judgement(slope.exponent >= declared.order as f64 - tolerance)
        }
        None if round_off > errors.len() / 2 => Judgement::Met,
        None => Judgement::Open,
    }
}

struct Defects {
    at_step: Option<f64>,
    slope: Option<Slope>,
    /// Whether every defect is round-off; `None` where none could be measured.
    round_off: Option<bool>,
}

/// Tensor defects of one step, relative to the tensor, over a sequence of step sizes.
fn defects(problem: &Problem, map: &dyn StepMap) -> Defects {
    let values = problem.system.parameter_values();
    let mut points = Vec::new();
    let mut at_step = None;
    let mut worst = 0.0_f64;
    for k in 0..10 {
        let t = problem.time_step * libm::exp2(1.0 - 0.5 * f64::from(k));
        let Ok(mut instrument) = TensorDefect::new(&problem.system, map, &values, 1.0, t) else {
            continue;
        };
        let Ok(defect) = instrument.measure(&problem.initial) else {
            continue;
        };
        if let Some(relative) = defect.relative() {
            points.push((t, relative));
            worst = worst.max(relative);
            if k == 2 {
                at_step = Some(relative);
            }
        }
    }
    let plateau = ROUND_OFF * f64::EPSILON;
    let round_off = if points.is_empty() {
        None
    } else {
        Some(worst <= plateau)
    };
    Defects {
        at_step,
        slope: fit_slope(&points, plateau),
        round_off,
    }
}

fn judge_structure(declared: MapProperties, defects: &Defects) -> Judgement {
    match (declared.structure, defects.round_off) {
        (_, None) | (Structure::None, _) => Judgement::Open,
        (_, Some(true)) => Judgement::Met,
        (Structure::Exact, Some(false)) => Judgement::NotMet,
        (Structure::Order(n), Some(false)) => match defects.slope {
            None => Judgement::Open,
            Some(slope) => {
                let tolerance = 0.25 + 3.0 * slope.standard_error;
                judgement(slope.exponent >= n as f64 + 1.0 - tolerance)
            }
        },
    }
}

fn judge_symmetry(declared: MapProperties, defect: f64) -> Judgement {
    match declared.self_adjoint {
        Some(true) => judgement(defect <= ROUND_OFF * f64::EPSILON),
        Some(false) | None => Judgement::Open,
    }
}

fn judgement(met: bool) -> Judgement {
    if met {
        Judgement::Met
    } else {
        Judgement::NotMet
    }
}

struct Drift {
    energy: f64,
    growth: Option<f64>,
    casimirs: f64,
    evaluations: f64,
    nanoseconds: f64,
}

fn drift(problem: &Problem, map: &dyn StepMap) -> Result<Drift, StepError> {
    let values = problem.system.parameter_values();
    let start = || Integrator::new(map, &values, 1.0, problem.time_step, &problem.initial);
    let mut integrator = start();
    let started = Instant::now();
    for _ in 0..DRIFT_STEPS {
        integrator.step()?;
    }
    let nanoseconds = started.elapsed().as_secs_f64() * 1e9 / DRIFT_STEPS as f64;
    let evaluations = integrator.statistics().evaluations_per_step();
    let invariants = match SystemInvariants::new(&problem.system, &values) {
        Ok(mut observer) => measure_drift(&mut start(), &mut observer, DRIFT_STEPS)?,
        Err(_) => Vec::new(),
    };
    Ok(Drift {
        energy: invariants
            .first()
            .map_or(f64::NAN, InvariantDrift::relative),
        growth: invariants.first().and_then(|energy| energy.growth),
        casimirs: invariants
            .iter()
            .skip(1)
            .map(InvariantDrift::relative)
            .fold(0.0, f64::max),
        evaluations,
        nanoseconds,
    })
}
