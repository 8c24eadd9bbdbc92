//! From a composed ensemble to a complete run directory.

use std::path::PathBuf;
use std::time::Duration;

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
use crate::{
    Beginning, Kind, Progress, REPORT, RunDirectory, RunError, RunOptions, RunOutcome, RunRequest,
    SCENE, files, plugins, replace,
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

/// Checks the scene, then steps all members and reduces them into a directory; an unfinished ensemble
/// of the same scene is resumed, to the same bits as without interruption, and a finished one reported
/// again.
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
    let composed = &ensemble.run;
    let checks = SceneChecks::of(&composed.system, &composed.near)?;
    if let Some(refusal) = checks.refusal(document, &composed.system, options.allow_non_poisson) {
        return Err(RunError::Refused(refusal));
    }
    let kind = Kind::Ensemble;
    let files = files(composed);
    let asked = RunRequest {
        kind,
        scene: &document.text,
        plugins: &plugins(composed),
        files: files.as_ref(),
    };
    let directory = RunDirectory::open(&options.directory, &asked, options.force)?;
    let held = directory.held.as_ref();
    let resumed = match held {
        Some(_) => resume(ensemble, &directory)?,
        None => None,
    };
    let resumed_at = resumed.as_ref().map(|session| session.tree.members().end);
    let is_done = held.is_some_and(|held| held.is_done);
    if is_done && let Some(session) = resumed {
        let crossings = ensemble.run.plan.events.section.as_ref();
        let crossings = crossings.map(|_| session.section.count);
        let mut report = EnsembleReport {
            outcome: RunOutcome::Done,
            wall_seconds: session.wall.as_secs_f64(),
            reductions: session.tree.total(),
            crossings,
            resumed_at: None,
            is_repeated: true,
            threads: session.threads,
            advice: Vec::new(),
            directory: directory.path.clone(),
        };
        report.advice = measured(document, ensemble, &report);
        return Ok(report);
    }
    let command = &options.command;
    let started = held.map(|held| held.started.clone());
    let beginning = Beginning::new(kind, document, composed, &checks, command, started);
    beginning.write_running(&directory.path)?;
    replace(&directory.path.join(SCENE), document.text.as_bytes())?;
    let mut session = match resumed {
        Some(mut session) => {
            session.store.go_on()?;
            session.section.go_on(&directory.path)?;
            session
        }
        None => Session {
            ensemble,
            tree: Tree::new(ensemble.shape(), 0),
            store: FinalStore::create(ensemble, &directory.path)?,
            section: SectionStore::create(ensemble, &directory.path)?,
            directory: &directory.path,
            wall: Duration::ZERO,
            threads: 0,
        },
    };
    session.checkpoint()?.write(&directory.path)?;
    let save = &mut |checkpoint: &Checkpoint| checkpoint.write(&directory.path);
    let outcome = session.drive(workforce, progress, save)?;
    session.checkpoint()?.write(&directory.path)?;
    let crossings = ensemble.run.plan.events.section.as_ref();
    let crossings = crossings.map(|_| session.section.count);
    let mut report = EnsembleReport {
        outcome,
        wall_seconds: session.wall.as_secs_f64(),
        reductions: session.tree.total(),
        crossings,
        resumed_at,
        is_repeated: false,
        threads: session.threads,
        advice: Vec::new(),
        directory: directory.path.clone(),
    };
    // Who interrupts an ensemble wants it to end.
    if report.outcome != RunOutcome::Interrupted {
        report.advice = measured(document, ensemble, &report);
    }
    tables::write(ensemble, &report)?;
    let data = page::data(document, ensemble, &report, &options.command)
        .map_err(RunError::io(&directory.path))?;
    let page = render_ensemble(&data)?;
    replace(&directory.path.join(REPORT), page.as_bytes())?;
    beginning.write_end(&directory.path, EnsembleEnding::new(ensemble, &report))?;
    Ok(report)
}

/// An ensemble as its checkpoint has it, which must be of these members; `None` where it was killed
/// before the first, and begins anew.
fn resume<'a>(
    ensemble: &'a ComposedEnsemble,
    directory: &'a RunDirectory,
) -> Result<Option<Session<'a>>, RunError> {
    let file = directory.path.join(crate::CHECKPOINT);
    if !file.exists() && has_begun_at_most(ensemble, &directory.path) {
        return Ok(None);
    }
    let checkpoint = Checkpoint::read(&directory.path)?;
    let damaged = |reason: &str| RunError::Damaged {
        file,
        reason: reason.to_owned(),
    };
    let population = &ensemble.population;
    if checkpoint.fingerprint != population.fingerprint() {
        return Err(damaged(
            "the file of states has changed since it was written",
        ));
    }
    if checkpoint.members != population.members() || checkpoint.tree.shape() != ensemble.shape() {
        return Err(damaged("it is of another ensemble"));
    }
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
    }))
}
