//! Runs in directories.

mod acts;
mod between;
mod corners;
mod damage;
mod directories;
mod drifts;
mod in_memory;
mod indicators;
mod pictured;
mod recorded;
mod resuming;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::Path;

use leafwise_core::Registry;

use super::{Progress, RunError, RunJob, RunOptions, RunReport, Status, perform};
use leafwise_scene::compose::{ComposedRun, compose};
use leafwise_scene::document::SceneDocument;

const SCENE: &str = r#"
[system]
variables   = ["x1", "x2", "x3"]
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/2 + x2^2/1.5 + x3^2/2.5"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }
[method]
realization = { name = "karasev-truncated", order = 4 }
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.1
[run]
initial = [1, 2, -0.5]
steps   = 20000
record  = { every = 7, observables = ["energy", "x1*x2"] }
"#;

/// Stops after a number of looks.
struct StopAfter(u32);

impl Progress for StopAfter {
    fn show(&mut self, _status: &Status) {
        self.0 = self.0.saturating_sub(1);
    }

    fn is_interrupted(&self) -> bool {
        self.0 == 0
    }
}

fn attempt(
    text: &str,
    directory: &Path,
    force: bool,
    progress: &mut dyn Progress,
) -> Result<RunReport, RunError> {
    Prepared::new(text).attempt(directory, force, progress)
}

/// A scene, read and composed once.
struct Prepared {
    document: SceneDocument,
    registry: Registry,
    composed: ComposedRun,
}

impl Prepared {
    fn new(text: &str) -> Self {
        let document = SceneDocument::parse("top.toml", text, &Registry::empty()).expect("a scene");
        let registry = Registry::with_builtin();
        let composed = compose(&document, &registry).expect("a run");
        Self {
            document,
            registry,
            composed,
        }
    }

    fn attempt(
        &self,
        directory: &Path,
        force: bool,
        progress: &mut dyn Progress,
    ) -> Result<RunReport, RunError> {
        let options = RunOptions {
            force,
            command: "leafwise run top.toml".to_owned(),
            ..RunOptions::within(directory)
        };
        let Self {
            document,
            registry,
            composed,
        } = self;
        let job = RunJob::new(document, composed, registry, &options)?;
        perform(&job, progress)
    }
}

/// Loses, cuts and changes files of a finished directory one by one: a lost one is made anew by `again`, to the same bytes, and one that
/// is another now is refused by its name, where nothing is written.
pub(crate) fn check_end_files(
    directory: &Path,
    files: &[&str],
    again: impl Fn() -> Result<(), RunError>,
) {
    let whole = contents(directory);
    for file in files {
        let path = directory.join(file);
        let good = fs::read(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
        fs::remove_file(&path).expect("a file");
        again().unwrap_or_else(|error| panic!("{file} is lost: {error}"));
        assert!(contents(directory) == whole, "{file} was made otherwise");
        let middle = good.len() / 2;
        let mut changed = good.clone();
        changed[middle] ^= 1;
        let behind = [&good[..], b"\n"].concat();
        for other in [&good[..middle], &[], &changed, &behind] {
            fs::write(&path, other).expect("writable");
            let before = contents(directory);
            let said = again().expect_err("it is another file").to_string();
            let is_told = said.contains(file) && said.contains("remove it");
            assert!(is_told, "{file}: {said}");
            assert!(
                contents(directory) == before,
                "{file}: something was written"
            );
        }
        // As the message says.
        fs::remove_file(&path).expect("a file");
        again().unwrap_or_else(|error| panic!("{file} is removed: {error}"));
        assert!(contents(directory) == whole);
    }
}

/// The names and contents of a directory.
fn contents(directory: &Path) -> BTreeMap<OsString, Vec<u8>> {
    let entries = fs::read_dir(directory).expect("a readable directory");
    let entries = entries.map(|entry| entry.expect("an entry"));
    entries
        .map(|entry| (entry.file_name(), fs::read(entry.path()).expect("a file")))
        .collect()
}

/// A short run whose samples are all on the grid.
fn short_scene() -> String {
    SCENE
        .replace("steps   = 20000", "steps   = 8")
        .replace("every = 7", "every = 1")
}
