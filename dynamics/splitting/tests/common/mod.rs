//! Systems of the problem library as strings, so that pieces can be systems of their own.

#[allow(dead_code, reason = "the claims about compositions use all of it")]
#[path = "../../../composition/tests/common/mod.rs"]
mod oracle;

use std::sync::Arc;

use leafwise_core::registry::Registry;
use leafwise_core::solver::StepMap;
use leafwise_core::{BuildError, Convention, PartParameters, PoissonSystem};
use leafwise_expression::Expression;
pub use oracle::{distance, gauss, largest, run, step};
use toml::{Table, Value};

/// The splitting of a system.
pub fn splitting(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let registry = Registry::with_builtin();
    let part = registry.stepper("splitting").expect("a built-in stepper");
    part.build(system, parameters)
}

/// Casimirs, and more that a map conserves, over 2,000 steps, relative to what they are made of: the end is rounded to doubles,
/// and the steps' rounding of a few ulps of h times the velocity walks at random.
pub fn assert_conserved(problem: &Problem, map: &dyn StepMap, more: &[&Expression]) {
    let system = problem.system();
    let formulas = system.expressions().expect("formulas");
    let casimirs = formulas.casimirs().iter().map(|c| &c.expression);
    let observed: Vec<_> = casimirs.chain(more.iter().copied()).collect();
    let (steps, h) = (2000, problem.time_step);
    let before = oracle::observe(&system, &observed, &problem.initial);
    let end = run(&system, map, &problem.initial, h * steps as f64, steps).expect("finite");
    let after = oracle::observe(&system, &observed, &end);
    let walk = libm::sqrt(steps as f64) * h * f64::EPSILON;
    for (before, after) in before.iter().zip(&after) {
        let drift = (after - before).abs() / before.abs().max(1.0);
        let bound = 16.0 * f64::EPSILON + 8.0 * walk;
        assert!(drift <= bound, "{}: {drift:e}", problem.id);
    }
}

/// A system's text with a state to start from.
pub struct Problem {
    pub id: &'static str,
    pub variables: Vec<String>,
    pub parameters: Vec<(String, f64)>,
    pub bracket: Vec<(String, String, String)>,
    pub hamiltonian: String,
    pub casimirs: Vec<String>,
    pub convention: Convention,
    pub initial: Vec<f64>,
    pub time_step: f64,
}

impl Problem {
    pub fn system(&self) -> PoissonSystem {
        self.with_hamiltonian(&self.hamiltonian)
    }

    /// The same Poisson manifold with another Hamiltonian.
    pub fn with_hamiltonian(&self, hamiltonian: &str) -> PoissonSystem {
        let texts = |list: &[String]| -> Vec<String> { list.to_vec() };
        let variables = texts(&self.variables);
        let variables: Vec<&str> = variables.iter().map(String::as_str).collect();
        let parameters: Vec<(&str, f64)> = self
            .parameters
            .iter()
            .map(|(name, value)| (name.as_str(), *value))
            .collect();
        let bracket: Vec<(&str, &str, &str)> = self
            .bracket
            .iter()
            .map(|(a, b, entry)| (a.as_str(), b.as_str(), entry.as_str()))
            .collect();
        let casimirs: Vec<&str> = self.casimirs.iter().map(String::as_str).collect();
        oracle::system(
            &variables,
            &parameters,
            &bracket,
            hamiltonian,
            &casimirs,
            self.convention,
        )
    }
}

fn number(value: &Value) -> f64 {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|v| v as f64))
        .expect("a number")
}

fn text(value: &Value) -> String {
    value.as_str().expect("a text").to_owned()
}

