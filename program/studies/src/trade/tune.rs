//! The cheapest method and step that hold what is asked, found by measuring.

use leafwise_core::{StepMap, Structure};
use leafwise_scene::document::MethodTable;
use leafwise_scene::{SceneDocument, compose};
use serde::Serialize;

use super::candidate::{Bench, Candidate, Setting};
use super::catalogue::{Entry, UNBUILT, catalogue};
use super::compare::some_fit;
use super::error::TradeError;
use super::horizon::Horizon;
use super::measured::{Cost, Measured};
use super::reference::{Judged, Reference};
use super::search::Search;
use super::stage::Stage;
use super::tolerances::{Limits, Tolerances};
use super::track::{End, Track, Tried};
use super::trial::{run_counted, run_trial, time_run};

/// Options of a tuner: the methods to try, the budget of a run and where runs are judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TuneOptions {
    /// Methods beside all that fit the scene.
    pub with: Vec<MethodTable>,
    /// These methods alone, where there are any.
    pub only: Vec<MethodTable>,
    /// Largest number of operations that one run may cost. The default is [`MOST_OPERATIONS`], or ten runs of the
    /// scene's own method where that is more.
    pub budget: Option<u64>,
    /// Where runs are judged.
    pub judged: Judged,
}

/// Usual budget of one run, in operations: about a second.
pub const MOST_OPERATIONS: u64 = 500_000_000;

/// The methods that fit a scene and the state that they are judged by.
pub struct Tuner<'a> {
    bench: &'a Bench<'a>,
    reference: Reference,
    candidates: Vec<Candidate>,
    refused: Vec<(String, String)>,
    budget: u64,
    cost: Cost,
}

/// A method with its step.
#[derive(Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// The method.
    pub method: MethodTable,
    /// One line: parts and orders.
    pub name: String,
    /// Steps and tolerance.
    pub setting: Setting,
    /// εh.
    pub time_step: f64,
    /// Prediction of error and cost from the runs beside it; `None` with fewer than two.
    pub predicted: Option<Predicted>,
    /// Structure that the method declares to keep.
    pub structure: Structure,
    /// Measurements of the run, stepped as `leafwise run` will.
    pub measured: Measured,
    /// The scene with this method.
    pub scene: String,
}

/// Prediction for a run: its error and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// The error where runs are judged.
    pub error: f64,
    /// The [`Tuner::cost`].
    pub cost: f64,
}

/// A run that came as near as any to what is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// The method at its setting.
    pub name: String,
    /// Steps and tolerance.
    pub setting: Setting,
    /// The error where runs are judged.
    pub error: f64,
    /// The largest deviation of each invariant, the energy first.
    pub drift: Vec<f64>,
    /// The largest ratio of what was measured to what is asked.
    pub ratio: f64,
    /// Name of the quantity that is missed by that ratio: `state`, or an invariant's name.
    pub missed: String,
    /// Why it does not come nearer.
    pub limit: Limit,
}

/// Obstacle that keeps a method from what is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// The reference itself is not known as well as is asked.
    Reference,
    /// Smaller steps do not help: round-off, or the motion's own sensitivity to it.
    RoundOff,
    /// A run may not cost as much as it would take.
    Budget,
    /// The search was ended first.
    #[serde(rename = "time")]
    Ended,
    /// Steps that are small enough fail.
    Failure,
    /// None of the methods is a Poisson map.
    Structure,
}

/// Result of tuning: the methods recommended, the next best, and the effort of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// Tolerances that were asked for, as given: of the state, the energy and the Casimirs.
    pub asked: Tolerances,
    /// The cheapest Poisson map that holds it.
    pub poisson: Option<Recommendation>,
    /// The cheapest of all methods that hold it.
    pub any: Option<Recommendation>,
    /// The next best, the cheapest run of each: first Poisson maps, then the others.
    pub runners_up: Vec<RunnerUp>,
    /// The Poisson map's run that comes nearest, where none holds it.
    pub nearest: Option<Reached>,
    /// Whether the search came to its own end; otherwise a cheaper method may not have been tried.
    pub is_complete: bool,
    /// Methods tried.
    pub methods: usize,
    /// Runs made.
    pub runs: u64,
    /// Total cost of the runs in the unit of [`Tuner::cost`], including those that were stopped or failed.
    pub spent: u64,
    /// Why there is no Poisson map that holds what is asked, where there is none.
    pub limit: Option<Limit>,
    /// How long the motion can be known as well as is asked, where the reference is the limit.
    pub horizon: Option<Horizon>,
}

