//! Work–precision: every method over a grid of settings.

use leafwise_core::Structure;
use leafwise_scene::document::MethodTable;

use super::candidate::{Bench, Candidate, Knob, Setting};
use super::catalogue::{Entry, Extent, catalogue};
use super::error::TradeError;
use super::front::pareto_front;
use super::grid::Grid;
use super::reference::Reference;
use super::trial::{Trial, TrialFailure, Wall, distance, run_trial, tensor_defect, time_run};

/// What is compared.
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
    /// What one run may cost in operations; otherwise [`LEAST_BUDGET`], or four runs of the
    /// scene's own method where that is more.
    pub budget: Option<u64>,
    /// How often a run is timed; 0 for not at all.
    pub repetitions: usize,
}

/// What a run may cost at least, in operations: some ten milliseconds.
pub const LEAST_BUDGET: u64 = 10_000_000;

/// A method that was compared.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedMethod {
    /// The method; an adaptive one without its tolerance.
    pub method: MethodTable,
    /// One line: parts and orders.
    pub name: String,
    /// The declared order in t.
    pub order: usize,
    /// The declared structure.
    pub structure: Structure,
    /// What is varied.
    pub knob: Knob,
    /// Whether it is the scene's own.
    pub is_own: bool,
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
    /// What was measured, or why nothing was.
    pub outcome: Result<Measured, TrialFailure>,
}

/// What a run costs and what it keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Operations of the whole run, as
    /// [`SolverStatistics::operations`](leafwise_core::SolverStatistics::operations) counts them.
    pub operations: Option<u64>,
    /// Evaluations of the whole run.
    pub evaluations: u64,
    /// How long it took.
    pub wall: Option<Wall>,
    /// ‖x − x*‖ at the end time.
    pub error: f64,
    /// The same over ‖x*‖.
    pub relative_error: f64,
    /// Whether the error is below ten times the reference's own: it may be smaller or larger.
    pub at_floor: bool,
    /// max |H(x_k) − H(x_0)| over every step.
    pub energy_drift: f64,
    /// The largest max |C(x_k) − C(x_0)| of a Casimir over every step; 0 where there is none.
    pub casimir_drift: f64,
    /// The tensor defect of one step, from the first state and from the last, relative; `None`
    /// where the map offers no tangent.
    pub tensor_defect: Option<f64>,
    /// Whether the run is one of a Poisson map: declared exact, or declared to some order and
    /// with a tensor defect of round-off at this step.
    pub is_poisson: bool,
    /// Which fronts it stands on.
    pub front: Front,
}

/// The fronts on which a point stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Front {
    /// Error against counted operations, among all methods.
    pub all: bool,
    /// The same among Poisson maps.
    pub poisson: bool,
    /// Error against wall time, among all methods.
    pub wall: bool,
}

/// Methods compared on a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The time over which they were.
    pub time: f64,
    /// The names of the invariants.
    pub invariants: Vec<String>,
    /// What errors are measured against.
    pub reference: Reference,
    /// What one run was allowed to cost.
    pub budget: u64,
    /// The methods.
    pub methods: Vec<ComparedMethod>,
    /// Every method at every setting, coarse to fine.
    pub points: Vec<Point>,
    /// Methods that do not fit, with the reason.
    pub refused: Vec<(String, String)>,
}

/// A tensor defect of round-off, in units of u: products of up to a dozen factors, a few dozen of
/// them, and the solve.
pub(super) const DEFECT_ROUND_OFF: f64 = 256.0 * f64::EPSILON;

/// Measures every method at every setting. `progress` is told the method and the number of
/// methods before each one; it ends the comparison by returning `false`.
///
/// # Errors
/// [`TradeError::NoReference`]; failures of single configurations are points with their reason.
pub fn compare(
    bench: &Bench<'_>,
    options: &CompareOptions,
    progress: &mut dyn FnMut(&str, usize, usize) -> bool,
) -> Result<Comparison, TradeError> {
    let reference = Reference::compute(bench)?;
    let (entries, mut refused) = (entries(bench, options), Vec::new());
    let budget = options.budget.unwrap_or_else(|| own_budget(bench));
    let own = MethodTable::of_choices(&bench.own().plan.parts);
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
            time_step: bench.time() / setting.steps as f64,
            outcome,
        }));
        methods.push(ComparedMethod {
            is_own: own.as_ref() == Some(&candidate.method),
            name: candidate.name,
            order: candidate.properties.order,
            structure: candidate.properties.structure,
            knob: candidate.knob,
            method: candidate.method,
        });
    }
    mark_fronts(&mut points, reference.floor());
    Ok(Comparison {
        time: bench.time(),
        invariants: bench.invariants(),
        reference,
        budget,
        methods,
        points,
        refused,
    })
}

