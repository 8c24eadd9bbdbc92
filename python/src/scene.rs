//! Scenes, composed and stepped without the interpreter's lock.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;

use leafwise::core::Registry;
use leafwise::run::ensemble::{Members, Workforce};
use leafwise::run::{Asked, Retraced as States, RunOutcome, StateError, run_in_memory};
use leafwise::scene::compose::{are_values, check_varied};
use leafwise::scene::{ComposedRun, SceneDocument};
use leafwise_cli::failure::Failure;
use leafwise_cli::scene::SceneText;
use numpy::{PyArrayDyn, PyReadonlyArray2, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use crate::arrays::Arrays;
use crate::ensemble::{Ensemble, Left};
use crate::error::{LeafwiseError, exception, is_interruption, of_scene};
use crate::functions::Functions;
use crate::gradient::Map;
use crate::integrator::Integrator;
use crate::job::{Origin, unless_interrupted};
use crate::kept::{Kept, compose};
use crate::progress::PythonProgress;
use crate::read::{AskedEvent, Read, options, record_invariants};
use crate::recorded::{ErrorOfStates, Recorded, as_tuple};
use crate::retraced::Retraced;
use crate::sweep::Sweep;

type Overrides = Vec<(String, String)>;

/// A parameter's name with its value.
type Parameters = Vec<(String, f64)>;

/// Coordinates, Casimirs, parameters with their values, and the method in words.
type Description = (Vec<String>, Vec<String>, Vec<(String, f64)>, Vec<String>);

/// All that makes a scene again.
type Told<'a> = (
    &'a str,
    &'a str,
    Overrides,
    Option<Py<PyAny>>,
    Vec<(String, Py<PyArrayDyn<f64>>)>,
);

/// A scene with its overrides.
#[pyclass(frozen, module = "leafwise")]
pub(crate) struct Scene {
    document: SceneDocument,
    registry: Registry,
    source: String,
    overrides: Overrides,
    /// `leafwise.System`, where the scene's system is functions of Python.
    system: Option<Arc<Py<PyAny>>>,
    arrays: Arrays,
    /// The method, which scenes share that were made from this one with other values.
    kept: Kept,
}

impl Scene {
    /// The scene with more overrides and its run, where the invariants are recorded. The method is composed once for
    /// all scenes that differ in values alone. At other parameters (`at`) it is the one of the scene's own, as those of
    /// members of an ensemble are.
    fn composed(&self, more: &Overrides, at: &Parameters) -> PyResult<(Read, ComposedRun)> {
        let mut read = self.with(&[more.clone(), self.chosen_at(at)].concat())?;
        record_invariants(&mut read.document);
        if read.functions.is_none() && are_values(more) {
            let own = || {
                let mut document = self.document.clone();
                record_invariants(&mut document);
                let run = compose(&document, &self.registry).ok()?;
                Some((document.text, run))
            };
            let found = self.kept.at(&read.document, own);
            let found = found.map_err(|refusal| exception(&Failure::from(refusal)))?;
            if let Some(run) = found {
                return Ok((read, run));
            }
        }
        let run = read.composed()?;
        Ok((read, run))
    }

    /// Overrides that set parameters and leave the method that of the scene's own.
    fn chosen_at(&self, parameters: &Parameters) -> Overrides {
        if parameters.is_empty() {
            return Vec::new();
        }
        let mut overrides: Overrides = parameters
            .iter()
            .map(|(name, value)| (format!("system.parameters.{name}"), format!("{value:?}")))
            .collect();
        if self.document.system.numbers.is_none() {
            let mut chosen = self.document.method.chosen_at.clone();
            for (name, value) in &self.document.system.parameters {
                let is_given = parameters.iter().any(|(given, _)| *given == name.value);
                if is_given && chosen.iter().all(|(known, _)| known.value != name.value) {
                    chosen.push((name.clone(), value.clone()));
                }
            }
            let chosen = chosen.iter();
            let chosen =
                chosen.map(|(name, value)| format!("{} = {}", name.value, value.value.literal));
            let table = chosen.collect::<Vec<_>>().join(", ");
            overrides.push(("method.chosen-at".to_owned(), format!("{{ {table} }}")));
        }
        overrides
    }

