//! Plugins built when a test needs them: those of the gallery, and the examples.

#![allow(dead_code, reason = "each test file uses a part of it")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// The folder `plugins` of this workspace.
fn plugins() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = own
        .ancestors()
        .find(|folder| folder.join("Cargo.lock").exists());
    root.expect("the workspace around this package")
        .join("plugins")
}

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

    /// Compiles `tests/fixtures/NAME.c` (or a path from there), as plugins are.
    pub fn compile(&self, name: &str) -> PathBuf {
        self.compile_with(name, &["-O3", "-ffp-contract=off"])
    }

    /// Compiles with other options.
    pub fn compile_with(&self, name: &str, options: &[&str]) -> PathBuf {
        let plugins = plugins();
        let stem = name.rsplit('/').next().unwrap_or(name);
        let library = self.path(&format!("lib{stem}.so"));
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
            .arg(plugins.join("abi/include"))
            .arg("-o")
            .arg(&library)
            .arg(plugins.join(format!("loader/tests/fixtures/{name}.c")))
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

/// The library of the example plugin in Rust, built in this test's profile.
pub fn rust_example() -> PathBuf {
    let package = ["-p", "leafwise-example-plugin", "--lib"];
    cargo_library(&package, "leafwise_example_plugin")
}

/// A library among the examples of the kit for Rust, which are plugins for these tests.
pub fn rust_fixture(name: &str) -> PathBuf {
    cargo_library(&["-p", "leafwise-plugin-sdk", "--example", name], name)
}

/// The shared library that Cargo makes of a target.
fn cargo_library(target: &[&str], name: &str) -> PathBuf {
    let profile = if cfg!(debug_assertions) {
        "test"
    } else {
        "release"
    };
    let output = Command::new(env!("CARGO"))
        .arg("build")
        .args(target)
        .args(["--profile", profile])
        .arg("--message-format=json-render-diagnostics")
        .current_dir(plugins())
        .output()
        .expect("cargo runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter(|message| message["target"]["name"] == name)
        .filter_map(|message| message["filenames"].as_array().cloned())
        .flatten()
        .filter_map(|file| file.as_str().map(PathBuf::from))
        .find(|file| file.extension().is_some_and(|extension| extension == "so"))
        .expect("a shared library among what was built")
}
