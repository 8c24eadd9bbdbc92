//! Shards joined into the directory that one process would have written.

use std::time::Duration;

use super::checkpoint::Checkpoint;
use super::drive::Session;
use super::execute::{
    begin, beginning, checked, open, repeat_end, write_begun, write_end, write_shard_end,
};
use super::plan::ComposedEnsemble;
use super::report::EnsembleReport;
use crate::shards::{Found, MergeError, Shard, Shards};
use crate::{CHECKPOINT, RunError, RunOptions, RunOutcome};
use leafwise_scene::document::SceneDocument;

/// Joins shards into a directory. The bytes are those that one process writes.
///
/// # Errors
/// [`MergeError`] for members that are missing or there twice, and for shards that were changed since. Also those of
/// [`run_ensemble`](super::run_ensemble).
pub fn merge_shards(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    shards: &Shards,
    options: &RunOptions,
) -> Result<EnsembleReport, MergeError> {
    shards.check_whole()?;
    join(document, (ensemble, None), shards, options)
}

/// Joins shards that follow one another into a larger one. Shards of shards are merged to the same bytes.
///
/// # Errors
/// As [`merge_shards`], of the members between the first and the last.
pub fn join_shards(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    shards: &Shards,
    options: &RunOptions,
) -> Result<EnsembleReport, MergeError> {
    let larger = shards.together()?;
    join(document, (ensemble, Some(&larger)), shards, options)
}

/// Joins shards into the whole ensemble, or into a larger shard.
fn join(
    document: &SceneDocument,
    (ensemble, larger): (&ComposedEnsemble, Option<&Shard>),
    shards: &Shards,
    options: &RunOptions,
) -> Result<EnsembleReport, MergeError> {
    let checks = checked(document, ensemble, options)?;
    let directory = open(document, ensemble, options, larger)?;
    if directory.held.as_ref().is_some_and(|held| held.is_done) {
        let held = begin(document, ensemble, options, (&checks, larger), &directory)?;
        let mut report = held.session.report(RunOutcome::Done, None);
        report.is_repeated = true;
        if larger.is_none() {
            repeat_end(document, ensemble, options, &mut report)?;
        }
        return Ok(report);
    }
    let beginning = beginning(document, ensemble, options, (&checks, larger), &directory);
    write_begun(document, &beginning, &directory)?;
    let members = larger.map_or(0..ensemble.population.members(), Shard::items);
    let mut session = Session::new(ensemble, &directory.path, members)?;
    for shard in shards.done() {
        session.append(shard)?;
    }
    session.checkpoint()?.write(&directory.path)?;
    let report = session.report(RunOutcome::Done, None);
    Ok(match larger {
        None => write_end(document, ensemble, options, &beginning, report)?,
        Some(_) => write_shard_end(&beginning, report)?,
    })
}

impl Session<'_> {
    fn append(&mut self, shard: &Found) -> Result<(), RunError> {
        let members = shard.items();
        if members.is_empty() {
            return Ok(());
        }
        let path = &shard.directory;
        let file = path.join(CHECKPOINT);
        let checkpoint = Checkpoint::read(path)?;
        checkpoint.check(self.ensemble, &members, &file)?;
        if checkpoint.tree.members() != members {
            return Err(RunError::Damaged {
                file,
                reason: "it holds fewer members than its manifest says".to_owned(),
            });
        }
        self.tree.append(checkpoint.tree);
        self.store
            .append(self.ensemble, path, &checkpoint.vouched)?;
        let (section, crossings) = (&checkpoint.section, checkpoint.crossings);
        self.section
            .append(self.ensemble, path, section, crossings)?;
        self.wall += Duration::try_from_secs_f64(checkpoint.wall_seconds).unwrap_or_default();
        Ok(())
    }
}
