//! Formulas as parts: everything works for them that works for a built-in part.
//!
//! - `keys`: lists of formulas by key, parsed;
//! - `system`: a scene's `[system]` table;
//! - `realization`: α̂ and β̂ as a closed form;
//! - `dynamics`: the coefficients S_l;
//! - `step_map`: Φ(x) − x as code.

mod dynamics;
mod keys;
mod realization;
mod step_map;
mod system;

pub(crate) use dynamics::FormulaDynamicsPart;
pub(crate) use realization::FormulaRealizationPart;
pub(crate) use step_map::FormulaStepMapPart;
pub(crate) use system::FormulaSystemPart;

use leafwise_core::PartKind;

use crate::declaration::PartDeclaration;
use crate::error::Refusal;

/// Reads the formulas of a part, to refuse now what cannot be used.
pub(crate) fn check(part: &PartDeclaration) -> Result<(), Refusal> {
    if part.formulas.is_empty() {
        return Ok(());
    }
    match part.kind() {
        PartKind::System => system::read(part).map(drop),
        PartKind::Realization => realization::read(part).map(drop),
        PartKind::Dynamics => dynamics::Formulas::read(part).map(drop),
        _ => step_map::Formulas::read(part).map(drop),
    }
}
