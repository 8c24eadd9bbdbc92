//! Every pair of realization and dynamics, every stepper and every composition.

use std::sync::Arc;

use leafwise_core::part::PartKind;
use leafwise_core::{BuildError, Method, PartParameters, Registry, StepMap};
use serde::Serialize;

use super::measure::{Judgement, Measured, measure};
use super::problem::{FlowError, Problem};

/// What a survey covers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SurveyOptions {
    /// Every order of every part, not only the defaults.
    pub full: bool,
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
}

impl Row {
    /// Whether every declaration that could be judged is met.
    pub fn is_met(&self) -> bool {
        self.measured
            .as_ref()
            .is_some_and(|m| !m.judgements.contains(&Judgement::NotMet))
    }
}

/// All rows, and the combinations that do not fit.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Survey {
    /// The rows.
    pub rows: Vec<Row>,
    /// Combinations refused when they were built, with the reason.
    pub refused: Vec<(String, String)>,
}

impl Survey {
    /// Whether every declaration is met.
    pub fn is_met(&self) -> bool {
        self.rows.iter().all(Row::is_met)
    }
}

/// Measures every step map that the registry's parts make on each problem; `progress` is told
/// before each one.
///
/// # Errors
/// [`FlowError`] when a problem's reference flow cannot be computed.
pub fn survey(
    registry: &Registry,
    problems: &[Problem],
    options: &SurveyOptions,
    progress: &mut dyn FnMut(&str, &str),
) -> Result<Survey, FlowError> {
    let mut survey = Survey::default();
    for problem in problems {
        let horizon = 10.0 * problem.time_step;
        let flow = problem.flow(registry, horizon)?;
        for (name, map) in maps(registry, problem, options) {
            let map = match map {
                Ok(map) => map,
                Err(error) => {
                    survey
                        .refused
                        .push((format!("{name} on {}", problem.name), error.to_string()));
                    continue;
                }
            };
            progress(&problem.name, &name);
            let properties = map.properties();
            let (measured, failure) = match measure(problem, map.as_ref(), &flow, horizon) {
                Ok(measured) => (Some(measured), None),
                Err(error) => (None, Some(error.to_string())),
            };
            survey.rows.push(Row {
                problem: problem.name.clone(),
                map: name,
                declared_order: properties.order,
                declared_structure: structure(properties.structure),
                measured,
                failure,
            });
        }
    }
    Ok(survey)
}

fn structure(structure: leafwise_core::Structure) -> String {
    match structure {
        leafwise_core::Structure::Exact => "exact".to_owned(),
        leafwise_core::Structure::Order(n) => format!("order {n}"),
        leafwise_core::Structure::None => "none".to_owned(),
    }
}

type Candidate = (String, Result<Arc<dyn StepMap>, BuildError>);

/// The parameters a part is tried with: its defaults, or several orders.
fn settings(registry: &Registry, name: &str, options: &SurveyOptions) -> Vec<PartParameters> {
    let with = |key: &str, values: &[i64]| {
        values
            .iter()
            .map(|v| PartParameters::new().with(key, *v))
            .collect()
    };
    let info = registry.parts().into_iter().find(|info| info.name == name);
    let takes = |key: &str| {
        info.is_some_and(|info| {
            info.parameters
                .iter()
                .any(|parameter| parameter.name == key)
        })
    };
    match name {
        "hamilton-jacobi" if options.full => with("order", &[2, 4, 6, 8]),
        "karasev-truncated" if options.full => with("order", &[1, 2, 3, 4, 6, 8]),
        "karasev-collocated" if options.full => with("points", &[0, 1, 2, 3]),
        _ if options.full && takes("stages") => with("stages", &[1, 2, 3]),
        // An adaptive method shows its order where the tolerance leaves the step alone.
        _ if takes("tolerance") => vec![PartParameters::new().with("tolerance", 0.1)],
        _ => vec![PartParameters::new()],
    }
}

fn maps(registry: &Registry, problem: &Problem, options: &SurveyOptions) -> Vec<Candidate> {
    let of_kind = |kind: PartKind| -> Vec<&'static str> {
        registry
            .parts()
            .into_iter()
            .filter(|p| p.kind == kind)
            .map(|p| p.name)
            .collect()
    };
    let mut maps: Vec<Candidate> = Vec::new();
    for realization in of_kind(PartKind::Realization) {
        for dynamics in of_kind(PartKind::Dynamics) {
            for r in settings(registry, realization, options) {
                for d in settings(registry, dynamics, options) {
                    maps.push(pair(registry, problem, (realization, &r), (dynamics, &d)));
                }
            }
        }
    }
    for stepper in of_kind(PartKind::Stepper) {
        for given in settings(registry, stepper, options) {
            let map = registry
                .stepper(stepper)
                .and_then(|p| p.build(&problem.system, &given));
            let name = map
                .as_ref()
                .map_or_else(|_| stepper.to_owned(), |map| map.describe());
            maps.push((name, map));
        }
    }
    for composition in of_kind(PartKind::Composition) {
        let (base_name, base) = default_method(registry, problem);
        let map = base.and_then(|base| {
            registry
                .composition(composition)?
                .build(base, &PartParameters::new())
        });
        maps.push((format!("{composition} of {base_name}"), map));
    }
    maps
}

fn pair(
    registry: &Registry,
    problem: &Problem,
    (realization, r): (&str, &PartParameters),
    (dynamics, d): (&str, &PartParameters),
) -> Candidate {
    let method = || -> Result<Method, BuildError> {
        let realization = registry
            .realization(realization)?
            .build(&problem.system, r)?;
        let dynamics = registry.dynamics(dynamics)?.build(d)?;
        Method::compose(&problem.system, realization, dynamics)
    };
    let method = method();
    let name = method.as_ref().map_or_else(
        |_| format!("{realization} + {dynamics}"),
        |method| method.describe(),
    );
    (
        name,
        method.map(|method| Arc::new(method) as Arc<dyn StepMap>),
    )
}

/// The realizations that a composition is measured over, the first that fits: exact ones, so that
/// the composition's own order is seen.
const BASES: [&str; 5] = [
    "constant",
    "log-canonical",
    "so3-exponential",
    "lie-poisson",
    "karasev-collocated",
];

/// What compositions are measured over: Hamilton–Jacobi of order 2 over an exact realization.
fn default_method(
    registry: &Registry,
    problem: &Problem,
) -> (String, Result<Arc<dyn StepMap>, BuildError>) {
    let defaults = PartParameters::new();
    let order = PartParameters::new().with("order", 2);
    let mut candidates = BASES.iter().map(|base| {
        pair(
            registry,
            problem,
            (base, &defaults),
            ("hamilton-jacobi", &order),
        )
    });
    candidates.find(|(_, map)| map.is_ok()).unwrap_or_else(|| {
        pair(
            registry,
            problem,
            ("karasev-truncated", &defaults),
            ("hamilton-jacobi", &order),
        )
    })
}