/// A system of the problem library without families.
pub fn library(id: &'static str) -> Problem {
    let entry = leafwise_systems::find(id).expect("a system of the library");
    let system = entry.system().expect("a well-formed text");
    let defaults = entry.defaults().expect("a well-formed text");
    let empty = Table::new();
    let table = |name: &str| system.get(name).and_then(Value::as_table).unwrap_or(&empty);
    let list = |value: &Value| value.as_array().expect("a list").clone();
    Problem {
        id,
        variables: list(&system["variables"]).iter().map(text).collect(),
        parameters: table("parameters")
            .iter()
            .map(|(name, v)| (name.clone(), number(v)))
            .collect(),
        bracket: table("bracket")
            .iter()
            .map(|(pair, entry)| {
                let (a, b) = pair.split_once(',').expect("a pair");
                (a.trim().to_owned(), b.trim().to_owned(), text(entry))
            })
            .collect(),
        hamiltonian: text(&system["hamiltonian"]),
        casimirs: table("casimirs").values().map(text).collect(),
        convention: match text(&system["convention"]).as_str() {
            "{x,H}" => Convention::HamiltonianSecond,
            _ => Convention::HamiltonianFirst,
        },
        initial: list(&defaults.initial).iter().map(number).collect(),
        time_step: defaults.time_step,
    }
}

/// The Volterra lattice on a ring of n sites, written out.
pub fn volterra(n: usize) -> Problem {
    let name = |i: usize| format!("x{}", i % n);
    let bracket = (0..n).map(|i| (name(i), name(i + 1), format!("{}*{}", name(i), name(i + 1))));
    Problem {
        id: "volterra-lattice",
        variables: (0..n).map(name).collect(),
        parameters: Vec::new(),
        bracket: bracket.collect(),
        hamiltonian: (0..n).map(name).collect::<Vec<_>>().join(" + "),
        casimirs: [0, 1]
            .map(|parity| {
                let sites = (parity..n).step_by(2).map(|i| format!("ln({})", name(i)));
                sites.collect::<Vec<_>>().join(" + ")
            })
            .to_vec(),
        convention: Convention::HamiltonianSecond,
        initial: (0..n).map(|i| 1.0 + 0.3 * libm::sin(i as f64)).collect(),
        time_step: 0.1,
    }
}

/// The periodic Toda lattice of n sites in Flaschka's variables, written out.
pub fn toda(n: usize) -> Problem {
    let (a, b) = (
        |i: usize| format!("a{}", i % n),
        |i: usize| format!("b{}", i % n),
    );
    let entries = (0..n).flat_map(|i| [(a(i), b(i), format!("-{}", a(i))), (a(i), b(i + 1), a(i))]);
    let energy = (0..n).map(|i| format!("{}^2/2 + {}^2", b(i), a(i)));
    Problem {
        id: "toda",
        variables: (0..n).map(a).chain((0..n).map(b)).collect(),
        parameters: Vec::new(),
        bracket: entries.collect(),
        hamiltonian: energy.collect::<Vec<_>>().join(" + "),
        casimirs: vec![(0..n).map(b).collect::<Vec<_>>().join(" + ")],
        convention: Convention::HamiltonianSecond,
        initial: (0..n)
            .map(|i| 0.5 + 0.1 * libm::cos(i as f64))
            .chain((0..n).map(|i| 0.2 * libm::sin(i as f64)))
            .collect(),
        time_step: 0.1,
    }
}

/// The splitting of a system whose bodies about centres move whole.
pub fn whole(system: &PoissonSystem) -> Result<Arc<dyn StepMap>, BuildError> {
    splitting(system, &PartParameters::new().with("bodies", "whole"))
}

/// Canonical pairs with this Hamiltonian.
pub fn canonical(
    pairs: &[[String; 2]],
    parameters: &[(&str, f64)],
    hamiltonian: String,
    initial: Vec<f64>,
) -> Problem {
    Problem {
        id: "canonical",
        variables: pairs.iter().flatten().cloned().collect(),
        parameters: parameters
            .iter()
            .map(|(name, value)| ((*name).to_owned(), *value))
            .collect(),
        bracket: pairs
            .iter()
            .map(|[q, p]| (q.clone(), p.clone(), "1".to_owned()))
            .collect(),
        hamiltonian,
        casimirs: Vec::new(),
        convention: Convention::HamiltonianSecond,
        initial,
        time_step: 0.1,
    }
}
