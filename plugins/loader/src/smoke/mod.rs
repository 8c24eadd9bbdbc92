//! A few calls of every function of every part, before anything is registered.
//!
//! - `problems`: the systems that parts are tried on;
//! - `function`: one function in every layout, with canaries;
//! - `answers`: the same again beside other instances, on this thread and on others;
//! - `compare`: equations and derivatives;
//! - `system`, `realization`, `dynamics`, `step_map`: one kind each.

mod answers;
mod compare;
mod dynamics;
mod function;
mod problems;
mod realization;
mod step_map;
mod system;

use std::sync::Arc;

use leafwise_core::PartParameters;
use leafwise_core::part::{ParameterSetting, PartInfo};
use serde::Serialize;

use crate::declaration::{Functions, PartDeclaration};
use crate::floating_point::ControlWord;
use crate::foreign::{CallFailure, ForeignPart, HostObjects, Instance, Making, own_settings};
use crate::smoke_failure::SmokeFailure;

use answers::Tester;
pub(crate) use problems::TestProblem;

/// Outcome of a part's trial.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tried {
    /// The test problems that its functions were called on; none where it serves none of them.
    #[serde(rename = "tried_on")]
    pub problems: Vec<String>,
    /// The problems that it does not serve, with its reasons.
    #[serde(rename = "not_served")]
    pub refusals: Vec<String>,
    /// The functions whose calls change the library's own data, which all its instances share.
    pub writing_static_data: Vec<String>,
}

/// Tries a part at its default parameters.
pub(crate) fn try_part(
    declaration: &PartDeclaration,
    info: &'static PartInfo,
) -> Result<Tried, SmokeFailure> {
    let control = ControlWord::read();
    let tried = match declaration.functions {
        None => Ok(Tried::default()),
        Some(functions) => {
            let part = Arc::new(ForeignPart::new(declaration, functions, info));
            let settings = own_settings(info, &PartParameters::new()).unwrap_or_default();
            let mut subject = Subject {
                maker: Maker { part, settings },
                tried: Tried::default(),
                testers: Vec::new(),
            };
            match functions {
                Functions::System(table) => system::try_part(&mut subject, &table),
                Functions::Realization(table) => realization::try_part(&mut subject, &table),
                Functions::Dynamics(table) => dynamics::try_part(&mut subject, &table),
                Functions::StepMap(table) => step_map::try_part(&mut subject, &table),
            }
            .and_then(|()| subject.all_together())
            .map(|()| subject.tried)
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
    maker: Maker,
    tried: Tried,
    /// The instances of the problems so far.
    testers: Vec<Tester>,
}

impl Subject {
    /// Tries the part on one problem, of dimension d, with instances of what `lend` lends them; `run`
    /// tries all functions and says whether the problem's states are in their domain.
    fn on_problem(
        &mut self,
        problem: &str,
        dimension: usize,
        lend: &(dyn Fn() -> Option<HostObjects> + Sync),
        run: &mut dyn FnMut(&ForeignPart, &mut Tester) -> Result<bool, SmokeFailure>,
    ) -> Result<(), SmokeFailure> {
        let Some(lent) = lend() else {
            return Ok(());
        };
        let maker = &self.maker;
        let instance = match maker.instance(dimension, lent, &maker.settings) {
            Ok(instance) => instance,
            Err((_, failure @ CallFailure::Unsupported { .. })) => {
                self.tried.refusals.push(format!("{problem}: {failure}"));
                return Ok(());
            }
            Err((function, failure)) => {
                return Err(SmokeFailure::Call {
                    function: function.to_owned(),
                    message: failure.to_string(),
                });
            }
        };
        let mut tester = Tester::new(instance);
        if !run(&maker.part, &mut tester)? {
            let why = "the states tried are outside its domain";
            self.tried.refusals.push(format!("{problem}: {why}"));
            return Ok(());
        }
        let make = |settings: &[(String, ParameterSetting)]| {
            maker.instance(dimension, lend()?, settings).ok()
        };
        // An instance with other parameters is to leave this one as it is.
        if let Some(mut other) = make(&maker.others()) {
            tester.ask(&mut other);
            tester.again()?;
        }
        // What holds of one problem's instances holds of the others'.
        if self.tried.problems.is_empty() {
            let writing = tester.writes_static_data();
            tester.in_parallel(&|| make(&maker.settings), !writing.is_empty())?;
            self.tried.writing_static_data = writing;
        }
        self.tried.problems.push(problem.to_owned());
        self.testers.push(tester);
        Ok(())
    }

    /// Checks that the instances of all problems still answer as each did alone.
    fn all_together(&mut self) -> Result<(), SmokeFailure> {
        self.testers.iter_mut().try_for_each(Tester::again)
    }
}

/// Maker of instances of a part.
struct Maker {
    part: Arc<ForeignPart>,
    /// Its parameters at their defaults.
    settings: Vec<(String, ParameterSetting)>,
}

impl Maker {
    /// An instance, after the promises that it is made with; or the function that refused, and why.
    fn instance(
        &self,
        dimension: usize,
        lent: HostObjects,
        settings: &[(String, ParameterSetting)],
    ) -> Result<Instance, (&'static str, CallFailure)> {
        let of_whole = match self.part.functions {
            // A dynamic approximation promises before it is bound to a system.
            Functions::Dynamics(_) => 0,
            _ => dimension,
        };
        let promises = self.part.properties(of_whole, settings);
        promises.map_err(|failure| ("properties", failure))?;
        let making = Making {
            dimension,
            settings,
        };
        Instance::new(&self.part, making, lent).map_err(|failure| ("create", failure))
    }

    /// Other values of the numbers among the parameters.
    fn others(&self) -> Vec<(String, ParameterSetting)> {
        let other = |setting: &ParameterSetting| match setting {
            ParameterSetting::Real(value) => ParameterSetting::Real(1.25 * value + 0.125),
            kept => kept.clone(),
        };
        let settings = self.settings.iter();
        settings
            .map(|(name, setting)| (name.clone(), other(setting)))
            .collect()
    }
}
