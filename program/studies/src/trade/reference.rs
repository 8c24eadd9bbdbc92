//! The motion to the end time, by two methods of high accuracy.

use leafwise_core::PartKind;
use leafwise_core::part::Family;
use leafwise_core::registry::CompositionPart;
use leafwise_core::solver::judge::larger;
use leafwise_scene::document::{MethodTable, PartUse};

use super::candidate::{Bench, Candidate, Knob, Setting};
use super::curve::Curve;
use super::error::TradeError;
use super::grid::Grid;
use super::norm::{distance, norm};
use super::trial::{Trial, TrialFailure, run_counted, run_trial};

/// Where runs are judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Judged {
    /// By the largest ‖x_k − x*(t_k)‖ over all steps.
    #[default]
    AtEveryStep,
    /// By ‖x − x*‖ at the end time alone.
    AtTheEnd,
}

impl Judged {
    /// At the end alone, or at every step.
    pub fn at_the_end(alone: bool) -> Self {
        if alone {
            Self::AtTheEnd
        } else {
            Self::AtEveryStep
        }
    }

    /// In words: `at every step`, `at the end`.
    pub fn words(self) -> &'static str {
        match self {
            Self::AtEveryStep => "at every step",
            Self::AtTheEnd => "at the end",
        }
    }
}

/// The motion that errors are measured against, and how well it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// x at the end time.
    pub state: Vec<f64>,
    /// Estimate of the state's error where runs are judged: the largest of three numbers. The first is the largest
    /// distance to the other method's states. The second is the change at the end by the better method's last
    /// refinement. The third is the error that interpolation between its steps may add.
    pub error: f64,
    /// The methods that agree, the better one first, with their settings.
    pub methods: Vec<String>,
    /// How far their states are from each other where runs are judged; 0 of one alone.
    pub(super) apart: f64,
    /// The better one.
    best: (MethodTable, Setting),
    /// x*(t), where runs are judged at every step.
    curve: Option<Curve>,
}

/// Errors below this many times the reference's own cannot be told from it.
const FLOOR: f64 = 10.0;

/// Budget of one run of a reference, in operations.
const BUDGET: u64 = 1_000_000_000;

/// Refinements that are tried: steps halved, tolerances lowered tenfold.
const MOST_REFINEMENTS: u32 = 9;

/// A change below this many units of round-off of the state is not refined any further.
pub(super) const ROUND_OFF: f64 = 4.0;

impl Reference {
    /// Computes the reference by two methods of different families, each refined until it no longer changes at the end.
    /// Where they come to different ends all the same, one of them has stepped over something. A third is computed
    /// then, and the two that are nearest to each other are taken.
    ///
    /// # Errors
    /// [`TradeError::NoReference`] when no method reaches the end.
    pub fn compute(bench: &Bench<'_>, judged: Judged) -> Result<Self, TradeError> {
        let mut found: Vec<Refined> = Vec::new();
        let mut reasons = Vec::new();
        for method in families(bench) {
            match refine(bench, &method) {
                Ok(refined) => found.push(refined),
                Err(reason) => reasons.push(format!("{method}: {reason}")),
            }
            if found.len() > 2 || found.len() == 2 && !is_parted(&found[0], &found[1]) {
                break;
            }
        }
        keep_nearest(&mut found);
        found.sort_by(|a, b| a.change.total_cmp(&b.change));
        let Some(best) = found.first() else {
            return Err(TradeError::NoReference { reasons });
        };
        let other = found
            .get(1)
            .map(|other| distance(&best.state, &other.state));
        let mut apart = other.unwrap_or(0.0);
        let mut error = best.change.max(apart);
        let curve = match judged {
            Judged::AtTheEnd => None,
            Judged::AtEveryStep => {
                let curve = best.curve(bench, error).map_err(|reason| {
                    let reasons = vec![format!("{}: {reason}", best.name)];
                    TradeError::NoReference { reasons }
                })?;
                let largest = found
                    .get(1)
                    .and_then(|other| other.largest_distance(bench, &curve));
                apart = apart.max(largest.unwrap_or(0.0) - curve.error);
                error = error.max(curve.error).max(largest.unwrap_or(0.0));
                Some(curve)
            }
        };
        Ok(Self {
            state: best.state.clone(),
            error,
            methods: found.iter().map(|refined| refined.name.clone()).collect(),
            apart,
            best: (best.method.clone(), best.setting),
            curve,
        })
    }

