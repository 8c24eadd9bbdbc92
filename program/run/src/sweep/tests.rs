//! Sweeps in directories: threads, interruptions and shards of shards leave the same bytes.

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use leafwise_core::Registry;
use leafwise_scene::document::SceneDocument;

use super::{Settings, SweepJob, SweepReport, compose_sweep};
use crate::shards::{MergeError, Portion, Shard, Shards, Whole};
use crate::{Progress, Quiet, RunError, RunOptions, RunOutcome, Status, perform};

const SCENE: &str = r#"
[system]
variables   = ["x1", "x2", "x3"]
parameters  = { I = 1.5 }
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/2 + x2^2/I + x3^2/2.5"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }
[method]
stepper   = "rk4"
time-step = 0.1
[run]
initial = { x1 = 1, x2 = 2, x3 = "I - 2" }
steps   = 50
[sweep]
grid = { "system.parameters.I" = { range = [1.2, 1.9, 4] }, "method.time-step" = [0.1, 0.2, 1e200], "run.initial.x2" = [2, 0.5] }
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

fn options(directory: PathBuf) -> RunOptions {
    RunOptions::within(directory)
}

fn sweep(
    directory: &Path,
    place: Option<(u64, u64)>,
    threads: usize,
    progress: &mut dyn Progress,
) -> Result<SweepReport, RunError> {
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("scene.toml", SCENE, &registry).expect("a scene");
    let settings = Settings::of(&document).map_err(RunError::Refused)?;
    let count = settings.count();
    let shard =
        place.map(|(number, of)| Shard::of(Whole::Settings, number, of, count).expect("a shard"));
    let items = shard.as_ref().map_or(0..count, Shard::items);
    let sweep = compose_sweep(&document, &registry, settings, items, false, &mut |_, _| ())?;
    assert_eq!(
        sweep.methods(),
        1,
        "settings of values share the scene's method"
    );
    let threads = NonZeroUsize::new(threads).expect("threads");
    let options = options(directory.to_owned());
    let portion = Portion::computed(shard.as_ref());
    let job = SweepJob::new(&document, &sweep, portion, &options, threads);
    perform(&job, progress)
}

fn join(folder: &Path, out: &Path, is_whole: bool) -> Result<SweepReport, MergeError> {
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("scene.toml", SCENE, &registry).expect("a scene");
    let settings = Settings::of(&document).map_err(RunError::Refused)?;
    let sweep = compose_sweep(&document, &registry, settings, 0..0, false, &mut |_, _| ())?;
    let shards = Shards::find(&[folder.to_owned()])?;
    let options = options(out.to_owned());
    let portion = match is_whole {
        true => Portion::merged(&shards)?,
        false => Portion::joined(&shards)?,
    };
    let job = SweepJob::new(&document, &sweep, portion, &options, NonZeroUsize::MIN);
    Ok(perform(&job, &mut Quiet)?)
}

fn table(directory: &Path) -> String {
    fs::read_to_string(directory.join("sweep.csv")).expect("a table")
}

#[test]
fn no_thread_and_no_interruption_changes_a_byte() {
    let root = tempfile::tempdir().expect("a directory");
    let whole = root.path().join("whole");
    let report = sweep(&whole, None, 1, &mut Quiet).expect("a sweep");
    assert_eq!((report.done, report.failed), (24, 8));
    let expected = table(&whole);
    for (threads, looks) in [(1, 2), (2, 3), (3, 7), (2, 20)] {
        let pieces = root.path().join(format!("pieces-{threads}-{looks}"));
        let mut sessions = 0;
        loop {
            let report = sweep(&pieces, None, threads, &mut StopAfter(looks)).expect("a sweep");
            sessions += 1;
            if report.outcome == RunOutcome::Done {
                break;
            }
            assert!(report.done < 24 && sessions < 100);
            // Rows behind the checkpoint, as a kill leaves them.
            let file = pieces.join("sweep.csv");
            fs::write(&file, table(&pieces) + "17,half a row").expect("a file");
        }
        assert!(sessions > 1, "{looks} looks are no interruption");
        assert_eq!(expected, table(&pieces));
    }
    let again = sweep(&whole, None, 1, &mut Quiet).expect("a sweep");
    assert!(again.is_repeated && again.failed == 8);
    crate::tests::check_end_files(&whole, &["report.html"], || {
        assert!(sweep(&whole, None, 1, &mut Quiet)?.is_repeated);
        Ok(())
    });
}

#[test]
fn shards_of_shards_are_merged_to_the_bytes_of_one_process() {
    let root = tempfile::tempdir().expect("a directory");
    let path = |name: &str| root.path().join(name);
    sweep(&path("whole"), None, 1, &mut Quiet).expect("a sweep");
    for number in (1..=7).rev() {
        let group = if number < 4 { "low" } else { "high" };
        let directory = path(group).join(format!("shard-{number}"));
        sweep(&directory, Some((number, 7)), 1, &mut Quiet).expect("a shard");
    }
    // A gap within what is joined.
    fs::rename(path("low/shard-2"), path("aside")).expect("a move");
    let gap = join(&path("low"), &path("gap"), false).expect_err("a gap");
    assert!(
        gap.to_string().contains("settings are missing: 3 to 5"),
        "{gap}"
    );
    fs::rename(path("aside"), path("low/shard-2")).expect("a move");
    for group in ["low", "high"] {
        let report = join(&path(group), &path("parts").join(group), false).expect("a shard");
        assert!(report.done < 24);
    }
    let missing = join(&path("parts/low"), &path("merged"), true).expect_err("half of it");
    assert!(matches!(missing, MergeError::Missing(_)), "{missing}");
    let report = join(&path("parts"), &path("merged"), true).expect("the whole");
    assert_eq!((report.done, report.failed), (24, 8));
    assert_eq!(table(&path("whole")), table(&path("merged")));
}

/// Nothing that is asked for is passed over: the estimate of a run's error is none of a sweep's.
#[test]
fn an_estimate_of_the_error_is_refused_where_it_is_asked_for() {
    let registry = Registry::with_builtin();
    let text = SCENE.replace("[run]", "[run]\nerror = \"estimate\"");
    assert_ne!(text, SCENE);
    let document = SceneDocument::parse("scene.toml", &text, &registry).expect("a scene");
    let settings = Settings::of(&document)
        .map_err(RunError::Refused)
        .expect("settings");
    let outcome = compose_sweep(&document, &registry, settings, 0..1, false, &mut |_, _| {});
    let Err(RunError::Refused(refusal)) = outcome else {
        panic!("refused");
    };
    assert!(
        refusal.message.ends_with("and this is a sweep"),
        "{}",
        refusal.message
    );
    assert_eq!(&text[refusal.span.clone()], "\"estimate\"");
}
