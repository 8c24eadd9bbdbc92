//! Arguments of what is listed, described, evaluated and found.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use leafwise::equilibrium::Species;

use super::SceneArguments;

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

/// The particles of a name.
fn species(name: &str) -> Result<Species, String> {
    let known = Species::ALL.into_iter().find(|kind| kind.name() == name);
    known.ok_or_else(|| {
        let names = Species::ALL.map(Species::name);
        format!("there are {}", names.join(", "))
    })
}

/// Arguments of `import`.
#[derive(Args, Clone, Debug)]
pub struct ImportArguments {
    /// A g-file of EFIT: the flux psi(R, Z) in Wb/rad, and F = R B_phi; or a field in Boozer coordinates as JSON
    pub file: PathBuf,
    /// The new directory of the scene and its tables [default: the name of the file without its ending]
    #[arg(long, value_name = "DIRECTORY")]
    pub out: Option<PathBuf>,
    /// The particles: proton, deuteron, triton, alpha or electron
    #[arg(long, default_value = "deuteron", value_parser = species, value_name = "KIND")]
    pub species: Species,
    /// The kinetic energy, in keV
    #[arg(long, default_value_t = 10.0, value_name = "KEV")]
    pub energy: f64,
    /// The speed along the field as a part of the speed, from -1 to 1, of the single particle
    #[arg(
        long,
        default_value_t = 0.5,
        allow_hyphen_values = true,
        value_name = "U/V"
    )]
    pub pitch: f64,
    /// The surface where particles start: 0 is the axis, 1 the edge
    #[arg(long, default_value_t = 0.5, value_name = "S")]
    pub surface: f64,
    /// Particles of an ensemble, uniform in a thin shell about the surface and in u/v [default: no ensemble]
    #[arg(
        long,
        default_value_t = 0,
        hide_default_value = true,
        value_name = "COUNT"
    )]
    pub members: u32,
    /// The seed of their draws
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The degree of the splines: 5 serves methods of order 4
    #[arg(long, default_value_t = 5, value_name = "K", value_parser = clap::value_parser!(u8).range(2..=9))]
    pub degree: u8,
    /// Nodes across the disk of a field in Boozer coordinates, along x and along y
    #[arg(long, default_value_t = 65, value_name = "N", value_parser = clap::value_parser!(u16).range(16..=513))]
    pub nodes: u16,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `plot`.
#[derive(Args, Clone, Debug)]
pub struct PlotArguments {
    /// Run directories, or tables of numbers as CSV: a curve each, for each of the columns --y; one directory for --map
    #[arg(required = true)]
    pub runs: Vec<PathBuf>,
    /// The column along the horizontal axis, one for all curves or one for each --y [default: the first one, the time]
    #[arg(long, value_name = "COLUMN")]
    pub x: Vec<String>,
    /// A column along the vertical axis; several times for several curves of each run
    #[arg(long, value_name = "COLUMN", required_unless_present = "map")]
    pub y: Vec<String>,
    /// Draw maps over a lattice of two or three axes: a family or component in colour, as q or s.z, or a vector s with arrows
    #[arg(long, value_name = "FIELD", conflicts_with_all = ["x", "y", "table", "x_label", "y_label", "x_scale", "y_scale", "name", "log", "angle", "equal", "points"])]
    pub map: Option<String>,
    /// Times of the maps; of each the nearest recorded state is drawn [default: up to six recorded ones]
    #[arg(
        long,
        value_name = "T",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub at: Vec<f64>,
    /// The plane of a lattice of three axes: the axis i, j or k that is cut, and the site [default: the middle of k]
    #[arg(long, value_name = "AXIS=SITE")]
    pub slice: Option<String>,
    /// The table of a run directory, as section.csv
    #[arg(long, value_name = "FILE", default_value = "samples.csv")]
    pub table: PathBuf,
    /// The label of the horizontal axis, with its unit [default: the column]
    #[arg(long, value_name = "LABEL")]
    pub x_label: Option<String>,
    /// The label of the vertical axis, with its unit [default: the columns]
    #[arg(long, value_name = "LABEL")]
    pub y_label: Option<String>,
    /// The number by which horizontal values are multiplied, for another unit
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_hyphen_values = true
    )]
    pub x_scale: f64,
    /// The number by which vertical values are multiplied, for another unit
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_hyphen_values = true
    )]
    pub y_scale: f64,
    /// The name of a curve in the legend, in the order of the runs and, within one, of --y [default: directory and column]
    #[arg(long, value_name = "NAME")]
    pub name: Vec<String>,
    /// Make a logarithmic axis of x, y or both
    #[arg(long, value_name = "AXIS")]
    pub log: Vec<AxisName>,
    /// Show angles of x, y or both modulo 2 pi, from -pi to pi
    #[arg(long, value_name = "AXIS")]
    pub angle: Vec<AxisName>,
    /// Make a unit as long along both axes
    #[arg(long)]
    pub equal: bool,
    /// Draw points, not lines
    #[arg(long)]
    pub points: bool,
    /// The new file; its ending says which: .svg or .pdf
    #[arg(long, value_name = "FILE", default_value = "plot.svg")]
    pub out: PathBuf,
    /// Replace the file where it exists
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// An axis of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AxisName {
    /// The horizontal one
    X,
    /// The vertical one
    Y,
}

