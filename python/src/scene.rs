//! Scenes, composed and stepped without the interpreter's lock.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use leafwise::core::Registry;
use leafwise::run::ensemble::{
    Members, Workforce, compose_ensemble, compose_members, run_ensemble,
};
use leafwise::run::{Progress, RunOptions, Status, run_in_memory};
use leafwise::scene::document::{Located, ObservableSpec, Place, Source};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise_cli::failure::Failure;
use leafwise_cli::scene::SceneText;
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::command::with_plugins;
use crate::ensemble::{Ensemble, Left};
use crate::error::{exception, of_scene};
use crate::integrator::Integrator;
use crate::recorded::Recorded;

/// How often signals are looked for and progress is told.
const LOOK_EVERY: Duration = Duration::from_millis(50);

type Overrides = Vec<(String, String)>;

/// Coordinates, Casimirs, parameters with their values, and the method in words.
type Description = (Vec<String>, Vec<String>, Vec<(String, f64)>, Vec<String>);

/// A scene with its overrides.
#[pyclass(frozen, module = "leafwise")]
pub(crate) struct Scene {
    document: SceneDocument,
    registry: Registry,
    source: String,
    overrides: Overrides,
}

impl Scene {
    /// The scene with more overrides.
    fn with(&self, more: &Overrides) -> PyResult<SceneDocument> {
        if more.is_empty() {
            return Ok(self.document.clone());
        }
        let (name, text) = (&self.document.name, &self.document.text);
        let document = SceneDocument::parse_with(name, text, more, &self.registry);
        document.map_err(|errors| of_scene(&errors))
    }

    /// The scene with more overrides, and its system and method.
    fn composed(&self, more: &Overrides) -> PyResult<(SceneDocument, ComposedRun)> {
        let mut document = self.with(more)?;
        record_invariants(&mut document);
        let composed = compose(&document, &self.registry);
        let composed = composed.map_err(|refusal| exception(&Failure::from(refusal)))?;
        Ok((document, composed))
    }
}

