//! C plugins of `tests/fixtures`, compiled when a test needs them.

#![allow(dead_code, reason = "each test file uses a part of it")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use leafwise_core::Registry;
use leafwise_plugin_loader::{
    LoadedPlugin, Loader, PluginError, PluginRequest, ProbeCommand, SearchPath,
};
use tempfile::TempDir;

/// A folder with compiled plugins.
pub struct Workshop {
    folder: TempDir,
}

impl Workshop {
    /// An empty folder.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        Self { folder }
    }

    /// A file of the folder, by its true path.
    pub fn path(&self, name: &str) -> PathBuf {
        let folder = self
            .folder
            .path()
            .canonicalize()
            .expect("the folder is there");
        folder.join(name)
    }

    /// Compiles `tests/fixtures/NAME.c`, as plugins are.
    pub fn compile(&self, name: &str) -> PathBuf {
        self.compile_with(name, &["-O2", "-ffp-contract=off"])
    }

    /// Compiles with other options.
    pub fn compile_with(&self, name: &str, options: &[&str]) -> PathBuf {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let library = self.path(&format!("lib{name}.so"));
        let output = Command::new("cc")
            .args([
                "-std=c11",
                "-D_GNU_SOURCE",
                "-Wall",
                "-Wextra",
                "-shared",
                "-fPIC",
            ])
            .args(options)
            .arg("-I")
            .arg(here.join("../abi/include"))
            .arg("-o")
            .arg(&library)
            .arg(here.join(format!("tests/fixtures/{name}.c")))
            .arg("-lm")
            .output()
            .expect("a C compiler called cc");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {said}");
        library
    }

    /// Writes a file.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, content).expect("a writable folder");
        path
    }
}

/// The probe that this package ships.
pub fn probe() -> ProbeCommand {
    ProbeCommand::new(env!("CARGO_BIN_EXE_leafwise-plugin-probe"), [])
}

/// The same with a short time limit.
pub fn impatient() -> ProbeCommand {
    ProbeCommand {
        time_limit: Duration::from_millis(1500),
        ..probe()
    }
}

/// Loads one file in this process, tried in a child process first where there is a probe.
pub fn load(
    path: &Path,
    probe: Option<ProbeCommand>,
    registry: &mut Registry,
) -> Result<LoadedPlugin, PluginError> {
    let loader = Loader::new(SearchPath::default());
    let loader = match probe {
        Some(probe) => loader.with_probe(probe),
        None => loader,
    };
    loader.load(&PluginRequest::new(path), Path::new("/"), registry)
}
