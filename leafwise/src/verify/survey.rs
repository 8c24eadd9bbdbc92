//! Every combination of parts measured on every problem.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use leafwise_core::{Registry, Structure};
use serde::Serialize;

use super::candidates::Candidate;
use super::judgement::Judgement;
use super::measure::{Measured, measure};
use super::problem::{FlowError, Problem};

/// What a survey covers, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurveyOptions {
    /// Every order of every part, not only the defaults.
    pub full: bool,
    /// How many combinations are measured at the same time. What is measured does not depend on it,
    /// apart from times.
    pub threads: NonZeroUsize,
}

/// One step map on one problem.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The problem.
    pub problem: String,
    /// The map.
    pub map: String,
    /// The declared order in t.
    pub declared_order: usize,
    /// The declared structure, in words.
    pub declared_structure: String,
    /// What was measured.
    pub measured: Option<Measured>,
    /// Why nothing was.
    pub failure: Option<String>,
    /// How long building and measuring took.
    pub seconds: f64,
}

impl Row {
    /// Whether every declaration that could be judged is met.
    pub fn is_met(&self) -> bool {
        self.measured
            .as_ref()
            .is_some_and(|m| !m.judgements.contains(&Judgement::NotMet))
    }

    /// Whether a declaration could not be told from the order below.
    pub fn is_undecided(&self) -> bool {
        self.measured
            .as_ref()
            .is_some_and(|m| m.judgements.contains(&Judgement::Undecided))
    }
}

/// A combination that does not fit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Refused {
    /// The problem.
    pub problem: String,
    /// The parts.
    pub combination: String,
    /// What is missing.
    pub reason: String,
}

/// All rows, and the combinations that do not fit.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Survey {
    /// The rows.
    pub rows: Vec<Row>,
    /// Combinations refused when they were built, with the reason.
    pub refused: Vec<Refused>,
}

impl Survey {
    /// Whether every declaration is met.
    pub fn is_met(&self) -> bool {
        self.rows.iter().all(Row::is_met)
    }
}

/// What a survey tells while it goes on.
pub trait Progress {
    /// A problem is about to be measured with `combinations` of parts.
    fn problem(&mut self, name: &str, combinations: usize);
    /// The next combination does not fit.
    fn refused(&mut self, refused: &Refused);
    /// The next row.
    fn row(&mut self, row: &Row);
}

/// Global errors are measured over so many of a problem's steps.
const HORIZON: f64 = 20.0;

/// What became of a combination.
enum Outcome {
    Refused(Refused),
    Row(Box<Row>),
}

/// Measures every step map that the registry's parts make on each problem. Rows come in one order
/// whatever the number of threads, each as soon as it and all before it are measured.
///
/// # Errors
/// [`FlowError`] when a problem's reference flow cannot be computed.
pub fn survey(
    registry: &Registry,
    problems: &[Problem],
    options: &SurveyOptions,
    progress: &mut dyn Progress,
) -> Result<Survey, FlowError> {
    let candidates = Candidate::all(registry, options.full);
    let mut survey = Survey::default();
    for problem in problems {
        let horizon = HORIZON * problem.time_step;
        let flow = problem.flow(registry, horizon)?;
        progress.problem(&problem.name, candidates.len());
        let measured = |at: usize| outcome(registry, problem, &candidates[at], &flow, horizon);
        in_order(
            candidates.len(),
            options.threads.get(),
            &measured,
            |outcome| match outcome {
                Outcome::Refused(refused) => {
                    progress.refused(&refused);
                    if !survey.refused.contains(&refused) {
                        survey.refused.push(refused);
                    }
                }
                Outcome::Row(row) => {
                    progress.row(&row);
                    survey.rows.push(*row);
                }
            },
        );
    }
    Ok(survey)
}

/// work(0), work(1), … on several threads, handed over in this order.
fn in_order<T: Send>(
    count: usize,
    threads: usize,
    work: &(dyn Fn(usize) -> T + Sync),
    mut take: impl FnMut(T),
) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.min(count) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    if at >= count || sender.send((at, work(at))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut early = BTreeMap::new();
        let mut due = 0;
        for (at, result) in receiver {
            early.insert(at, result);
            while let Some(result) = early.remove(&due) {
                take(result);
                due += 1;
            }
        }
    });
}

fn outcome(
    registry: &Registry,
    problem: &Problem,
    candidate: &Candidate,
    flow: &[f64],
    horizon: f64,
) -> Outcome {
    let started = Instant::now();
    let map = match candidate.build(registry, &problem.system) {
        Ok(map) => map,
        Err(error) => {
            return Outcome::Refused(Refused {
                problem: problem.name.clone(),
                combination: candidate.to_string(),
                reason: error.to_string(),
            });
        }
    };
    let properties = map.properties();
    let (measured, failure) = match measure(problem, map.as_ref(), flow, horizon) {
        Ok(measured) => (Some(measured), None),
        Err(error) => (None, Some(error.to_string())),
    };
    Outcome::Row(Box::new(Row {
        problem: problem.name.clone(),
        map: map.describe(),
        declared_order: properties.order,
        declared_structure: structure(properties.structure),
        measured,
        failure,
        seconds: started.elapsed().as_secs_f64(),
    }))
}

fn structure(structure: Structure) -> String {
    match structure {
        Structure::Exact => "exact".to_owned(),
        Structure::Order(n) => format!("order {n}"),
        Structure::None => "none".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::in_order;

    #[test]
    fn results_come_in_order_from_any_number_of_threads() {
        for threads in 1..5 {
            let mut taken = Vec::new();
            // The first of a few takes the longest.
            let work =
                |at: usize| (0..(7 - at % 7) * 1000).fold(at, |a, _| std::hint::black_box(a));
            in_order(40, threads, &work, |result| taken.push(result));
            assert_eq!(taken, (0..40).collect::<Vec<_>>());
        }
    }
}