    /// The scene with more overrides.
    fn with(&self, more: &Overrides) -> PyResult<Read> {
        if self.system.is_some() {
            // Its functions tell their exceptions to this reader alone.
            let text = SceneText {
                name: self.document.name.clone(),
                text: self.document.text.clone(),
                overrides: more.clone(),
            };
            return Read::new(text, self.system.as_ref(), &self.arrays);
        }
        let document = match more.is_empty() {
            true => self.document.clone(),
            false => {
                let (name, text) = (&self.document.name, &self.document.text);
                let document = SceneDocument::parse_with(name, text, more, &self.registry);
                document.map_err(|errors| of_scene(&errors))?
            }
        };
        Ok(Read {
            document,
            registry: self.registry.clone(),
            functions: None,
        })
    }

    /// A scene of a text and its name.
    fn read(
        py: Python<'_>,
        (source, name): (String, &str),
        overrides: Overrides,
        system: Option<Py<PyAny>>,
        arrays: Arrays,
    ) -> PyResult<Self> {
        let text = SceneText {
            name: name.to_owned(),
            text: source.clone(),
            overrides: overrides.clone(),
        };
        let system = system.map(Arc::new);
        let read = py.detach(|| Read::new(text, system.as_ref(), &arrays))?;
        Ok(Self {
            document: read.document,
            registry: read.registry,
            source,
            overrides,
            system,
            arrays,
            kept: Kept::default(),
        })
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new(
        py: Python<'_>,
        source: String,
        name: &str,
        overrides: Overrides,
        system: Option<Py<PyAny>>,
        arrays: Vec<(String, PyReadonlyArrayDyn<'_, f64>)>,
    ) -> PyResult<Self> {
        let arrays = Arrays::of(arrays);
        Self::read(py, (source, name), overrides, system, arrays)
    }

    /// The same scene with more overrides, and with the same method where these are values.
    fn set(&self, py: Python<'_>, overrides: Overrides) -> PyResult<Self> {
        if !are_values(&overrides) || self.system.is_some() {
            let system = self.system.as_ref().map(|system| system.clone_ref(py));
            let text = (self.document.text.clone(), self.document.name.as_str());
            let arrays = self.arrays.without(&overrides);
            return Self::read(py, text, overrides, system, arrays);
        }
        let read = py.detach(|| self.with(&overrides))?;
        Ok(Self {
            document: read.document,
            registry: read.registry,
            source: self.document.text.clone(),
            overrides,
            system: None,
            arrays: self.arrays.clone(),
            kept: self.kept.clone(),
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

    /// Origin of the scene: its text, name, overrides, a system of functions, and arrays of tables.
    #[getter]
    fn origin(&self, py: Python<'_>) -> PyResult<Told<'_>> {
        let system = self.system.as_ref().map(|system| system.clone_ref(py));
        let (overrides, arrays) = (self.overrides.clone(), self.arrays.given(py)?);
        Ok((&self.source, &self.document.name, overrides, system, arrays))
    }

    /// Whether it has a table `[ensemble]` or `[sweep]`.
    fn has(&self, section: &str) -> bool {
        match section {
            "ensemble" => self.document.ensemble.is_some(),
            _ => self.document.sweep.is_some(),
        }
    }

    /// Names, Casimirs, parameters and method that the scene composes to.
    fn describe(&self, py: Python<'_>) -> PyResult<Description> {
        py.detach(|| {
            let (_, run) = self.composed(&Vec::new(), &Vec::new())?;
            let casimirs = run.system.casimir_names();
            let parameters = run.system.parameters().iter();
            Ok((
                run.names(),
                casimirs.iter().map(|name| (*name).to_owned()).collect(),
                parameters.map(|p| (p.name.clone(), p.value)).collect(),
                method_lines(&run),
            ))
        })
    }

    /// Steps the scene with more overrides, at other parameters, and looks for events; `progress` is called with the steps made and
    /// their number.
    #[allow(clippy::too_many_arguments)]
    fn run(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        parameters: Parameters,
        events: Vec<AskedEvent>,
        is_silent: bool,
        allow_non_poisson: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Recorded> {
        let (coordinates, of, recorded) = py.detach(|| {
            let (read, composed) = self.composed(&overrides, &parameters)?;
            let events = read.events(&composed, &events)?;
            let mut told = PythonProgress::new(progress, read.functions.as_ref());
            let recorded = run_in_memory(
                &read.document,
                &composed,
                &read.registry,
                Asked {
                    allow_non_poisson,
                    events: &events,
                    is_silent,
                },
                &mut told,
            );
            let recorded = recorded.map_err(|error| exception(&Failure::from(error)));
            let recorded = match told.into_raised() {
                None => recorded?,
                // Ctrl-C within a function of the system.
                Some(error) if is_interruption(&error) => {
                    let mut recorded = recorded?;
                    recorded.report.outcome = RunOutcome::Interrupted;
                    recorded
                }
                Some(error) => return Err(error),
            };
            let is_estimated = read.document.run.estimates_error.is_some();
            let error = is_estimated
                .then(|| {
                    StateError::of_report(&composed, &recorded.report, &|| {
                        Python::attach(|py| py.check_signals().is_err())
                    })
                })
                .flatten();
            if let Some(raised) = read.functions.as_ref().and_then(Functions::raised) {
                return Err(raised);
            }
            let of = (read.document.text.clone(), method_lines(&composed));
            PyResult::Ok((composed.plan.states.width(), of, (recorded, error)))
        })?;
        Recorded::new(py, coordinates, of, recorded)
    }

    /// Steps an ensemble of the scene with more overrides into the directory `out`; with `shards`, joins those in that
    /// folder instead. Its members have these states (n, d) and parameters, or are those of its own table, whose files
    /// are in `files`.
    #[allow(clippy::too_many_arguments)]
    fn ensemble(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        states: Option<PyReadonlyArray2<'_, f64>>,
        parameters: Vec<(String, Vec<f64>)>,
        files: PathBuf,
        out: PathBuf,
        shards: Option<PathBuf>,
        threads: Option<NonZeroUsize>,
        allow_non_poisson: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Ensemble> {
        let members = members(states, parameters);
        let (composed, report, left) = py.detach(|| {
            let read = self.with(&overrides)?;
            let ensemble = read.ensemble(&members, &files)?;
            let (options, origin) = (options(out, allow_non_poisson), Origin::find(None, shards)?);
            let report = read.make(&ensemble, &origin, &options, workforce(threads), progress)?;
            let left = Left::read(&ensemble, &report)?;
            PyResult::Ok((ensemble, report, left))
        })?;
        Ensemble::new(py, &composed, &report, left)
    }

    /// Makes a shard of it in the directory `out`: the one at `place`, I of N, or with `shards` those in that folder joined.
    #[allow(clippy::too_many_arguments)]
    fn shard(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        states: Option<PyReadonlyArray2<'_, f64>>,
        parameters: Vec<(String, Vec<f64>)>,
        files: PathBuf,
        out: PathBuf,
        place: (u64, u64),
        shards: Option<PathBuf>,
        threads: Option<NonZeroUsize>,
        allow_non_poisson: bool,
    ) -> PyResult<()> {
        let members = members(states, parameters);
        py.detach(|| {
            let read = self.with(&overrides)?;
            let ensemble = read.ensemble(&members, &files)?;
            let options = options(out, allow_non_poisson);
            let origin = Origin::find(Some(place), shards)?;
            let report = read.make(&ensemble, &origin, &options, workforce(threads), None)?;
            unless_interrupted(&report.outcome)
        })
    }

    /// Runs the settings of the scene's sweep into the directory `out`; with `shards`, joins those in that folder instead.
    #[allow(clippy::too_many_arguments)]
    fn sweep(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        out: PathBuf,
        shards: Option<PathBuf>,
        threads: Option<NonZeroUsize>,
        allow_non_poisson: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Sweep> {
        py.detach(|| {
            let read = self.with(&overrides)?;
            let (options, origin) = (options(out, allow_non_poisson), Origin::find(None, shards)?);
            let report = read.sweep(&origin, &options, workforce(threads).threads, progress)?;
            Sweep::read(&report)
        })
    }

    /// Makes a shard of it in the directory `out`: the one at `place`, I of N, or with `shards` those in that folder joined.
    #[allow(clippy::too_many_arguments)]
    fn sweep_shard(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        out: PathBuf,
        place: (u64, u64),
        shards: Option<PathBuf>,
        threads: Option<NonZeroUsize>,
        allow_non_poisson: bool,
    ) -> PyResult<()> {
        py.detach(|| {
            let read = self.with(&overrides)?;
            let options = options(out, allow_non_poisson);
            let origin = Origin::find(Some(place), shards)?;
            let report = read.sweep(&origin, &options, workforce(threads).threads, None)?;
            unless_interrupted(&report.outcome)
        })
    }

    /// The method's steps from the initial state, with more overrides and at other parameters.
    fn integrator(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        parameters: Parameters,
        allow_non_poisson: bool,
    ) -> PyResult<Integrator> {
        py.detach(|| {
            let (read, run) = self.composed(&overrides, &parameters)?;
            read.check(&run, allow_non_poisson)?;
            let acts = run.has_no_acts();
            acts.map_err(|acts| LeafwiseError::new_err(acts.to_string()))?;
            Ok(Integrator::new(&run, read.functions))
        })
    }

    /// The estimated error of its run's states: the largest, its time, that at the end, and whether it is large.
    fn state_error(
        &self,
        py: Python<'_>,
        overrides: Overrides,
        parameters: Parameters,
    ) -> PyResult<ErrorOfStates> {
        py.detach(|| {
            let (read, run) = self.composed(&overrides, &parameters)?;
            let found = StateError::measured(&run, run.plan.steps, &|| {
                Python::attach(|py| py.check_signals().is_err())
            });
            if let Some(raised) = read.functions.as_ref().and_then(Functions::raised) {
                return Err(raised);
            }
            let found = found.map_err(|no| LeafwiseError::new_err(no.to_string()))?;
            Ok(as_tuple(found))
        })
    }

    /// The states of the run at any times; None where these are not known from its steps, as with a pace, and of functions of Python.
    fn retraced(&self, py: Python<'_>) -> PyResult<Option<Retraced>> {
        py.detach(|| {
            let (read, run) = self.composed(&Vec::new(), &Vec::new())?;
            let dimension = run.plan.layout.coordinates();
            let states = States::of(run).filter(|_| read.functions.is_none());
            Ok(states.map(|states| Retraced::new(states, dimension)))
        })
    }

    /// A lower bound of the method's order, 0 where its error does not depend on the step.
    fn order(&self, py: Python<'_>) -> PyResult<usize> {
        py.detach(|| {
            let (_, run) = self.composed(&Vec::new(), &Vec::new())?;
            Ok(run.method.map().properties().order)
        })
    }

    /// Refuses values of sites, and an initial state where motions begin there, that are formed once of a parameter that varies.
    fn check_varied(&self, names: Vec<String>, begin_there: bool) -> PyResult<()> {
        let varied: Vec<&str> = names.iter().map(String::as_str).collect();
        check_varied(&self.document, &varied, begin_there)
            .map_err(|refusal| exception(&Failure::from(refusal)))
    }

    /// The method, to be stepped and differentiated from any state with any parameters.
    fn map(&self, py: Python<'_>, allow_non_poisson: bool) -> PyResult<Map> {
        py.detach(|| {
            let (read, run) = self.composed(&Vec::new(), &Vec::new())?;
            read.check(&run, allow_non_poisson)?;
            Map::new(run, read.functions)
        })
    }
}

/// The method in words.
fn method_lines(run: &ComposedRun) -> Vec<String> {
    let parts = run.method.parts(run.system.motion()).into_iter();
    parts
        .map(|(label, text)| format!("{label}: {text}"))
        .collect()
}

/// Members as arrays.
fn members(
    states: Option<PyReadonlyArray2<'_, f64>>,
    parameters: Vec<(String, Vec<f64>)>,
) -> Members {
    Members {
        states: states.map(|states| states.as_array().iter().copied().collect()),
        parameters,
    }
}

fn workforce(threads: Option<NonZeroUsize>) -> Workforce {
    let all = Workforce::default();
    Workforce {
        threads: threads.unwrap_or(all.threads),
        ..all
    }
}
