//! The plugins that a command line and a scene ask for.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use leafwise::core::Registry;
use leafwise::plugins::{
    LoadedPlugin, Loader, PluginError, PluginRequest, ProbeCommand, SearchPath,
};
use leafwise::scene::document::PluginSpec;
use leafwise::scene::{SceneDiagnostic, SceneDocument};

use crate::arguments::{PluginArguments, SceneArguments};
use crate::failure::Failure;
use crate::scene::{SceneText, read};

/// Forbids plugins where it is set to anything but nothing and `0`.
pub const NO_PLUGINS: &str = "LEAFWISE_NO_PLUGINS";

/// The hidden command that tries a library in a process of its own.
pub const PROBE: [&str; 2] = ["plugin", "probe"];

/// How this program is started again; see [`start_again_by`].
static PROGRAM: OnceLock<(PathBuf, Vec<OsString>)> = OnceLock::new();

/// Says which file with which arguments is this program, where it runs within another: libraries are tried, and measured, in
/// processes of their own. The first word counts.
pub fn start_again_by(program: PathBuf, arguments: Vec<OsString>) {
    PROGRAM.get_or_init(|| (program, arguments));
}

/// The file and the first arguments that start this program again: its own file where nothing else was said. A program that
/// does not know its own file starts nothing, and every plugin is refused with that reason.
pub fn own_program() -> (PathBuf, Vec<OsString>) {
    let own = || (std::env::current_exe().unwrap_or_default(), Vec::new());
    PROGRAM.get().cloned().unwrap_or_else(own)
}

/// Parts that a command works with: the built-in ones, and those of the plugins asked for.
pub struct Parts {
    /// The parts by name.
    pub registry: Registry,
    loader: Loader,
}

impl Parts {
    /// The built-in parts and those of `--plugin`.
    ///
    /// # Errors
    /// [`Failure::Plugin`].
    pub fn new(arguments: &PluginArguments) -> Result<Self, Failure> {
        Self::with(loader(arguments), arguments)
    }

    /// The same, trying each library anew, whatever passed before: its dependencies may have changed.
    ///
    /// # Errors
    /// [`Failure::Plugin`].
    pub fn trying_anew(arguments: &PluginArguments) -> Result<Self, Failure> {
        Self::with(loader(arguments).without_cache(), arguments)
    }

    fn with(loader: Loader, arguments: &PluginArguments) -> Result<Self, Failure> {
        let mut parts = Self {
            registry: Registry::with_builtin(),
            loader,
        };
        for plugin in &arguments.plugins {
            parts.load(&PluginRequest::new(plugin), Path::new("."))?;
        }
        Ok(parts)
    }

    /// Loads a plugin; a relative path starts from `base`.
    ///
    /// # Errors
    /// [`Failure::Plugin`].
    pub fn load(&mut self, request: &PluginRequest, base: &Path) -> Result<LoadedPlugin, Failure> {
        let loaded = self.loader.load(request, base, &mut self.registry);
        loaded.map_err(|error| Failure::plugin(error, None))
    }

    /// Whether plugins are forbidden.
    pub fn are_off(&self) -> bool {
        self.loader.is_off()
    }

    /// The folders in which plugins are looked for by name.
    pub fn search(&self) -> &SearchPath {
        self.loader.search()
    }

    /// Reads a scene, after loading the plugins that it names.
    ///
    /// # Errors
    /// [`Failure::Plugin`] where one of them is refused, and those of reading a scene.
    pub fn scene(&mut self, arguments: &SceneArguments) -> Result<SceneDocument, Failure> {
        let base = arguments.scene.parent().unwrap_or(Path::new("."));
        self.document(read(arguments)?, base)
    }

    /// The same of a text; relative paths of plugins start from `base`.
    ///
    /// # Errors
    /// As [`scene`](Self::scene).
    pub fn document(&mut self, text: SceneText, base: &Path) -> Result<SceneDocument, Failure> {
        let (effective, plugins) = PluginSpec::of_scene(&text.text, &text.overrides);
        for plugin in plugins {
            let request = PluginRequest {
                name: plugin.path.value.clone().into(),
                sha256: plugin.sha256.as_ref().map(|hash| hash.value.clone()),
            };
            let loaded = self.loader.load(&request, base, &mut self.registry);
            loaded.map_err(|error| {
                let place = diagnostic(&error, &plugin, &text, &effective);
                Failure::plugin(error, Some(place))
            })?;
        }
        let SceneText {
            name,
            text,
            overrides,
        } = text;
        SceneDocument::parse_with(&name, &text, &overrides, &self.registry)
            .map_err(|errors| Failure::Scene(errors.diagnostics()))
    }
}

/// The refusal of a plugin at its place in the scene.
fn diagnostic(
    error: &PluginError,
    plugin: &PluginSpec,
    text: &SceneText,
    effective: &str,
) -> SceneDiagnostic {
    SceneDiagnostic {
        message: error.to_string(),
        label: "refused".to_owned(),
        source_name: text.name.clone(),
        source_text: effective.to_owned(),
        span: plugin.path.span.clone(),
        help: None,
    }
}

/// Whether the command line or the environment forbids plugins.
pub fn are_forbidden(arguments: &PluginArguments) -> bool {
    let set = std::env::var_os(NO_PLUGINS);
    arguments.no_plugins || set.is_some_and(|set| !set.is_empty() && set != "0")
}

/// The loader of this program: it tries libraries in a process of its own.
fn loader(arguments: &PluginArguments) -> Loader {
    if are_forbidden(arguments) {
        return Loader::off();
    }
    let (own, arguments) = own_program();
    let probe = ProbeCommand::new(own, arguments.into_iter().chain(PROBE.map(Into::into)));
    Loader::new(SearchPath::of_environment())
        .with_probe(probe)
        .with_user_cache()
}
