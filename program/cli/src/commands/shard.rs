//! A shard of an ensemble, as the command line or a scheduler names it.

use std::env;

use leafwise::run::ensemble::{Shard, ShardError};

use crate::arguments::EnsembleArguments;
use crate::failure::Failure;

/// What an array's task knows of itself.
const TASK: &str = "SLURM_ARRAY_TASK_ID";
const FIRST: &str = "SLURM_ARRAY_TASK_MIN";
const LAST: &str = "SLURM_ARRAY_TASK_MAX";
const COUNT: &str = "SLURM_ARRAY_TASK_COUNT";

/// The shard that is asked for of an ensemble of so many members.
///
/// # Errors
/// [`Failure::Usage`] where it is none.
pub(super) fn asked(
    arguments: &EnsembleArguments,
    ensemble: u64,
) -> Result<Option<Shard>, Failure> {
    if let Some(text) = &arguments.members {
        let bounds = text.split_once("..");
        let bounds = bounds.and_then(|(from, to)| Some((whole(from)?, whole(to)?)));
        let Some((from, to)) = bounds else {
            return Err(Failure::usage(
                format!("--members: `{text}` is no range of members"),
                "write the first and the one behind the last, as in --members 0..6400",
            ));
        };
        return Shard::between(from..to, ensemble)
            .map(Some)
            .map_err(|error| refused(&error, ensemble));
    }
    let Some(text) = &arguments.shard else {
        return Ok(None);
    };
    let (number, of) = match text.split_once('/') {
        None if text == "slurm" => of_array()?,
        Some(("slurm", of)) => (variable(TASK)?, whole(of).ok_or_else(|| no_shard(text))?),
        parts => parts
            .and_then(|(number, of)| Some((whole(number)?, whole(of)?)))
            .ok_or_else(|| no_shard(text))?,
    };
    Shard::of(number, of, ensemble)
        .map(Some)
        .map_err(|error| refused(&error, ensemble))
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
        format!("--shard: `{text}` is no shard"),
        "write which of how many, as in --shard 7/1000, or --shard slurm in a task of an array",
    )
}

fn refused(error: &ShardError, ensemble: u64) -> Failure {
    Failure::usage(
        error.to_string(),
        format!("the scene's ensemble has {ensemble} members"),
    )
}
