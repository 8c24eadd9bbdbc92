//! Work–precision: every method over a grid of settings.

use leafwise_core::part::Family;
use leafwise_core::{Registry, Structure};
use leafwise_scene::document::{MethodParts, MethodTable};
use serde::Serialize;

use super::candidate::{Bench, Candidate, Knob, Setting};
use super::catalogue::{Entry, catalogue};
use super::error::TradeError;
use super::front::pareto_front;
use super::grid::Grid;
use super::horizon::Horizon;
use super::measured::{Cost, Front, Measured};
use super::plateau::{Plateau, SMALL};
use super::reference::{Judged, Reference};
use super::trial::{TrialFailure, run_counted, run_trial, time_run};

/// Options of a comparison: methods, grid, budget, timing and where runs are judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CompareOptions {
    /// Methods beside the standard ones.
    pub with: Vec<MethodTable>,
    /// These methods alone, where there are any.
    pub only: Vec<MethodTable>,
    /// Only methods of these declared orders; Hamilton–Jacobi at each of them.
    pub orders: Option<Vec<usize>>,
    /// The numbers of steps; the standard grid otherwise.
    pub steps: Option<Grid>,
    /// Largest number of operations that one run may cost. The default is [`LEAST_BUDGET`], or four runs of the scene's
    /// own method where that is more.
    pub budget: Option<u64>,
    /// How often a run is timed; 0 for not at all.
    pub repetitions: usize,
    /// Where runs are judged.
    pub judged: Judged,
}

/// Least budget of one run, in operations: some ten milliseconds.
pub const LEAST_BUDGET: u64 = 10_000_000;

/// A method that was compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedMethod {
    /// The method; an adaptive one without its tolerance.
    #[serde(skip)]
    pub method: MethodTable,
    /// One line: parts and orders.
    pub name: String,
    /// The declared order in t.
    pub order: usize,
    /// The declared structure.
    pub structure: Structure,
    /// Quantity that is varied: steps or tolerance.
    #[serde(skip)]
    pub knob: Knob,
    /// Whether it is the scene's own.
    pub is_own: bool,
    /// Family of its stepper, where it has one that names its family.
    #[serde(skip)]
    pub family: Option<Family>,
}

/// A method at one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its place in the list of methods.
    pub method: usize,
    /// Steps, and the tolerance of an adaptive method.
    pub setting: Setting,
    /// εh.
    pub time_step: f64,
    /// Measurements of the run, or the reason why there are none.
    pub outcome: Result<Measured, TrialFailure>,
}

/// Methods compared on a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The time over which they were.
    pub time: f64,
    /// The names of the invariants.
    pub invariants: Vec<String>,
    /// Reference solution that errors are measured against.
    pub reference: Reference,
    /// How long the motion can be known to eight digits, where its end is not.
    pub horizon: Option<Horizon>,
    /// Budget of one run, in operations.
    pub budget: u64,
    /// Cost by which the fronts compare runs: operations or time.
    pub cost: Cost,
    /// The methods.
    pub methods: Vec<ComparedMethod>,
    /// Every method at every setting, coarse to fine.
    pub points: Vec<Point>,
    /// Methods that do not fit, with the reason.
    pub refused: Vec<(String, String)>,
}

