//! From a composed ensemble to a complete run directory.

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use super::checkpoint::Checkpoint;
use super::drive::{Session, Workforce};
use super::plan::ComposedEnsemble;
use super::statistics::Reductions;
use super::store::FinalStore;
use super::{page, tables};
use crate::compose::SceneChecks;
use crate::document::SceneDocument;
use crate::report::render_ensemble;
use crate::run::{
    Asked, Beginning, Kind, Progress, REPORT, RunDirectory, RunError, RunOptions, RunOutcome,
    SCENE, outcome_word, plugins, replace,
};

/// An ensemble that has ended and left its directory complete.
#[derive(Clone, Debug)]
pub struct EnsembleReport {
    /// How it ended: done, or interrupted. Members that failed are told in `reductions`.
    pub outcome: RunOutcome,
    /// What its members were reduced to.
    pub reductions: Reductions,
    /// Seconds of integration, observers and reductions included, all sessions together.
    pub wall_seconds: f64,
    /// The member an earlier session had come to.
    pub resumed_at: Option<u64>,
    /// The run directory.
    pub directory: PathBuf,
}

impl EnsembleReport {
    /// The page to open in a browser.
    pub fn report(&self) -> PathBuf {
        self.directory.join(REPORT)
    }

    /// Members a second.
    pub fn rate(&self) -> f64 {
        self.reductions.members as f64 / self.wall_seconds.max(1e-9)
    }
}

/// `runs/` and the scene file's name with `-ensemble`.
pub fn default_ensemble_directory(document: &SceneDocument) -> PathBuf {
    let out = document.ensemble.as_ref().and_then(|e| e.out.as_ref());
    match out {
        Some(out) => PathBuf::from(&out.value),
        None => PathBuf::from("runs").join(format!("{}-ensemble", crate::run::stem(document))),
    }
}

/// Checks the scene, then steps all members and reduces them into a directory; an unfinished ensemble
/// of the same scene is resumed, to the same bits as without interruption.
///
/// # Errors
/// As [`run`](crate::run::run).
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
    let asked = Asked {
        kind,
        scene: &document.text,
        plugins: &plugins(composed),
    };
    let directory = RunDirectory::open(&options.directory, &asked, options.force)?;
    let started = directory.unfinished.clone();
    let resumed = match started {
        Some(_) => Some(resume(ensemble, &directory)?),
        None => None,
    };
    let resumed_at = resumed
        .as_ref()
        .map(|checkpoint| checkpoint.reductions.members);
    let store = FinalStore::open(
        ensemble,
        &directory.path,
        resumed.as_ref().map(|checkpoint| checkpoint.stored_bytes),
    )?;
    let (reductions, wall_seconds) = match resumed {
        Some(checkpoint) => (checkpoint.reductions, checkpoint.wall_seconds),
        None => (Reductions::new(ensemble.shape()), 0.0),
    };
    let mut session = Session {
        ensemble,
        reductions,
        store,
        wall: Duration::try_from_secs_f64(wall_seconds).unwrap_or_default(),
    };
    let command = &options.command;
    let beginning = Beginning::new(kind, document, composed, &checks, command, started);
    replace(&directory.path.join(SCENE), document.text.as_bytes())?;
    session.checkpoint()?.write(&directory.path)?;
    beginning.write_running(&directory.path)?;
    let save = &mut |checkpoint: &Checkpoint| checkpoint.write(&directory.path);
    let outcome = session.drive(workforce, progress, save)?;
    session.checkpoint()?.write(&directory.path)?;
    let report = EnsembleReport {
        outcome,
        wall_seconds: session.wall.as_secs_f64(),
        reductions: session.reductions,
        resumed_at,
        directory: directory.path.clone(),
    };
    tables::write(ensemble, &report)?;
    let data = page::data(document, ensemble, &report, &options.command);
    let path = directory.path.join(REPORT);
    fs::write(&path, render_ensemble(&data)?).map_err(RunError::io(&path))?;
    let mut ending = tables::ending(ensemble, &report);
    ending["outcome"] = outcome_word(&report.outcome).into();
    beginning.write_end(&directory.path, ending)?;
    Ok(report)
}

/// The checkpoint of an unfinished ensemble, which must be of these members.
fn resume(ensemble: &ComposedEnsemble, directory: &RunDirectory) -> Result<Checkpoint, RunError> {
    let checkpoint = Checkpoint::read(&directory.path)?;
    let damaged = |reason: &str| RunError::Damaged {
        file: directory.path.join(crate::run::CHECKPOINT),
        reason: reason.to_owned(),
    };
    let population = &ensemble.population;
    if checkpoint.fingerprint != population.fingerprint() {
        return Err(damaged(
            "the file of states has changed since it was written",
        ));
    }
    let fresh = Reductions::new(ensemble.shape());
    let sizes = |all: &Reductions| {
        let deviations = [&all.windows, &all.whole, &all.relative].map(Vec::len);
        (all.summaries.len(), all.initial.len(), deviations)
    };
    if checkpoint.members != population.members() || sizes(&fresh) != sizes(&checkpoint.reductions)
    {
        return Err(damaged("it is of another ensemble"));
    }
    Ok(checkpoint)
}
