//! Library systems as parts of the registry.

use std::sync::LazyLock;

use leafwise_core::part::{ParameterSetting, PartInfo};
use leafwise_core::part_description::{ParameterDescription, PartDescription};
use leafwise_core::registry::SystemPart;
use leafwise_core::{BuildError, PartKind, PartParameters, PoissonSystem};
use leafwise_scene::compose::system_of_fragment;
use toml::{Table, Value};

use crate::{LibrarySystem, all};

/// Declarations of the library systems as parts, one each.
static INFOS: LazyLock<Vec<&'static PartInfo>> = LazyLock::new(|| {
    all()
        .iter()
        .map(|system| description(system).leak(&[]))
        .collect()
});

/// The system with this id, one of the library.
fn part(id: &str) -> SystemPart {
    let mut systems = all().iter().zip(INFOS.iter());
    let found = systems.find(|(system, _)| system.id == id);
    let (system, info) = found.expect("an id of the library");
    SystemPart::new(info, |given| build(system, info, given)).with_fragment(system.text)
}

/// Description of a system as a part, by the tables of its own text; every text of the library has
/// them.
fn description(system: &LibrarySystem) -> PartDescription {
    let about = system.about().ok();
    let table = system.system().unwrap_or_default();
    let parameters = table.get("parameters").and_then(Value::as_table);
    let parameters = parameters.into_iter().flatten();
    PartDescription {
        name: system.id.to_owned(),
        kind: PartKind::System,
        summary: about
            .as_ref()
            .map_or(String::new(), |about| about.title.clone()),
        declares: String::new(),
        domain: String::new(),
        literature: about.map_or(String::new(), |about| about.reference.to_string()),
        parameters: parameters
            .filter_map(|(name, value)| {
                let value = value
                    .as_float()
                    .or(value.as_integer().map(|value| value as f64))?;
                Some(ParameterDescription {
                    name: name.clone(),
                    summary: String::new(),
                    default: ParameterSetting::Real(value),
                })
            })
            .collect(),
    }
}

/// The system at its library lengths, with these values of its parameters.
fn build(
    system: &LibrarySystem,
    info: &'static PartInfo,
    given: &PartParameters,
) -> Result<PoissonSystem, BuildError> {
    let unfit = |reason: String| BuildError::DoesNotFit {
        part: info.name,
        reason,
    };
    let mut table = system.system().map_err(|error| unfit(error.to_string()))?;
    if !info.parameters.is_empty() {
        let values = info.parameters.iter().map(|parameter| {
            let value = given.real(info, parameter.name)?;
            Ok((parameter.name.to_owned(), Value::Float(value)))
        });
        let values = values.collect::<Result<Table, BuildError>>()?;
        table.insert("parameters".to_owned(), Value::Table(values));
    }
    given.refuse_unknown(info)?;
    let text = Table::from_iter([("system".to_owned(), Value::Table(table))]).to_string();
    system_of_fragment(info.name, &text)
        .map_err(|(key, problem)| unfit(format!("{key}: {problem}")))
}

macro_rules! parts {
    ($($id:literal),*) => {
        $(leafwise_core::built_in!(part($id));)*
    };
}

of_each_system!(parts);
