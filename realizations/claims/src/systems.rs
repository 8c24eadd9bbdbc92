//! Poisson systems of the library by id, or from a few formulas.

use leafwise_core::system::{Casimir, Convention, Parameter};
use leafwise_core::{PoissonSystem, Registry};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_scene::{SceneDocument, compose_system};
use toml::{Table, Value};

/// A system with the state and the time step its library text starts from.
#[derive(Clone, Debug)]
pub struct Problem {
    /// (M, π, H).
    pub system: PoissonSystem,
    /// x_0.
    pub initial: Vec<f64>,
    /// ε h.
    pub time_step: f64,
}

/// The library's system with this id.
///
/// # Panics
/// When the library has no such system or its text does not compose.
pub fn library(id: &str) -> Problem {
    let entry = leafwise_systems::find(id).unwrap_or_else(|| panic!("`{id}` is in the library"));
    let defaults = entry.defaults().expect("a library text has defaults");
    let table = |entries: &[(&str, Value)]| -> Value {
        let named = entries.iter().map(|(k, v)| ((*k).to_owned(), v.clone()));
        Value::from(named.collect::<Table>())
    };
    let scene = table(&[
        ("system", table(&[("library", Value::from(id))])),
        (
            "method",
            table(&[
                ("realization", Value::from("auto")),
                ("dynamics", Value::from("auto")),
                ("time-step", Value::from(defaults.time_step)),
            ]),
        ),
        (
            "run",
            table(&[("initial", defaults.initial), ("steps", Value::from(1))]),
        ),
    ]);
    let text = toml::to_string(&scene).expect("tables have a text");
    let document = SceneDocument::parse("claim.toml", &text, &Registry::with_builtin())
        .unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    let composed = compose_system(&document)
        .unwrap_or_else(|refusal| panic!("{}: {refusal:?}", document.name));
    Problem {
        system: composed.system,
        initial: composed.initial,
        time_step: defaults.time_step,
    }
}

/// A system in the paper's convention from formulas; bracket entries are (x_i, x_j, {x_i, x_j})
/// in any order, parameters come with their values.
///
/// # Panics
/// When a formula or a name is wrong.
pub fn from_formulas(
    variables: &[&str],
    parameters: &[(&str, f64)],
    bracket: &[(&str, &str, &str)],
    hamiltonian: &str,
    casimirs: &[&str],
) -> PoissonSystem {
    let names: Vec<&str> = parameters.iter().map(|p| p.0).collect();
    let scope = Scope::new()
        .with_variables(variables)
        .with_parameters(&names);
    let expression = |text: &str| -> Expression {
        let formula = Formula::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let resolved = formula.resolve(&scope, None);
        resolved
            .unwrap_or_else(|error| panic!("{text}: {error}"))
            .expect("no boundary")
    };
    let at = |name: &str| {
        let position = variables.iter().position(|v| *v == name);
        position.unwrap_or_else(|| panic!("`{name}` is a variable"))
    };
    let entries = bracket.iter().map(|(a, b, text)| {
        let (i, j, entry) = (at(a), at(b), expression(text));
        if i < j {
            ((i, j), entry)
        } else {
            ((j, i), Expression::Negate(Box::new(entry)))
        }
    });
    let parameters = parameters.iter().map(|&(name, value)| Parameter {
        name: name.to_owned(),
        value,
    });
    let casimirs = casimirs.iter().map(|text| Casimir {
        name: (*text).to_owned(),
        expression: expression(text),
    });
    PoissonSystem::new(
        variables.iter().map(|v| (*v).to_owned()).collect(),
        parameters.collect(),
        entries,
        expression(hamiltonian),
        casimirs.collect(),
        Convention::HamiltonianFirst,
    )
    .expect("formulas of these variables")
}
