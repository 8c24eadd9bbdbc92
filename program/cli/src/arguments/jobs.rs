//! Arguments of runs, ensembles, sweeps and their joins, and of checks.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use leafwise::run::RunOptions;

/// A scene file and its overrides.
#[derive(Args, Clone, Debug)]
pub struct SceneArguments {
    /// The scene file
    pub scene: PathBuf,
    /// Override a value of the scene, as in --set method.epsilon=0.05
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

/// How a run directory is written, and what is told of it.
#[derive(Args, Clone, Copy, Debug)]
pub struct OutputArguments {
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Replace the run that the directory holds
    #[arg(long)]
    pub force: bool,
    /// Integrate a tensor that violates the Jacobi identity
    #[arg(long)]
    pub allow_non_poisson: bool,
}

impl OutputArguments {
    /// The options of what writes into `directory`; `command` repeats it.
    pub fn options(self, directory: PathBuf, command: String) -> RunOptions {
        RunOptions {
            command,
            force: self.force,
            allow_non_poisson: self.allow_non_poisson,
            ..RunOptions::within(directory)
        }
    }
}

/// Arguments of `run`.
#[derive(Args, Clone, Debug)]
pub struct RunArguments {
    /// Scene to run, with its overrides.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Print what was built: shape, series, operation counts
    #[arg(long)]
    pub explain: bool,
    /// Estimate the error of the states, after the run, by a pass with half the step; takes three times as long again
    #[arg(long)]
    pub error: bool,
    /// The run directory [default: runs/ and the scene's name]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// How often a checkpoint is written: what a kill costs at most
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true, default_value_t =
          RunOptions::CHECKPOINT_EVERY.as_secs_f64())]
    pub checkpoint_every: f64,
    /// How the directory is written.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `ensemble`.
#[derive(Args, Clone, Debug)]
pub struct EnsembleArguments {
    /// Scene to run, with its overrides: a scene with a table `[ensemble]`.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Run this member alone, as an ordinary run into a directory of its own
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, conflicts_with_all = ["threads", "lanes"])]
    pub member: Option<u64>,
    /// Run a part of the members for `merge`: I/N, the I-th of N shards, or slurm or slurm/N, that of the array's task
    #[arg(long, value_name = "I/N", conflicts_with_all = ["member", "members"])]
    pub shard: Option<String>,
    /// The same of these members, FROM and TO multiples of 64, or TO the number of members
    #[arg(long, value_name = "FROM..TO", conflicts_with = "member")]
    pub members: Option<String>,
    /// Threads [default: all of the machine's]; the results do not depend on it
    #[arg(long, value_name = "COUNT")]
    pub threads: Option<NonZeroUsize>,
    /// Members side by side on a thread; the results do not depend on it
    #[arg(long, value_name = "COUNT", default_value = "64")]
    pub lanes: NonZeroUsize,
    /// The run directory [default: runs/ and the scene's name with -ensemble, or -member-NUMBER]; a shard writes into a folder
    /// of its own in it [default: -shards]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// How the directory is written.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `sweep`.
#[derive(Args, Clone, Debug)]
pub struct SweepArguments {
    /// Scene to run, with its overrides: a scene with a table `[sweep]`.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Run a part of the settings for `merge`: I/N, the I-th of N shards, or slurm or slurm/N, that of the array's task
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Threads [default: all of the machine's]; the results do not depend on it
    #[arg(long, value_name = "COUNT")]
    pub threads: Option<NonZeroUsize>,
    /// The run directory [default: runs/ and the scene's name with -sweep]; a shard writes into a folder of its own in it
    /// [default: -sweep-shards]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// How the directory is written.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `merge`.
#[derive(Args, Clone, Debug)]
pub struct MergeArguments {
    /// Shards, or folders of shards
    #[arg(required = true, value_name = "DIR")]
    pub shards: Vec<PathBuf>,
    /// The run directory of the whole
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// The scene file, where files or plugins that it names stand beside it [default: the one that the shards hold]
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// How the directory is written.
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Arguments of `check`.
#[derive(Args, Clone, Debug)]
pub struct CheckArguments {
    /// Scene to check, with its overrides.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// A positive number.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("write a positive number, such as 1e-8".to_owned()),
    }
}
