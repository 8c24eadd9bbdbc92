//! The command line.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use leafwise::expression::Execution;
use leafwise::run::RunOptions;

/// Exit codes, for the help text.
const CODES: &str = "Exit codes: 0 done, 1 the run failed, 2 usage, 3 invalid scene, 4 a plugin \
                     was refused, 5 a check failed, 130 interrupted with a checkpoint written.";

/// Poisson integrators assembled from symplectic realizations and Lagrangian bisections.
#[derive(Debug, Parser)]
#[command(name = "leafwise", version, after_help = CODES)]
pub struct Arguments {
    /// Command to execute.
    #[command(subcommand)]
    pub command: Command,
    /// How kernels run; the results have the same bits either way
    #[arg(
        long,
        global = true,
        env = "LEAFWISE_KERNELS",
        value_name = "HOW",
        default_value = "adaptive"
    )]
    pub kernels: Kernels,
    /// Shared libraries with parts.
    #[command(flatten)]
    pub plugins: PluginArguments,
}

/// Which plugins are loaded beside those that a scene names.
#[derive(Args, Clone, Debug, Default)]
pub struct PluginArguments {
    /// Load the parts of a shared library: a path, or a name in the search path. It runs the
    /// library's code
    #[arg(long = "plugin", value_name = "PATH", global = true)]
    pub plugins: Vec<PathBuf>,
    /// Load no plugin, whatever a scene names; so does LEAFWISE_NO_PLUGINS
    #[arg(long, global = true)]
    pub no_plugins: bool,
    /// `plugin check` in this very process, for the one that waits
    #[arg(long, global = true, hide = true)]
    pub measures_here: bool,
}

/// How kernels run.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Kernels {
    /// By the interpreter
    Interpreted,
    /// As machine code, where the platform has a compiler
    Compiled,
    /// Interpreted first, compiled where that pays
    Adaptive,
}

impl From<Kernels> for Execution {
    fn from(kernels: Kernels) -> Self {
        match kernels {
            Kernels::Interpreted => Self::Interpreted,
            Kernels::Compiled => Self::Compiled,
            Kernels::Adaptive => Self::Adaptive,
        }
    }
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Integrate a scene into a run directory with a report
    Run(RunArguments),
    /// Integrate many initial states or parameter sets, reduced to statistics
    Ensemble(EnsembleArguments),
    /// Run a scene for each of many settings of its keys, into one table
    Sweep(SweepArguments),
    /// Join the shards of an ensemble or a sweep, to the bytes of one process
    Merge(MergeArguments),
    /// Check that the tensor is Poisson and the Casimirs are Casimirs
    Check(CheckArguments),
    /// List systems, realizations, dynamics and the Lie algebras a bracket may name
    List(ListArguments),
    /// Describe a part, a library system or a Lie algebra
    Describe(DescribeArguments),
    /// Evaluate a scene's realization and generating function at a point
    Evaluate(EvaluateArguments),
    /// Find the bracket and the Hamiltonian of equations of motion, and the Casimirs of a bracket
    Find(FindArguments),
    /// Print the shadow Hamiltonian of a scene's method, and how well it is kept
    Shadow(ShadowArguments),
    /// Measure what every part declares: orders, tensor defects, drift, cost
    Verify(VerifyArguments),
    /// Measure cost against accuracy over methods, orders and steps
    Compare(CompareArguments),
    /// Find the cheapest method and step that hold given tolerances
    Tune(TuneArguments),
    /// Measure the figures and numbers of the paper's section 5 beside what it prints
    Reproduce(ReproduceArguments),
    /// Run the extremes, each against its expected outcome
    Stress(StressArguments),
    /// Write a commented scene file to start from
    New(NewArguments),
    /// Explain a word of a warning, a key of scenes or a subject, by the pages of the guide
    Explain(ExplainArguments),
    /// Print every key of scenes: a JSON Schema for editors, or tables to read
    Schema(SchemaArguments),
    /// List plugins, or check one
    #[command(subcommand)]
    Plugin(PluginCommand),
}

/// Subcommands of `plugin`.
#[derive(Debug, Subcommand)]
pub enum PluginCommand {
    /// List the libraries of the search path, without loading any
    List(PluginListArguments),
    /// Try a library, load it, and measure its parts against what they declare
    Check(PluginCheckArguments),
    /// Try a library and report to the process that waits
    #[command(hide = true)]
    Probe {
        /// The library.
        path: PathBuf,
    },
}

