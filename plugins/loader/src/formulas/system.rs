//! A system by formulas: a scene's `[system]` table.

use std::fmt::Write as _;

use leafwise_core::part::{PATH, ParameterSetting, PartInfo};
use leafwise_core::{BuildError, PartParameters, PoissonSystem};
use leafwise_scene::compose::system_of_fragment;

use super::keys::refused;
use crate::declaration::PartDeclaration;
use crate::error::Refusal;
use crate::foreign::own_settings;

/// Keys of the table that stand alone; the others are `families.…`, `bracket.…`, `casimirs.…`.
const SINGLE: [&str; 4] = ["variables", "hamiltonian", "convention", "boundary"];

/// The part's formulas as the text of a library system, with parameters of these values: a `[system]`
/// table, as scenes have it.
pub(crate) fn fragment(
    part: &PartDeclaration,
    settings: &[(String, ParameterSetting)],
) -> Result<String, Refusal> {
    let mut text = "[system]\n".to_owned();
    let mut tables: [(&str, Vec<String>); 3] =
        ["families", "bracket", "casimirs"].map(|name| (name, Vec::new()));
    for (key, formula) in &part.formulas {
        if SINGLE.contains(&key.as_str()) {
            let value = match key.as_str() {
                "variables" => {
                    let names: Vec<String> = formula.split(',').map(|n| quoted(n.trim())).collect();
                    format!("[{}]", names.join(", "))
                }
                _ => quoted(formula),
            };
            line(&mut text, key, &value);
            continue;
        }
        let table = key.split_once('.').and_then(|(table, name)| {
            let entry = tables.iter_mut().find(|(known, _)| *known == table)?;
            Some((entry, name))
        });
        let Some(((table, entries), name)) = table else {
            let known = format!(
                "{}, families.NAME, bracket.…, casimirs.NAME",
                SINGLE.join(", ")
            );
            return Err(refused(
                part,
                key,
                format!("no such key here; a system has {known}"),
            ));
        };
        let value = match *table {
            "families" => {
                let length = formula.trim().parse::<u64>();
                length
                    .map_err(|_| refused(part, key, "a length is a whole number"))?
                    .to_string()
            }
            _ => quoted(formula),
        };
        entries.push(format!("{} = {value}", quoted(name)));
    }
    let numbers = settings.iter().filter_map(|(name, setting)| match setting {
        ParameterSetting::Integer(value) => Some(format!("{} = {value}", quoted(name))),
        ParameterSetting::Real(value) => Some(format!("{} = {value:?}", quoted(name))),
        ParameterSetting::Text(_) => None,
    });
    let parameters = ("parameters", numbers.collect());
    for (table, entries) in tables.into_iter().chain([parameters]) {
        if !entries.is_empty() {
            line(&mut text, table, &format!("{{ {} }}", entries.join(", ")));
        }
    }
    Ok(text)
}

fn line(text: &mut String, key: &str, value: &str) {
    writeln!(text, "{key} = {value}").expect("a string takes any text");
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// The part's own parameters at their defaults.
fn defaults(part: &PartDeclaration) -> Vec<(String, ParameterSetting)> {
    let own = part
        .description
        .parameters
        .iter()
        .filter(|parameter| parameter.name != PATH);
    own.map(|parameter| (parameter.name.clone(), parameter.default.clone()))
        .collect()
}

/// The system of the part's formulas at its defaults.
pub(super) fn read(part: &PartDeclaration) -> Result<PoissonSystem, Refusal> {
    let text = fragment(part, &defaults(part))?;
    system_of_fragment(part.id(), &text).map_err(|(key, problem)| refused(part, &key, problem))
}

/// A part of kind `LW_KIND_SYSTEM` with formulas.
pub(crate) struct FormulaSystemPart {
    info: &'static PartInfo,
    declaration: PartDeclaration,
    /// The table with the default parameters.
    pub(crate) fragment: String,
}

impl FormulaSystemPart {
    pub(crate) fn new(
        declaration: &PartDeclaration,
        info: &'static PartInfo,
    ) -> Result<Self, Refusal> {
        Ok(Self {
            info,
            fragment: fragment(declaration, &defaults(declaration))?,
            declaration: declaration.clone(),
        })
    }

    pub(crate) fn build(&self, parameters: &PartParameters) -> Result<PoissonSystem, BuildError> {
        let settings = own_settings(self.info, parameters)?;
        let unfit = |reason: String| BuildError::DoesNotFit {
            part: self.info.name,
            reason,
        };
        let text = fragment(&self.declaration, &settings).map_err(|e| unfit(e.to_string()))?;
        system_of_fragment(self.info.name, &text)
            .map_err(|(key, problem)| unfit(format!("{key}: {problem}")))
    }
}
