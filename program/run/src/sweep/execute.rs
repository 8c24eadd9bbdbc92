//! From a composed sweep to a complete run directory.

use std::fs;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::PathBuf;

use sha2::{Digest, Sha256};

use super::page;
use super::plan::ComposedSweep;
use super::report::{SweepEnding, SweepReport};
use super::session::Session;
use crate::shards::{MergeError, Shard, Shards};
use crate::{
    Beginning, FilesRecord, Kind, Progress, RunDirectory, RunError, RunOptions, RunOutcome,
    RunRequest, SCENE, confirm_page, files, plugins, replace, write_page,
};
use leafwise_report::render_sweep;
use leafwise_scene::document::SceneDocument;

/// `runs/` and the scene file's name with `-sweep`.
pub fn default_sweep_directory(document: &SceneDocument) -> PathBuf {
    let out = document.sweep.as_ref().and_then(|sweep| sweep.out.as_ref());
    match out {
        Some(out) => PathBuf::from(&out.value),
        None => PathBuf::from("runs").join(format!("{}-sweep", crate::stem(document))),
    }
}

/// `runs/` and the scene file's name with `-sweep-shards`: a folder of shards.
pub fn default_sweep_shards_directory(document: &SceneDocument) -> PathBuf {
    PathBuf::from("runs").join(format!("{}-sweep-shards", crate::stem(document)))
}

/// Runs all settings into a directory. An unfinished sweep of the same scene goes on, to the same bytes as without
/// interruption. A finished one is reported again.
///
/// # Errors
/// Those of [`run`](crate::run) of the directory and of files.
pub fn run_sweep(
    document: &SceneDocument,
    sweep: &ComposedSweep<'_>,
    options: &RunOptions,
    threads: NonZeroUsize,
    progress: &mut dyn Progress,
) -> Result<SweepReport, RunError> {
    let asked = Asked::new(document, sweep, options, None);
    let (report, beginning) = asked.integrate(threads, progress)?;
    if report.is_repeated {
        asked.repeat_end(&report)?;
        return Ok(report);
    }
    asked.write_end(&beginning, report)
}

/// Runs the settings of a shard into a directory of its own, for [`merge_sweep`]; an unfinished shard goes on, and a finished
/// one is reported again.
///
/// # Errors
/// As [`run_sweep`].
pub fn run_sweep_shard(
    document: &SceneDocument,
    sweep: &ComposedSweep<'_>,
    shard: &Shard,
    options: &RunOptions,
    threads: NonZeroUsize,
    progress: &mut dyn Progress,
) -> Result<SweepReport, RunError> {
    let asked = Asked::new(document, sweep, options, Some(shard));
    let (report, beginning) = asked.integrate(threads, progress)?;
    match report.is_repeated {
        true => Ok(report),
        false => write_shard_end(&beginning, report),
    }
}

/// Joins shards into a directory. The bytes of the table are those that one process writes.
///
/// # Errors
/// [`MergeError`] for settings that are missing or there twice, and for shards that were changed since. Also those of
/// [`run_sweep`].
pub fn merge_sweep(
    document: &SceneDocument,
    sweep: &ComposedSweep<'_>,
    shards: &Shards,
    options: &RunOptions,
) -> Result<SweepReport, MergeError> {
    shards.check_whole()?;
    join(document, (sweep, None), shards, options)
}

/// Joins shards that follow one another into a larger one. Shards of shards are merged to the same bytes.
///
/// # Errors
/// As [`merge_sweep`], of the settings between the first and the last.
pub fn join_sweep_shards(
    document: &SceneDocument,
    sweep: &ComposedSweep<'_>,
    shards: &Shards,
    options: &RunOptions,
) -> Result<SweepReport, MergeError> {
    let larger = shards.together()?;
    join(document, (sweep, Some(&larger)), shards, options)
}

/// Joins shards into the whole sweep, or into a larger shard.
fn join(
    document: &SceneDocument,
    (sweep, larger): (&ComposedSweep<'_>, Option<&Shard>),
    shards: &Shards,
    options: &RunOptions,
) -> Result<SweepReport, MergeError> {
    let asked = Asked::new(document, sweep, options, larger);
    let directory = asked.open()?;
    let items = asked.items();
    if directory.held.as_ref().is_some_and(|held| held.is_done)
        && let Some(session) = Session::resume(sweep, &directory.path, items.clone())?
    {
        let mut report = asked.report(&session, RunOutcome::Done, None);
        report.is_repeated = true;
        if larger.is_none() {
            asked.repeat_end(&report)?;
        }
        return Ok(report);
    }
    let beginning = asked.begin(&directory)?;
    let mut session = Session::new(sweep, &directory.path, items)?;
    for shard in shards.done() {
        session.append(shard)?;
    }
    session.checkpoint()?;
    let report = asked.report(&session, RunOutcome::Done, None);
    Ok(match larger {
        None => asked.write_end(&beginning, report)?,
        Some(_) => write_shard_end(&beginning, report)?,
    })
}

/// Writes what is told of a shard that has ended.
fn write_shard_end(
    beginning: &Beginning<'_>,
    report: SweepReport,
) -> Result<SweepReport, RunError> {
    beginning.write_end(&report.directory, SweepEnding::new(&report))?;
    Ok(report)
}

/// A sweep, or a shard of it, that wants a directory.
struct Asked<'a> {
    document: &'a SceneDocument,
    sweep: &'a ComposedSweep<'a>,
    options: &'a RunOptions,
    shard: Option<&'a Shard>,
    kind: Kind,
    files: Option<FilesRecord>,
}

