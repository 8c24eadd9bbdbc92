//! A realization by itself, and under dynamic approximations.

use leafwise_core::solver::judge::larger;
use std::sync::Arc;

use leafwise_core::diagnostics::realization_error::Relative;
use leafwise_core::diagnostics::{RealizationInstrument, section_defect};
use leafwise_core::part::PartInfo;
use leafwise_core::{
    Accuracy, BuildError, ChartMaps, Ends, RealizationData, RealizationMaps, Registry, StepError,
};

use leafwise_scene::compose::check_tensor;

use super::finding::{Finding, Place, worst};
use super::problems::along;
use super::{maps, parameters};
use crate::verify::{Floor, Judgement, MeasuredOrder, Problem};

/// Round-off of a bracket in units of u and of its terms: 2d products of two derivatives, each a few
/// dozen operations.
const OF_BRACKET: f64 = 256.0;

/// Round-off of a map in units of u and of its values.
const OF_MAP: f64 = 64.0;

/// How far a momentum moves the ends apart, relative to the state.
const REACH: f64 = 0.05;

/// Examines a realization on every problem that it fits.
///
/// # Errors
/// [`BuildError`] where it is not in the registry.
pub(super) fn examine(
    registry: &Registry,
    part: &PartInfo,
    path: Option<&'static str>,
    problems: &[Problem],
    findings: &mut Vec<Finding>,
) -> Result<(), BuildError> {
    let offered = registry.realization(part.name)?;
    let given = parameters(part, path);
    let mut others = 0;
    let before = findings.len();
    for problem in problems {
        let Ok(realization) = offered.build(&problem.system, &given) else {
            continue;
        };
        let place = Place {
            path,
            problem: &problem.name,
        };
        let fits = check_tensor(part.name, &problem.system, &realization, &problem.initial);
        if fits.is_err() {
            others += 1;
            // Functions are told the system and may refuse it; formulas alone cannot.
            if offered.info.path(&given) == Some("numbers") {
                let quantity = "accepts only tensors that it realizes";
                findings.push(place.holds(quantity, fits.err().map(|error| error.to_string())));
            }
            continue;
        }
        by_itself(registry, place, problem, &realization, findings);
        maps::under_dynamics(registry, place, problem, &realization, findings);
    }
    if others > 0 && findings.len() == before {
        let place = Place {
            path,
            problem: "all",
        };
        let how = format!(
            "on none of the {others} problems of its dimension; offer a system of its tensor in the \
             same plugin"
        );
        findings.push(place.open("{alpha, alpha} = eps Pi on the section", how));
    }
    Ok(())
}

fn by_itself(
    registry: &Registry,
    place: Place<'_>,
    problem: &Problem,
    realization: &Arc<dyn RealizationData>,
    findings: &mut Vec<Finding>,
) {
    let values = problem.system.parameter_values();
    let x = problem.initial.as_slice();
    let identity = "alpha(sigma(x)) = beta(sigma(x)) = x";
    match section_defect(realization.as_ref(), &values, 1.0, x) {
        Ok(Ok(defect)) => {
            findings.push(place.at_most(identity, defect, OF_MAP * f64::EPSILON));
        }
        Ok(Err(error)) => findings.push(place.failed(identity, &error)),
        Err(error) => return findings.push(place.open(identity, error.to_string())),
    }
    let charted = match Charted::new(problem, realization) {
        Ok(charted) => charted,
        Err(error) => return findings.push(place.open("brackets", error.to_string())),
    };
    let Some(p) = charted.momentum(x) else {
        let why = "no momentum at the problem's state is inside its domain";
        return findings.push(place.open("brackets", why));
    };
    if realization.abilities().is_reversible {
        let quantity = "beta(x, p) = alpha(x, -p)";
        findings.push(match charted.inversion(x, &p) {
            Ok(off) => place.at_most(quantity, off, OF_MAP * f64::EPSILON),
            Err(error) => place.failed(quantity, &error),
        });
    }
    let instrument = RealizationInstrument::new(&problem.system, realization, &values);
    match instrument {
        Ok(mut instrument) => match realization.accuracy() {
            Accuracy::Exact => {
                let pair = |x: Vec<f64>| Some((charted.momentum(&x)?, x));
                let states = along(registry, problem).into_iter().filter_map(pair);
                exact(place, &mut instrument, states, findings);
            }
            Accuracy::Order(n) => of_order(place, &mut instrument, (x, &p), n, findings),
        },
        Err(error) => findings.push(place.open("brackets", error.to_string())),
    }
}

/// One error of a realization.
type Of = fn(&Relative) -> f64;

/// The three errors by name.
const ERRORS: [(&str, Of); 3] = [
    ("alpha is Poisson", |error| error.source),
    ("beta is anti-Poisson", |error| error.target),
    ("{alpha, beta} = 0", |error| error.dual_pair),
];

