//! A few calls of every function of every part, before anything is registered.
//!
//! - `problems`: the systems that parts are tried on;
//! - `function`: one function in every layout, with canaries;
//! - `compare`: equations and derivatives;
//! - `system`, `realization`, `dynamics`, `step_map`: one kind each.

mod compare;
mod dynamics;
mod failure;
mod function;
mod problems;
mod realization;
mod step_map;
mod system;

use std::sync::Arc;

use leafwise_core::PartParameters;
use leafwise_core::part::{ParameterSetting, PartInfo};

use crate::declaration::{Functions, PartDeclaration};
use crate::floating_point::ControlWord;
use crate::foreign::{CallFailure, ForeignPart, Instance, Lent, Making, own_settings};

pub use failure::SmokeFailure;
pub(crate) use problems::TestProblem;

/// The problems that a part was tried on; none where it serves none of them.
pub(crate) type Tried = Vec<String>;

/// Tries a part at its default parameters.
pub(crate) fn try_part(
    declaration: &PartDeclaration,
    info: &'static PartInfo,
) -> Result<Tried, SmokeFailure> {
    let control = ControlWord::read();
    let tried = match declaration.functions {
        None => Ok(Vec::new()),
        Some(functions) => {
            let part = Arc::new(ForeignPart::new(declaration, functions, info));
            let settings = own_settings(info, &PartParameters::new()).unwrap_or_default();
            let subject = Subject { part, settings };
            match functions {
                Functions::System(table) => system::try_part(&subject, &table),
                Functions::Realization(table) => realization::try_part(&subject, &table),
                Functions::Dynamics(table) => dynamics::try_part(&subject, &table),
                Functions::StepMap(table) => step_map::try_part(&subject, &table),
            }
        }
    };
    let restored = control.restore("called");
    let tried = tried?;
    restored.map_err(|refusal| SmokeFailure::FloatingPoint {
        problem: refusal.to_string(),
    })?;
    Ok(tried)
}

/// A part that is tried, at its defaults.
struct Subject {
    part: Arc<ForeignPart>,
    settings: Vec<(String, ParameterSetting)>,
}

impl Subject {
    /// An instance, `None` where the part does not serve what it is made of.
    fn instance(&self, dimension: usize, lent: Lent) -> Result<Option<Instance>, SmokeFailure> {
        let making = Making {
            dimension,
            settings: &self.settings,
        };
        match Instance::new(&self.part, making, lent) {
            Ok(instance) => Ok(Some(instance)),
            Err(failure @ CallFailure::Broken { .. }) => Err(SmokeFailure::Call {
                function: "create".to_owned(),
                message: failure.to_string(),
            }),
            Err(_) => Ok(None),
        }
    }
}
