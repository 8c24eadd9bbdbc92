//! A system whose values a library computes.

use std::ffi::CStr;
use std::sync::Arc;

use leafwise_core::part::{ParameterSetting, PartInfo};
use leafwise_core::registry::SystemPart;
use leafwise_core::system::{Derivatives, NumbersWorker, OpaqueSystem, Parameter, SystemNumbers};
use leafwise_core::{BuildError, PartParameters, PoissonSystem, StepError};
use leafwise_plugin_abi::{LwMapFn, LwSystem};

use super::batch::{Input, Output};
use super::callee::Callee;
use super::instance::{Call, Instance, Lent, Making};
use super::part::ForeignPart;

/// The most variables and Casimirs that a system may have.
const MOST: usize = 1 << 20;

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
}

impl SystemPart for ForeignSystemPart {
    fn info(&self) -> &'static PartInfo {
        self.part.info
    }

    /// The part's numbers are the system's parameters, whose values may change from run to run; its
    /// whole numbers and words are fixed here.
    fn build(&self, parameters: &PartParameters) -> Result<PoissonSystem, BuildError> {
        let name = self.part.name();
        let settings = self.part.settings(parameters)?;
        let making = Making {
            dimension: 0,
            settings: &settings,
        };
        let refused = |reason: String| BuildError::NotMade { part: name, reason };
        let trial = Instance::new(&self.part, making, Lent::default())
            .map_err(|failure| refused(failure.to_string()))?;
        let (variables, casimirs) = names(&trial, &self.table).map_err(refused)?;
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
            numbers: Arc::new(ForeignNumbers {
                part: Arc::clone(&self.part),
                table: self.table,
                settings,
                dimension: variables.len(),
                casimirs: casimirs.len(),
            }),
            variables,
            parameters,
            casimirs,
        }
        .into())
    }
}

/// The names of an instance's variables and Casimirs.
fn names(instance: &Instance, table: &LwSystem) -> Result<(Vec<String>, Vec<String>), String> {
    let pointer = instance.pointer();
    let counted = |what: &str, count: usize| {
        if count > MOST {
            Err(format!("{count} {what} are more than {MOST}"))
        } else {
            Ok(count)
        }
    };
    // SAFETY: functions of the instance's own table, here and below.
    let d = table
        .dimension
        .map_or(0, |dimension| unsafe { dimension(pointer) });
    if counted("variables", d)? == 0 {
        return Err("it has dimension 0".to_owned());
    }
    // SAFETY: as above.
    let casimirs = table
        .casimir_count
        .map_or(0, |count| unsafe { count(pointer) });
    let variable = |index: usize| match table.variable_name {
        // SAFETY: as above; a name is NULL or a string that lives as long as the instance.
        Some(name) => unsafe { owned(name(pointer, index)) },
        None => None,
    };
    let casimir = |index: usize| match table.casimir_name {
        // SAFETY: as above.
        Some(name) => unsafe { owned(name(pointer, index)) },
        None => None,
    };
    let variables = (0..d)
        .map(|i| variable(i).unwrap_or_else(|| format!("x{}", i + 1)))
        .collect();
    let casimirs = (0..counted("Casimirs", casimirs)?)
        .map(|i| casimir(i).unwrap_or_else(|| format!("C{}", i + 1)))
        .collect();
    Ok((variables, casimirs))
}

/// # Safety
/// `name` is NULL or a string.
unsafe fn owned(name: *const std::ffi::c_char) -> Option<String> {
    if name.is_null() {
        return None;
    }
    // SAFETY: passed on to the caller.
    let name = unsafe { CStr::from_ptr(name) }.to_string_lossy();
    (!name.trim().is_empty()).then(|| name.into_owned())
}

/// Π, H and their derivatives by calls.
#[derive(Debug)]
struct ForeignNumbers {
    part: Arc<ForeignPart>,
    table: LwSystem,
    settings: Vec<(String, ParameterSetting)>,
    dimension: usize,
    casimirs: usize,
}

impl SystemNumbers for ForeignNumbers {
    fn derivatives(&self) -> Derivatives {
        Derivatives {
            tensor: self.table.tensor_tangent.is_some(),
            hamiltonian: self.table.hessian.is_some(),
            casimirs: self.table.casimir_gradients.is_some(),
        }
    }

    fn worker(&self, parameters: &[f64]) -> Box<dyn NumbersWorker> {
        let mut values = parameters.iter();
        let mut settings = self.settings.clone();
        for (_, setting) in &mut settings {
            if let ParameterSetting::Real(value) = setting {
                *value = values.next().copied().unwrap_or(*value);
            }
        }
        let part = Arc::clone(&self.part);
        let make = move || {
            let making = Making {
                dimension: 0,
                settings: &settings,
            };
            Instance::new(&part, making, Lent::default())
        };
        Box::new(Worker {
            callee: Callee::shared(&self.part, make),
            table: self.table,
            dimension: self.dimension,
            casimirs: self.casimirs,
        })
    }
}

struct Worker {
    callee: Callee,
    table: LwSystem,
    dimension: usize,
    casimirs: usize,
}

impl Worker {
    /// One function of y and up to two vectors, with `results` numbers a point.
    #[inline(always)]
    fn evaluate(
        &mut self,
        (name, function): (&str, LwMapFn),
        y: &[f64],
        vectors: [&[f64]; 2],
        out: &mut [f64],
        results: usize,
    ) -> Result<(), StepError> {
        if results == 0 {
            return Ok(());
        }
        let d = self.dimension;
        let [y, v, w] = [y, vectors[0], vectors[1]].map(|values| match values.len() {
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
        self.callee.evaluate(name, function, &call, output)
    }
}

impl NumbersWorker for Worker {
    fn tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let function = ("tensor", self.table.tensor);
        self.evaluate(function, y, [v, &[]], out, self.dimension)
    }

    fn hamiltonian(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let function = ("hamiltonian", self.table.hamiltonian);
        self.evaluate(function, y, [&[], &[]], out, 1)
    }

    fn gradient(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let function = ("gradient", self.table.gradient);
        self.evaluate(function, y, [&[], &[]], out, self.dimension)
    }

    fn casimirs(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let function = ("casimirs", self.table.casimirs);
        self.evaluate(function, y, [&[], &[]], out, self.casimirs)
    }

    fn tensor_tangent(
        &mut self,
        y: &[f64],
        v: &[f64],
        w: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        let function = ("tensor_tangent", self.table.tensor_tangent);
        self.evaluate(function, y, [v, w], out, self.dimension)
    }

    fn hessian(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let function = ("hessian", self.table.hessian);
        self.evaluate(function, y, [v, &[]], out, self.dimension)
    }

    fn casimir_gradients(&mut self, y: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        let function = ("casimir_gradients", self.table.casimir_gradients);
        let results = self.casimirs * self.dimension;
        self.evaluate(function, y, [&[], &[]], out, results)
    }
}
