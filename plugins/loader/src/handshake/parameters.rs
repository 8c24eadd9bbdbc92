//! The parameters of a part.

use leafwise_core::part::ParameterSetting;
use leafwise_core::part_description::ParameterDescription;
use leafwise_plugin_abi::LwParameter;
use serde_json::Value;

use super::memory::{self, required_text};
use crate::declaration::ValuePath;
use crate::error::Refusal;

/// The name of the parameter that the host adds to a part with both formulas and functions.
pub(crate) const PATH: &str = "path";

/// The key by which a scene's method says which part it means, beside the part's parameters.
const NAME: &str = "name";

/// Copies and checks a list of parameters.
///
/// # Safety
/// The list and its strings belong to a part of this version.
pub(super) unsafe fn read(
    part: &str,
    is_system: bool,
    pointer: *const LwParameter,
    count: usize,
) -> Result<Vec<ParameterDescription>, Refusal> {
    // SAFETY: passed on to the caller, here and below.
    let list = unsafe { memory::parameters(part, pointer, count) }?;
    let mut parameters: Vec<ParameterDescription> = Vec::with_capacity(list.len());
    for (place, parameter) in list.iter().enumerate() {
        let what = || format!("part {part}: the name of parameter {place}");
        // SAFETY: as above.
        let name = unsafe { required_text(what, parameter.name) }?;
        let refused = |problem: &str| Refusal::Declaration {
            part: part.to_owned(),
            problem: format!("parameter `{name}` {problem}"),
        };
        if !is_name(&name) {
            return Err(refused(
                "is not a letter followed by letters, digits and `_`",
            ));
        }
        if name == PATH || (name == NAME && !is_system) {
            return Err(refused("has a name that the host reserves"));
        }
        if parameters.iter().any(|known| known.name == name) {
            return Err(refused("is declared twice"));
        }
        let what = |which: &str| format!("part {part}: {which} of parameter `{name}`");
        // SAFETY: as above.
        let summary = unsafe { required_text(|| what("the summary"), parameter.summary) }?;
        // SAFETY: as above.
        let json = unsafe { required_text(|| what("the default"), parameter.default_json) }?;
        let default = setting(&json).ok_or_else(|| {
            refused(&format!(
                "has the default {json}, which is neither a finite number nor a word in quotes"
            ))
        })?;
        parameters.push(ParameterDescription {
            name,
            summary,
            default,
        });
    }
    Ok(parameters)
}

/// The parameter that the host adds to a part with both formulas and functions.
pub(super) fn path() -> ParameterDescription {
    let words = [ValuePath::Expressions, ValuePath::Numbers].map(ValuePath::word);
    ParameterDescription {
        name: PATH.to_owned(),
        summary: format!("where values come from: {}", words.join(" or ")),
        default: words[0].into(),
    }
}

fn is_name(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|c| c.is_ascii_alphabetic())
        && letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// A JSON literal as a value of its type.
fn setting(json: &str) -> Option<ParameterSetting> {
    match serde_json::from_str(json).ok()? {
        Value::String(word) => Some(ParameterSetting::Text(word)),
        Value::Number(number) => match number.as_i64() {
            Some(integer) => Some(ParameterSetting::Integer(integer)),
            None => number.as_f64().map(ParameterSetting::Real),
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_default_shows_its_type() {
        assert_eq!(setting("4"), Some(4.into()));
        assert_eq!(setting("4.0"), Some(4.0.into()));
        assert_eq!(setting("1e-3"), Some(0.001.into()));
        assert_eq!(setting("\"none\""), Some("none".into()));
        for wrong in ["true", "none", "[1]", "1e999", "nan", ""] {
            assert_eq!(setting(wrong), None, "{wrong}");
        }
    }
}
