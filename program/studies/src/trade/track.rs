//! One candidate in the search: what was tried, what may still pay.

use leafwise_core::{Structure, Walk};

use super::candidate::{Bench, Candidate, Knob, Setting};
use super::grid::{Grid, tolerance};
use super::plateau::Plateau;
use super::tolerances::Violation;
use super::trial::Trial;

/// One run of a candidate.
#[derive(Clone, Debug)]
pub(super) struct Tried {
    pub setting: Setting,
    pub trial: Trial,
    /// The distance from the reference where runs are judged.
    pub error: f64,
    pub excess: Violation,
    /// Whether the run is that of a Poisson map; judged where it meets what is asked.
    pub is_poisson: bool,
}

impl Tried {
    pub fn is_met(&self) -> bool {
        self.excess.ratio <= 1.0
    }
}

/// Why no further run of a candidate is made.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum End {
    /// Whatever it finds, another method does for less.
    Beaten,
    /// More work does not make it more accurate.
    RoundOff,
    /// It would cost more than a run may.
    Budget,
    /// No step of it succeeds.
    Failed(String),
}

/// A candidate with its runs.
pub(super) struct Track<'a> {
    pub candidate: &'a Candidate,
    settings: Vec<Setting>,
    next: usize,
    /// The fewest steps that were tried.
    fewest: u64,
    /// The least cost of a step, however small.
    floor: f64,
    pub tried: Vec<Tried>,
    pub plateau: Plateau,
    pub ended: Option<End>,
}

/// Steps by which the least cost of a step is found, and how many times smaller than the scene's.
const PROBE_STEPS: u64 = 12;
const PROBE_RATIO: f64 = 1.0 / 1024.0;

/// The next error of a method may fall by this much more than its order says.
const OPTIMISM: f64 = 1.0;

/// Bound of the range in which the order is seen: an error or drift below this part of its size follows it.
const ASYMPTOTIC: f64 = 1e-2;

impl<'a> Track<'a> {
    pub fn new(bench: &Bench<'_>, candidate: &'a Candidate) -> Self {
        let mut track = Self {
            candidate,
            settings: Grid::standard(candidate, bench.steps()).settings(),
            next: 0,
            fewest: u64::MAX,
            floor: 0.0,
            tried: Vec::new(),
            plateau: Plateau::default(),
            ended: None,
        };
        if candidate.knob == Knob::Steps {
            match probe(bench, candidate) {
                Ok(floor) => track.floor = floor,
                Err(reason) => track.ended = Some(End::Failed(reason)),
            }
        }
        track
    }

    /// Whether the candidate may be a Poisson map.
    pub fn is_geometric(&self) -> bool {
        !matches!(
            self.candidate.properties.structure,
            Structure::Leaves | Structure::Contact | Structure::None
        )
    }

    /// The next setting, `None` behind the last.
    pub fn setting(&self) -> Option<Setting> {
        self.settings.get(self.next).copied()
    }

    /// Passes to the next setting.
    pub fn advance(&mut self) {
        self.next += 1;
    }

    /// Takes in that a setting is tried.
    pub fn begin(&mut self, setting: Setting) {
        self.fewest = self.fewest.min(setting.steps);
    }

    /// Half the steps, where the cheapest run that meets what is asked has the fewest that were tried: the grid begins
    /// somewhere, and what is exact takes any step.
    pub fn below(&self, poisson: bool) -> Option<Setting> {
        let best = self.cheapest(poisson)?.setting;
        let is_first = best.tolerance.is_none() && best.steps == self.fewest && best.steps > 1;
        is_first.then_some(Setting {
            steps: best.steps / 2,
            tolerance: None,
        })
    }

    /// A lower bound of what the next setting costs.
    pub fn bound(&self) -> f64 {
        let setting = self.setting();
        setting.map_or(f64::INFINITY, |setting| self.bound_at(setting))
    }

    /// A lower bound of the cost of a setting: the cheapest steps, or the runs at larger
    /// tolerances.
    pub fn bound_at(&self, setting: Setting) -> f64 {
        match setting.tolerance {
            None => self.floor * setting.steps as f64,
            Some(_) => {
                let value = value(setting);
                let looser = self
                    .tried
                    .iter()
                    .filter(|t| self::value(t.setting) <= value);
                looser.map(|t| t.trial.cost()).max().unwrap_or(0) as f64
            }
        }
    }

    /// A lower bound of what meets the tolerances, from runs whose errors follow the order; 0 as
    /// long as none do.
    pub fn foreseen(&self) -> f64 {
        let [.., before, last] = self.tried.as_slice() else {
            return 0.0;
        };
        let follows = |t: &Tried| t.excess.relative < ASYMPTOTIC;
        if !follows(before) || !follows(last) || last.is_met() {
            return 0.0;
        }
        let ratio = value(last.setting) / value(before.setting);
        let slope = libm::log(before.excess.ratio / last.excess.ratio) / libm::log(ratio);
        let declared = match self.candidate.knob {
            Knob::Steps => self.candidate.properties.order as f64,
            Knob::Tolerance => 1.0,
        };
        let order = slope.max(declared) + OPTIMISM;
        let needed = value(last.setting) * libm::pow(last.excess.ratio, 1.0 / order);
        match self.candidate.knob {
            Knob::Steps => self.floor * needed,
            Knob::Tolerance => last.trial.cost() as f64,
        }
    }

