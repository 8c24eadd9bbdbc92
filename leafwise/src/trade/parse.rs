//! Methods by name, as the command line gives them.

use leafwise_core::Registry;
use leafwise_core::part::{ParameterSetting, PartKind};
use leafwise_scene::document::{MethodTable, PartUse};

use super::error::TradeError;

/// Reads a method from the command line: `realization+dynamics`, `stepper`, or
/// `composition/…` of one of them; `name:value` gives a part's first parameter.
///
/// ```
/// use leafwise::core::Registry;
/// use leafwise::trade::parse_method;
///
/// let registry = Registry::with_builtin();
/// let method = parse_method("suzuki-4/so3-cayley+hamilton-jacobi:4", &registry).expect("a method");
/// assert_eq!(method.to_string(), "suzuki-4 of so3-cayley + hamilton-jacobi 4");
/// ```
///
/// # Errors
/// [`TradeError::Method`] with what is wrong.
pub fn parse_method(text: &str, registry: &Registry) -> Result<MethodTable, TradeError> {
    let wrong = |reason: String| TradeError::Method {
        text: text.to_owned(),
        reason,
    };
    let part = |text: &str, kind: PartKind| -> Result<PartUse, TradeError> {
        let (name, value) = match text.trim().split_once(':') {
            Some((name, value)) => (name, Some(value)),
            None => (text.trim(), None),
        };
        let parts = registry.parts();
        let info = parts.iter().find(|p| p.kind == kind && p.name == name);
        if info.is_none() && !(kind == PartKind::Realization && name == "auto") {
            return Err(wrong(format!("no {} is called `{name}`", kind.noun())));
        }
        let Some(value) = value else {
            return Ok(PartUse::named(name));
        };
        let parameter = info.and_then(|info| info.parameters.first());
        let parameter = parameter
            .ok_or_else(|| wrong(format!("`{name}` takes no parameter")))?
            .name;
        let setting = match (value.parse::<i64>(), value.parse::<f64>()) {
            (Ok(whole), _) => ParameterSetting::Integer(whole),
            (_, Ok(real)) => ParameterSetting::Real(real),
            _ => ParameterSetting::Text(value.to_owned()),
        };
        Ok(PartUse::named(name).with(parameter, setting))
    };
    let (composition, base) = match text.split_once('/') {
        Some((composition, base)) => (Some(composition), base),
        None => (None, text),
    };
    let method = match base.split_once('+') {
        Some((realization, dynamics)) => MethodTable::pair(
            part(realization, PartKind::Realization)?,
            part(dynamics, PartKind::Dynamics)?,
        ),
        None => MethodTable::stepper(part(base, PartKind::Stepper)?),
    };
    Ok(match composition {
        None => method,
        Some(name) => method.composed(part(name, PartKind::Composition)?),
    })
}
