//! From a composed scene to a complete run directory.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use leafwise_core::Registry;

use super::checkpoint::{Checkpoint, replace};
use super::directory::{Asked, FINAL_STATE, REPORT, RunDirectory, SCENE, WINDOWS};
use super::drive::{Session, invariant_name};
use super::error::RunError;
use super::manifest::{Beginning, Kind, plugins};
use super::outcome::{InvariantDrift, RunOutcome, RunReport};
use super::progress::Progress;
use super::samples::WIDEST_STATE;
use super::summary::{self, report_data};
use crate::advice::advise;
use crate::compose::{ComposedRun, SceneChecks};
use crate::document::SceneDocument;
use crate::report::render_report;

/// Where a run is written and what is let pass.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The run directory.
    pub directory: PathBuf,
    /// Replaces the run that the directory holds.
    pub force: bool,
    /// Integrates a tensor that violates the Jacobi identity.
    pub allow_non_poisson: bool,
    /// The command that repeats this run, for the report.
    pub command: String,
    /// How often a checkpoint is written: what a kill costs at most.
    pub checkpoint_every: Duration,
}

impl RunOptions {
    /// The usual [`checkpoint_every`](Self::checkpoint_every).
    pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);
}

/// Checks the scene with the parts that it may name, then steps it into its directory; an unfinished run of the same scene is
/// resumed, to the same bits as without interruption.
///
/// Nothing is written before the scene has passed its checks. A numerical failure is an outcome,
/// not an error: the directory is then complete, with everything recorded up to the failure.
///
/// # Errors
/// [`RunError::Refused`] for a tensor that is not Poisson or a Casimir that is not one; the
/// directory's refusals; failures of the file system.
pub fn run(
    document: &SceneDocument,
    composed: &ComposedRun,
    registry: &Registry,
    options: &RunOptions,
    progress: &mut dyn Progress,
) -> Result<RunReport, RunError> {
    let checks = SceneChecks::of(&composed.system, &composed.near)?;
    if let Some(refusal) = checks.refusal(document, &composed.system, options.allow_non_poisson) {
        return Err(RunError::Refused(refusal));
    }
    let kind = Kind::Run;
    let asked = Asked {
        kind,
        scene: &document.text,
        plugins: &plugins(composed),
    };
    let directory = RunDirectory::open(&options.directory, &asked, options.force)?;
    let started = directory.unfinished.clone();
    let resumed = match started {
        Some(_) => Checkpoint::of_unfinished(&directory.path)?,
        None => None,
    };
    let resumed_at = resumed
        .as_ref()
        .map(|checkpoint| checkpoint.integrator.steps);
    let command = &options.command;
    let beginning = Beginning::new(kind, document, composed, &checks, command, started);
    // From here on the directory is that of this run, with nothing in it yet or all that was recorded.
    replace(&directory.path.join(SCENE), document.text.as_bytes())?;
    beginning.write_running(&directory.path)?;
    let mut session = Session::new(
        composed,
        &directory,
        resumed.as_ref(),
        options.checkpoint_every,
    )?;
    let mut finish = |progress: &mut dyn Progress| -> Result<RunReport, RunError> {
        let outcome = session.drive(progress)?;
        let mut report = describe(composed, &session, outcome, resumed_at, &directory);
        // Who interrupts a run wants it to end.
        if report.outcome != RunOutcome::Interrupted {
            let states = summary::states(composed, &report);
            let states = states.map_err(RunError::io(&directory.path))?;
            report.advice = advise(composed, registry, &states);
        }
        write_end(document, composed, &session, &report, &options.command)?;
        beginning.write_ended(&report, composed.method.map())?;
        Ok(report)
    };
    finish(progress).map_err(|error| error.with_a_checkpoint(&directory.path))
}

/// Everything of a run directory that is written when the run has ended, but the manifest.
fn write_end(
    document: &SceneDocument,
    composed: &ComposedRun,
    session: &Session<'_>,
    report: &RunReport,
    command: &str,
) -> Result<(), RunError> {
    let directory = &report.directory;
    write_windows(composed, session, directory)?;
    if report.final_state.len() > WIDEST_STATE {
        let bytes: Vec<u8> = report
            .final_state
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        replace(&directory.join(FINAL_STATE), &bytes)?;
    }
    let data = report_data(document, composed, session, report, command)?;
    let page = render_report(&data)?;
    let path = directory.join(REPORT);
    fs::write(&path, page).map_err(RunError::io(&path))
}

fn describe(
    composed: &ComposedRun,
    session: &Session<'_>,
    outcome: RunOutcome,
    resumed_at: Option<u64>,
    directory: &RunDirectory,
) -> RunReport {
    let windows = session.windows();
    let invariants = windows
        .initial
        .iter()
        .zip(windows.largest())
        .enumerate()
        .map(|(index, (initial, maximum))| InvariantDrift {
            name: invariant_name(composed, index).to_owned(),
            initial: *initial,
            maximum,
        })
        .collect();
    let status = session.status();
    RunReport {
        outcome,
        final_state: session.state().to_vec(),
        time: status.time,
        steps: status.steps,
        wall_seconds: session.wall_seconds(),
        invariants,
        statistics: session.statistics(),
        samples: session.samples(),
        resumed_at,
        advice: Vec::new(),
        directory: directory.path.clone(),
    }
}

/// `windows.csv`: the end of each window and the invariants' largest deviations in it.
fn write_windows(
    composed: &ComposedRun,
    session: &Session<'_>,
    directory: &Path,
) -> Result<(), RunError> {
    let windows = session.windows();
    let time_step = composed.plan.epsilon * composed.plan.h;
    let columns: Vec<Vec<f64>> = (0..windows.initial.len())
        .map(|index| windows.series(index))
        .collect();
    let mut text = String::from("t_end");
    for index in 0..columns.len() {
        text.push_str(&format!(",{}", invariant_name(composed, index)));
    }
    text.push('\n');
    for (row, end) in windows.ends().into_iter().enumerate() {
        text.push_str(&format!("{:?}", end as f64 * time_step));
        for column in &columns {
            text.push_str(&format!(",{:?}", column[row]));
        }
        text.push('\n');
    }
    replace(&directory.join(WINDOWS), text.as_bytes())
}
