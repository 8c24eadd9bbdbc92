//! Quantities that are columns of their own, and that no formula names.

use super::spin_temperature::SPIN_TEMPERATURE;
use crate::document::{Located, SceneDocument};

/// The energy of the map's shadow, alone or with ` of order P` behind it.
pub(super) const SHADOW_ENERGY: &str = "shadow-energy";

/// Indicators of chaos; a number k may stand behind the second, for the k-th largest exponent.
pub(super) const INDICATORS: [&str; 3] = ["megno", "lyapunov", "sali"];

/// Message and advice for an observable or an event that computes with such a quantity, and the length of its name. The name
/// begins at a place of the text. `None` where it is another formula or another name.
pub(super) fn about_own_columns(
    document: &SceneDocument,
    formula: &Located<String>,
    begin: usize,
) -> Option<(String, String, usize)> {
    let run = &document.run;
    let is = |other: &Located<String>| other.place() == formula.place();
    let is_recorded = run.record.observables.iter().any(|own| is(&own.formula));
    let section = run.section.as_ref().map(|section| &section.at);
    let event = match () {
        () if is_recorded => None,
        () if run.stop.as_ref().is_some_and(is) => Some("`stop`"),
        () if section.is_some_and(is) => Some("`section`"),
        () => return None,
    };
    let text = formula.value.get(begin..)?;
    let begins = |name: &&str| {
        let behind = text.strip_prefix(*name).map(|rest| rest.chars().next());
        behind.is_some_and(|next| next.is_none_or(|c| !(c.is_alphanumeric() || c == '_')))
    };
    // Energy and Casimirs have formulas, which may be written in their place.
    let mut casimirs = document.system.casimirs.iter();
    let casimir = casimirs.find(|(name, _)| begins(&name.value.as_str()));
    let written = match casimir {
        Some((name, formula)) => Some((name.value.as_str(), formula)),
        None => begins(&"energy").then_some(("energy", &document.system.hamiltonian)),
    };
    let fixed = [SHADOW_ENERGY, SPIN_TEMPERATURE].into_iter();
    let name = match written {
        Some((name, _)) => name,
        None => fixed.chain(INDICATORS).find(begins)?,
    };
    let message = format!("`{name}` is a column of its own: no formula computes with it");
    let help = match (event, written) {
        (None, Some((_, formula))) => format!(
            "record it as it is, observables = [\"{name}\"], or write its formula in its place, ({})",
            formula.value.trim()
        ),
        (Some(_), Some((_, formula))) => {
            format!("write its formula in its place, ({})", formula.value.trim())
        }
        (None, None) => {
            format!("record it as it is, observables = [\"{name}\"], and compute with the column")
        }
        (Some(event), None) => format!(
            "leave {event} out, and record it: observables = [\"{name}\"]; events watch formulas of the coordinates"
        ),
    };
    Some((message, help, name.len()))
}
