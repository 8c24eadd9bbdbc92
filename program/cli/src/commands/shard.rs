//! A shard of an ensemble or a sweep, as the command line or a scheduler names it.

use std::env;
use std::path::PathBuf;

use leafwise::run::shards::{Portion, Shard, ShardError, Whole};
use leafwise::run::{RunOutcome, default_directory};
use leafwise::scene::SceneDocument;

use crate::failure::{Failure, exit};

/// Environment variables of a task of a Slurm array: its own number, the first and the last number, and how many tasks
/// there are.
const TASK: &str = "SLURM_ARRAY_TASK_ID";
const FIRST: &str = "SLURM_ARRAY_TASK_MIN";
const LAST: &str = "SLURM_ARRAY_TASK_MAX";
const COUNT: &str = "SLURM_ARRAY_TASK_COUNT";

/// The directory of a job that makes a portion: the one that is named, or the usual; of a shard a folder within.
pub(super) fn directory(
    out: &Option<PathBuf>,
    document: &SceneDocument,
    portion: &Portion<'_>,
    whole: Whole,
) -> PathBuf {
    let usual = || default_directory(document, portion.kind(whole));
    let folder = out.clone().unwrap_or_else(usual);
    match portion.shard() {
        None => folder,
        Some(shard) => folder.join(shard.name()),
    }
}

/// The members that are asked for, of an ensemble of so many.
///
/// # Errors
/// [`Failure::Usage`] where they are no shard.
pub(super) fn of_members(text: &str, count: u64) -> Result<Shard, Failure> {
    let bounds = text.split_once("..");
    let bounds = bounds.and_then(|(from, to)| Some((whole(from)?, whole(to)?)));
    let Some((from, to)) = bounds else {
        return Err(Failure::usage(
            format!("--members: `{text}` is not a range of members"),
            "write the first and the one after the last, as in --members 0..6400",
        ));
    };
    Shard::between(Whole::Members, from..to, count)
        .map_err(|error| refused(&error, Whole::Members, count))
}

/// The shard that is asked for, of so many members or settings.
///
/// # Errors
/// [`Failure::Usage`] where it is none.
pub(super) fn of_number(text: &str, of_what: Whole, count: u64) -> Result<Shard, Failure> {
    let (number, of) = match text.split_once('/') {
        None if text == "slurm" => of_array()?,
        Some(("slurm", of)) => (variable(TASK)?, whole(of).ok_or_else(|| no_shard(text))?),
        parts => parts
            .and_then(|(number, of)| Some((whole(number)?, whole(of)?)))
            .ok_or_else(|| no_shard(text))?,
    };
    Shard::of(of_what, number, of, count).map_err(|error| refused(&error, of_what, count))
}

/// The task of an array from 1 to the number of shards.
fn of_array() -> Result<(u64, u64), Failure> {
    let [task, first, last, count] = [
        variable(TASK)?,
        variable(FIRST)?,
        variable(LAST)?,
        variable(COUNT)?,
    ];
    if first == 1 && count == last {
        return Ok((task, last));
    }
    Err(Failure::usage(
        format!(
            "--shard slurm: an array of {count} tasks from {first} to {last} does not say how many shards there are"
        ),
        "name their number, as in --shard slurm/1000, or submit the whole with --array=1-1000",
    ))
}

/// A whole number of the environment.
fn variable(name: &str) -> Result<u64, Failure> {
    let value = env::var(name).ok();
    value.as_deref().and_then(whole).ok_or_else(|| {
        let found = match value {
            None => format!("{name} is not set"),
            Some(value) => format!("{name} is `{value}`"),
        };
        Failure::usage(
            format!("--shard slurm: {found}"),
            "it is read in the tasks of an array, sbatch --array=1-1000; elsewhere name the shard, as in --shard 7/1000",
        )
    })
}

fn whole(text: &str) -> Option<u64> {
    text.trim().parse().ok()
}

fn no_shard(text: &str) -> Failure {
    Failure::usage(
        format!("--shard: `{text}` is not a shard"),
        "write which of how many, as in --shard 7/1000, or --shard slurm in a task of an array",
    )
}

fn refused(error: &ShardError, of_what: Whole, count: u64) -> Failure {
    let (word, items) = (of_what.word(), of_what.items());
    Failure::usage(
        error.to_string(),
        format!("the scene's {word} has {count} {items}"),
    )
}

/// The exit code of so many members or settings of which some have failed. A shard that is complete has done what it was
/// asked: its files hold the failures, and `merge` tells them.
pub(super) fn exit_code(outcome: &RunOutcome, [made, failed]: [u64; 2], is_shard: bool) -> u8 {
    match outcome {
        RunOutcome::Interrupted => exit::INTERRUPTED,
        _ if is_shard || failed == 0 => exit::DONE,
        _ if failed == made => exit::RUN_FAILED,
        _ => exit::SOME_FAILED,
    }
}
