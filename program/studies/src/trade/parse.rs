//! Methods by name, as the command line gives them.

use leafwise_core::Registry;
use leafwise_core::part::{Family, ParameterSetting, PartKind};
use leafwise_scene::document::{MethodTable, PartUse};

use super::error::TradeError;

/// Reads a method from the command line: `realization+dynamics`, `stepper`, or
/// `composition/…` of one of them; `name:value:…` gives a part's parameters in their order. Names of
/// parts from plugins hold a `/` of their own, as in `suzuki-4/acme/strang`.
/// `suzuki-4/so3-cayley+hamilton-jacobi:4` is suzuki-4 of so3-cayley + hamilton-jacobi 4.
///
/// # Errors
/// [`TradeError::Method`] with what is wrong.
pub fn parse_method(text: &str, registry: &Registry) -> Result<MethodTable, TradeError> {
    let wrong = |reason: String| TradeError::Method {
        text: text.to_owned(),
        reason,
    };
    let part = |text: &str, kind: PartKind| -> Result<PartUse, TradeError> {
        let mut words = text.trim().split(':');
        let name = words.next().unwrap_or_default();
        let parts = registry.parts();
        let info = parts.iter().find(|p| p.kind == kind && p.name == name);
        if info.is_none() && !(kind == PartKind::Realization && name == "auto") {
            let other = parts.iter().find(|p| p.name == name);
            return Err(wrong(match other.map(|p| p.kind) {
                Some(other @ PartKind::Dynamics) if kind == PartKind::Stepper => format!(
                    "`{name}` is a {}: write it after a realization, as `auto+{text}`",
                    other.noun()
                ),
                Some(other @ PartKind::Realization) if kind == PartKind::Stepper => format!(
                    "`{name}` is a {}: write a dynamic approximation after it, as \
                     `{text}+{}:4`",
                    other.noun(),
                    registry
                        .of_order(PartKind::Dynamics)
                        .map_or("…", |part| part.name)
                ),
                Some(PartKind::Composition) if kind == PartKind::Stepper => format!(
                    "`{name}` is a composition: write the composed method after it, as \
                     `{text}/{}`",
                    registry
                        .family(Family::Splitting)
                        .first()
                        .map_or("…", |part| part.name)
                ),
                _ => format!(
                    "no {} is called `{name}`; `leafwise list` shows all, and a method is written as \
                     realization+dynamics, as a stepper, or as composition/… of one of them",
                    kind.noun()
                ),
            }));
        }
        let mut parameters = info.map_or(&[][..], |info| info.parameters).iter();
        let mut part = PartUse::named(name);
        for value in words {
            let parameter = parameters
                .next()
                .ok_or_else(|| wrong(too_many(name, part.parameters.len())))?;
            part = part.with(parameter.name, setting(value));
        }
        Ok(part)
    };
    let is = |text: &str, kinds: &[PartKind]| {
        let name = text.split([':', '+']).next().unwrap_or_default().trim();
        let mut parts = registry.parts().into_iter();
        parts.any(|part| part.name == name && kinds.contains(&part.kind))
    };
    let parts = text
        .match_indices('/')
        .map(|(at, _)| (&text[..at], &text[at + 1..]));
    let mut composed = parts.filter(|(name, _)| is(name, &[PartKind::Composition]));
    let (composition, base) = match composed.next() {
        Some((composition, base)) => (Some(composition), base),
        None if is(text, &[PartKind::Realization, PartKind::Stepper]) => (None, text),
        // Neither: the word before the `/` is what is not known.
        None => match text.split_once('/') {
            Some((composition, base)) => (Some(composition), base),
            None => (None, text),
        },
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

fn setting(value: &str) -> ParameterSetting {
    match (value.parse::<i64>(), value.parse::<f64>()) {
        (Ok(whole), _) => ParameterSetting::Integer(whole),
        (_, Ok(real)) => ParameterSetting::Real(real),
        _ => ParameterSetting::Text(value.to_owned()),
    }
}

fn too_many(name: &str, taken: usize) -> String {
    match taken {
        0 => format!("`{name}` takes no parameter"),
        1 => format!("`{name}` takes one parameter"),
        several => format!("`{name}` takes {several} parameters"),
    }
}