/// Measures every method at every setting. Calls `progress` before each method with the method, its number and the
/// number of methods. While methods are built their number is not known, and both numbers are 0. After that, returning
/// `false` ends the comparison.
///
/// # Errors
/// Returns [`TradeError::NoReference`], and [`TradeError::NoMethods`] where none of the methods asked for fits.
/// Failures of single configurations are points with their reason.
pub fn compare(
    bench: &Bench<'_>,
    options: &CompareOptions,
    progress: &mut dyn FnMut(&str, usize, usize) -> bool,
) -> Result<Comparison, TradeError> {
    let entries = entries(bench, options, &mut |method| {
        progress(method, 0, 0);
        true
    })?;
    let mut refused = Vec::new();
    let reference = Reference::compute(bench, options.judged)?;
    let wanted = SMALL * reference.norm();
    let is_unknown = reference.floor() > wanted && wanted > 0.0;
    let horizon = is_unknown.then(|| reference.horizon(bench, wanted));
    let budget = options.budget.unwrap_or_else(|| own_budget(bench));
    let own = bench.own_method();
    let (mut methods, mut points) = (Vec::new(), Vec::new());
    let count = entries.len();
    for (at, entry) in entries.into_iter().enumerate() {
        let candidate = match entry.candidate {
            Ok(candidate) => candidate,
            Err(reason) => {
                refused.push((entry.method.to_string(), reason));
                continue;
            }
        };
        if !progress(&candidate.name, at, count) {
            break;
        }
        let grid = match (&options.steps, candidate.knob) {
            (Some(grid), Knob::Steps) => grid.clone(),
            _ => Grid::standard(&candidate, bench.steps()),
        };
        let mut sweep = Sweep {
            bench,
            candidate: &candidate,
            reference: &reference,
            repetitions: options.repetitions,
            budget,
        };
        let stops_early = options.steps.is_none();
        let of_method = sweep.run(&grid, stops_early);
        let place = methods.len();
        points.extend(of_method.into_iter().map(|(setting, outcome)| Point {
            method: place,
            setting,
            time_step: bench.extent() / setting.steps as f64,
            outcome,
        }));
        methods.push(ComparedMethod {
            is_own: own.as_ref() == Some(&candidate.method),
            family: family(bench.registry(), &candidate.method),
            name: candidate.name,
            order: candidate.properties.order,
            structure: candidate.properties.structure,
            knob: candidate.knob,
            method: candidate.method,
        });
    }
    let cost = cost_of(&points);
    mark_fronts(&mut points, &reference, cost);
    Ok(Comparison {
        time: bench.time(),
        invariants: bench.invariants(),
        reference,
        horizon,
        budget,
        cost,
        methods,
        points,
        refused,
    })
}

fn entries(
    bench: &Bench<'_>,
    options: &CompareOptions,
    progress: &mut dyn FnMut(&str) -> bool,
) -> Result<Vec<Entry>, TradeError> {
    let build = |method: &MethodTable| Entry {
        method: method.clone(),
        candidate: Candidate::build(bench, method),
    };
    if !options.only.is_empty() {
        let entries: Vec<Entry> = options.only.iter().map(build).collect();
        return some_fit(entries);
    }
    let mut entries = catalogue(bench, options.orders.as_deref(), progress);
    for entry in options.with.iter().map(build) {
        let is_there = |known: &Entry| match (&known.candidate, &entry.candidate) {
            (Ok(known), Ok(new)) => known.method == new.method,
            _ => false,
        };
        if !entries.iter().any(is_there) {
            entries.push(entry);
        }
    }
    if let Some(orders) = &options.orders {
        let is_wanted = |entry: &Entry| {
            let built = entry.candidate.as_ref();
            built.is_ok_and(|built| orders.contains(&built.properties.order))
        };
        if options.with.is_empty() && !entries.iter().any(is_wanted) {
            let orders: Vec<String> = orders.iter().map(usize::to_string).collect();
            let reason = format!(
                "none that fits the scene is of order {}",
                orders.join(" or ")
            );
            return Err(TradeError::NoMethods {
                reasons: vec![reason],
            });
        }
    }
    Ok(entries)
}

/// Refuses entries none of which fits.
pub(super) fn some_fit(entries: Vec<Entry>) -> Result<Vec<Entry>, TradeError> {
    let reasons: Vec<String> = entries
        .iter()
        .filter_map(|entry| {
            let reason = entry.candidate.as_ref().err()?;
            Some(format!("{}: {reason}", entry.method))
        })
        .collect();
    if reasons.len() == entries.len() {
        return Err(TradeError::NoMethods { reasons });
    }
    Ok(entries)
}

/// Four runs of the scene's own method, or the least budget.
fn own_budget(bench: &Bench<'_>) -> u64 {
    let time_step = bench.extent() / bench.steps() as f64;
    let own = run_trial(
        bench,
        bench.own(),
        [1.0, time_step],
        bench.steps(),
        u64::MAX,
    );
    own.map_or(0, |trial| 4 * trial.cost()).max(LEAST_BUDGET)
}

