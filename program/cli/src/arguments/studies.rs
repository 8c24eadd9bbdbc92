//! Arguments of studies: what methods do, cost and find.

use std::path::PathBuf;

use clap::Args;

use super::SceneArguments;
use super::jobs::positive;

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
