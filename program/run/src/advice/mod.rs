//! Advice where a scene asks for more than it uses or for less than it needs, measured at states of the run; each with
//! the one line to change.
//!
//! - `cheaper`: methods with which a run takes a fraction of the operations, no warning;
//! - `probe`: the method at those states;
//! - `truncation`: a truncation order above what a step can feel;
//! - `dynamics`: terms of the generating function below the realization's own error;
//! - `chart`: a step that nearly leaves the chart;
//! - `solutions`: a step whose equation has several solutions inside it;
//! - `defect`: a truncated realization that hardly keeps the tensor;
//! - `leaves`: forces over a realization that is not exact;
//! - `degree`: a table whose derivatives jump below the order of the method;
//! - `direction`: Hamilton's equations that run backwards in time;
//! - `energy`: an energy that is kept badly;
//! - `exact`: an exact realization that costs no more;
//! - `rounding`: a step that the state's round-off decides, an energy that doubles do not hold;
//! - `step`: a step that is too long for its order, a tolerance that is too loose;
//! - `stepper`: a stepper that is no Poisson map where splitting is one for no more, stages that no step feels;
//! - `seams`: a Hamiltonian that is smooth in pieces, under a method of a high order;
//! - `shortened`: steps that are shortened to come to `until`;
//! - `unused`: parameters that nothing depends on;
//! - `constraints`: a start off the constraints;
//! - `claims`: parts that are not what they say;
//! - `trial`: operations and energy error of a step map over its first steps;
//! - `motion`: trajectories by their motions;
//! - `sizes`: sizes of coordinates, which their changes are measured by.

mod chart;
mod cheaper;
mod claims;
mod constraints;
mod defect;
mod degree;
mod direction;
mod dynamics;
mod energy;
mod exact;
mod leaves;
mod motion;
mod probe;
mod rounding;
mod seams;
mod shortened;
mod sizes;
mod solutions;
mod step;
mod stepper;
mod trial;
mod truncation;
mod unused;

use leafwise_core::{Registry, Walk};
use serde::Serialize;

pub use cheaper::{CheaperMethod, cheaper_method, splitting_instead};
pub(crate) use claims::casimir_drift;
pub(crate) use constraints::off_constraints;
pub(crate) use energy::EnergyError;
use leafwise_scene::compose::ComposedRun;
use leafwise_scene::document::SceneDocument;
use probe::Probe;

/// One thing to change.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Advice {
    /// Kind of the advice, for programs.
    pub kind: AdviceKind,
    /// Message on what was measured.
    pub message: String,
    /// The line of the scene to write instead, or two.
    pub change: String,
}

/// Message and change of each, for a page.
pub(crate) fn lines(advice: &[Advice]) -> Vec<(String, String)> {
    let line = |advice: &Advice| (advice.message.clone(), advice.change.clone());
    advice.iter().map(line).collect()
}

/// The kinds of advice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AdviceKind {
    /// A truncation order above what a step can feel.
    TruncationOrder,
    /// Terms of the generating function below the realization's own error.
    DynamicsOrder,
    /// A chart that is nearly used up.
    Chart,
    /// Several solutions inside the chart.
    SeveralSolutions,
    /// A truncated realization that hardly keeps the tensor.
    RealizationDefect,
    /// Forces over a realization that is not exact.
    LeftLeaf,
    /// An exact realization that costs no more and was not taken.
    ExactRealization,
    /// A stepper that is no Poisson map, where splitting is one and costs no more.
    NoPoissonMap,
    /// Stages that no step feels.
    Stages,
    /// A step that is too long for its order, or a tolerance that is too loose.
    CoarseStep,
    /// A step that the state's round-off decides, an energy or a derivative of it that doubles do not hold.
    RoundOff,
    /// A recorded formula without a finite value at some samples.
    UndefinedObservable,
    /// Hamilton's equations that run backwards in time.
    BackwardTime,
    /// An error of the energy that is a large part of its scale along the orbit.
    EnergyError,
    /// Steps that are shorter than the scene's, so that a whole number of them comes to its time at the end.
    ShortenedStep,
    /// A Hamiltonian that is smooth in pieces, under a method of a higher order than steps across a seam have.
    Seams,
    /// A table whose derivatives jump below the order of the method.
    TableDegree,
    /// A parameter that no formula names.
    UnusedParameter,
    /// Rows of states that are no member's.
    UnusedStates,
    /// An initial state off the constraints.
    OffConstraint,
    /// A part that claims to be exact and is not.
    BrokenClaim,
    /// A Casimir that drifts over a map that keeps it.
    CasimirDrift,
}