    /// Where runs are judged.
    pub fn judged(&self) -> Judged {
        match self.curve {
            Some(_) => Judged::AtEveryStep,
            None => Judged::AtTheEnd,
        }
    }

    /// Curve x*(t) that runs are compared with at every step; `None` where they are judged at the end alone.
    pub(super) fn curve(&self) -> Option<&Curve> {
        self.curve.as_ref()
    }

    /// A run's error where it is judged.
    pub(super) fn error_of(&self, trial: &Trial) -> f64 {
        let end = distance(&trial.state, &self.state);
        trial
            .largest_error
            .map_or(end, |largest| larger(largest, end))
    }

    /// The smallest error that can be told from the reference's own.
    pub fn floor(&self) -> f64 {
        FLOOR * self.error
    }

    /// The better method and its setting.
    pub(super) fn best(&self) -> &(MethodTable, Setting) {
        &self.best
    }

    /// ‖x*‖ where runs are judged: the largest of all times, or at the end.
    pub fn norm(&self) -> f64 {
        let end = norm(&self.state);
        self.curve.as_ref().map_or(end, |curve| curve.norm.max(end))
    }
}

/// A method refined until it no longer changes.
struct Refined {
    state: Vec<f64>,
    change: f64,
    name: String,
    method: MethodTable,
    setting: Setting,
}

/// Two methods that no longer change by this part of their distance have come to different ends.
const PARTED: f64 = 1e-3;

/// Whether two methods that no longer change differ all the same.
fn is_parted(a: &Refined, b: &Refined) -> bool {
    let apart = distance(&a.state, &b.state);
    let rounded = ROUND_OFF * f64::EPSILON * norm(&a.state);
    a.change.max(b.change).max(rounded) < PARTED * apart
}

/// Of three methods the two that are nearest to each other.
fn keep_nearest(found: &mut Vec<Refined>) {
    if found.len() < 3 {
        return;
    }
    let apart = |left_out: usize| {
        let [a, b] = [(left_out + 1) % 3, (left_out + 2) % 3];
        distance(&found[a].state, &found[b].state)
    };
    // The third is taken before one of the first two where it does not tell them apart.
    let nearest = [2, 0, 1]
        .into_iter()
        .min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
    found.remove(nearest.unwrap_or(2));
}

/// A method that chooses its own steps is compared with the other at no more instants than these.
const MOST_INSTANTS: u64 = 4096;

impl Refined {
    /// Its motion between its steps.
    fn curve(&self, bench: &Bench<'_>, error: f64) -> Result<Curve, String> {
        let candidate = Candidate::build(bench, &self.method)?;
        let run = candidate.run_at(bench, self.setting)?;
        let wanted = error.max(ROUND_OFF * f64::EPSILON * norm(&self.state));
        Curve::of(&run, bench.extent(), self.setting.steps, wanted, BUDGET)
    }

    /// The largest distance of its states from the other's motion.
    fn largest_distance(&self, bench: &Bench<'_>, curve: &Curve) -> Option<f64> {
        let candidate = Candidate::build(bench, &self.method).ok()?;
        let mut setting = self.setting;
        if candidate.knob == Knob::Tolerance {
            setting.steps = setting.steps.max(bench.steps().min(MOST_INSTANTS));
        }
        let run = candidate.run_at(bench, setting).ok()?;
        let sizes = [1.0, bench.extent() / setting.steps as f64];
        let trial = run_counted(
            bench,
            &run,
            sizes,
            setting.steps,
            BUDGET,
            Some(curve),
            &mut 0,
        );
        trial.ok()?.largest_error
    }
}

