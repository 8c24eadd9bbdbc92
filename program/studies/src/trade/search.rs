//! The search for the cheapest run that meets what is asked: branch and bound over all candidates.
//!
//! Settings of all candidates are tried in the order of lower bounds of their costs, so that a
//! setting that was not tried costs more than what was found. Then the steps of the best are
//! refined between those of the grid, and below its first.

use leafwise_core::Structure;

use super::candidate::{Bench, Knob, Setting};
use super::measured::is_poisson;
use super::plateau::SMALL;
use super::reference::Reference;
use super::stage::Stage;
use super::tolerances::Limits;
use super::track::{End, Track, Tried};
use super::trial::{Trial, TrialFailure, run_counted, tensor_defect};

/// A search under way.
pub(super) struct Search<'a> {
    pub bench: &'a Bench<'a>,
    pub reference: &'a Reference,
    pub limits: &'a Limits,
    pub tracks: Vec<Track<'a>>,
    /// Budget of one run: the largest cost that it may have.
    pub budget: u64,
    /// Runs made.
    pub runs: u64,
    /// Total cost of the runs, including those that were stopped or failed.
    pub spent: u64,
}

/// Candidates are followed up to this many times the cost of the cheapest: to name the next best.
const SLACK: f64 = 1.5;

/// Refinements of a candidate's setting between those of the grid.
const REFINEMENTS: usize = 5;

impl Search<'_> {
    /// The cost that a candidate has to beat.
    fn cap(&self, is_geometric: bool) -> u64 {
        let best = |poisson: bool| {
            let found = self.tracks.iter().filter_map(|t| t.cheapest(poisson));
            found.map(|t| t.trial.cost()).min()
        };
        // A Poisson map is worth a run while no other Poisson map is cheaper.
        best(is_geometric).unwrap_or(self.budget).min(self.budget)
    }

    /// Tries settings in the order of their bounds until none can be cheaper than what was found;
    /// `false` when `progress` ends it.
    pub fn screen(&mut self, progress: &mut dyn FnMut(Stage<'_>) -> bool) -> bool {
        loop {
            let open = self
                .tracks
                .iter()
                .enumerate()
                .filter(|(_, t)| t.ended.is_none());
            let next = open.min_by(|a, b| a.1.bound().total_cmp(&b.1.bound()));
            let Some((at, track)) = next else {
                return true;
            };
            let stage = Stage::Running {
                method: &track.candidate.name,
                runs: self.runs,
            };
            if !progress(stage) {
                return false;
            }
            let is_geometric = track.is_geometric();
            let cap = (SLACK * self.cap(is_geometric) as f64).min(self.budget as f64);
            let bound = track.bound().max(track.foreseen());
            if bound >= cap {
                let is_beaten = cap < self.budget as f64;
                self.tracks[at].ended = Some(if is_beaten { End::Beaten } else { End::Budget });
                continue;
            }
            if let Some(setting) = track.setting() {
                self.tracks[at].advance();
                self.try_setting(at, setting, cap as u64);
            }
        }
    }

    /// Runs a candidate at a setting and takes in what it did.
    fn try_setting(&mut self, at: usize, setting: Setting, cap: u64) {
        self.runs += 1;
        self.tracks[at].begin(setting);
        let candidate = self.tracks[at].candidate;
        let time_step = self.bench.extent() / setting.steps as f64;
        let outcome = candidate
            .run_at(self.bench, setting)
            .map_err(|reason| TrialFailure::DoesNotFit { reason })
            .and_then(|run| {
                let curve = self.reference.curve();
                let sizes = [1.0, time_step];
                run_counted(
                    self.bench,
                    &run,
                    sizes,
                    setting.steps,
                    cap,
                    curve,
                    &mut self.spent,
                )
            });
        match outcome {
            Ok(trial) => self.take(at, setting, trial),
            Err(TrialFailure::DoesNotFit { reason }) => {
                self.tracks[at].ended = Some(End::Failed(reason));
            }
            // Coarse steps may fail, or cost more than finer ones.
            Err(_) => {}
        }
    }

    fn take(&mut self, at: usize, setting: Setting, trial: Trial) {
        let excess = self.limits.excess(&trial, self.reference);
        let error = self.reference.error_of(&trial);
        let track = &mut self.tracks[at];
        let mut tried = Tried {
            setting,
            error,
            excess,
            is_poisson: false,
            trial,
        };
        if tried.is_met() {
            let structure = track.candidate.properties.structure;
            if !matches!(
                structure,
                Structure::Leaves | Structure::Contact | Structure::None
            ) {
                let time_step = self.bench.extent() / setting.steps as f64;
                let run = &track.candidate.run;
                let states: [&[f64]; 2] = [&run.plan.initial, &tried.trial.stepped];
                tried.is_poisson = is_poisson(structure, tensor_defect(run, time_step, &states));
            }
        } else {
            let is_flat = track.plateau.is_reached(excess.ratio, tried.trial.cost());
            if is_flat && excess.relative <= SMALL {
                track.ended = Some(End::RoundOff);
            }
        }
        track.tried.push(tried);
    }

    /// Refines the settings of candidates that may become cheaper than the cheapest; `false` when
    /// `progress` ends it.
    pub fn refine(&mut self, progress: &mut dyn FnMut(Stage<'_>) -> bool) -> bool {
        for poisson in [true, false] {
            for at in 0..self.tracks.len() {
                if poisson && !self.tracks[at].is_geometric() {
                    continue;
                }
                let mut refinements = 0;
                while refinements < REFINEMENTS {
                    let cap = self.cap(poisson);
                    let track = &self.tracks[at];
                    let below = track.below(poisson);
                    refinements += usize::from(below.is_none());
                    let Some(setting) = below.or_else(|| track.between(poisson)) else {
                        break;
                    };
                    if !pays(track, setting, cap) {
                        break;
                    }
                    let stage = Stage::Running {
                        method: &track.candidate.name,
                        runs: self.runs,
                    };
                    if !progress(stage) {
                        return false;
                    }
                    self.try_setting(at, setting, cap);
                }
            }
        }
        true
    }
}

/// Whether a setting may cost less than `cap`: by what the nearest run cost a step.
fn pays(track: &Track<'_>, setting: Setting, cap: u64) -> bool {
    let expected = match track.candidate.knob {
        Knob::Tolerance => track.bound_at(setting),
        Knob::Steps => {
            let each = |t: &Tried| t.trial.cost() as f64 / t.setting.steps as f64;
            let least = track.tried.iter().map(each).fold(f64::INFINITY, f64::min);
            least * setting.steps as f64
        }
    };
    expected < cap as f64
}