/// All three at round-off, at every state with its momentum.
fn exact(
    place: Place<'_>,
    instrument: &mut RealizationInstrument,
    states: impl Iterator<Item = (Vec<f64>, Vec<f64>)>,
    findings: &mut Vec<Finding>,
) {
    let measured: Vec<_> = states
        .map(|(p, x)| instrument.measure(1.0, &x, &p))
        .collect();
    if let Some(Err(error)) = measured.iter().find(|measured| measured.is_err()) {
        return findings.push(place.failed("brackets", error));
    }
    for (quantity, of) in ERRORS {
        let errors = measured.iter().flatten();
        findings.extend(worst(errors.map(|error| {
            let bound = OF_BRACKET * f64::EPSILON + error.relative_floor;
            place.at_most(quantity, of(&error.relative), bound)
        })));
    }
}

/// Values of ε, six an octave.
const SIZES: u32 = 60;

/// The order n of the errors O(ε^{n+1}), brackets being O(ε).
fn of_order(
    place: Place<'_>,
    instrument: &mut RealizationInstrument,
    (x, p): (&[f64], &[f64]),
    declared: usize,
    findings: &mut Vec<Finding>,
) {
    let errors: Vec<_> = (0..SIZES)
        .map(|k| libm::exp2(4.0 - f64::from(k) / 6.0))
        .filter_map(|epsilon| Some((epsilon, instrument.measure(epsilon, x, p).ok()?)))
        .collect();
    for (quantity, of) in ERRORS {
        let mut floor = Floor::new(8.0 * f64::EPSILON, OF_BRACKET * f64::EPSILON);
        let mut points = Vec::new();
        let mut differences = 0.0_f64;
        for (epsilon, error) in &errors {
            let (relative, noise) = (of(&error.relative), error.relative_floor);
            if noise == 0.0 || relative > 4.0 * noise {
                points.push((*epsilon, relative));
                differences = differences.max(noise);
                floor.take(*epsilon, relative);
            }
        }
        let round_off = floor.round_off.max(differences);
        let is_round_off = points.iter().all(|(_, error)| *error <= 4.0 * round_off);
        let (measured, judgement) = if errors.is_empty() {
            (Some(MeasuredOrder::default()), Judgement::Undecided)
        } else if is_round_off {
            (None, Judgement::Met)
        } else {
            let order = MeasuredOrder::of(&points, round_off, 1.0);
            (Some(order), order.judge(declared))
        };
        findings.push(place.order(
            format!("{quantity}: order in epsilon"),
            &declared.to_string(),
            measured,
            judgement,
        ));
    }
}

/// A realization's maps through its chart.
struct Charted {
    maps: RealizationMaps,
    chart: ChartMaps,
    values: Vec<f64>,
    space: usize,
}

impl Charted {
    fn new(problem: &Problem, realization: &Arc<dyn RealizationData>) -> Result<Self, BuildError> {
        let values = problem.system.parameter_values();
        let chart = ChartMaps::of(realization.as_ref(), values.len())?;
        Ok(Self {
            chart: chart.ok_or_else(|| BuildError::Incompatible {
                dynamics: "the bracket of S".to_owned(),
                realization: realization.describe(),
                reason: "it offers no chart (x, p) about its section".to_owned(),
            })?,
            maps: RealizationMaps::new(realization.as_ref(), values.len())?,
            space: realization.space_dimension(),
            values,
        })
    }

    /// The ends at χ(x, p) for ε = 1.
    fn ends(&self, x: &[f64], p: &[f64]) -> Result<Vec<f64>, StepError> {
        let mut z = vec![0.0; self.space];
        let mut ends = vec![0.0; 3 * x.len()];
        let pair = [x, p].concat();
        self.chart
            .evaluator(&self.values, 1.0)
            .values(&pair, &mut z)?;
        self.maps
            .evaluator(&self.values, 1.0)
            .values(&z, &mut ends)?;
        Ok(ends)
    }

    /// A momentum that moves the ends apart by a twentieth of the state, or as far as the domain
    /// allows.
    fn momentum(&self, x: &[f64]) -> Option<Vec<f64>> {
        const HALVINGS: usize = 40;
        let direction = |size: f64| -> Vec<f64> {
            let one = |i: usize| size * (1.0 - 0.375 * (i % 5) as f64);
            (0..x.len()).map(one).collect()
        };
        let mut size = 1.0;
        for _ in 0..HALVINGS {
            let p = direction(size);
            if let Ok(ends) = self.ends(x, &p)
                && largest(Ends::of(&ends).increment) <= REACH * largest(x)
            {
                return Some(p);
            }
            size /= 2.0;
        }
        None
    }

    /// |β̂(x, p) − α̂(x, −p)| over the size of x.
    fn inversion(&self, x: &[f64], p: &[f64]) -> Result<f64, StepError> {
        let minus: Vec<f64> = p.iter().map(|p| -p).collect();
        let (there, back) = (self.ends(x, p)?, self.ends(x, &minus)?);
        let (there, back) = (Ends::of(&there), Ends::of(&back));
        let off = |i: usize| (there.target(i) - back.source(i)).abs();
        let size = largest(x).max(f64::MIN_POSITIVE);
        Ok((0..x.len()).map(off).fold(0.0, larger) / size)
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| v.abs().max(largest))
}
