//! The command line.

mod jobs;
mod questions;
mod studies;

pub use jobs::{
    CheckArguments, EnsembleArguments, MergeArguments, OutputArguments, RunArguments,
    SceneArguments, SweepArguments,
};
pub use questions::{
    AxisName, DescribeArguments, EvaluateArguments, ExplainArguments, FindArguments, FmuArguments,
    ImportArguments, Kind, LearnArguments, ListArguments, NewArguments, OrbitArguments,
    PlotArguments, SchemaArguments, ShadowArguments, TabulateArguments,
};
pub use studies::{
    CompareArguments, ReproduceArguments, StressArguments, TuneArguments, VerifyArguments,
};

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use leafwise::expression::Execution;

/// Exit codes, for the help text.
const CODES: &str = "Exit codes: 0 done, 1 the run failed, 2 usage, 3 invalid scene, 4 a plugin \
                     was refused, 5 a check failed, \
                     6 some members or settings failed, 130 interrupted with a checkpoint written.";

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
    /// Write a scene of guiding centres in a tokamak's equilibrium, from a g-file
    Import(ImportArguments),
    /// Draw columns of one or more runs as a figure for a paper, SVG or PDF
    Plot(PlotArguments),
    /// Learn a Poisson map and its Hamiltonian from pairs of states one step apart
    Learn(LearnArguments),
    /// Put many steps of a scene together into one: a table that is exactly as Poisson
    Tabulate(TabulateArguments),
    /// Print the shadow Hamiltonian of a scene's method, and how well it is kept
    Shadow(ShadowArguments),
    /// Close a periodic orbit near a scene's initial state, with its period, multipliers and stability
    Orbit(OrbitArguments),
    /// Write a scene as a functional mock-up unit, FMI 3.0 for co-simulation
    Fmu(FmuArguments),
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
            Self::Import(arguments) => arguments.json,
            Self::Plot(arguments) => arguments.json,
            Self::Learn(arguments) => arguments.json,
            Self::Tabulate(arguments) => arguments.json,
            Self::Shadow(arguments) => arguments.json,
            Self::Orbit(arguments) => arguments.json,
            Self::Fmu(arguments) => arguments.json,
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