    /// The cheapest run that meets what is asked, among Poisson maps alone if so wanted.
    pub fn cheapest(&self, poisson: bool) -> Option<&Tried> {
        let met = self
            .tried
            .iter()
            .filter(|t| t.is_met() && (!poisson || t.is_poisson));
        met.min_by_key(|t| t.trial.cost())
    }

    /// Setting between a run that misses what is asked and the cheapest that meets it, where the error model says that
    /// it is just met. Where no run meets it, the setting lies behind the one that misses.
    pub fn between(&self, poisson: bool) -> Option<Setting> {
        let best = self.cheapest(poisson).map(|t| t.setting);
        let below =
            |t: &&Tried| !t.is_met() && best.is_none_or(|best| value(t.setting) < value(best));
        let low = self
            .tried
            .iter()
            .filter(below)
            .max_by(|a, b| value(a.setting).total_cmp(&value(b.setting)))?;
        let high = best.and_then(|best| self.tried.iter().find(|t| t.setting == best));
        let (a, r) = (value(low.setting), low.excess.ratio);
        let wanted = match high {
            Some(high) => {
                let b = value(high.setting);
                let slope = libm::log(r / high.excess.ratio) / libm::log(b / a);
                let guess = a * libm::pow(r / MARGIN, 1.0 / slope.max(0.5));
                // Inside the bracket, off its ends.
                let span = libm::log(b / a);
                let share = (libm::log(guess / a) / span).clamp(0.1, 0.9);
                a * libm::exp(share * span)
            }
            None => {
                let order = match self.candidate.knob {
                    Knob::Steps => self.candidate.properties.order.max(1) as f64,
                    Knob::Tolerance => 1.0,
                };
                a * libm::pow(r / MARGIN, 1.0 / order)
            }
        };
        let setting = match self.candidate.knob {
            Knob::Steps => Setting {
                steps: libm::ceil(wanted) as u64,
                tolerance: None,
            },
            Knob::Tolerance => Setting {
                steps: low.setting.steps,
                tolerance: Some(tolerance(libm::log10(wanted))),
            },
        };
        let is_new = self.tried.iter().all(|t| t.setting != setting);
        is_new.then_some(setting)
    }

    /// Predicts error and cost of a setting from the other runs, by straight lines in a log–log picture. They pass
    /// through the nearest runs on either side, or through the two nearest where one side has none.
    pub fn predicted(&self, setting: Setting, error: impl Fn(&Tried) -> f64) -> Option<(f64, f64)> {
        let at = libm::log(value(setting));
        let mut others: Vec<&Tried> = self.tried.iter().filter(|t| t.setting != setting).collect();
        let distance = |t: &&Tried| (libm::log(value(t.setting)) - at).abs();
        others.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let a = *others.first()?;
        let is_above = |t: &Tried| libm::log(value(t.setting)) > at;
        let across = others.iter().find(|b| is_above(b) != is_above(a));
        let b = *across.or(others.get(1))?;
        let (x, y) = (libm::log(value(a.setting)), libm::log(value(b.setting)));
        let line = |of: &dyn Fn(&Tried) -> f64| {
            let (u, v) = (libm::log(of(a)), libm::log(of(b)));
            libm::exp(u + (v - u) * (at - x) / (y - x))
        };
        Some((line(&error), line(&|t| t.trial.cost() as f64)))
    }
}

/// The model aims at this part of what is allowed.
const MARGIN: f64 = 0.97;

/// Number that rises with the cost of a setting: its steps, or the inverse of its tolerance.
fn value(setting: Setting) -> f64 {
    match setting.tolerance {
        None => setting.steps as f64,
        Some(tolerance) => 1.0 / tolerance,
    }
}

/// The least cost of a step: the cheapest of a few that are far smaller than any that is tried.
fn probe(bench: &Bench<'_>, candidate: &Candidate) -> Result<f64, String> {
    let run = &candidate.run;
    let values = run.system.parameter_values();
    let step = PROBE_RATIO * bench.extent() / bench.steps() as f64;
    let mut walk = Walk::new(run.method.map(), &values, 1.0, step, &run.plan.initial);
    let mut least = u64::MAX;
    let mut before = 0;
    let stepped = walk.watch(PROBE_STEPS, |walk| {
        let after = walk.statistics().cost();
        least = least.min(after - before);
        before = after;
    });
    stepped.map_err(|error| error.to_string())?;
    Ok(least as f64)
}
