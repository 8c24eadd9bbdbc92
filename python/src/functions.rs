//! A Poisson system whose values functions of Python compute.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use leafwise::core::part::{
    ParameterDefault, ParameterInfo, ParameterSetting, PartInfo, PartKind, PartParameters,
};
use leafwise::core::registry::SystemPart;
use leafwise::core::system::{
    Derivatives, OpaqueSystem, Parameter, SystemEvaluator, SystemFunction, SystemNumbers,
};
use leafwise::core::{Origin, PoissonSystem, Registry, StepError};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error::{LeafwiseError, is_interruption};

/// The id under which a scene names the one system of this kind that it has.
const NAME: &str = "python/functions";

/// Declarations of the part, one for every list of parameters' names that a system has had. Declarations of parts live
/// as long as the program.
static DECLARED: Mutex<BTreeMap<Vec<String>, &'static PartInfo>> = Mutex::new(BTreeMap::new());

/// The declaration of the part of a system with these parameters, leaked once for each list of their names.
fn declared(parameters: &[(String, f64)]) -> &'static PartInfo {
    let names: Vec<String> = parameters.iter().map(|(name, _)| name.clone()).collect();
    let mut declared = DECLARED.lock().unwrap_or_else(PoisonError::into_inner);
    declared.entry(names).or_insert_with_key(|names| {
        let parameters = names.iter().map(|name| ParameterInfo {
            name: name.clone().leak(),
            summary: "a parameter of the functions",
            default: ParameterDefault::Real(0.0),
        });
        Box::leak(Box::new(PartInfo {
            name: NAME,
            summary: "functions of Python",
            declares: "Π(x)p, H, ∇H and Casimirs as numbers",
            domain: "where the functions are defined",
            parameters: parameters.collect::<Vec<_>>().leak(),
            ..PartInfo::of(PartKind::System)
        }))
    })
}

/// The system with the values that a scene gives to its parameters.
fn with_values(mut system: OpaqueSystem, given: &PartParameters) -> OpaqueSystem {
    for (name, setting) in given.iter() {
        let mut own = system.parameters.iter_mut();
        if let (Some(parameter), ParameterSetting::Real(value)) =
            (own.find(|own| own.name == name), setting)
        {
            parameter.value = *value;
        }
    }
    system
}

/// The functions, and the first exception that one of them has raised. Every run has its own.
#[derive(Clone)]
pub(crate) struct Functions {
    /// `leafwise.System`: what it has, and `_values`, which calls its functions.
    system: Arc<Py<PyAny>>,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl fmt::Debug for Functions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(NAME)
    }
}

impl Functions {
    pub fn new(system: Arc<Py<PyAny>>) -> Self {
        let raised = Arc::default();
        Self { system, raised }
    }

    /// Adds the system to those that a scene may name.
    ///
    /// # Errors
    /// A system without names.
    pub fn join(&self, registry: &mut Registry) -> PyResult<()> {
        let (info, system) = Python::attach(|py| {
            let of = |name: &str| self.system.bind(py).getattr(name);
            let parameters: Vec<(String, f64)> = of("_parameters")?.extract()?;
            let info = declared(&parameters);
            let parameters = parameters.into_iter();
            let system = OpaqueSystem {
                name: NAME.to_owned(),
                variables: of("variables")?.extract()?,
                parameters: parameters
                    .map(|(name, value)| Parameter { name, value })
                    .collect(),
                casimirs: of("casimirs")?.extract()?,
                numbers: self.numbers(),
            };
            PyResult::Ok((info, system))
        })?;
        let part = SystemPart::new(info, move |given| {
            Ok(PoissonSystem::from(with_values(system.clone(), given)))
        });
        let origin = Origin::built_in(env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"));
        let joined = registry.register(part.into(), origin);
        joined.map_err(|error| LeafwiseError::new_err(error.to_string()))
    }

    /// The first exception that a function has raised since the last time.
    pub fn raised(&self) -> Option<PyErr> {
        let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        raised.take()
    }

    /// Whether one has raised an exception.
    pub fn has_raised(&self) -> bool {
        let raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        raised.is_some()
    }

    fn keep(&self, error: PyErr) {
        let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        raised.get_or_insert(error);
    }
}

impl Functions {
    fn numbers(&self) -> SystemNumbers {
        let evaluator = |functions: Self, is_on_trial| {
            move |parameters: &[f64]| -> Box<dyn SystemEvaluator> {
                Box::new(FunctionsEvaluator {
                    functions: functions.clone(),
                    parameters: parameters.to_vec(),
                    is_on_trial,
                })
            }
        };
        SystemNumbers::new(Derivatives::default(), evaluator(self.clone(), false))
            .with_trials(evaluator(self.clone(), true))
    }
}

struct FunctionsEvaluator {
    functions: Functions,
    parameters: Vec<f64>,
    /// Whether what a function raises is of no account, but Ctrl-C.
    is_on_trial: bool,
}

impl FunctionsEvaluator {
    /// `_values` of one of the functions, points one after the other.
    fn values(
        &self,
        function: &str,
        y: &[f64],
        v: Option<&[f64]>,
        out: &mut [f64],
    ) -> Result<(), StepError> {
        if out.is_empty() {
            return Ok(());
        }
        Python::attach(|py| {
            let array = |values: &[f64]| PyArray1::from_slice(py, values);
            let arguments = (
                function,
                &self.parameters,
                out.len(),
                array(y),
                v.map(array),
            );
            let system = self.functions.system.bind(py);
            let copied = system
                .call_method1("_values", arguments)
                .and_then(|values| {
                    let values: PyReadonlyArray1<'_, f64> = values.extract()?;
                    out.copy_from_slice(values.as_slice()?);
                    Ok(())
                });
            copied.map_err(|error| {
                let message = error.to_string();
                if !self.is_on_trial || is_interruption(&error) {
                    self.functions.keep(error);
                }
                StepError::Part {
                    part: format!("the function `{function}`"),
                    message,
                }
            })
        })
    }
}

impl SystemEvaluator for FunctionsEvaluator {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        match function {
            SystemFunction::Tensor(v) => self.values("tensor", y, Some(v), out),
            SystemFunction::Hamiltonian => self.values("hamiltonian", y, None, out),
            SystemFunction::Gradient => self.values("gradient", y, None, out),
            SystemFunction::Casimirs => self.values("casimirs", y, None, out),
            _ => Err(StepError::NoTangent),
        }
    }

    /// Python does not count them.
    fn operations(&self) -> Option<u64> {
        None
    }
}
