//! One step map on one problem.

use leafwise_core::diagnostics::{Defect, self_adjointness_defect};
use leafwise_core::{MapProperties, StepError, StepMap, Structure};
use leafwise_scene::json::{double, optional, points};
use serde::{Serialize, Serializer};

use super::convergence::Convergence;
use super::defects::{Defects, StepDefect, step_defect};
use super::drift::Drift;
use super::judgement::Judgement;
use super::kept_energy::KeptEnergy;
use super::order::MeasuredOrder;
use super::problem::Problem;

/// Measurements of a step map on a problem, with their judgements.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The order in t.
    pub order: MeasuredOrder,
    /// Global errors (t, error) over twenty of the problem's steps, relative to the state.
    #[serde(serialize_with = "points")]
    pub errors: Vec<(f64, f64)>,
    /// Whether every error is round-off.
    #[serde(skip)]
    pub is_flow: bool,
    /// The order n of the tensor defect O(tⁿ⁺¹) of one step; empty where it is round-off.
    pub structure: MeasuredOrder,
    /// The step at which the rest is measured: the problem's, or half of it again and again until
    /// the map succeeds.
    #[serde(serialize_with = "double")]
    pub time_step: f64,
    /// Why the problem's step is too large for the map.
    pub too_large: Option<String>,
    /// A solve that fails though a larger step succeeds: no declaration is met by a map that fails so.
    pub broken_solve: Option<String>,
    /// The largest tensor defect of such a step, relative to the tensor, at states along an orbit; `None` where the map
    /// offers no tangent and declares no structure.
    #[serde(serialize_with = "optional")]
    pub tensor_defect: Option<f64>,
    /// ‖Φ_{−h}(Φ_h(x)) − x‖ relative to x.
    #[serde(serialize_with = "double")]
    pub self_adjointness: f64,
    /// The largest |C(x_k) − C(x_0)| over all Casimirs and steps, relative.
    #[serde(serialize_with = "double")]
    pub casimir_drift: f64,
    /// The same of the energy.
    #[serde(serialize_with = "double")]
    pub energy_drift: f64,
    /// The energy's largest deviation over the last tenth of the steps over that of the first.
    #[serde(serialize_with = "optional")]
    pub energy_growth: Option<f64>,
    /// The order to which the shadow energy is kept; `None` where it has no short formula.
    pub shadow_energy: Option<KeptEnergy>,
    /// Solver evaluations a step.
    #[serde(serialize_with = "double")]
    pub evaluations_per_step: f64,
    /// Nanoseconds a step, interpreter and observers apart.
    #[serde(serialize_with = "double")]
    pub nanoseconds_per_step: f64,
    /// Order as declared, structure as declared, symmetry as declared.
    #[serde(serialize_with = "judgements")]
    pub judgements: [Judgement; 3],
}

impl Measured {
    /// Judgements of every declaration: order, structure, symmetry, and the kept shadow energy where it is measured.
    pub fn all_judgements(&self) -> impl Iterator<Item = Judgement> {
        let shadow = self.shadow_energy.as_ref().map(|kept| kept.judgement);
        self.judgements.into_iter().chain(shadow)
    }
}

/// The judgements by their names.
fn judgements<S: Serializer>(judged: &[Judgement; 3], serializer: S) -> Result<S::Ok, S::Error> {
    let names = ["order", "structure", "self_adjoint"];
    serializer.collect_map(names.iter().zip(judged))
}

/// How often the problem's step is halved before a map is said to fail at every one.
const HALVINGS: u32 = 6;