/// One method over a grid.
struct Sweep<'a> {
    bench: &'a Bench<'a>,
    candidate: &'a Candidate,
    reference: &'a Reference,
    repetitions: usize,
    budget: u64,
}

type Outcome = Result<Measured, TrialFailure>;

impl Sweep<'_> {
    /// Coarse to fine; with `stops_early`, until the error is the reference's or round-off, or the
    /// budget is spent.
    fn run(&mut self, grid: &Grid, stops_early: bool) -> Vec<(Setting, Outcome)> {
        let mut points = Vec::new();
        let mut plateau = Plateau::default();
        for setting in grid.settings() {
            let outcome = self.point(setting);
            let stops = match &outcome {
                Err(TrialFailure::OverBudget { .. } | TrialFailure::DoesNotFit { .. }) => true,
                Err(_) => false,
                Ok(measured) => {
                    let is_flat = plateau.is_reached(measured.error, measured.cost());
                    let is_small = plateau.least <= SMALL * self.reference.norm();
                    measured.at_floor || (is_small && is_flat)
                }
            };
            points.push((setting, outcome));
            if stops && stops_early {
                break;
            }
        }
        points
    }

    fn point(&self, setting: Setting) -> Outcome {
        let unfit = |reason| TrialFailure::DoesNotFit { reason };
        let run = self.candidate.run_at(self.bench, setting).map_err(unfit)?;
        let time_step = self.bench.extent() / setting.steps as f64;
        let sizes = [1.0, time_step];
        let curve = self.reference.curve();
        let trial = run_counted(
            self.bench,
            &run,
            sizes,
            setting.steps,
            self.budget,
            curve,
            &mut 0,
        )?;
        let structure = self.candidate.properties.structure;
        let mut measured = Measured::of(&trial, &run, time_step, structure, self.reference);
        if self.repetitions > 0 {
            let wall = time_run(&run, 1.0, time_step, setting.steps, self.repetitions)?;
            measured.wall = Some(wall);
        }
        Ok(measured)
    }
}

/// The largest relative error of a point on a front: beyond, the end state says nothing.
const LARGEST_ERROR: f64 = 0.1;

/// Time where there are runs and none counts its operations.
fn cost_of(points: &[Point]) -> Cost {
    let measured = points
        .iter()
        .filter_map(|point| point.outcome.as_ref().ok());
    let counted: Vec<bool> = measured.map(|run| run.operations.is_some()).collect();
    if counted.is_empty() || counted.contains(&true) {
        Cost::Operations
    } else {
        Cost::Time
    }
}

fn mark_fronts(points: &mut [Point], reference: &Reference, cost: Cost) {
    let floor = reference.floor();
    let largest = match reference.norm() {
        0.0 => f64::INFINITY,
        norm => LARGEST_ERROR * norm,
    };
    let front = |of: &dyn Fn(&Measured) -> Option<f64>| {
        let pairs: Vec<_> = points
            .iter()
            .map(|point| {
                let measured = point.outcome.as_ref().ok()?;
                let is_useful = measured.relative_error < LARGEST_ERROR && floor <= largest;
                is_useful.then_some((of(measured)?, measured.error))
            })
            .collect();
        pareto_front(&pairs, floor)
    };
    let all = front(&|m| cost.of(m));
    let poisson = front(&|m| cost.of(m).filter(|_| m.is_poisson));
    let wall = front(&|m| m.wall.map(|wall| wall.seconds));
    for (at, point) in points.iter_mut().enumerate() {
        if let Ok(measured) = &mut point.outcome {
            measured.front = Front {
                all: all[at],
                poisson: poisson[at],
                wall: wall[at],
            };
        }
    }
}

/// Family of a method's stepper; `None` for a pair, and for a stepper that names none.
fn family(registry: &Registry, method: &MethodTable) -> Option<Family> {
    match &method.parts {
        MethodParts::Stepper(stepper) => registry.stepper(&stepper.name).ok()?.info.family,
        MethodParts::Pair { .. } => None,
    }
}
