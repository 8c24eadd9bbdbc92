//! A system whose values a library computes.

use std::collections::HashSet;
use std::sync::Arc;

use leafwise_core::part::ParameterSetting;
use leafwise_core::system::{
    Derivatives, OpaqueSystem, Parameter, SystemEvaluator, SystemFunction, SystemNumbers,
};
use leafwise_core::{BuildError, PartParameters, PoissonSystem, StepError};
use leafwise_expression::syntax::Scope;
use leafwise_plugin_abi::LwSystem;

use super::batch::{Input, Output};
use super::callee::{Callee, Idle};
use super::instance::{Call, Instance};
use super::making::{HostObjects, Making};
use super::part::ForeignPart;
use crate::handshake::memory::{LONGEST_TEXT, text};
use crate::trial_points::states;

/// The most variables and Casimirs that a system may have.
const MOST: usize = 1 << 20;

/// A function that names one of an instance's variables or Casimirs.
type LwNameFn = Option<
    unsafe extern "C" fn(instance: *mut std::ffi::c_void, index: usize) -> *const std::ffi::c_char,
>;

/// A part of kind `LW_KIND_SYSTEM` with functions.
pub(crate) struct ForeignSystemPart {
    part: Arc<ForeignPart>,
    table: LwSystem,
}

impl ForeignSystemPart {
    pub(crate) fn new(part: ForeignPart, table: LwSystem) -> Self {
        Self {
            part: Arc::new(part),
            table,
        }
    }

    /// The part's numbers are the system's parameters, whose values may change from run to run; its
    /// whole numbers and words are fixed here.
    pub(crate) fn build(&self, parameters: &PartParameters) -> Result<PoissonSystem, BuildError> {
        let name = self.part.name();
        let settings = self.part.settings(parameters)?;
        let making = Making {
            dimension: 0,
            settings: &settings,
        };
        let refused = |reason: String| BuildError::NotMade { part: name, reason };
        let trial = Instance::new(&self.part, making, HostObjects::default())
            .map_err(|failure| refused(failure.to_string()))?;
        let own: Vec<&str> = settings.iter().map(|(name, _)| name.as_str()).collect();
        let (variables, casimirs) = names(&trial, &self.table, &own).map_err(refused)?;
        self.part.check_dimension(variables.len())?;
        let parameters = settings
            .iter()
            .filter_map(|(name, setting)| match setting {
                ParameterSetting::Real(value) => Some(Parameter {
                    name: name.clone(),
                    value: *value,
                }),
                _ => None,
            })
            .collect();
        Ok(OpaqueSystem {
            name: name.to_owned(),
            numbers: ForeignNumbers {
                part: Arc::clone(&self.part),
                table: offered(self.table, trial, variables.len(), casimirs.len()),
                settings,
                dimension: variables.len(),
                casimirs: casimirs.len(),
                idle: Idle::default(),
            }
            .numbers(),
            variables,
            parameters,
            casimirs,
        }
        .into())
    }
}

/// The table without the derivatives that the instance does not offer.
fn offered(table: LwSystem, mut instance: Instance, d: usize, casimirs: usize) -> LwSystem {
    let y = states(d).swap_remove(0);
    let at = Call::at(1, 1.0, 0.0, Input::points(&y, d));
    let with_v = Call {
        v: Input::points(&y, d),
        ..at
    };
    let with_both = Call {
        w: Input::points(&y, d),
        ..with_v
    };
    LwSystem {
        casimir_gradients: instance.offered(table.casimir_gradients, &at, casimirs * d),
        tensor_tangent: instance.offered(table.tensor_tangent, &with_both, d),
        hessian: instance.offered(table.hessian, &with_v, d),
        ..table
    }
}

/// The names of an instance's variables and Casimirs.
pub(crate) fn names(
    instance: &Instance,
    table: &LwSystem,
    parameters: &[&str],
) -> Result<(Vec<String>, Vec<String>), String> {
    let counted = |what: &str, count: usize| {
        if count > MOST {
            Err(format!("{count} {what} are more than {MOST}"))
        } else {
            Ok(count)
        }
    };
    let d = table.dimension.map_or(0, |dimension| {
        // SAFETY: a function of the instance's own table, here and below.
        instance.ask(|instance| unsafe { dimension(instance) })
    });
    if counted("variables", d)? == 0 {
        return Err("it has dimension 0".to_owned());
    }
    let casimirs = table.casimir_count.map_or(0, |count| {
        // SAFETY: as above.
        instance.ask(|instance| unsafe { count(instance) })
    });
    let name = |function: LwNameFn, what: &str, letter: char, index: usize| {
        let own = match function {
            // SAFETY: as above.
            Some(name) => instance.ask(|instance| unsafe { name(instance, index) }),
            None => std::ptr::null(),
        };
        let what = || format!("the name of {what} {}", index + 1);
        // SAFETY: a name is NULL or a string that lives as long as the instance.
        let own = unsafe { text(what, own, LONGEST_TEXT) };
        let own = own.map_err(|refusal| refusal.to_string())?;
        let own = own.filter(|name| !name.trim().is_empty());
        Ok(own.unwrap_or_else(|| format!("{letter}{}", index + 1)))
    };
    let all = |function: LwNameFn, what: &str, letter: char, count: usize| {
        (0..counted(&format!("{what}s"), count)?)
            .map(|index| name(function, what, letter, index))
            .collect::<Result<Vec<String>, String>>()
    };
    let variables = all(table.variable_name, "variable", 'x', d)?;
    let casimirs = all(table.casimir_name, "Casimir", 'C', casimirs)?;
    check_names(&variables, &casimirs, parameters)?;
    Ok((variables, casimirs))
}

