//! Plan of an ensemble: its method, members, clock and observables, composed from a scene.

use std::path::Path;

use leafwise_core::Registry;
use leafwise_walk::{Course, StateFunctions};

use super::clock::Clock;
use super::population::Population;
use super::states::Members;
use super::statistics::Shape;
use crate::state_error::refuse_estimate;
use leafwise_scene::compose::{ComposedRun, Observable, Refusal, check_varied, compose};
use leafwise_scene::document::{EnsembleSection, FinalStates, SceneDocument};

/// Windows of steps over which the invariants' deviations are taken, at most.
const MOST_WINDOWS: u64 = 32;

/// Observables at their times that are reduced, at most: each holds a summary, and a member one
/// number for each until it is taken in.
const MOST_SUMMARIES: u64 = 1 << 16;

/// The same where each holds a sketch of quantiles: up to 25 kB for each binary digit of the number of members.
const MOST_SKETCHES: u64 = 1 << 12;

/// An ensemble with its system, method and members.
pub struct ComposedEnsemble {
    /// The method and the scene's own run, its observables those of the ensemble.
    pub run: ComposedRun,
    /// The members.
    pub population: Population,
    /// The quantiles of every observable.
    pub quantiles: Vec<f64>,
    /// Whether each member's last state is kept.
    pub final_states: FinalStates,
    /// The way of every member; the invariants are looked at every `drift_every` steps.
    pub(super) course: Course,
    pub(super) formulas: StateFunctions,
    pub(super) columns: Vec<Column>,
    pub(super) clock: Clock,
}

/// Where a reduced value comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Column {
    Invariant(usize),
    /// A formula or a coordinate.
    Recorded(usize),
    Indicator(usize),
}

/// Builds the system, the method and the members of a scene with an `[ensemble]` table. Its files are in `directory`.
///
/// # Errors
/// The first thing wrong, underlined in the scene.
pub fn compose_ensemble(
    document: &SceneDocument,
    registry: &Registry,
    directory: &Path,
) -> Result<ComposedEnsemble, Refusal> {
    compose_from(document, registry, directory, None)
}

/// The same with members in memory, in the place of those of `[ensemble] initial`.
///
/// # Errors
/// As [`compose_ensemble`]; members that are not whole, not finite or of another system.
pub fn compose_members(
    document: &SceneDocument,
    registry: &Registry,
    members: &Members,
) -> Result<ComposedEnsemble, Refusal> {
    compose_from(document, registry, Path::new(""), Some(members))
}

fn compose_from(
    document: &SceneDocument,
    registry: &Registry,
    directory: &Path,
    members: Option<&Members>,
) -> Result<ComposedEnsemble, Refusal> {
    let ensemble = section(document)?;
    refuse_estimate(document, "an ensemble")?;
    let mut own = document.clone();
    own.run.record = ensemble.record.clone();
    (own.run.seed, own.run.member) = (ensemble.seed, 0);
    let run = compose(&own, registry)?;
    let refuse = |message: String, help: &str| {
        let help = Some(help.to_owned());
        Box::new(document.diagnostic(&ensemble.place, message, "here", help))
    };
    check_paced(document, ensemble)?;
    let population = Population::of(document, ensemble, &run, directory, members)?;
    let declared = run.system.parameters();
    let varied = population
        .varied()
        .into_iter()
        .map(|at| declared[at].name.as_str());
    let varied: Vec<&str> = varied.collect();
    check_varied(document, &varied, !population.has_states())?;
    let every = ensemble.record.every.min(run.plan.steps.max(1));
    let count = Clock::count(&run, every);
    let numbers = count.saturating_mul(run.plan.observables.len() as u64);
    let most = if ensemble.quantiles.is_empty() {
        MOST_SUMMARIES
    } else {
        MOST_SKETCHES
    };
    if numbers > most {
        return Err(refuse(
            format!("{numbers} statistics over the members, at most {most} are held in memory"),
            "record more rarely: a larger `every` or `interval`",
        ));
    }
    let without_code =
        |error: leafwise_core::BuildError| refuse(error.to_string(), "record something else");
    let mut recorded = 0..;
    let column = |observable: &Observable| match observable {
        Observable::Invariant { index, .. } => Column::Invariant(*index),
        Observable::Indicator { index, .. } => Column::Indicator(*index),
        Observable::Formula { .. } | Observable::Coordinate { .. } => {
            Column::Recorded(recorded.next().unwrap_or_default())
        }
    };
    let columns = run.plan.observables.iter().map(column).collect();
    let formulas = run.recorded_columns().map_err(without_code)?;
    let mut course = run.course(&[]).map_err(without_code)?;
    course.invariants_every = ensemble.record.drift_every;
    Ok(ComposedEnsemble {
        course,
        formulas,
        columns,
        population,
        clock: Clock::of(&run, every),
        quantiles: ensemble.quantiles.clone(),
        final_states: ensemble.final_states,
        run,
    })
}