impl AdviceKind {
    /// Its word in JSON and in the guide: `coarse-step`.
    pub fn word(self) -> String {
        let word = serde_json::to_value(self).unwrap_or_default();
        word.as_str().unwrap_or_default().to_owned()
    }
}

/// The most states that are looked at.
pub const MOST_STATES: usize = 8;

/// The most steps between two states that are looked at before a run.
const MOST_STRIDE: u64 = 64;

/// States of more coordinates than this are not looked at: the alternatives are built and solved
/// densely.
pub(crate) const LARGEST: usize = 64;

/// The initial state and some that the run's first steps lead to: where a method is judged before it
/// has run.
pub fn states_ahead(run: &ComposedRun) -> Vec<Vec<f64>> {
    states_from(run, &run.plan.initial, MOST_STATES)
}

/// `x` and some states that the run's method leads to from there, `count` at most.
pub(crate) fn states_from(run: &ComposedRun, x: &[f64], count: usize) -> Vec<Vec<f64>> {
    let mut states = vec![x.to_vec()];
    if run.dimension() > LARGEST {
        return states;
    }
    let parameters = run.system.parameter_values();
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let mut walk = Walk::new(run.method.map(), &parameters, epsilon, h, x);
    let stride = (run.plan.steps / count as u64).clamp(1, MOST_STRIDE);
    while states.len() < count {
        if walk.advance(stride).is_err() {
            break;
        }
        states.push(walk.state().to_vec());
    }
    states
}

/// `x` and the states that the run's method leads to from there with these parameters, one a step,
/// `count` at most.
pub(crate) fn orbit_from(
    run: &ComposedRun,
    parameters: &[f64],
    x: &[f64],
    count: u64,
) -> Vec<Vec<f64>> {
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let mut walk = Walk::new(run.method.map(), parameters, epsilon, h, x);
    let mut states = vec![x.to_vec()];
    // The orbit ends where a step fails.
    let _ = walk.watch(count, |walk| states.push(walk.state().to_vec()));
    states
}

/// Advice about a scene, with no step of its method. It tells of parameters that no formula names and of an initial state
/// off the constraints. It also tells of motion backwards in time, shortened steps, seams of the Hamiltonian and degrees of tables.
pub fn about_the_scene(document: &SceneDocument, run: &ComposedRun) -> Vec<Advice> {
    let mut advice = unused::unused_parameters(document);
    advice.extend(off_constraints(document, run, &run.plan.initial, ""));
    advice.extend(direction::advice(document, run));
    advice.extend(shortened::advice(document));
    advice.extend(seams::advice(run));
    advice.extend(degree::advice(run));
    advice
}

/// Where states that a method is judged at come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JudgedStates {
    /// The run went through them.
    OfTheRun,
    /// The first steps of a run that was not made lead to them.
    Ahead,
    /// Members of an ensemble, whose own failures are told of them.
    OfMembers,
}

/// Advice about a scene's method, judged at `states`. Nothing is said of what cannot be measured, of a long
/// lattice, and with noise, where two steps differ by what they draw.
pub fn advise(
    run: &ComposedRun,
    registry: &Registry,
    (states, whose): (&[Vec<f64>], JudgedStates),
) -> Vec<Advice> {
    if run.dimension() > LARGEST || run.method.noise().is_some() {
        return Vec::new();
    }
    let coarse = step::advice(run, registry, (states, whose));
    let coarse = coarse.or_else(|| rounding::advice(run, states)).into_iter();
    let coarse = claims::advice(run, registry, states)
        .into_iter()
        .chain(coarse);
    if run.method.written().is_none() {
        return coarse
            .chain(stepper::advice(run, registry, states))
            .collect();
    }
    let Some(mut probe) = Probe::new(run, registry, states) else {
        return coarse.collect();
    };
    let mut advice: Vec<Advice> = [
        solutions::advice,
        chart::advice,
        leaves::advice,
        exact::advice,
        truncation::advice,
        dynamics::advice,
    ]
    .iter()
    .filter_map(|advice| advice(&mut probe))
    .collect();
    // Beside a better realization or a smaller step it would say the same again.
    if advice.is_empty() {
        advice.extend(defect::advice(&mut probe));
    }
    advice.extend(coarse);
    advice
}

/// A number with two digits.
fn number(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-2..1e4).contains(&value.abs()) {
        let digits = usize::from(value.abs() < 10.0) + usize::from(value.abs() < 1.0);
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}
