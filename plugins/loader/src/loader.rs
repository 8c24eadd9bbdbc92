//! Finding, checking, opening, registering.

use std::path::{Path, PathBuf};

use leafwise_core::registry::{Registry, RegistryError};
use leafwise_core::{Origin, Part};

use crate::declaration::{PartDeclaration, PluginDeclaration};
use crate::error::{PluginError, Refusal};
use crate::exits;
use crate::file;
use crate::find::SearchPath;
use crate::formulas;
use crate::opened::open_and_try;
use crate::part::part;
use crate::probe::{ProbeCache, ProbeCommand};
use crate::side_file;
use crate::smoke::Tried;

/// A plugin as a scene or a command line asks for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PluginRequest {
    /// A path, or a name to search for.
    pub name: PathBuf,
    /// The SHA-256 that the file must have, in hexadecimal.
    pub sha256: Option<String>,
}

impl PluginRequest {
    /// Any file of this name or path.
    pub fn new(name: impl Into<PathBuf>) -> Self {
        Self {
            name: name.into(),
            sha256: None,
        }
    }
}

/// A plugin whose parts are registered.
#[derive(Clone, Debug)]
pub struct LoadedPlugin {
    /// The file: absolute, free of symbolic links.
    pub path: PathBuf,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// The plugin's declaration.
    pub declaration: PluginDeclaration,
    /// The outcome of the trial of each part, in their order.
    pub tried: Vec<Tried>,
}

impl LoadedPlugin {
    /// Where its parts come from.
    pub fn origin(&self) -> Origin {
        Origin::Library {
            path: self.path.clone(),
            sha256: self.sha256.clone(),
            version: self.declaration.version.clone(),
            abi: self.declaration.abi.clone(),
        }
    }
}

/// Loads plugins into a registry. Nothing is loaded that is not asked for by name.
#[derive(Clone, Debug, Default)]
pub struct Loader {
    search: SearchPath,
    probe: Option<ProbeCommand>,
    cache: Option<ProbeCache>,
    is_off: bool,
}

impl Loader {
    /// A loader that searches these folders and tries nothing in a child process: a library that
    /// crashes when it is opened ends this one.
    pub fn new(search: SearchPath) -> Self {
        Self {
            search,
            ..Self::default()
        }
    }

    /// A loader that refuses every plugin.
    pub fn off() -> Self {
        Self {
            is_off: true,
            ..Self::default()
        }
    }

    /// The same, trying each library in a child process first.
    pub fn with_probe(mut self, probe: ProbeCommand) -> Self {
        self.probe = Some(probe);
        self
    }

    /// The same, remembering in `folder` which files passed the probe.
    pub fn with_probe_cache(mut self, folder: PathBuf) -> Self {
        self.cache = Some(ProbeCache::new(folder));
        self
    }

    /// The same, trying each library anew.
    pub fn without_cache(mut self) -> Self {
        self.cache = None;
        self
    }

    /// The same, remembering in the user's cache folder which files passed the probe.
    pub fn with_user_cache(mut self) -> Self {
        self.cache = ProbeCache::of_user();
        self
    }

    /// Where plugins are searched.
    pub fn search(&self) -> &SearchPath {
        &self.search
    }

    /// Whether it loads nothing.
    pub fn is_off(&self) -> bool {
        self.is_off
    }

    /// Loads a plugin and registers its parts, all or none; `base` is the folder that a relative path
    /// starts from.
    ///
    /// A plugin that is loaded already, under whatever name, is left as it is.
    ///
    /// # Errors
    /// The first [`Refusal`]; the registry is unchanged then.
    pub fn load(
        &self,
        request: &PluginRequest,
        base: &Path,
        registry: &mut Registry,
    ) -> Result<LoadedPlugin, PluginError> {
        if self.is_off {
            return Err(Refusal::SwitchedOff.of(&request.name));
        }
        let path = self.search.find(&request.name, base)?;
        let loaded = self.load_file(&path, request, registry);
        loaded.map_err(|refusal| refusal.of(path))
    }

    fn load_file(
        &self,
        path: &Path,
        request: &PluginRequest,
        registry: &mut Registry,
    ) -> Result<LoadedPlugin, Refusal> {
        let side = side_file::read(path)?;
        let checked = file::check(path, request.sha256.as_deref())?;
        if let Some(expected) = side.as_ref().and_then(|side| side.sha256.as_deref())
            && !expected.eq_ignore_ascii_case(&checked.sha256)
        {
            return Err(Refusal::Hash {
                expected: expected.to_owned(),
                found: checked.sha256,
            });
        }
        if let Some(probe) = &self.probe {
            let is_known = self
                .cache
                .as_ref()
                .is_some_and(|cache| cache.has(path, &checked));
            if !is_known {
                probe.try_library(path)?;
                if let Some(cache) = &self.cache {
                    cache.add(path, &checked);
                }
            }
        }
        exits::guard();
        let opened = open_and_try(path, &checked)?;
        if let Some(side) = side {
            side.check(path, &opened.declaration)?;
        }
        let plugin = LoadedPlugin {
            path: path.to_owned(),
            sha256: checked.sha256,
            declaration: opened.declaration,
            tried: opened.tried,
        };
        register(registry, opened.parts, &plugin.origin())?;
        Ok(plugin)
    }
}

/// Registers all parts, or none.
fn register(registry: &mut Registry, parts: Vec<Part>, origin: &Origin) -> Result<(), Refusal> {
    let mut trial = registry.clone();
    for part in parts {
        let name = part.info().name;
        if registry.origin(name) == Some(origin) {
            continue;
        }
        trial.register(part, origin.clone()).map_err(|error| {
            let taken_by = match &error {
                RegistryError::Duplicate { origin, .. } => origin.to_string(),
                _ => String::new(),
            };
            Refusal::Duplicate {
                id: name.to_owned(),
                taken_by,
                message: error.to_string(),
            }
        })?;
    }
    *registry = trial;
    Ok(())
}

impl PartDeclaration {
    /// The part that this declares: of formulas, of a library's functions, or of both. What it says of
    /// itself is kept for as long as the program runs; call it once.
    ///
    /// # Errors
    /// [`Refusal::Formula`] where a formula cannot be read.
    pub fn part(&self) -> Result<Part, Refusal> {
        formulas::check(self)?;
        part(self, self.info())
    }
}