/// Energy and Casimirs among what is recorded.
fn record_invariants(document: &mut SceneDocument) {
    let casimirs = document.system.casimirs.iter();
    let names = casimirs.map(|(name, _)| name.value.clone());
    let names: Vec<String> = std::iter::once("energy".to_owned()).chain(names).collect();
    let recorded = &mut document.run.record.observables;
    let place = Place {
        source: Source::Scene,
        span: 0..0,
    };
    for name in names {
        if recorded.iter().all(|known| known.heading() != name) {
            recorded.push(ObservableSpec {
                name: None,
                formula: Located::new(name, place.clone()),
            });
        }
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new(py: Python<'_>, source: String, name: &str, overrides: Overrides) -> PyResult<Self> {
        let text = SceneText {
            name: name.to_owned(),
            text: source.clone(),
            overrides: overrides.clone(),
        };
        let base = Path::new(name).parent().unwrap_or(Path::new("."));
        let (document, parts) = py.detach(|| {
            let mut parts = with_plugins()?;
            let document = parts.document(text, base);
            let document = document.map_err(|failure| exception(&failure))?;
            PyResult::Ok((document, parts))
        })?;
        Ok(Self {
            document,
            registry: parts.registry,
            source,
            overrides,
        })
    }

    /// The scene's name.
    #[getter]
    fn name(&self) -> &str {
        &self.document.name
    }

    /// Its text, with the overrides.
    #[getter]
    fn text(&self) -> &str {
        &self.document.text
    }

    /// What it was made of: text, name and overrides.
    #[getter]
    fn origin(&self) -> (&str, &str, Overrides) {
        (&self.source, &self.document.name, self.overrides.clone())
    }

    /// What it composes to.
    fn describe(&self, py: Python<'_>) -> PyResult<Description> {
        py.detach(|| {
            let (_, run) = self.composed(&Vec::new())?;
            let casimirs = run.system.casimir_names();
            let parameters = run.system.parameters().iter();
            Ok((
                run.names(),
                casimirs.iter().map(|name| (*name).to_owned()).collect(),
                parameters.map(|p| (p.name.clone(), p.value)).collect(),
                (run.method.parts().into_iter())
                    .map(|(label, text)| format!("{label}: {text}"))
                    .collect(),
            ))
        })
    }

    /// Steps the scene with more overrides; `progress` is called with the steps made and their number.
    fn run(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        allow_non_poisson: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Recorded> {
        let (coordinates, recorded) = py.detach(|| {
            let (document, composed) = self.composed(&overrides)?;
            let mut told = Told::new(progress);
            let registry = &self.registry;
            let recorded =
                run_in_memory(&document, &composed, registry, allow_non_poisson, &mut told);
            match told.raised {
                Some(error) => Err(error),
                None => recorded
                    .map(|recorded| (composed.plan.states.width(), recorded))
                    .map_err(|error| exception(&Failure::from(error))),
            }
        })?;
        Recorded::new(py, coordinates, recorded)
    }

    /// Steps an ensemble of the scene with more overrides into the directory `out`: members with these states (n, d) and
    /// parameters, or those of its own table, whose files are in `files`.
    #[allow(clippy::too_many_arguments)]
    fn ensemble(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        states: Option<PyReadonlyArray2<'_, f64>>,
        parameters: Vec<(String, Vec<f64>)>,
        files: PathBuf,
        out: PathBuf,
        threads: Option<NonZeroUsize>,
        allow_non_poisson: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Ensemble> {
        let states = states.map(|states| states.as_array().iter().copied().collect());
        let members = Members { states, parameters };
        let (composed, report, left) = py.detach(|| {
            let document = self.with(&overrides)?;
            let ensemble = match members == Members::default() {
                true => compose_ensemble(&document, &self.registry, &files),
                false => compose_members(&document, &self.registry, &members),
            };
            let ensemble = ensemble.map_err(|refusal| exception(&Failure::from(refusal)))?;
            let options = RunOptions {
                directory: out,
                force: false,
                allow_non_poisson,
                command: String::new(),
                checkpoint_every: Duration::MAX,
            };
            let mut workforce = Workforce::default();
            workforce.threads = threads.unwrap_or(workforce.threads);
            let mut told = Told::new(progress);
            let report = run_ensemble(&document, &ensemble, &options, workforce, &mut told);
            if let Some(error) = told.raised {
                return Err(error);
            }
            let report = report.map_err(|error| exception(&Failure::from(error)))?;
            let left = Left::read(&ensemble, &report)?;
            Ok((ensemble, report, left))
        })?;
        Ensemble::new(py, &composed, &report, left)
    }

    /// The method's steps from the initial state.
    fn integrator(&self, py: Python<'_>) -> PyResult<Integrator> {
        let (_, composed) = py.detach(|| self.composed(&Vec::new()))?;
        Ok(Integrator::new(composed.integrator()))
    }
}

/// Looks for Ctrl-C, and tells a function of Python where the run stands.
struct Told {
    function: Option<Py<PyAny>>,
    looked: Instant,
    is_interrupted: bool,
    /// What the function raised.
    raised: Option<PyErr>,
}

impl Told {
    fn new(function: Option<Py<PyAny>>) -> Self {
        Self {
            function,
            looked: Instant::now(),
            is_interrupted: false,
            raised: None,
        }
    }
}

impl Progress for Told {
    fn show(&mut self, status: &Status) {
        if self.looked.elapsed() < LOOK_EVERY || self.is_interrupted {
            return;
        }
        Python::attach(|py| {
            self.is_interrupted = py.check_signals().is_err();
            if let Some(function) = &self.function
                && let Err(error) = function.call1(py, (status.steps, status.total))
            {
                self.is_interrupted = true;
                // Ctrl-C while the function runs.
                let is_interruption = error.is_instance_of::<PyKeyboardInterrupt>(py);
                self.raised = (!is_interruption).then_some(error);
            }
        });
        self.looked = Instant::now();
    }

    fn is_interrupted(&self) -> bool {
        self.is_interrupted
    }
}
