//! Killed, terminated or out of disk, a run loses no recorded sample and goes on to the same bits.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use crate::support::{ENDLESS, Place, Said, catches, endless_run, long_scene, wait_for};

/// Kills in the test at random moments.
const KILLS: u32 = 20;

/// Steele, Lea and Flood's SplitMix64: moments of kills.
struct Moments(u64);

impl Moments {
    /// A new series each time; `LEAFWISE_SEED` repeats one.
    fn new() -> Self {
        let given = std::env::var("LEAFWISE_SEED").ok();
        let seed = given.and_then(|text| text.parse().ok()).unwrap_or_else(|| {
            let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
            now.map_or(0, |time| time.as_nanos() as u64)
        });
        // Past the test harness, which keeps the output of tests that pass to itself.
        let _ = writeln!(std::io::stderr(), "moments of kills: LEAFWISE_SEED={seed}");
        Self(seed)
    }

    fn next(&mut self, below: Duration) -> Duration {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        below.mul_f64(((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// The samples of an uninterrupted run, and how long that takes.
fn uninterrupted() -> (Place, Duration) {
    let place = Place::with(&long_scene());
    let start = Instant::now();
    let said = place.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    (place, start.elapsed())
}

fn is_same(whole: &Place, pieces: &Place) {
    for file in ["samples.csv", "windows.csv"] {
        let name = format!("runs/scene/{file}");
        assert!(whole.read(&name) == pieces.read(&name), "{file} differs");
    }
    let manifest = |place: &Place| -> serde_json::Value {
        serde_json::from_str(&place.read("runs/scene/manifest.json")).expect("JSON")
    };
    let (a, b) = (manifest(whole), manifest(pieces));
    for key in ["outcome", "steps", "samples", "drift", "solver"] {
        assert_eq!(a[key], b[key], "{key}");
    }
}

/// The whole rows of a file of samples.
fn rows(file: &Path) -> String {
    let mut text = std::fs::read_to_string(file).unwrap_or_default();
    text.truncate(text.rfind('\n').map_or(0, |at| at + 1));
    text
}

#[test]
fn twenty_kills_at_random_moments_lose_no_sample_and_change_no_bit() {
    let mut moments = Moments::new();
    let (whole, duration) = uninterrupted();
    let all = whole.read("runs/scene/samples.csv");
    let (mut kills, mut finished) = (0, 0);
    while kills < KILLS || finished == 0 {
        let pieces = Place::with(&long_scene());
        let samples = pieces.path("runs/scene/samples.csv");
        let mut kept = String::new();
        loop {
            let mut command = pieces.command(&["run", "scene.toml", "--checkpoint-every", "0.02"]);
            let mut child = command
                .stderr(Stdio::null())
                .spawn()
                .expect("the program starts");
            if kills < KILLS {
                std::thread::sleep(moments.next(duration));
                // Fails only where the run has ended.
                let _ = child.kill();
            }
            let status = child.wait().expect("an end");
            let now = rows(&samples);
            assert!(
                now.starts_with(&kept) && all.starts_with(&now),
                "after {kills} kills: {} bytes of samples, {} before",
                now.len(),
                kept.len()
            );
            kept = now;
            match status.code() {
                Some(code) => {
                    assert_eq!(code, 0);
                    break;
                }
                None => kills += 1,
            }
        }
        is_same(&whole, &pieces);
        finished += 1;
    }
}

#[cfg(unix)]
fn signal(name: &str, process: u32) {
    let sent = Command::new("kill")
        .args([name, &process.to_string()])
        .status()
        .expect("kill runs");
    assert!(sent.success());
}

/// Goes on with an interrupted run of [`ENDLESS`] steps to an end not far ahead, and compares it with
/// one that was never interrupted.
#[cfg(unix)]
fn goes_on_to_the_same_bits(pieces: &Place) {
    let manifest = pieces.read("runs/scene/manifest.json");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    let made = manifest["steps"].as_u64().unwrap_or(0);
    let steps = format!("run.steps={}", made + 5000);
    let said = pieces.leafwise(&["run", "scene.toml", "--json", "--set", &steps]);
    // A session that was ended at once has not said how far it came; its checkpoint has.
    let further = said.err.split_once("same scene of ").and_then(|(_, rest)| {
        let made: u64 = rest.split_once(' ')?.0.parse().ok()?;
        Some(format!("run.steps={}", made + 5000))
    });
    let (said, steps) = match further {
        Some(steps) => {
            let again = pieces.leafwise(&["run", "scene.toml", "--json", "--set", &steps]);
            (again, steps)
        }
        None => (said, steps),
    };
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["resumed at step"]);
    let whole = Place::with(&long_scene());
    let all = whole.leafwise(&["run", "scene.toml", "--set", &steps]);
    assert_eq!(all.code, Some(0), "{}", all.err);
    is_same(&whole, pieces);
}

#[cfg(unix)]
#[test]
fn an_interrupted_or_terminated_run_writes_a_checkpoint_exits_130_and_goes_on() {
    for name in ["-INT", "-TERM", "-USR1"] {
        let pieces = Place::with(&long_scene());
        let child = endless_run(&pieces);
        signal(name, child.id());
        let said = Said::from(child.wait_with_output().expect("an end"));
        assert_eq!(said.code, Some(130), "{}", said.err);
        said.says(&["the same command continues from there"]);
        let manifest = pieces.read("runs/scene/manifest.json");
        assert!(manifest.contains("\"outcome\": \"interrupted\""));
        let changed = [
            "run",
            "scene.toml",
            "--set",
            ENDLESS,
            "--set",
            "method.time-step=0.2",
        ];
        let changed = pieces.leafwise(&changed);
        assert_eq!(changed.code, Some(2));
        changed.says(&["\n  method.time-step: 0.1 → 0.2\n", "undo the change"]);
        goes_on_to_the_same_bits(&pieces);
    }
}

#[cfg(unix)]
#[test]
fn a_second_interruption_ends_the_program_and_loses_nothing() {
    let pieces = Place::with(&long_scene());
    let child = endless_run(&pieces);
    // One of each: two equal signals that arrive together are one.
    signal("-INT", child.id());
    signal("-TERM", child.id());
    let said = Said::from(child.wait_with_output().expect("an end"));
    assert_eq!(said.code, Some(130), "{}", said.err);
    goes_on_to_the_same_bits(&pieces);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interruption_before_the_first_step_ends_the_program_at_once() {
    // The scene is a pipe that nobody writes to: no step is ever made.
    let here = Place::new();
    let made = Command::new("mkfifo").arg(here.path("scene.toml")).status();
    assert!(made.expect("mkfifo runs").success());
    let mut child = here
        .command(&["run", "scene.toml"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let id = child.id();
    wait_for(&mut child, || catches(id, 2), "the handler");
    signal("-INT", child.id());
    let said = Said::from(child.wait_with_output().expect("an end"));
    assert_eq!(said.code, Some(130), "{}", said.err);
    assert!(here.is_untouched());
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_and_the_run_goes_on_once_there_is_room() {
    let (whole, _) = uninterrupted();
    let pieces = Place::with(&long_scene());
    // No file may grow beyond 200 blocks.
    let limited = Command::new("sh")
        .args(["-c", r#"trap "" XFSZ; ulimit -f 200; exec "$0" "$@""#])
        .arg(env!("CARGO_BIN_EXE_leafwise"))
        .args(["run", "scene.toml", "--json"])
        .current_dir(pieces.path("."))
        .output()
        .expect("a shell");
    let said = Said::from(limited);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&[
        "cannot write runs/scene/samples.csv",
        "the same command continues from there",
    ]);
    assert_eq!(said.json()["outcome"], "failed");
    let kept = rows(&pieces.path("runs/scene/samples.csv"));
    assert!(kept.lines().count() > 100);
    assert!(whole.read("runs/scene/samples.csv").starts_with(&kept));
    let said = pieces.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    is_same(&whole, &pieces);
}

#[cfg(target_os = "linux")]
#[test]
fn a_result_that_cannot_be_written_is_an_error() {
    let here = Place::with(&long_scene().replace("200000", "40"));
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .expect("a full device");
    let output = here
        .command(&["run", "scene.toml", "--json"])
        .stdout(full)
        .output()
        .expect("the program starts");
    let said = Said::from(output);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&["cannot write the result to standard output"]);
}

#[cfg(target_os = "linux")]
#[test]
fn help_and_version_that_cannot_be_written_are_errors() {
    for asked in ["--help", "--version"] {
        let full = std::fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .expect("a full device");
        let output = Place::new().command(&[asked]).stdout(full).output();
        let said = Said::from(output.expect("the program starts"));
        assert_eq!(said.code, Some(1), "{asked}: {}", said.err);
        said.says(&["cannot write the result to standard output"]);
    }
}