/// Arguments of `plugin list`.
#[derive(Args, Clone, Debug)]
pub struct PluginListArguments {
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `plugin check`.
#[derive(Args, Clone, Debug)]
pub struct PluginCheckArguments {
    /// The library: a path, or a name in the search path
    #[arg(value_name = "PATH")]
    pub path: PathBuf,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

impl Command {
    /// Whether the command was asked for JSON.
    pub fn wants_json(&self) -> bool {
        match self {
            Self::Run(arguments) => arguments.output.json,
            Self::Ensemble(arguments) => arguments.output.json,
            Self::Sweep(arguments) => arguments.output.json,
            Self::Merge(arguments) => arguments.output.json,
            Self::Check(arguments) => arguments.json,
            Self::List(arguments) => arguments.json,
            Self::Describe(arguments) => arguments.json,
            Self::Evaluate(arguments) => arguments.json,
            Self::Find(arguments) => arguments.json,
            Self::Shadow(arguments) => arguments.json,
            Self::Verify(arguments) => arguments.json,
            Self::Compare(arguments) => arguments.json,
            Self::Tune(arguments) => arguments.json,
            Self::Reproduce(arguments) => arguments.json,
            Self::Stress(arguments) => arguments.json,
            Self::Plugin(PluginCommand::List(arguments)) => arguments.json,
            Self::Plugin(PluginCommand::Check(arguments)) => arguments.json,
            Self::Plugin(PluginCommand::Probe { .. })
            | Self::New(_)
            | Self::Explain(_)
            | Self::Schema(_) => false,
        }
    }
}

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

/// Arguments of `verify`.
#[derive(Args, Clone, Debug)]
pub struct VerifyArguments {
    /// Measure on this scene's system, from its initial state and with its step [default: the rigid
    /// body, the periodic Lotka-Volterra system and the heavy top]
    pub scene: Option<PathBuf>,
    /// Override a value of the scene, as in --set method.epsilon=0.05
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scene")]
    pub overrides: Vec<String>,
    /// The whole library, several orders and every choice of every part: takes many minutes
    #[arg(long)]
    pub full: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// Write errors and table as a page to open in a browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// Arguments of `compare`.
#[derive(Args, Clone, Debug)]
pub struct CompareArguments {
    /// Scene to compare methods on, with its overrides.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Methods beside the standard ones: `realization:order+dynamics:order`, a stepper, or
    /// `composition/…` of one of them
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    pub with: Vec<String>,
    /// These methods alone
    #[arg(
        long,
        value_name = "METHOD,…",
        value_delimiter = ',',
        conflicts_with = "with"
    )]
    pub only: Vec<String>,
    /// Methods of these orders alone, Hamilton-Jacobi at each of them
    #[arg(
        long,
        value_name = "M,…",
        value_delimiter = ',',
        conflicts_with = "only"
    )]
    pub orders: Vec<usize>,
    /// Numbers of steps to the end time, as 100,200,400 or 100..6400 [default: from a sixteenth of the scene's number
    /// on, by factors of √2, until round-off or the budget]
    #[arg(long, value_name = "LIST", allow_negative_numbers = true)]
    pub steps: Option<String>,
    /// The end time [default: the scene's]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// The operations that one run may take [default: 1e7, or four runs of the scene's own method]
    #[arg(long, value_name = "OPERATIONS", value_parser = positive, allow_hyphen_values = true)]
    pub budget: Option<f64>,
    /// Judge errors at the end time alone, not over every step
    #[arg(long)]
    pub at_end: bool,
    /// How often each run is timed; 0 for not at all
    #[arg(
        long,
        value_name = "TIMES",
        default_value_t = 3,
        allow_negative_numbers = true
    )]
    pub repeat: usize,
    /// Show every point, not only those on a front
    #[arg(long)]
    pub all: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// Write every point as a line of numbers
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write a page with figures, these as SVG too, the table and the object into a directory
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `tune`.
#[derive(Args, Clone, Debug)]
pub struct TuneArguments {
    /// Scene to find a method for, with its overrides.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The largest error of the state over every step: its Euclidean distance from the true one
    #[arg(long, value_name = "ERROR", value_parser = positive, allow_hyphen_values = true)]
    pub error: Option<f64>,
    /// Judge the error at the end time alone
    #[arg(long)]
    pub at_end: bool,
    /// The largest deviation of the energy over every step
    #[arg(long, value_name = "DRIFT", value_parser = positive, allow_hyphen_values = true)]
    pub energy: Option<f64>,
    /// The largest deviation of every Casimir over every step
    #[arg(long, value_name = "DRIFT", value_parser = positive, allow_hyphen_values = true)]
    pub casimir: Option<f64>,
    /// The largest deviation of the shadow energy: the step of the scene's own method alone, without a reference solution
    #[arg(long, value_name = "DRIFT", value_parser = positive, allow_hyphen_values = true,
          conflicts_with_all = ["error", "at_end", "energy", "casimir", "relative", "any", "with", "only", "time", "budget",
                                "within", "write"])]
    pub shadow: Option<f64>,
    /// Take all three relative to the state's and the invariants' sizes
    #[arg(long)]
    pub relative: bool,
    /// Recommend the cheapest of all methods, not the cheapest Poisson map
    #[arg(long)]
    pub any: bool,
    /// Methods beside all that fit: `realization:order+dynamics:order`, a stepper, or
    /// `composition/…` of one of them
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    pub with: Vec<String>,
    /// These methods alone
    #[arg(
        long,
        value_name = "METHOD,…",
        value_delimiter = ',',
        conflicts_with = "with"
    )]
    pub only: Vec<String>,
    /// The end time [default: the scene's]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// The operations that one run may take [default: 5e8, or ten runs of the scene's own method]
    #[arg(long, value_name = "OPERATIONS", value_parser = positive, allow_hyphen_values = true)]
    pub budget: Option<f64>,
    /// The seconds after which no method is tried any more, forming methods included; half of them for that
    /// alone [default: until all are tried]
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    pub within: Option<f64>,
    /// Put the method into the scene file; comments and layout stay
    #[arg(long, conflicts_with = "overrides")]
    pub write: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `reproduce`.