/// Measures a step map on a problem; `flow` is the state after `horizon` by another method. Of a map that makes steps of one length
/// alone, that is `only_step`: an order, which is of steps that shorten, is then open.
///
/// # Errors
/// The map's [`StepError`] when not even small steps succeed.
pub fn measure(
    problem: &Problem,
    map: &dyn StepMap,
    (flow, horizon): (&[f64], f64),
    only_step: Option<f64>,
) -> Result<Measured, StepError> {
    let declared = map.properties();
    let convergence = Convergence::measure(problem, map, (flow, horizon), only_step)?;
    let defects = Defects::measure(problem, map, only_step);
    let halvings = if only_step.is_some() { 0 } else { HALVINGS };
    let run = Run::at_largest_step(problem, map, halvings)?;
    let smooth = problem.smooth_order();
    let judgements = [
        match only_step {
            Some(_) => Judgement::Open,
            None => convergence.judge(declared).on_rough(declared.order, smooth),
        },
        match declared.structure {
            Structure::Leaves => judge_leaves(problem, run.drift.casimirs),
            Structure::Exact => match defects.judge(declared) {
                _ if !run.keeps_structure(defects.round_off()) => Judgement::NotMet,
                judgement => judgement,
            },
            Structure::Order(_) if only_step.is_some() => Judgement::Open,
            Structure::Order(n) => defects.judge(declared).on_rough(n, smooth),
            Structure::Contact | Structure::None => defects.judge(declared),
        },
        judge_symmetry(declared, run.self_adjointness),
    ];
    Ok(Measured {
        order: convergence.order,
        is_flow: convergence.is_round_off(),
        broken_solve: convergence.broken_solve(problem.time_step.abs()),
        errors: convergence.errors,
        structure: defects.order,
        time_step: run.time_step,
        too_large: run.too_large.map(|error| error.to_string()),
        tensor_defect: run.tensor_defect.map(|told| told.defect),
        self_adjointness: run.self_adjointness,
        casimir_drift: run.drift.casimirs,
        energy_drift: run.drift.energy,
        energy_growth: run.drift.growth,
        shadow_energy: match only_step {
            Some(_) => None,
            None => KeptEnergy::measure(problem, map, horizon),
        },
        evaluations_per_step: run.drift.evaluations,
        nanoseconds_per_step: run.drift.nanoseconds,
        judgements,
    })
}

/// Declared maps along leaves against the Casimirs; nothing is known where there are none.
fn judge_leaves(problem: &Problem, drift: f64) -> Judgement {
    match problem.system.casimir_names().is_empty() {
        true => Judgement::Open,
        false if drift <= Defect::ROUND_OFF => Judgement::Met,
        false => Judgement::NotMet,
    }
}

/// A declared symmetry against its defect.
fn judge_symmetry(declared: MapProperties, defect: f64) -> Judgement {
    match declared.self_adjoint {
        Some(true) if defect <= Defect::ROUND_OFF => Judgement::Met,
        Some(true) => Judgement::NotMet,
        Some(false) | None => Judgement::Open,
    }
}

/// Measurements at one step size.
struct Run {
    time_step: f64,
    too_large: Option<StepError>,
    self_adjointness: f64,
    drift: Drift,
    /// The largest of a step along the orbit.
    tensor_defect: Option<StepDefect>,
}

/// Bound on the tensor defect of a step from any state of an orbit, in units of the bound on that from the first:
/// elsewhere solves may be worse conditioned.
const ALONG: f64 = 64.0;

impl Run {
    /// Whether steps keep tensor and Casimirs to round-off along the orbit.
    fn keeps_structure(&self, round_off: f64) -> bool {
        let is_kept = |told: &StepDefect| told.defect <= ALONG * round_off || !told.is_told();
        self.tensor_defect.as_ref().is_none_or(is_kept) && self.drift.keeps_casimirs != Some(false)
    }

    /// At the problem's step or the largest of so many halves that the map bears: a step too large for
    /// a solve or a chart is not a broken promise.
    fn at_largest_step(
        problem: &Problem,
        map: &dyn StepMap,
        halvings: u32,
    ) -> Result<Self, StepError> {
        let values = problem.system.parameter_values();
        let at = |t: f64| -> Result<(f64, Drift), StepError> {
            let defect = self_adjointness_defect(map, &values, 1.0, t, &problem.initial)?;
            Ok((defect, Drift::measure(problem, map, t)?))
        };
        let mut time_step = problem.time_step;
        let mut too_large = None;
        for halving in 0..=halvings {
            match at(time_step) {
                Ok((self_adjointness, drift)) => {
                    let states = drift.states.iter();
                    let defects = states.filter_map(|x| step_defect(problem, map, x, time_step));
                    return Ok(Self {
                        time_step,
                        too_large,
                        self_adjointness,
                        tensor_defect: defects.max_by(|a, b| a.defect.total_cmp(&b.defect)),
                        drift,
                    });
                }
                Err(error) if halving == halvings => return Err(error),
                Err(error) => too_large = too_large.or(Some(error)),
            }
            time_step /= 2.0;
        }
        unreachable!("the last halving returns")
    }
}
