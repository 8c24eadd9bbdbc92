//! Every combination of parts measured on every problem.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use leafwise_core::diagnostics::COVECTORS;
use leafwise_core::{BuildError, Registry, StepMap};
use serde::Serialize;

use super::candidates::Candidate;
use super::judgement::Judgement;
use super::measure::{Measured, measure};
use super::problem::{FlowError, Own, Problem};

/// Options of a survey: the orders that it covers, and its threads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurveyOptions {
    /// Every order of every part, not only the defaults.
    pub full: bool,
    /// How many combinations are measured at the same time. What is measured does not depend on it,
    /// apart from times.
    pub threads: NonZeroUsize,
}

/// One step map on one problem.
#[derive(Clone, Debug)]
pub struct Row {
    /// The problem.
    pub problem: String,
    /// The map.
    pub map: String,
    /// Whether it is the scene's own.
    pub is_own: bool,
    /// The declared order in t.
    pub declared_order: usize,
    /// The order that seams and tables of the problem may reduce a step to; `None` where its formulas are smooth.
    pub smooth_order: Option<usize>,
    /// The declared structure, in words.
    pub declared_structure: String,
    /// Measurements of the map; `None` where they fail.
    pub measured: Option<Measured>,
    /// Reason why nothing was measured.
    pub failure: Option<String>,
    /// How long measuring took.
    pub seconds: f64,
}

impl Row {
    /// Whether every declaration that could be judged is met, and no solve fails that has a solution.
    pub fn is_met(&self) -> bool {
        self.measured.as_ref().is_some_and(|m| {
            m.broken_solve.is_none() && m.all_judgements().all(|j| j != Judgement::NotMet)
        })
    }

    /// Whether the problem's formulas are too rough for the declared order.
    pub fn is_rough(&self) -> bool {
        self.smooth_order
            .is_some_and(|order| order < self.declared_order)
    }

    /// Whether a declaration could not be told from the order below.
    pub fn is_undecided(&self) -> bool {
        self.measured
            .as_ref()
            .is_some_and(|m| m.all_judgements().any(|j| j == Judgement::Undecided))
    }
}

/// A combination that does not fit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Refused {
    /// The problem.
    pub problem: String,
    /// The parts.
    pub combination: String,
    /// Reason for the refusal: what is missing, in words.
    pub reason: String,
    /// Who refuses: a part, or the whole combination.
    #[serde(skip)]
    who: String,
    /// The reason without a name, the same for all that lack the same.
    #[serde(skip)]
    cause: String,
}

impl Refused {
    fn new(registry: &Registry, problem: &str, combination: String, error: &BuildError) -> Self {
        let (who, cause) = match error {
            BuildError::NotOffered {
                part,
                system,
                missing,
            } => (
                (*part).to_owned(),
                format!("{missing} are needed, and {system} offers only numbers"),
            ),
            BuildError::Forces { part } => (
                part.clone(),
                "it integrates only x' = {H, x}, and this system has forces".to_owned(),
            ),
            BuildError::Friction { part } => (
                part.clone(),
                "it steps by Poisson maps or along symplectic leaves, and this system has friction"
                    .to_owned(),
            ),
            BuildError::DoesNotFit { part, reason } => ((*part).to_owned(), reason.clone()),
            BuildError::Incompatible { reason, .. } => (combination.clone(), reason.clone()),
            BuildError::LiftAlone { .. } => (
                combination.clone(),
                "its points are coordinates in which the tensor is constant".to_owned(),
            ),
            other => (combination.clone(), other.to_string()),
        };
        Self {
            problem: problem.to_owned(),
            reason: registry.explain(error),
            combination,
            who,
            cause: match registry.instead(error) {
                Some(instead) => format!("{cause}; {instead}"),
                None => cause,
            },
        }
    }
}

/// All that does not fit a problem for one reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal<'a> {
    /// The problem.
    pub problem: &'a str,
    /// The reason.
    pub cause: &'a str,
    /// Parts that fit in no combination, and combinations of parts that do not fit each other.
    pub who: Vec<&'a str>,
}

/// All rows, and the combinations that do not fit.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// The rows.
    pub rows: Vec<Row>,
    /// Combinations refused when they were built, with the reason.
    pub refused: Vec<Refused>,
    /// The problems of many coordinates, of which a part is measured.
    pub sampled: Vec<Sampled>,
}

/// Extent of the measurements of a problem of many coordinates.
#[derive(Clone, Debug, Serialize)]
pub struct Sampled {
    /// The problem.
    pub problem: String,
    /// How many coordinates it has.
    pub coordinates: usize,
    /// The number of random covectors along which tensor defects are measured.
    pub covectors: usize,
    /// Whether the scene's own method alone is measured.
    pub is_own_alone: bool,
}

impl Survey {
    /// Whether every declaration is met.
    pub fn is_met(&self) -> bool {
        self.rows.iter().all(Row::is_met)
    }

    /// Groups the combinations that do not fit, a problem and a reason at a time.
    pub fn refusals(&self) -> Vec<Refusal<'_>> {
        let mut refusals: Vec<Refusal<'_>> = Vec::new();
        for refused in &self.refused {
            let same = |known: &&mut Refusal<'_>| {
                (known.problem, known.cause) == (&refused.problem, &refused.cause)
            };
            match refusals.iter_mut().find(same) {
                Some(known) if known.who.contains(&refused.who.as_str()) => {}
                Some(known) => known.who.push(&refused.who),
                None => refusals.push(Refusal {
                    problem: &refused.problem,
                    cause: &refused.cause,
                    who: vec![&refused.who],
                }),
            }
        }
        refusals
    }
}

