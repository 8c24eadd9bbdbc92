//! From a composed ensemble to a complete run directory.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use super::advice::measured;
use super::checkpoint::Checkpoint;
use super::drive::{Session, Workforce};
use super::ending::EnsembleEnding;
use super::plan::ComposedEnsemble;
use super::report::EnsembleReport;
use super::section::SectionStore;
use super::store::{FinalStore, has_begun_at_most};
use super::tree::Tree;
use super::{page, tables};
use crate::shards::Shard;
use crate::{
    Beginning, Kind, Progress, RunDirectory, RunError, RunOptions, RunOutcome, RunRequest, SCENE,
    confirm, confirm_page, files, plugins, replace, write_page,
};
use leafwise_report::render_ensemble;
use leafwise_scene::compose::SceneChecks;
use leafwise_scene::document::SceneDocument;

/// `runs/` and the scene file's name with `-ensemble`.
pub fn default_ensemble_directory(document: &SceneDocument) -> PathBuf {
    let out = document.ensemble.as_ref().and_then(|e| e.out.as_ref());
    match out {
        Some(out) => PathBuf::from(&out.value),
        None => PathBuf::from("runs").join(format!("{}-ensemble", crate::stem(document))),
    }
}

/// `runs/` and the scene file's name with `-shards`: a folder of shards.
pub fn default_shards_directory(document: &SceneDocument) -> PathBuf {
    PathBuf::from("runs").join(format!("{}-shards", crate::stem(document)))
}

/// Checks the scene, then steps all members and reduces them into a directory. An unfinished ensemble of the same scene
/// is resumed, to the same bits as without interruption. A finished one is reported again.
///
/// # Errors
/// As [`run`](crate::run).
pub fn run_ensemble(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    options: &RunOptions,
    workforce: Workforce,
    progress: &mut dyn Progress,
) -> Result<EnsembleReport, RunError> {
    let end = |beginning: &Beginning<'_>, report| {
        write_end(document, ensemble, options, beginning, report)
    };
    let asked = (ensemble, None);
    let mut report = integrate(document, asked, options, workforce, progress, end)?;
    if report.is_repeated {
        repeat_end(document, ensemble, options, &mut report)?;
    }
    Ok(report)
}

/// Tells of an ensemble that has ended before: its advice, and tables and a page as they were written. A file that is
/// not there is made anew.
///
/// # Errors
/// [`RunError::Changed`] where one is not what was written.
pub(super) fn repeat_end(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    options: &RunOptions,
    report: &mut EnsembleReport,
) -> Result<(), RunError> {
    report.advice = measured(document, ensemble, report);
    tables::write(ensemble, report, confirm)?;
    confirm_page(&report.report(), || {
        page(document, ensemble, options, report)
    })
}

/// `report.html`.
fn page(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    options: &RunOptions,
    report: &EnsembleReport,
) -> Result<String, RunError> {
    let data = page::data(document, ensemble, report, &options.command)
        .map_err(RunError::reading(&report.directory))?;
    Ok(render_ensemble(&data)?)
}

/// Steps the members of a shard into a directory of its own, for [`merge_shards`](super::merge_shards); an unfinished shard
/// goes on, and a finished one is reported again.
///
/// # Errors
/// As [`run_ensemble`].
pub fn run_shard(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    shard: &Shard,
    options: &RunOptions,
    workforce: Workforce,
    progress: &mut dyn Progress,
) -> Result<EnsembleReport, RunError> {
    let asked = (ensemble, Some(shard));
    integrate(
        document,
        asked,
        options,
        workforce,
        progress,
        write_shard_end,
    )
}