/// Names that stand beside the state in samples and formulas.
const TAKEN: [&str; 3] = ["t", "time", "energy"];

/// The rules that names of a scene obey, so that formulas may use them, and one name for one thing.
fn check_names(
    variables: &[String],
    casimirs: &[String],
    parameters: &[&str],
) -> Result<(), String> {
    let mut seen = HashSet::new();
    let variables = variables.iter().map(|name| ("variable", name.as_str()));
    let casimirs = casimirs.iter().map(|name| ("Casimir", name.as_str()));
    let parameters = parameters.iter().map(|name| ("parameter", *name));
    for (what, name) in parameters.chain(variables).chain(casimirs) {
        let refused =
            |problem: &str| Err(format!("the {what} `{}` {problem}", name.escape_debug()));
        if let Err(error) = Scope::check_name(name) {
            return refused(&format!("cannot have this name: {}", error.kind));
        }
        if TAKEN.contains(&name) {
            return refused("has a name that is reserved in samples and formulas");
        }
        if !seen.insert(name) {
            return refused("has the name of another variable, Casimir or parameter");
        }
    }
    Ok(())
}

/// Π, H and their derivatives by calls.
#[derive(Debug)]
struct ForeignNumbers {
    part: Arc<ForeignPart>,
    table: LwSystem,
    settings: Vec<(String, ParameterSetting)>,
    dimension: usize,
    casimirs: usize,
    idle: Idle,
}

impl ForeignNumbers {
    fn numbers(self) -> SystemNumbers {
        let derivatives = Derivatives {
            tensor: self.table.tensor_tangent.is_some(),
            hamiltonian: self.table.hessian.is_some(),
            casimirs: self.table.casimir_gradients.is_some(),
        };
        SystemNumbers::new(derivatives, move |parameters| self.evaluator(parameters))
    }

    fn evaluator(&self, parameters: &[f64]) -> Box<dyn SystemEvaluator> {
        let mut values = parameters.iter();
        let mut settings = self.settings.clone();
        for (_, setting) in &mut settings {
            if let ParameterSetting::Real(value) = setting {
                *value = values.next().copied().unwrap_or(*value);
            }
        }
        let making = (0, settings);
        let lend = || Ok(HostObjects::default());
        Box::new(ForeignValues {
            callee: Callee::new(&self.part, &self.idle, parameters, making, lend),
            table: self.table,
            dimension: self.dimension,
            casimirs: self.casimirs,
        })
    }
}

struct ForeignValues {
    callee: Callee,
    table: LwSystem,
    dimension: usize,
    casimirs: usize,
}

impl SystemEvaluator for ForeignValues {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        let (table, d, casimirs) = (&self.table, self.dimension, self.casimirs);
        let (name, function_of, results) = match function {
            SystemFunction::Tensor(_) => ("tensor", table.tensor, d),
            SystemFunction::Hamiltonian => ("hamiltonian", table.hamiltonian, 1),
            SystemFunction::Gradient => ("gradient", table.gradient, d),
            SystemFunction::Casimirs => ("casimirs", table.casimirs, casimirs),
            SystemFunction::TensorTangent(..) => ("tensor_tangent", table.tensor_tangent, d),
            SystemFunction::Hessian(_) => ("hessian", table.hessian, d),
            SystemFunction::CasimirGradients => {
                ("casimir_gradients", table.casimir_gradients, casimirs * d)
            }
        };
        if results == 0 {
            return Ok(());
        }
        let [v, w] = function.vectors();
        let [y, v, w] = [y, v, w].map(|values| match values.len() {
            0 => Input::NONE,
            length if length == d => Input::shared(values),
            _ => Input::points(values, d),
        });
        let count = if out.len() == results {
            1
        } else {
            out.len() / results
        };
        let call = Call {
            v,
            w,
            ..Call::at(count, 1.0, 0.0, y)
        };
        let output = Output::points(out, results);
        self.callee.evaluate(name, function_of, &call, output)
    }

    /// The library does not count them.
    fn operations(&self) -> Option<u64> {
        None
    }
}