/// The largest system of stage equations that a Gauss method of eight stages is tried on.
const LARGEST_GAUSS: usize = 12;

/// Methods of order 8 and more for a reference, of families that share no code. These are Taylor series, which reach
/// round-off in the fewest operations, implicit collocation, compositions of Poisson maps, and an adaptive explicit
/// pair.
fn families(bench: &Bench<'_>) -> Vec<MethodTable> {
    let registry = bench.registry();
    let stepper = |family| {
        let (part, given) = registry.reference(family).ok()?;
        let mut used = PartUse::named(part.info.name);
        for (name, value) in given.iter() {
            used = used.with(name, value.clone());
        }
        Some(MethodTable::stepper(used))
    };
    let hamilton_jacobi = |order| {
        let dynamics = bench.of_order(PartKind::Dynamics, order);
        MethodTable::pair(PartUse::named("auto"), dynamics)
    };
    // Compositions that serve references, those of the highest order first.
    let mut compositions: Vec<CompositionPart> = registry
        .compared(PartKind::Composition)
        .into_iter()
        .filter(|info| info.reference.is_some())
        .filter_map(|info| registry.composition(info.name).ok())
        .collect();
    compositions.sort_by_key(|part| std::cmp::Reverse(part.order));
    let composed = |at: usize, base: MethodTable| {
        let part = compositions.get(at)?;
        Some(base.composed(PartUse::named(part.info.name)))
    };
    let is_small = bench.own().dimension() <= LARGEST_GAUSS;
    [
        stepper(Family::Series),
        stepper(Family::Implicit).filter(|_| is_small),
        stepper(Family::Splitting).and_then(|base| composed(0, base)),
        stepper(Family::Explicit),
        composed(0, hamilton_jacobi(2)),
        composed(1, hamilton_jacobi(4)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn refine(bench: &Bench<'_>, method: &MethodTable) -> Result<Refined, String> {
    let candidate = Candidate::build(bench, method)?;
    let grid = Grid::of_reference(&candidate, bench.steps());
    let mut last: Option<Trial> = None;
    let mut best: Option<Refined> = None;
    let mut failure = None;
    let mut before = f64::INFINITY;
    for setting in (0..MOST_REFINEMENTS).map_while(|k| grid.setting(k as usize)) {
        let trial = match run_setting(bench, &candidate, setting) {
            Ok(trial) => trial,
            Err(error @ TrialFailure::OverBudget { .. }) => {
                failure = Some(error.to_string());
                break;
            }
            // A coarse step may fail where a fine one does not.
            Err(error) => {
                failure = Some(error.to_string());
                last = None;
                continue;
            }
        };
        if let Some(coarser) = &last {
            let change = distance(&coarser.state, &trial.state);
            if best.as_ref().is_none_or(|best| change < best.change) {
                best = Some(Refined {
                    state: trial.state.clone(),
                    change,
                    name: described(&candidate, setting),
                    method: method.clone(),
                    setting,
                });
            }
            let size = norm(&trial.state);
            let stagnates = change >= 0.5 * before && before <= 1e-9 * size;
            if change <= ROUND_OFF * f64::EPSILON * size || stagnates {
                break;
            }
            before = change;
        }
        last = Some(trial);
    }
    best.ok_or_else(|| failure.unwrap_or_else(|| "it cannot be refined".to_owned()))
}

fn run_setting(
    bench: &Bench<'_>,
    candidate: &Candidate,
    setting: Setting,
) -> Result<Trial, TrialFailure> {
    let run = candidate
        .run_at(bench, setting)
        .map_err(|reason| TrialFailure::DoesNotFit { reason })?;
    let time_step = bench.extent() / setting.steps as f64;
    run_trial(bench, &run, [1.0, time_step], setting.steps, BUDGET)
}

fn described(candidate: &Candidate, setting: Setting) -> String {
    match setting.tolerance {
        Some(tolerance) => format!("{} at tolerance {tolerance:e}", candidate.name),
        None => format!("{} in {} steps", candidate.name, setting.steps),
    }
}
