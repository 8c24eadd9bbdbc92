//! What an ensemble does.

use std::path::Path;

use leafwise_core::Registry;
use leafwise_expression::Expression;

use super::observers::{Functions, Watched};
use super::population::Population;
use super::states::Members;
use super::statistics::Shape;
use leafwise_scene::compose::{ComposedRun, DENSE_LIMIT, Observable, Refusal, Stepping, compose};
use leafwise_scene::document::{EnsembleSection, FinalStates, SceneDocument};

/// Windows of steps over which the invariants' deviations are taken, at most.
const MOST_WINDOWS: u64 = 32;

/// Observables at their times that are reduced, at most: each holds a summary, and a member one
/// number for each until it is taken in.
const MOST_SUMMARIES: u64 = 1 << 16;

/// The same where each holds a sketch of quantiles, up to 100 kB.
const MOST_SKETCHES: u64 = 1 << 12;

/// An ensemble with its system, method and members.
pub struct ComposedEnsemble {
    /// The method and the scene's own run, its observables those of the ensemble.
    pub run: ComposedRun,
    /// The members.
    pub population: Population,
    /// Every how many steps observables are reduced.
    pub every: u64,
    /// Every how many steps the invariants' deviations are taken in.
    pub drift_every: u64,
    /// The quantiles of every observable.
    pub quantiles: Vec<f64>,
    /// Whether each member's last state is kept.
    pub final_states: FinalStates,
    pub(super) invariants: Functions,
    pub(super) formulas: Functions,
    pub(super) watched: Watched,
    pub(super) columns: Vec<Column>,
}

/// Where a reduced value comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Column {
    Invariant(usize),
    Formula(usize),
}

/// Builds the system, the method and the members of a scene with an `[ensemble]` table; `directory`
/// is where its files are.
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
    let mut own = document.clone();
    own.run.record = ensemble.record.clone();
    let run = compose(&own, registry)?;
    let refuse = |message: String, help: &str| {
        let help = Some(help.to_owned());
        Box::new(document.diagnostic(&ensemble.place, message, "here", help))
    };
    if let Stepping::Lattice(_) = &run.method {
        return Err(refuse(
            format!(
                "an ensemble of lattices of more than {DENSE_LIMIT} coordinates is not offered, and this one has {}: \
                 they step by templates, one at a time",
                run.plan.coordinates
            ),
            "shorten the lattice, or run its members one by one: leafwise run SCENE --set …",
        ));
    }
    if let Some(pace) = &document.method.pace {
        return Err(Box::new(document.diagnostic(
            &pace.place(),
            "an ensemble is not offered with a pace: its statistics are of one time, and with a pace every member has its own",
            "here",
            Some(
                "take the pace out, or run its members one by one: leafwise run SCENE --set run.initial=…".to_owned(),
            ),
        )));
    }
    let population = Population::of(document, ensemble, &run, directory, members)?;
    let steps = run.plan.steps;
    let every = ensemble.record.every.min(steps.max(1));
    let numbers = (steps / every + 2).saturating_mul(run.plan.observables.len() as u64);
    let most = if ensemble.quantiles.is_empty() {
        MOST_SUMMARIES
    } else {
        MOST_SKETCHES
    };
    if numbers > most {
        return Err(refuse(
            format!("{numbers} statistics over the members, at most {most} are held in memory"),
            "write a larger `every` into record",
        ));
    }
    let without_code =
        |error: leafwise_core::BuildError| refuse(error.to_string(), "record something else");
    let mut columns = Vec::with_capacity(run.plan.observables.len());
    let mut expressions = Vec::new();
    for observable in &run.plan.observables {
        columns.push(match observable {
            Observable::Invariant { index, .. } => Column::Invariant(*index),
            Observable::Formula { expression, .. } => {
                expressions.push(expression.clone());
                Column::Formula(expressions.len() - 1)
            }
            Observable::Coordinate { index, .. } => {
                expressions.push(Expression::Variable(*index));
                Column::Formula(expressions.len() - 1)
            }
        });
    }
    let expressions: Vec<&Expression> = expressions.iter().collect();
    let formulas = Functions::formulas(&run.system, &expressions).map_err(without_code)?;
    let invariants = Functions::invariants(&run.system).map_err(without_code)?;
    let watched = Watched::of(&run).map_err(without_code)?;
    Ok(ComposedEnsemble {
        watched,
        invariants,
        formulas,
        columns,
        population,
        every,
        drift_every: ensemble.drift_every,
        quantiles: ensemble.quantiles.clone(),
        final_states: ensemble.final_states,
        run,
    })
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
    /// The steps after which observables are reduced: the first and the last among them.
    pub fn sampled_steps(&self) -> Vec<u64> {
        let steps = self.run.plan.steps;
        let mut sampled: Vec<u64> = (0..=steps / self.every).map(|k| k * self.every).collect();
        if sampled.last() != Some(&steps) {
            sampled.push(steps);
        }
        sampled
    }

    /// Steps in a window of the invariants' deviations.
    pub fn window(&self) -> u64 {
        self.run.plan.steps.div_ceil(MOST_WINDOWS).max(1)
    }

    /// The steps after which windows end.
    pub fn window_ends(&self) -> Vec<u64> {
        let steps = self.run.plan.steps;
        let count = steps.div_ceil(self.window());
        (1..=count)
            .map(|k| (k * self.window()).min(steps))
            .collect()
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

    /// t after so many steps.
    pub fn time(&self, steps: u64) -> f64 {
        steps as f64 * (self.run.plan.epsilon * self.run.plan.h)
    }

    pub(super) fn shape(&self) -> Shape {
        Shape {
            times: self.sampled_steps().len(),
            observables: self.columns.len(),
            windows: self.window_ends().len(),
            invariants: self.invariants.count(),
            has_quantiles: !self.quantiles.is_empty(),
            losses: match self.run.plan.events.stop {
                Some(_) => self.loss_ends().len(),
                None => 0,
            },
        }
    }
}
