//! Poisson systems of the library by id, or from a few formulas: the way a scene takes.

use leafwise_core::{PoissonSystem, Registry};
use leafwise_scene::{SceneDocument, compose_system};
use leafwise_systems::find;
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

/// How many members a family of a lattice gets: long enough that no stencil meets itself.
const FAMILY_LENGTH: usize = 4;

/// The library's system with this id, families cut to four members.
///
/// # Panics
/// When the library has no such system or its text does not compose.
pub fn library(id: &str) -> Problem {
    let entry = find(id).unwrap_or_else(|| panic!("`{id}` is in the library"));
    let text = entry.system().expect("a library text is well formed");
    let defaults = entry.defaults().expect("a library text has defaults");
    let families = text.get("families").and_then(Value::as_table);
    let shorter = families.into_iter().flat_map(Table::keys);
    let shorter: Vec<(String, String)> = shorter
        .map(|name| (format!("system.families.{name}"), FAMILY_LENGTH.to_string()))
        .collect();
    let system = Table::from_iter([("library".to_owned(), Value::from(id))]);
    let (system, initial) = compose(system, defaults.initial, &shorter);
    Problem {
        system,
        initial,
        time_step: defaults.time_step,
    }
}

/// A system in the paper's convention from formulas; `parameters` with their values.
///
/// # Panics
/// When the scene with these formulas is refused.
pub fn from_formulas(
    variables: &[&str],
    parameters: &[(&str, f64)],
    bracket: &[(&str, &str)],
    hamiltonian: &str,
    casimirs: &[(&str, &str)],
) -> PoissonSystem {
    let formulas = |named: &[(&str, &str)]| -> Table {
        let named = named
            .iter()
            .map(|&(name, formula)| (name.to_owned(), Value::from(formula)));
        named.collect()
    };
    let values = parameters
        .iter()
        .map(|&(name, value)| (name.to_owned(), Value::from(value)));
    let system = Table::from_iter([
        ("variables".to_owned(), Value::from(variables.to_vec())),
        (
            "parameters".to_owned(),
            Value::from(values.collect::<Table>()),
        ),
        ("bracket".to_owned(), Value::from(formulas(bracket))),
        ("hamiltonian".to_owned(), Value::from(hamiltonian)),
        ("casimirs".to_owned(), Value::from(formulas(casimirs))),
    ]);
    compose(system, Value::from(vec![1.0; variables.len()]), &[]).0
}

fn compose(
    system: Table,
    initial: Value,
    overrides: &[(String, String)],
) -> (PoissonSystem, Vec<f64>) {
    let method = Table::from_iter([
        ("realization".to_owned(), Value::from("auto")),
        ("dynamics".to_owned(), Value::from("auto")),
        ("time-step".to_owned(), Value::from(0.1)),
    ]);
    let run = Table::from_iter([
        ("initial".to_owned(), initial),
        ("steps".to_owned(), Value::from(1)),
    ]);
    let scene = Table::from_iter([
        ("system".to_owned(), Value::from(system)),
        ("method".to_owned(), Value::from(method)),
        ("run".to_owned(), Value::from(run)),
    ]);
    let text = toml::to_string(&scene).expect("tables have a text");
    let document =
        SceneDocument::parse_with("claim.toml", &text, overrides, &Registry::with_builtin())
            .unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    let composed = compose_system(&document)
        .unwrap_or_else(|refusal| panic!("{}: {refusal:?}\n{text}", document.name));
    (composed.system, composed.initial)
}