/// Receiver of the progress of a survey while it goes on.
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

/// Outcome of a combination: refused, or measured as a row.
enum Outcome {
    Refused(Refused),
    Row(Box<Row>),
}

/// Measures every step map that the registry's parts make on each problem. Rows come in one order whatever the number
/// of threads. Each comes as soon as it and all before it are measured.
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
        // The scene's own method comes first.
        let own = usize::from(problem.own.is_some());
        let is_alone = problem.is_sampled() && own == 1 && !options.full;
        let count = if is_alone {
            own
        } else {
            own + candidates.len()
        };
        if problem.is_sampled() {
            survey.sampled.push(Sampled {
                problem: problem.name.clone(),
                coordinates: problem.system.dimension(),
                covectors: COVECTORS,
                is_own_alone: is_alone,
            });
        }
        progress.problem(&problem.name, count);
        let measured = |at: usize| match &problem.own {
            Some(scene) if at == 0 => {
                row(problem, scene.map.as_ref(), Some(scene), (&flow, horizon))
            }
            _ => outcome(registry, problem, &candidates[at - own], &flow, horizon),
        };
        in_order(
            count,
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

/// work(0), work(1), … on several threads, as far as the machine grants any, handed over in this order.
fn in_order<T: Send>(
    count: usize,
    threads: usize,
    work: &(dyn Fn(usize) -> T + Sync),
    mut take: impl FnMut(T),
) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        let granted = (0..threads.min(count)).filter(|_| {
            let (sender, next) = (sender.clone(), &next);
            let worker = move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    if at >= count || sender.send((at, work(at))).is_err() {
                        return;
                    }
                }
            };
            std::thread::Builder::new()
                .spawn_scoped(scope, worker)
                .is_ok()
        });
        if granted.count() == 0 {
            (0..count).map(work).for_each(take);
            return;
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
    match candidate.build(registry, problem) {
        Ok(map) => row(problem, map.as_ref(), None, (flow, horizon)),
        Err(error) => Outcome::Refused(Refused::new(
            registry,
            &problem.name,
            candidate.to_string(),
            &error,
        )),
    }
}

fn row(
    problem: &Problem,
    map: &dyn StepMap,
    own: Option<&Own>,
    (flow, horizon): (&[f64], f64),
) -> Outcome {
    let started = Instant::now();
    let properties = map.properties();
    let only_step = own.and_then(|own| own.only_step);
    let (measured, failure) = match measure(problem, map, (flow, horizon), only_step) {
        Ok(measured) => (Some(measured), None),
        Err(error) => (None, Some(error.to_string())),
    };
    Outcome::Row(Box::new(Row {
        problem: problem.name.clone(),
        map: map.describe(),
        is_own: own.is_some(),
        declared_order: properties.order,
        smooth_order: problem.smooth_order(),
        declared_structure: properties.structure.to_string(),
        measured,
        failure,
        seconds: started.elapsed().as_secs_f64(),
    }))
}

#[cfg(test)]
mod tests {
    use leafwise_core::{BuildError, Registry};

    use super::{Refused, Survey, in_order};

    #[test]
    fn what_lacks_the_same_is_reported_together() {
        let registry = Registry::empty();
        let lacks = |part: &'static str| BuildError::NotOffered {
            part,
            system: "acme/top".to_owned(),
            missing: "formulas of the system",
        };
        let tensor = |part: &'static str| BuildError::DoesNotFit {
            part,
            reason: "the tensor is not constant".to_owned(),
        };
        let pair = BuildError::Incompatible {
            dynamics: "hamilton-jacobi m = 4".to_owned(),
            realization: "acme/chart".to_owned(),
            reason: "it offers no code".to_owned(),
        };
        let refused = |problem: &str, combination: &str, error: &BuildError| {
            Refused::new(&registry, problem, combination.to_owned(), error)
        };
        let survey = Survey {
            rows: Vec::new(),
            sampled: Vec::new(),
            refused: vec![
                refused("top", "constant + collective", &lacks("constant")),
                refused("top", "constant + hamilton-jacobi", &lacks("constant")),
                refused("top", "acme/chart + hamilton-jacobi", &pair),
                refused("top", "splitting", &lacks("splitting")),
                refused("other", "constant + collective", &tensor("constant")),
            ],
        };
        let told: Vec<_> = survey
            .refusals()
            .into_iter()
            .map(|refusal| (refusal.problem, refusal.who.join(", "), refusal.cause))
            .collect();
        let lacking = "formulas of the system are needed, and acme/top offers only numbers; what \
                       serves it: no part of this program";
        let expected = [
            ("top", "constant, splitting", lacking),
            ("top", "acme/chart + hamilton-jacobi", "it offers no code"),
            ("other", "constant", "the tensor is not constant"),
        ];
        assert_eq!(told, expected.map(|(a, b, c)| (a, b.to_owned(), c)));
        // Nothing is left out of the list itself.
        assert_eq!(survey.refused[1].combination, "constant + hamilton-jacobi");
        assert_eq!(
            survey.refused[1].reason,
            registry.explain(&lacks("constant"))
        );
    }

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