/// With a pace every member makes steps of its own: all of them are at one time, not after one number of steps.
fn check_paced(document: &SceneDocument, ensemble: &EnsembleSection) -> Result<(), Refusal> {
    let Some(pace) = &document.method.pace else {
        return Ok(());
    };
    let (message, help) = if document.run.until.is_none() {
        (
            "with a pace the members of an ensemble come to different times in one number of steps",
            "write `until`, the time at the end, in place of `steps`",
        )
    } else if ensemble.has_every {
        (
            "with a pace the members of an ensemble are at different times after one number of steps: `every` has no meaning",
            "write an `interval` or `times` into record, in place of `every`",
        )
    } else {
        return Ok(());
    };
    Err(Box::new(document.diagnostic(
        &pace.place(),
        message,
        "here",
        Some(help.to_owned()),
    )))
}

/// The scene's `[ensemble]` table.
pub(super) fn section(document: &SceneDocument) -> Result<&EnsembleSection, Refusal> {
    document.ensemble.as_ref().ok_or_else(|| {
        let end = document.text.trim_end().len();
        let place = leafwise_scene::document::Place {
            source: leafwise_scene::document::Source::Scene,
            span: end..end,
        };
        let help = "for example:\n[ensemble]\nmembers = 1000\ninitial = { ball = 0.1 }";
        Box::new(document.diagnostic(
            &place,
            "the scene has no [ensemble] table",
            "[ensemble] is missing",
            Some(help.to_owned()),
        ))
    })
}

impl ComposedEnsemble {
    /// The marks at which windows of the invariants' deviations end.
    pub(super) fn window_ends(&self) -> Vec<f64> {
        self.clock.windows(MOST_WINDOWS)
    }

    /// The names of the observables.
    pub fn observables(&self) -> Vec<&str> {
        self.run
            .plan
            .observables
            .iter()
            .map(Observable::name)
            .collect()
    }

    /// `energy`, then the Casimirs.
    pub fn invariant_names(&self) -> Vec<&str> {
        let casimirs = self.run.system.casimir_names();
        std::iter::once("energy").chain(casimirs).collect()
    }

    /// Origin that H + e is measured from: e at an initial state, beside a pace; `None` without a pace.
    pub(super) fn origin(&self, initial: &[f64]) -> Option<f64> {
        self.run.origin(initial)
    }

    /// The time at the end.
    pub fn end(&self) -> f64 {
        self.clock.time(self.clock.end())
    }

    /// The times at which observables are reduced: the first and the last among them.
    pub fn sampled(&self) -> Vec<f64> {
        let marks = self.clock.samples.iter();
        marks.map(|mark| self.clock.time(*mark)).collect()
    }

    /// The steps of each member, where all make the same.
    pub fn steps(&self) -> Option<u64> {
        self.run.plan.until.is_none().then_some(self.run.plan.steps)
    }

    pub(super) fn shape(&self) -> Shape {
        Shape {
            times: self.clock.samples.len(),
            observables: self.columns.len(),
            windows: self.window_ends().len(),
            invariants: self.course.invariants.count(),
            has_quantiles: !self.quantiles.is_empty(),
            losses: match self.run.plan.events.stop {
                Some(_) => self.loss_ends().len(),
                None => 0,
            },
        }
    }
}
