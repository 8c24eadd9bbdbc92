//! An interrupted run with one file changed, resumed: the same result as without, or a refusal that writes nothing.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use leafwise::core::Registry;
use leafwise::run::{Progress, Quiet, RunJob, Status, perform};
use leafwise::run::{RunOptions, RunOutcome};
use leafwise::scene::{ComposedRun, SceneDocument, compose};

use crate::Reached;
use crate::source::Source;

const SCENE: &str = "[system]\nlibrary = \"rigid-body\"\n[method]\nstepper = \"splitting\"\ntime-step = 0.1\n\
    [run]\ninitial = [1, 3, 3]\nsteps = 4000\nrecord = { every = 100 }\n";

/// The run is interrupted at the first look after so many steps.
const INTERRUPTED_AT: u64 = 1000;

/// Files that are the same whenever the run is made, and however often it is interrupted.
const RESULTS: [&str; 3] = ["samples.csv", "scene.toml", "windows.csv"];

type Files = BTreeMap<String, Vec<u8>>;

/// One change of one file.
///
/// # Errors
/// Other results, or a refusal after which files have changed.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let runs = Runs::get()?;
    let mut source = Source::new(bytes);
    let names: Vec<&String> = runs.interrupted.keys().collect();
    let name = names[source.below(names.len())].clone();
    let mut changed = runs.interrupted.clone();
    let Some(content) = changed.get_mut(&name) else {
        return Ok(Reached::Refusal);
    };
    mutate(&mut source, content);
    let place = first_difference(&runs.interrupted[&name], &changed[&name]);
    let said = |what: String| format!("{name} changed from byte {place} on: {what}");
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let directory = folder.path().join("run");
    write(&directory, &changed).map_err(|error| error.to_string())?;
    let outcome = runs.resume(&directory, &mut Quiet);
    let after = files(&directory).map_err(|error| error.to_string())?;
    match outcome {
        Ok(RunOutcome::Done) => {
            for result in RESULTS {
                if after.get(result) != runs.undisturbed.get(result) {
                    return Err(said(format!("the run is done, and {result} differs")));
                }
            }
        }
        Ok(outcome) => return Err(said(format!("the run ends as {outcome:?}"))),
        Err(refusal) if refusal.is_empty() => {
            return Err(said("a refusal without a word".to_owned()));
        }
        Err(_) if after != changed => {
            let names = after.keys().chain(changed.keys());
            let differ: Vec<&String> = names
                .filter(|name| after.get(*name) != changed.get(*name))
                .collect();
            return Err(said(format!("it is refused, and {differ:?} have changed")));
        }
        Err(_) => {}
    }
    Ok(Reached::Comparison)
}

/// Flips a bit, cuts the end, inserts or deletes.
pub(crate) fn mutate(source: &mut Source<'_>, content: &mut Vec<u8>) {
    let at = source
        .below(content.len().max(1))
        .min(content.len().saturating_sub(1));
    match (source.below(4), content.is_empty()) {
        (0, false) => content[at] ^= 1 << source.below(8),
        (1, _) => content.truncate(at),
        (2, false) => {
            let end = (at + 1 + source.below(8)).min(content.len());
            drop(content.drain(at..end));
        }
        _ => {
            let piece: Vec<u8> = (0..1 + source.below(4)).map(|_| source.byte()).collect();
            drop(content.splice(at..at, piece));
        }
    }
}

/// The run, and the files of it whole and interrupted.
struct Runs {
    document: SceneDocument,
    composed: ComposedRun,
    registry: Registry,
    undisturbed: Files,
    interrupted: Files,
}

impl Runs {
    fn get() -> Result<&'static Self, String> {
        static RUNS: OnceLock<Result<Runs, String>> = OnceLock::new();
        RUNS.get_or_init(Self::made).as_ref().map_err(Clone::clone)
    }

    fn made() -> Result<Self, String> {
        let registry = Registry::with_builtin();
        let document = SceneDocument::parse("scene.toml", SCENE, &registry);
        let document = document.map_err(|errors| errors.to_string())?;
        let composed = compose(&document, &registry).map_err(|refusal| refusal.to_string())?;
        let mut runs = Self {
            document,
            composed,
            registry,
            undisturbed: Files::new(),
            interrupted: Files::new(),
        };
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let [whole, part] = ["whole", "part"].map(|name| folder.path().join(name));
        let ends = [
            runs.resume(&whole, &mut Quiet)?,
            runs.resume(&part, &mut Interrupting::default())?,
        ];
        if ends != [RunOutcome::Done, RunOutcome::Interrupted] {
            return Err(format!("the runs end as {ends:?}"));
        }
        runs.undisturbed = files(&whole).map_err(|error| error.to_string())?;
        runs.interrupted = files(&part).map_err(|error| error.to_string())?;
        Ok(runs)
    }

    fn resume(&self, directory: &Path, progress: &mut dyn Progress) -> Result<RunOutcome, String> {
        let options = RunOptions {
            checkpoint_every: Duration::ZERO,
            ..RunOptions::within(directory)
        };
        let job = RunJob::new(&self.document, &self.composed, &self.registry, &options);
        let report = job.and_then(|job| perform(&job, progress));
        report
            .map(|report| report.outcome)
            .map_err(|error| error.to_string())
    }
}

/// Interrupts once a run is half done.
#[derive(Default)]
struct Interrupting {
    is_half_done: bool,
}

impl Progress for Interrupting {
    fn show(&mut self, status: &Status) {
        self.is_half_done = status.steps >= INTERRUPTED_AT;
    }

    fn is_interrupted(&self) -> bool {
        self.is_half_done
    }
}

fn first_difference(a: &[u8], b: &[u8]) -> usize {
    let same = a.iter().zip(b).take_while(|(a, b)| a == b);
    same.count()
}

fn write(directory: &Path, files: &Files) -> io::Result<()> {
    fs::create_dir_all(directory)?;
    files
        .iter()
        .try_for_each(|(name, content)| fs::write(directory.join(name), content))
}

fn files(directory: &Path) -> io::Result<Files> {
    let mut files = Files::new();
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        files.insert(name.unwrap_or_default(), fs::read(&path)?);
    }
    Ok(files)
}
