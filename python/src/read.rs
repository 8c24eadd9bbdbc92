//! Scenes as read: composed, checked, with what is asked of their runs.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use leafwise::core::Registry;
use leafwise::run::ensemble::{ComposedEnsemble, Members, compose_ensemble, compose_members};
use leafwise::run::{Event, RunOptions};
use leafwise::scene::document::{Located, ObservableSpec, Place, Source};
use leafwise::scene::{ComposedRun, SceneChecks, SceneDocument};
use leafwise::walk::Direction;
use leafwise_cli::failure::Failure;
use leafwise_cli::scene::SceneText;
use pyo3::prelude::*;

use crate::arrays::Arrays;
use crate::command::with_plugins;
use crate::error::{LeafwiseError, exception};
use crate::functions::Functions;
use crate::kept::compose;

/// A surface, the direction in which it is crossed, and the number of the crossing that ends the run.
pub(crate) type AskedEvent = (String, String, Option<u64>);

/// A scene with the parts that it names.
pub(crate) struct Read {
    pub(crate) document: SceneDocument,
    pub(crate) registry: Registry,
    pub(crate) functions: Option<Functions>,
}

impl Read {
    pub(crate) fn new(
        text: SceneText,
        system: Option<&Arc<Py<PyAny>>>,
        arrays: &Arrays,
    ) -> PyResult<Self> {
        let mut parts = with_plugins()?;
        arrays.join(&mut parts.registry);
        let functions = system.map(|system| Functions::new(Arc::clone(system)));
        if let Some(functions) = &functions {
            functions.join(&mut parts.registry)?;
        }
        let name = text.name.clone();
        let base = Path::new(&name).parent().unwrap_or(Path::new("."));
        let document = parts.document(text, base);
        let document = document.map_err(|failure| exception(&failure))?;
        let tables = &document.system.tables;
        let is_known = |name: &&str| tables.iter().any(|(known, _)| known.value == **name);
        if let Some(other) = arrays.names().find(|name| !is_known(name)) {
            let known: Vec<&str> = tables.iter().map(|(name, _)| name.value.as_str()).collect();
            let known = match known.is_empty() {
                true => "no table: write [system.tables]".to_owned(),
                false => format!("the tables {}", known.join(", ")),
            };
            return Err(LeafwiseError::new_err(format!(
                "an array is given for the table `{other}`, and the scene has {known}"
            )));
        }
        Ok(Self {
            document,
            registry: parts.registry,
            functions,
        })
    }

    /// The system and the method.
    pub(crate) fn composed(&self) -> PyResult<ComposedRun> {
        let composed = compose(&self.document, &self.registry);
        self.unless_raised(composed.map_err(|refusal| exception(&Failure::from(refusal))))
    }

    /// Events that are asked for beside the scene's own section.
    pub(crate) fn events(&self, run: &ComposedRun, asked: &[AskedEvent]) -> PyResult<Vec<Event>> {
        let events = asked.iter().map(|(text, direction, last)| {
            let direction = match direction.as_str() {
                "up" => Direction::Up,
                "down" => Direction::Down,
                _ => Direction::Both,
            };
            let section = run.section(&self.document, text, direction);
            let section = section.map_err(|refusal| exception(&Failure::from(refusal)))?;
            let last = *last;
            Ok(Event {
                section,
                act: None,
                last,
            })
        });
        events.collect()
    }

    /// The ensemble with these members, or those of its own table.
    pub(crate) fn ensemble(&self, members: &Members, files: &Path) -> PyResult<ComposedEnsemble> {
        let ensemble = match *members == Members::default() {
            true => compose_ensemble(&self.document, &self.registry, files),
            false => compose_members(&self.document, &self.registry, members),
        };
        self.unless_raised(ensemble.map_err(|refusal| exception(&Failure::from(refusal))))
    }

    /// Refuses a system that a run refuses: a bracket that is not Poisson, a Casimir that is none.
    pub(crate) fn check(&self, composed: &ComposedRun, allow_non_poisson: bool) -> PyResult<()> {
        let checks = SceneChecks::of(&composed.system, &composed.near);
        let checks =
            self.unless_raised(checks.map_err(|error| exception(&Failure::from(error))))?;
        let system = (&composed.system, composed.near.as_slice());
        match checks.refusal(&self.document, system, allow_non_poisson) {
            Some(refusal) => Err(exception(&Failure::from(refusal))),
            None => Ok(()),
        }
    }

    /// The result `found`, or the exception of a function of the system in its place where one was raised.
    fn unless_raised<T>(&self, found: PyResult<T>) -> PyResult<T> {
        match self.functions.as_ref().and_then(Functions::raised) {
            Some(error) => Err(error),
            None => found,
        }
    }
}

/// Energy and Casimirs among what is recorded.
pub(crate) fn record_invariants(document: &mut SceneDocument) {
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

/// Options of a run in a directory.
pub(crate) fn options(directory: PathBuf, allow_non_poisson: bool) -> RunOptions {
    RunOptions {
        allow_non_poisson,
        checkpoint_every: Duration::MAX,
        ..RunOptions::within(directory)
    }
}