impl<'a> Asked<'a> {
    fn new(
        document: &'a SceneDocument,
        sweep: &'a ComposedSweep<'a>,
        options: &'a RunOptions,
        shard: Option<&'a Shard>,
    ) -> Self {
        Self {
            document,
            sweep,
            options,
            shard,
            kind: match shard {
                None => Kind::Sweep,
                Some(_) => Kind::SweepShard,
            },
            files: read_files(sweep),
        }
    }

    fn items(&self) -> Range<u64> {
        let count = self.sweep.settings().count();
        self.shard.map_or(0..count, Shard::items)
    }

    fn open(&self) -> Result<RunDirectory, RunError> {
        let asked = RunRequest {
            kind: self.kind,
            scene: &self.document.text,
            plugins: &plugins(&self.sweep.base),
            files: self.files.as_ref(),
            shard: self.shard.map(Shard::record),
        };
        RunDirectory::open(&self.options.directory, &asked, self.options.force)
    }

    /// Makes a directory that of the sweep.
    fn begin(&self, directory: &RunDirectory) -> Result<Beginning<'a>, RunError> {
        let beginning = self.beginning(directory);
        beginning.write_running(&directory.path)?;
        replace(&directory.path.join(SCENE), self.document.text.as_bytes())?;
        Ok(beginning)
    }

    fn beginning(&self, directory: &RunDirectory) -> Beginning<'a> {
        let started = directory.held.as_ref().map(|held| held.started.clone());
        let (sweep, command) = (self.sweep, &self.options.command);
        Beginning::new(
            self.kind,
            self.document,
            &sweep.base,
            &sweep.checks,
            command,
            started,
        )
        .of_shard(self.shard.map(Shard::record))
        .of_files(self.files.clone())
    }

    /// Runs what is left.
    fn integrate(
        &self,
        threads: NonZeroUsize,
        progress: &mut dyn Progress,
    ) -> Result<(SweepReport, Beginning<'a>), RunError> {
        let directory = self.open()?;
        let held = directory.held.as_ref();
        let resumed = match held {
            Some(_) => Session::resume(self.sweep, &directory.path, self.items())?,
            None => None,
        };
        let resumed_at = resumed.as_ref().map(|session| session.next);
        if let Some(session) = &resumed
            && held.is_some_and(|held| held.is_done)
        {
            let mut report = self.report(session, RunOutcome::Done, None);
            report.is_repeated = true;
            return Ok((report, self.beginning(&directory)));
        }
        let beginning = self.begin(&directory)?;
        let mut session = match resumed {
            Some(session) => session,
            None => Session::new(self.sweep, &directory.path, self.items())?,
        };
        let outcome = session.drive(threads, progress)?;
        Ok((self.report(&session, outcome, resumed_at), beginning))
    }

    fn report(
        &self,
        session: &Session<'_>,
        outcome: RunOutcome,
        resumed_at: Option<u64>,
    ) -> SweepReport {
        let items = self.items();
        SweepReport {
            outcome,
            settings: items.end - items.start,
            done: session.next - items.start,
            failed: session.failed,
            wall_seconds: session.wall.as_secs_f64(),
            resumed_at,
            is_repeated: false,
            threads: session.threads,
            columns: self.sweep.columns().clone(),
            directory: match self.options.directory.as_os_str().is_empty() {
                true => PathBuf::from("."),
                false => self.options.directory.clone(),
            },
        }
    }

    /// Makes sure that the page of a sweep that has ended before is as it was written; one that is not there is made anew.
    fn repeat_end(&self, report: &SweepReport) -> Result<(), RunError> {
        confirm_page(&report.report(), || self.page(report))
    }

    /// `report.html`.
    fn page(&self, report: &SweepReport) -> Result<String, RunError> {
        let table = report.table();
        let text = fs::read_to_string(&table).map_err(RunError::reading(&table))?;
        let (sweep, command) = (self.sweep, &self.options.command);
        let data = page::data(self.document, sweep, report, &text, command);
        Ok(render_sweep(&data)?)
    }

    /// Writes all that is told of a sweep that has ended.
    fn write_end(
        &self,
        beginning: &Beginning<'_>,
        report: SweepReport,
    ) -> Result<SweepReport, RunError> {
        write_page(&report.report(), &self.page(&report)?)?;
        beginning.write_end(&report.directory, SweepEnding::new(&report))?;
        Ok(report)
    }
}

/// Record of the files that a sweep reads: values of sites, and its settings.
fn read_files(sweep: &ComposedSweep<'_>) -> Option<FilesRecord> {
    let of_run = files(&sweep.base);
    let Some((file, digest)) = &sweep.settings().file else {
        return of_run;
    };
    let mut all = Sha256::new_with_prefix(digest);
    let mut paths = vec![file.clone()];
    if let Some(record) = of_run {
        all.update(record.sha256.as_bytes());
        paths.extend(record.paths);
    }
    let sha256 = all
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    Some(FilesRecord { paths, sha256 })
}
