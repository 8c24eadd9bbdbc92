//! Parts whose mathematics is a list of formulas: a library's, read by keys, or a scene's, read by parameters.
//!
//! - `text`: formulas of a part's parameter, parsed;
//! - `realization`: [`FormulaRealization`], α̂ and β̂ as a closed form;
//! - `dynamics`: [`FormulaDynamics`], the coefficients S_1, S_3, … of a generating function.

mod dynamics;
mod realization;
mod text;

pub use dynamics::FormulaDynamics;
pub use realization::{FormulaRealization, OffSection, RealizationFormulas};
pub use text::{FormulaText, scope};