/// A method that holds what is asked and is not the cheapest.
#[derive(Clone, Debug, PartialEq)]
pub struct RunnerUp {
    /// Parts and orders.
    pub name: String,
    /// Steps and tolerance.
    pub setting: Setting,
    /// The [`Tuner::cost`].
    pub cost: u64,
    /// The error where runs are judged.
    pub error: f64,
    /// Whether it is a Poisson map.
    pub is_poisson: bool,
}

/// How many of each kind are listed.
const RUNNERS_UP: usize = 5;

impl<'a> Tuner<'a> {
    /// Builds every method that fits the scene and computes the reference. Calls `progress` before each stage. While
    /// that returns `false`, no method is built but the scene's own: see [`unbuilt`](Self::unbuilt).
    ///
    /// # Errors
    /// [`TradeError::NoReference`], [`TradeError::NoMethods`].
    pub fn new(
        bench: &'a Bench<'a>,
        options: &TuneOptions,
        progress: &mut dyn FnMut(Stage<'_>) -> bool,
    ) -> Result<Self, TradeError> {
        let mut building = |method: &str| progress(Stage::Building { method });
        let mut entries = if options.only.is_empty() {
            catalogue(bench, None, &mut building)
        } else {
            Vec::new()
        };
        for method in options.only.iter().chain(&options.with) {
            let candidate = if building(&method.to_string()) {
                Candidate::build(bench, method)
            } else {
                Err(UNBUILT.to_owned())
            };
            entries.push(Entry {
                method: method.clone(),
                candidate,
            });
        }
        let entries = some_fit(entries)?;
        progress(Stage::Reference);
        let reference = Reference::compute(bench, options.judged)?;
        let (mut candidates, mut refused) = (Vec::new(), Vec::new());
        for entry in entries {
            match entry.candidate {
                Ok(candidate) => candidates.push(candidate),
                Err(reason) => refused.push((entry.method.to_string(), reason)),
            }
        }
        let own = run_trial(
            bench,
            bench.own(),
            [1.0, bench.extent() / bench.steps() as f64],
            bench.steps(),
            u64::MAX,
        );
        let own = own.map_or(0, |trial| 10 * trial.cost());
        let budget = options.budget.unwrap_or(own.max(MOST_OPERATIONS));
        let mut tuner = Self {
            bench,
            reference,
            candidates,
            refused,
            budget,
            cost: Cost::Evaluations,
        };
        tuner.choose_cost();
        Ok(tuner)
    }

    /// Costs are compared in one unit: where some methods count operations, those that do not are
    /// left out.
    fn choose_cost(&mut self) {
        let counts = |candidate: &Candidate| {
            let run = &candidate.run;
            let values = run.system.parameter_values();
            let map: &dyn StepMap = run.method.map();
            map.stepper(1, &values, 1.0, 1.0)
                .statistics()
                .operations
                .is_some()
        };
        if !self.candidates.iter().any(counts) {
            return;
        }
        self.cost = Cost::Operations;
        let (kept, left_out): (Vec<_>, Vec<_>) = std::mem::take(&mut self.candidates)
            .into_iter()
            .partition(counts);
        self.candidates = kept;
        let reason = "it does not count its operations";
        let names = left_out.into_iter().map(|candidate| candidate.name);
        self.refused
            .extend(names.map(|name| (name, reason.to_owned())));
    }

    /// Cost by which runs are compared: [`Cost::Operations`], or [`Cost::Evaluations`] where no method counts its own.
    pub fn cost(&self) -> Cost {
        self.cost
    }

    /// Reference solution that errors are measured against.
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// The methods that fit, by name.
    pub fn methods(&self) -> impl Iterator<Item = &str> {
        self.candidates
            .iter()
            .map(|candidate| candidate.name.as_str())
    }

    /// Methods that do not fit, with the reason.
    pub fn refused(&self) -> &[(String, String)] {
        &self.refused
    }

    /// How many methods were not built because `progress` said so.
    pub fn unbuilt(&self) -> usize {
        let reasons = self.refused.iter().map(|(_, reason)| reason);
        reasons.filter(|reason| *reason == UNBUILT).count()
    }

    /// Budget of one run: the largest cost that it may have.
    pub fn budget(&self) -> u64 {
        self.budget
    }

    /// Finds the cheapest methods that hold `asked`. Calls `progress` before each run; returning `false` ends the
    /// search. The cheapest of those tried is then returned, and not timed.
    ///
    /// # Errors
    /// [`TradeError::NoCasimirs`]; [`TradeError::Build`] for an invariant without code.
    pub fn tune(
        &self,
        asked: &Tolerances,
        progress: &mut dyn FnMut(Stage<'_>) -> bool,
    ) -> Result<Tuning, TradeError> {
        asked.check(self.bench)?;
        let initial = self.initial_invariants()?;
        let limits = asked.limits(&self.reference, &initial);
        let mut search = Search {
            bench: self.bench,
            reference: &self.reference,
            limits: &limits,
            tracks: self
                .candidates
                .iter()
                .map(|c| Track::new(self.bench, c))
                .collect(),
            budget: self.budget,
            runs: 0,
            spent: 0,
        };
        // What the reference cannot judge is not searched for.
        let can_judge = self.reference.error < limits.error;
        let is_searched = !can_judge || search.screen(progress) && search.refine(progress);
        let repetitions = if is_searched { REPETITIONS } else { 0 };
        let recommend = |poisson| self.recommend(&search, poisson, repetitions);
        let [poisson, any] = [true, false].map(recommend);
        let nearest = match poisson {
            None if can_judge => self.nearest(&search, is_searched),
            _ => None,
        };
        let limit = match (&poisson, &nearest) {
            (Some(_), _) => None,
            (None, _) if !can_judge => Some(Limit::Reference),
            (None, None) if !search.tracks.iter().any(Track::is_geometric) => {
                Some(Limit::Structure)
            }
            (None, None) if !is_searched => Some(Limit::Ended),
            // No run came to its end.
            (None, None) => Some(Limit::Budget),
            (None, Some(reached)) => Some(reached.limit),
        };
        Ok(Tuning {
            asked: *asked,
            runners_up: runners_up(&search, [&poisson, &any]),
            poisson,
            any,
            nearest,
            is_complete: is_searched && self.unbuilt() == 0,
            methods: self.candidates.len(),
            runs: search.runs,
            spent: search.spent,
            limit,
            horizon: (!can_judge).then(|| self.reference.horizon(self.bench, limits.error)),
        })
    }

    fn initial_invariants(&self) -> Result<Vec<f64>, TradeError> {
        let own = self.bench.own();
        let mut observer = own.invariants()?;
        let mut values = vec![0.0; observer.observables()];
        observer.evaluate(&own.plan.initial, &mut values);
        Ok(values)
    }

    /// The cheapest run, repeated as the scene that is to be written runs it; the next one where
    /// the last bits of ε·h make it miss.
    fn recommend(
        &self,
        search: &Search<'_>,
        poisson: bool,
        repetitions: usize,
    ) -> Option<Recommendation> {
        let mut met: Vec<(&Track<'_>, &Tried)> = search
            .tracks
            .iter()
            .flat_map(|track| track.tried.iter().map(move |tried| (track, tried)))
            .filter(|(_, tried)| tried.is_met() && (!poisson || tried.is_poisson))
            .collect();
        met.sort_by_key(|(_, tried)| tried.trial.cost());
        met.into_iter()
            .find_map(|(track, tried)| self.repeat(track, tried, search.limits, repetitions))
    }

    fn repeat(
        &self,
        track: &Track<'_>,
        tried: &Tried,
        limits: &Limits,
        repetitions: usize,
    ) -> Option<Recommendation> {
        let setting = tried.setting;
        let method = track.candidate.method_at(setting);
        let time_step = self.bench.extent() / setting.steps as f64;
        let document = self.bench.document();
        let scene = method
            .write_into(&document.text, time_step, setting.steps)
            .ok()?;
        let written = SceneDocument::parse(&document.name, &scene, self.bench.registry()).ok()?;
        let run = compose(&written, self.bench.registry()).ok()?;
        let (epsilon, h, steps) = (run.plan.epsilon, run.plan.h, setting.steps);
        let curve = self.reference.curve();
        let trial = run_counted(
            self.bench,
            &run,
            [epsilon, h],
            steps,
            u64::MAX,
            curve,
            &mut 0,
        )
        .ok()?;
        if limits.excess(&trial, &self.reference).ratio > 1.0 {
            return None;
        }
        let structure = track.candidate.properties.structure;
        let mut measured = Measured::of(&trial, &run, time_step, structure, &self.reference);
        if repetitions > 0 {
            measured.wall = time_run(&run, epsilon, h, steps, repetitions).ok();
        }
        let predicted = track.predicted(setting, |tried| tried.error);
        Some(Recommendation {
            name: track.candidate.name.clone(),
            method,
            setting,
            time_step,
            predicted: predicted.map(|(error, cost)| Predicted { error, cost }),
            structure,
            measured,
            scene,
        })
    }

    /// The run of a Poisson map that misses by the least.
    fn nearest(&self, search: &Search<'_>, is_searched: bool) -> Option<Reached> {
        let runs = search
            .tracks
            .iter()
            .filter(|track| track.is_geometric())
            .flat_map(|track| track.tried.iter().map(move |tried| (track, tried)));
        let least = runs.min_by(|a, b| a.1.excess.ratio.total_cmp(&b.1.excess.ratio));
        let names = self.bench.invariants();
        let (track, tried) = least?;
        Some(Reached {
            name: track.candidate.name.clone(),
            setting: tried.setting,
            error: tried.error,
            drift: tried.trial.drift.clone(),
            ratio: tried.excess.ratio,
            missed: match tried.excess.invariant {
                None => "state".to_owned(),
                Some(at) => names.get(at).cloned().unwrap_or_default(),
            },
            limit: match &track.ended {
                Some(End::RoundOff) => Limit::RoundOff,
                Some(End::Failed(_)) => Limit::Failure,
                None if !is_searched => Limit::Ended,
                _ => Limit::Budget,
            },
        })
    }
}

/// How often the recommended run is timed.
const REPETITIONS: usize = 5;

fn runners_up(search: &Search<'_>, recommended: [&Option<Recommendation>; 2]) -> Vec<RunnerUp> {
    let mut of_kind = [Vec::new(), Vec::new()];
    for track in &search.tracks {
        let Some(tried) = track
            .cheapest(track.is_geometric())
            .or(track.cheapest(false))
        else {
            continue;
        };
        let is_recommended = recommended
            .iter()
            .copied()
            .flatten()
            .any(|r| r.method == track.candidate.method_at(r.setting));
        if !is_recommended {
            of_kind[usize::from(!tried.is_poisson)].push(RunnerUp {
                name: track.candidate.name.clone(),
                setting: tried.setting,
                cost: tried.trial.cost(),
                error: tried.error,
                is_poisson: tried.is_poisson,
            });
        }
    }
    let mut runners_up = Vec::new();
    for mut kind in of_kind {
        kind.sort_by_key(|runner| runner.cost);
        kind.truncate(RUNNERS_UP);
        runners_up.append(&mut kind);
    }
    runners_up
}
