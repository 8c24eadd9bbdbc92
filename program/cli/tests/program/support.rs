//! The program in a directory of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use tempfile::TempDir;

/// A rigid body, each line of which a test may change.
pub const BODY: &str = r#"[system]
variables   = ["x1", "x2", "x3"]
parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1.25 }
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }
[method]
realization = { name = "karasev-truncated", order = 4 }
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.1
[run]
initial = [1, 3, 3]
steps   = 40
record  = { every = 3, observables = ["energy", "spin"] }
"#;

/// A directory with scenes in it, where the program runs.
pub struct Place {
    directory: TempDir,
}

/// What the program said.
pub struct Said {
    /// The exit code; none if it was killed.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Place {
    /// An empty directory.
    pub fn new() -> Self {
        Self {
            directory: TempDir::new().expect("a temporary directory"),
        }
    }

    /// A directory that holds one scene, `scene.toml`.
    pub fn with(scene: &str) -> Self {
        let place = Self::new();
        place.write("scene.toml", scene);
        place
    }

    /// The rigid body with one text replaced by another, which must occur.
    pub fn with_body(from: &str, to: &str) -> Self {
        assert!(BODY.contains(from), "`{from}` is in the scene");
        Self::with(&BODY.replacen(from, to, 1))
    }

    /// Writes a file.
    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("a writable directory");
    }

    /// A path inside.
    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// A file's content.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The program, ready to run here.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_leafwise"));
        command.args(arguments).current_dir(self.directory.path());
        command
    }

    /// Runs the program to its end.
    pub fn leafwise(&self, arguments: &[&str]) -> Said {
        let output = self
            .command(arguments)
            .output()
            .expect("the program starts");
        Said::from(output)
    }

    /// Whether nothing was written beside the scene.
    pub fn is_untouched(&self) -> bool {
        let entries = fs::read_dir(self.directory.path()).expect("a readable directory");
        entries
            .filter_map(Result::ok)
            .all(|entry| entry.file_name() == "scene.toml")
    }
}

/// Waits until something has happened, as long as a program runs that may make it happen.
pub fn wait_for(child: &mut Child, mut is_so: impl FnMut() -> bool, what: &str) {
    while !is_so() {
        let ended = child.try_wait().expect("a child");
        assert!(
            ended.is_none() || is_so(),
            "{what} did not happen: {ended:?}"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Whether a process takes a signal itself, of this number; `true` where that cannot be seen.
pub fn catches(process: u32, signal: u32) -> bool {
    if !cfg!(target_os = "linux") {
        return true;
    }
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    let mask = caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).expect("UTF-8"),
            err: String::from_utf8(output.stderr).expect("UTF-8"),
        }
    }
}

impl Said {
    /// The one JSON object on standard output.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out)
            .unwrap_or_else(|error| panic!("{error}\n{}\n{}", self.out, self.err))
    }

    /// Asserts that every piece stands in standard error.
    pub fn says(&self, pieces: &[&str]) {
        for piece in pieces {
            assert!(
                self.err.contains(piece),
                "`{piece}` is missing from:\n{}",
                self.err
            );
        }
    }
}

/// A run without end, started and going.
pub fn endless_run(here: &Place) -> Child {
    let mut child = here
        .command(&["run", "scene.toml", "--set", ENDLESS])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let samples = here.path("runs/scene/samples.csv");
    let is_going = || fs::metadata(&samples).is_ok_and(|file| file.len() > 20_000);
    wait_for(&mut child, is_going, "the first samples");
    child
}

/// More steps than any machine makes while a test waits.
pub const ENDLESS: &str = "run.steps=1000000000000";

/// A scene that takes long enough to be killed several times.
pub fn long_scene() -> String {
    BODY.replace("steps   = 40", "steps   = 200000")
        .replace("every = 3", "every = 7")
}

/// A library that, loaded before all others, grants no thread.
#[cfg(target_os = "linux")]
pub fn refusing_threads(here: &Place) -> PathBuf {
    here.write(
        "refuse.c",
        "#include <errno.h>\n#include <pthread.h>\n\
         int pthread_create(pthread_t *t, const pthread_attr_t *a, void *(*f)(void *), void *x) {\n\
         (void)t; (void)a; (void)f; (void)x; return EAGAIN; }\n",
    );
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-o", "refuse.so", "refuse.c"])
        .current_dir(here.path("."))
        .status();
    assert!(built.expect("a C compiler").success());
    here.path("refuse.so")
}

/// The folder of ready scenes.
pub fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// The gallery of ready scenes.
pub fn gallery() -> Vec<PathBuf> {
    let mut scenes: Vec<PathBuf> = fs::read_dir(scenes())
        .expect("the gallery")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    scenes.sort();
    scenes
}