#[derive(Args, Clone, Debug)]
pub struct ReproduceArguments {
    /// The figures, by number (1 to 9) or name [default: all]
    #[arg(value_name = "FIGURE")]
    pub figures: Vec<String>,
    /// Print the figures with what they show, and measure none
    #[arg(long)]
    pub list: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// Write every figure as SVG and CSV, the object and a page into a directory
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `stress`.
#[derive(Args, Clone, Debug)]
pub struct StressArguments {
    /// The cases, by name as family/name or by family [default: all]
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// Give the long orbits 10^8 steps, not 10^6: takes minutes
    #[arg(long)]
    pub long: bool,
    /// Print the cases with what they expect, and run none
    #[arg(long)]
    pub list: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// A positive number.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("write a positive number, such as 1e-8".to_owned()),
    }
}

/// Kinds of entries that `list` can list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// The problem library
    Systems,
    /// Geometric approximations
    Realizations,
    /// Dynamic approximations
    Dynamics,
    /// Step maps that need no realization
    Steppers,
    /// Compositions of step maps
    Compositions,
    /// Linear brackets known by name
    LieAlgebras,
}

/// Arguments of `list`.
#[derive(Args, Clone, Debug)]
pub struct ListArguments {
    /// One kind only
    pub kind: Option<Kind>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `schema`.
#[derive(Args, Debug)]
pub struct SchemaArguments {
    /// Print tables in Markdown: each key with its default, and what it does not stand beside
    #[arg(long)]
    pub markdown: bool,
}

/// Arguments of `describe`.
#[derive(Args, Clone, Debug)]
pub struct DescribeArguments {
    /// The name, as `leafwise list` prints it
    pub name: String,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `explain`.
#[derive(Args, Clone, Debug)]
pub struct ExplainArguments {
    /// The word, as in `seams`, `time-step` or `forces`; none lists the pages
    pub words: Vec<String>,
}

/// Arguments of `evaluate`.
#[derive(Args, Clone, Debug)]
pub struct EvaluateArguments {
    /// Scene to evaluate, with its overrides.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The state, as comma-separated decimals [default: the scene's initial state]
    #[arg(long, allow_hyphen_values = true, value_name = "X1,X2,…")]
    pub x: Option<String>,
    /// The momentum, as comma-separated decimals [default: zero]
    #[arg(long, allow_hyphen_values = true, value_name = "P1,P2,…")]
    pub p: Option<String>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `find`.
#[derive(Args, Clone, Debug)]
pub struct FindArguments {
    /// A scene with `equations` and `bracket = "find"`, or with a bracket whose Casimirs are looked for
    #[arg(required_unless_present = "equations", conflicts_with = "equations")]
    pub scene: Option<PathBuf>,
    /// An equation in the place of a scene, once for each variable: -e "q' = p" -e "p' = -sin(q)"
    #[arg(short, long = "equation", value_name = "X'=F")]
    pub equations: Vec<String>,
    /// The value of a parameter of these equations: -p a=0.5
    #[arg(
        short,
        long = "parameter",
        value_name = "NAME=VALUE",
        requires = "equations"
    )]
    pub parameters: Vec<String>,
    /// The degree of first integrals and Casimirs [default: 2 of Casimirs, that of the equations, 2 or 3, of integrals]
    #[arg(long, value_name = "D", value_parser = clap::value_parser!(u8).range(1..=12))]
    pub degree: Option<u8>,
    /// Write the scene with what was found to this file
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `shadow`.
#[derive(Args, Clone, Debug)]
pub struct ShadowArguments {
    /// Whose method.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The order that H~ is cut at, 2, 4, … or 8 above the method's [default: m + 2, or m + 4 where that is short]
    #[arg(long, value_name = "P")]
    pub order: Option<usize>,
    /// Steps to follow both energies over [default: the scene's, 10 000 at most]
    #[arg(long, value_name = "COUNT")]
    pub steps: Option<u64>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `new`.
#[derive(Args, Clone, Debug)]
pub struct NewArguments {
    /// The file to write [default: scene.toml, or the library system's name]
    pub file: Option<PathBuf>,
    /// Start from a system of the problem library
    #[arg(long, value_name = "ID")]
    pub library: Option<String>,
}