/// Steps what is left of an ensemble, or of a shard of it; `end` writes what is told of the end.
fn integrate(
    document: &SceneDocument,
    (ensemble, shard): (&ComposedEnsemble, Option<&Shard>),
    options: &RunOptions,
    workforce: Workforce,
    progress: &mut dyn Progress,
    end: impl FnOnce(&Beginning<'_>, EnsembleReport) -> Result<EnsembleReport, RunError>,
) -> Result<EnsembleReport, RunError> {
    let checks = checked(document, ensemble, options)?;
    let directory = open(document, ensemble, options, shard)?;
    let begun = begin(document, ensemble, options, (&checks, shard), &directory)?;
    let Begun {
        mut session,
        beginning,
        resumed_at,
        is_done,
    } = begun;
    if is_done {
        let mut report = session.report(RunOutcome::Done, None);
        report.is_repeated = true;
        return Ok(report);
    }
    let outcome = session.steps(workforce, progress)?;
    end(&beginning, session.report(outcome, resumed_at))
}

/// The end of a shard's manifest.
#[derive(Serialize)]
struct ShardEnding {
    failed: u64,
    wall_seconds: f64,
    outcome: &'static str,
}

/// Writes what is told of a shard that has ended.
pub(super) fn write_shard_end(
    beginning: &Beginning<'_>,
    report: EnsembleReport,
) -> Result<EnsembleReport, RunError> {
    let ending = ShardEnding {
        failed: report.reductions.failed,
        wall_seconds: report.wall_seconds,
        outcome: report.outcome.word(),
    };
    beginning.write_end(&report.directory, ending)?;
    Ok(report)
}

/// The checks of a scene before it is stepped.
pub(super) fn checked(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    options: &RunOptions,
) -> Result<SceneChecks, RunError> {
    let composed = &ensemble.run;
    let checks = SceneChecks::of(&composed.system, &composed.near)?;
    match checks.refusal(document, &composed.system, options.allow_non_poisson) {
        Some(refusal) => Err(RunError::Refused(refusal)),
        None => Ok(checks),
    }
}

/// The directory of an ensemble or of a shard of it.
pub(super) fn open(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    options: &RunOptions,
    shard: Option<&Shard>,
) -> Result<RunDirectory, RunError> {
    let composed = &ensemble.run;
    let files = files(composed);
    let asked = RunRequest {
        kind: match shard {
            None => Kind::Ensemble,
            Some(_) => Kind::Shard,
        },
        scene: &document.text,
        plugins: &plugins(composed),
        files: files.as_ref(),
        shard: shard.map(Shard::record),
    };
    RunDirectory::open(&options.directory, &asked, options.force)
}

/// A session that may step, or has come to its end.
pub(super) struct Begun<'a> {
    pub session: Session<'a>,
    pub beginning: Beginning<'a>,
    pub resumed_at: Option<u64>,
    pub is_done: bool,
}

/// Resumes what a directory holds, or begins anew.
pub(super) fn begin<'a>(
    document: &'a SceneDocument,
    ensemble: &'a ComposedEnsemble,
    options: &'a RunOptions,
    (checks, shard): (&'a SceneChecks, Option<&Shard>),
    directory: &'a RunDirectory,
) -> Result<Begun<'a>, RunError> {
    let members = shard.map_or(0..ensemble.population.members(), Shard::items);
    let held = directory.held.as_ref();
    let resumed = match held {
        Some(_) => resume(ensemble, directory, &members)?,
        None => None,
    };
    let beginning = beginning(document, ensemble, options, (checks, shard), directory);
    let resumed_at = resumed.as_ref().map(|session| session.tree.next());
    let is_done = held.is_some_and(|held| held.is_done);
    let session = match resumed {
        Some(session) if is_done => session,
        resumed => {
            write_begun(document, &beginning, directory)?;
            match resumed {
                Some(mut session) => {
                    session.store.go_on()?;
                    session.section.go_on(&directory.path)?;
                    session
                }
                None => Session::new(ensemble, &directory.path, members)?,
            }
        }
    };
    Ok(Begun {
        is_done: is_done && resumed_at.is_some(),
        session,
        beginning,
        resumed_at,
    })
}

/// Beginning of the manifest of an ensemble or a shard: all that is told before the first member.
pub(super) fn beginning<'a>(
    document: &'a SceneDocument,
    ensemble: &'a ComposedEnsemble,
    options: &'a RunOptions,
    (checks, shard): (&'a SceneChecks, Option<&Shard>),
    directory: &RunDirectory,
) -> Beginning<'a> {
    let kind = match shard {
        None => Kind::Ensemble,
        Some(_) => Kind::Shard,
    };
    let started = directory.held.as_ref().map(|held| held.started.clone());
    let (composed, command) = (&ensemble.run, &options.command);
    let beginning = Beginning::new(kind, document, composed, checks, command, started);
    beginning.of_shard(shard.map(Shard::record))
}