/// Arguments of `learn`.
#[derive(Args, Clone, Debug)]
pub struct LearnArguments {
    /// Scene with the bracket and the time step; its Hamiltonian is not looked at.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Pairs of states: CSV with the columns x,y,x',y' or a trajectory x,y; or an array of NumPy's of the shape (N, 2, d) or (T, d)
    pub pairs: PathBuf,
    /// The degree of the basis, or one for each variable: 6, q=14,p=8 [default: the lowest that pairs which are held out do not tell from the best, up to 8]
    #[arg(long, value_name = "D")]
    pub degree: Option<String>,
    /// Functions of all variables or of one: polynomial, centred, spline, exponential, fourier, fourier:PERIOD, polynomial+ln, q=fourier [default:
    /// polynomial, with ln for a log-canonical bracket]
    #[arg(long, value_name = "[X=]FAMILY")]
    pub basis: Vec<String>,
    /// The penalty L of coefficients, relative to columns of unit length
    #[arg(long, value_name = "L", default_value_t = 0.0)]
    pub ridge: f64,
    /// A file with a weight for each pair, in place of a column `weight`
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Both states of a pair have errors of one size, and are corrected too: total least squares
    #[arg(long)]
    pub noisy: bool,
    /// Write the scene of the learned map to this file
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `tabulate`.
#[derive(Args, Clone, Debug)]
pub struct TabulateArguments {
    /// Scene whose steps are put together.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The number of steps that one step of the table is
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// The range of a variable, once for each: q=-1:1 [default: that of the scene's own orbit]
    #[arg(long = "box", value_name = "X=A:B", allow_hyphen_values = true)]
    pub bounds: Vec<String>,
    /// States in place of a box: CSV with a column for each variable, or an array of NumPy's of the shape (N, d)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["bounds", "pairs"])]
    pub states: Option<PathBuf>,
    /// The degree of the basis, or one for each variable: 6, th=14,I=8 [default: chosen by pairs that are held out, up to 8]
    #[arg(long, value_name = "D")]
    pub degree: Option<String>,
    /// Functions of all variables or of one, as in `learn` [default: centred, with ln for a log-canonical bracket]
    #[arg(long, value_name = "[X=]FAMILY")]
    pub basis: Vec<String>,
    /// The number of pairs of states [default: eight equations for each coefficient]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..))]
    pub pairs: Option<u64>,
    /// Write the scene whose step is the table to this file
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

/// Arguments of `orbit`.
#[derive(Args, Clone, Debug)]
pub struct OrbitArguments {
    /// Whose orbit: it is looked for near the initial state.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The period, about [default: the time that the scene's run takes]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    pub period: Option<f64>,
    /// Steps of a turn [default: as many as take no longer than the scene's]
    #[arg(long, value_name = "COUNT")]
    pub steps: Option<u64>,
    /// Hold the period in place of the energy
    #[arg(long)]
    pub hold_period: bool,
    /// Follow the family of the orbit to a value of `energy`, `period` or a parameter, as in --continue mu=0.1
    #[arg(long = "continue", value_name = "NAME=TO")]
    pub along: Option<String>,
    /// Follow the other family from the K-th branch point on; with -K on its other side
    #[arg(long, value_name = "K", requires = "along", allow_hyphen_values = true)]
    pub branch: Option<i64>,
    /// Orbits of the family, at most
    #[arg(long, value_name = "COUNT", default_value_t = 200, requires = "along")]
    pub orbits: usize,
    /// Write the family as a table, an object and a figure into a directory
    #[arg(long, value_name = "DIR", requires = "along")]
    pub out: Option<PathBuf>,
    /// Look for an equilibrium in the initial state's leaf in place of an orbit, with its stability
    #[arg(long, conflicts_with_all = ["period", "steps", "hold_period", "along"])]
    pub equilibrium: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `fmu`.
#[derive(Args, Clone, Debug)]
pub struct FmuArguments {
    /// Whose unit it is.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The unit's file
    #[arg(long, value_name = "NAME.fmu")]
    pub out: PathBuf,
    /// The library that steps it [default: libleafwise_c beside the program]
    #[arg(long, value_name = "FILE")]
    pub library: Option<PathBuf>,
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
