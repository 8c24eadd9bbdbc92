//! Parameters that nothing depends on.

use super::{Advice, AdviceKind};
use leafwise_scene::document::{FieldSpec, InitialSpec, ParameterValue, SceneDocument};

/// A warning of each parameter that stands in no formula of the scene; those of library systems are not
/// looked at.
pub(super) fn unused_parameters(document: &SceneDocument) -> Vec<Advice> {
    let system = &document.system;
    if system.library.is_some() {
        return Vec::new();
    }
    let formulas = formulas(document);
    let is_used = |name: &str| formulas.iter().any(|formula| names(formula, name));
    let numbers = system.parameters.iter().map(|(name, _)| &name.value);
    let at_rest = system.families[system.moving().len()..].iter();
    let declared = numbers.chain(at_rest.map(|(name, _)| &name.value));
    let unused = declared.filter(|name| !is_used(name));
    unused
        .map(|name| Advice {
            kind: AdviceKind::UnusedParameter,
            message: format!("nothing depends on the parameter `{name}`: no formula names it"),
            change: format!("use `{name}` in a formula, or remove it from [system] parameters"),
        })
        .collect()
}

/// Every text of a scene that may name a parameter.
fn formulas(document: &SceneDocument) -> Vec<&str> {
    let system = &document.system;
    let mut formulas = vec![system.hamiltonian.value.as_str()];
    formulas.extend(system.sites.iter().filter_map(|(_, field)| of_field(field)));
    let matrices = system.matrices.iter();
    formulas.extend(matrices.filter_map(|matrix| of_field(&matrix.field)));
    formulas.extend(system.define.iter().map(|(_, f)| f.value.as_str()));
    let bracket = system.bracket.value.formulas();
    formulas.extend(bracket.iter().map(|formula| formula.value.as_str()));
    formulas.extend(system.forces.formulas().iter().map(|f| f.value.as_str()));
    let noise = system.noise.iter();
    formulas.extend(noise.flat_map(|c| [c.hamiltonian.value.as_str(), c.strength.value.as_str()]));
    formulas.extend(system.constraints.iter().map(|f| f.value.as_str()));
    formulas.extend(system.casimirs.iter().map(|(_, f)| f.value.as_str()));
    formulas.extend(document.run.stop.iter().map(|f| f.value.as_str()));
    if let Some(section) = &document.run.section {
        formulas.push(&section.at.value);
        let set = section.set.iter().flat_map(|set| &set.value);
        formulas.extend(set.map(|(_, f)| f.value.as_str()));
    }
    let ensemble = document.ensemble.iter();
    let records = ensemble.map(|ensemble| &ensemble.record);
    for record in records.chain([&document.run.record]) {
        formulas.extend(record.observables.iter().map(|o| o.formula.value.as_str()));
    }
    if let InitialSpec::Fields(fields) = &document.run.initial.value {
        formulas.extend(fields.iter().filter_map(|(_, field)| of_field(field)));
    }
    let method = &document.method;
    let parts = [
        &method.realization,
        &method.dynamics,
        &method.composition,
        &method.stepper,
    ];
    for (_, value) in parts
        .into_iter()
        .flatten()
        .flat_map(|part| &part.parameters)
    {
        match &value.value {
            ParameterValue::Text(text) => formulas.push(text),
            ParameterValue::Formulas(given) => {
                formulas.extend(given.iter().map(|f| f.value.as_str()))
            }
            ParameterValue::Number(_) | ParameterValue::Flag(_) => {}
        }
    }
    formulas
}

fn of_field(field: &FieldSpec) -> Option<&str> {
    field.formula().map(|formula| formula.value.as_str())
}

/// Whether a formula has this name among its words.
fn names(formula: &str, name: &str) -> bool {
    let is_inside = |c: char| c.is_alphanumeric() || c == '_' || c == '\'';
    formula.split(|c| !is_inside(c)).any(|word| word == name)
}