/// Makes a directory that of an ensemble.
pub(super) fn write_begun(
    document: &SceneDocument,
    beginning: &Beginning<'_>,
    directory: &RunDirectory,
) -> Result<(), RunError> {
    beginning.write_running(&directory.path)?;
    replace(&directory.path.join(SCENE), document.text.as_bytes())
}

/// Writes all that is told of an ensemble that has ended.
pub(super) fn write_end(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    options: &RunOptions,
    beginning: &Beginning<'_>,
    mut report: EnsembleReport,
) -> Result<EnsembleReport, RunError> {
    // Who interrupts an ensemble wants it to end.
    if report.outcome != RunOutcome::Interrupted {
        report.advice = measured(document, ensemble, &report);
    }
    tables::write(ensemble, &report, replace)?;
    let page = page(document, ensemble, options, &report)?;
    write_page(&report.report(), &page)?;
    beginning.write_end(&report.directory, EnsembleEnding::new(ensemble, &report))?;
    Ok(report)
}

impl<'a> Session<'a> {
    /// No member yet, of these.
    pub fn new(
        ensemble: &'a ComposedEnsemble,
        directory: &'a Path,
        members: Range<u64>,
    ) -> Result<Self, RunError> {
        Ok(Session {
            ensemble,
            tree: Tree::new(ensemble.shape(), members.start),
            store: FinalStore::create(ensemble, directory, members.end - members.start)?,
            section: SectionStore::create(ensemble, directory)?,
            directory,
            wall: Duration::ZERO,
            threads: 0,
            end: members.end,
        })
    }

    /// Steps what is left, with checkpoints.
    fn steps(
        &mut self,
        workforce: Workforce,
        progress: &mut dyn Progress,
    ) -> Result<RunOutcome, RunError> {
        let directory = self.directory;
        self.checkpoint()?.write(directory)?;
        let save = &mut |checkpoint: &Checkpoint| checkpoint.write(directory);
        let mut steps = || {
            let outcome = self.drive(workforce, progress, save)?;
            self.checkpoint()?.write(directory)?;
            Ok(outcome)
        };
        steps().map_err(|error: RunError| error.with_a_checkpoint(directory))
    }

    /// Report of the ensemble as the session leaves it, still without advice.
    pub fn report(&self, outcome: RunOutcome, resumed_at: Option<u64>) -> EnsembleReport {
        let crossings = self.ensemble.run.plan.events.section.as_ref();
        EnsembleReport {
            outcome,
            wall_seconds: self.wall.as_secs_f64(),
            reductions: self.tree.total(),
            crossings: crossings.map(|_| self.section.count),
            resumed_at,
            is_repeated: false,
            threads: self.threads,
            advice: Vec::new(),
            directory: self.directory.to_owned(),
        }
    }
}

/// An ensemble, or these members of it, as its checkpoint has it; `None` where it was killed
/// before the first, and begins anew.
fn resume<'a>(
    ensemble: &'a ComposedEnsemble,
    directory: &'a RunDirectory,
    members: &Range<u64>,
) -> Result<Option<Session<'a>>, RunError> {
    let file = directory.path.join(crate::CHECKPOINT);
    if !file.exists() && has_begun_at_most(ensemble, &directory.path) {
        return Ok(None);
    }
    let checkpoint = Checkpoint::read(&directory.path)?;
    checkpoint.check(ensemble, members, &file)?;
    Ok(Some(Session {
        ensemble,
        store: FinalStore::resume(ensemble, &directory.path, &checkpoint.vouched)?,
        section: SectionStore::resume(
            ensemble,
            &directory.path,
            &checkpoint.section,
            checkpoint.crossings,
        )?,
        directory: &directory.path,
        wall: Duration::try_from_secs_f64(checkpoint.wall_seconds).unwrap_or_default(),
        tree: checkpoint.tree,
        threads: 0,
        end: members.end,
    }))
}