fn entries(bench: &Bench<'_>, options: &CompareOptions) -> Vec<Entry> {
    let build = |method: &MethodTable| Entry {
        method: method.clone(),
        candidate: Candidate::build(bench, method),
    };
    if !options.only.is_empty() {
        return options.only.iter().map(build).collect();
    }
    let mut entries = catalogue(bench, Extent::Standard, options.orders.as_deref());
    for entry in options.with.iter().map(build) {
        let is_there = |known: &Entry| match (&known.candidate, &entry.candidate) {
            (Ok(known), Ok(new)) => known.method == new.method,
            _ => false,
        };
        if !entries.iter().any(is_there) {
            entries.push(entry);
        }
    }
    entries
}

/// Four runs of the scene's own method, or the least budget.
fn own_budget(bench: &Bench<'_>) -> u64 {
    let time_step = bench.time() / bench.steps() as f64;
    let own = run_trial(bench.own(), time_step, bench.steps(), u64::MAX);
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
                    let cost = measured.operations.unwrap_or(measured.evaluations);
                    let is_flat = plateau.is_reached(measured.error, cost);
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
        let time_step = self.bench.time() / setting.steps as f64;
        let trial = run_trial(&run, time_step, setting.steps, self.budget)?;
        let wall = match self.repetitions {
            0 => None,
            count => Some(time_run(&run, time_step, setting.steps, count)?),
        };
        let defect = tensor_defect(&run, time_step, &[&run.plan.initial, &trial.state]);
        Ok(measured(
            &trial,
            wall,
            defect,
            self.candidate.properties.structure,
            self.reference,
        ))
    }
}

/// An error that is small enough, relative to the state, for a plateau to be round-off.
pub(super) const SMALL: f64 = 1e-8;

/// Watches whether more cost still makes less error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plateau {
    /// The least error so far.
    pub least: f64,
    cost: u64,
    without_gain: u32,
}

impl Default for Plateau {
    fn default() -> Self {
        Self {
            least: f64::INFINITY,
            cost: 0,
            without_gain: 0,
        }
    }
}

impl Plateau {
    /// Takes in the next run; tells whether two costlier ones in a row gained less than a tenth.
    pub fn is_reached(&mut self, error: f64, cost: u64) -> bool {
        if error < 0.9 * self.least {
            self.without_gain = 0;
        } else if cost > self.cost {
            self.without_gain += 1;
        }
        self.cost = self.cost.max(cost);
        self.least = self.least.min(error);
        self.without_gain >= 2
    }
}

fn measured(
    trial: &Trial,
    wall: Option<Wall>,
    tensor_defect: Option<f64>,
    structure: Structure,
    reference: &Reference,
) -> Measured {
    let error = distance(&trial.state, &reference.state);
    let size = reference.norm();
    Measured {
        operations: trial.statistics.operations,
        evaluations: trial.statistics.evaluations,
        wall,
        error,
        relative_error: if size > 0.0 { error / size } else { error },
        at_floor: error <= reference.floor(),
        energy_drift: trial.drift.first().copied().unwrap_or(0.0),
        casimir_drift: trial.drift.iter().skip(1).fold(0.0, |m, v| v.max(m)),
        tensor_defect,
        is_poisson: is_poisson(structure, tensor_defect),
        front: Front::default(),
    }
}

/// Whether a map of this declared structure and measured defect is Poisson to round-off.
pub(super) fn is_poisson(structure: Structure, tensor_defect: Option<f64>) -> bool {
    match structure {
        Structure::Exact => true,
        Structure::Order(_) => tensor_defect.is_some_and(|defect| defect <= DEFECT_ROUND_OFF),
        Structure::None => false,
    }
}

/// The largest relative error of a point on a front: beyond, the end state says nothing.
const LARGEST_ERROR: f64 = 0.1;

fn mark_fronts(points: &mut [Point], floor: f64) {
    let front = |of: &dyn Fn(&Measured) -> Option<f64>| {
        let pairs: Vec<_> = points
            .iter()
            .map(|point| {
                let measured = point.outcome.as_ref().ok()?;
                let is_useful = measured.relative_error < LARGEST_ERROR;
                is_useful.then_some((of(measured)?, measured.error))
            })
            .collect();
        pareto_front(&pairs, floor)
    };
    let operations = |m: &Measured| m.operations.map(|count| count as f64);
    let all = front(&operations);
    let poisson = front(&|m| operations(m).filter(|_| m.is_poisson));
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
