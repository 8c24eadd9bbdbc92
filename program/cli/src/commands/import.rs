//! `leafwise import`: a tokamak's equilibrium as a scene of guiding centres.

use std::fs;
use std::path::{Path, PathBuf};

use leafwise::equilibrium::{Equilibrium, EquilibriumError, Geqdsk, Ions, written};
use leafwise::scene::json::optional;
use serde::Serialize;

use crate::arguments::ImportArguments;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files;
use crate::table::words;

/// Surfaces whose safety factor is printed, by their normalized flux.
const SURFACES: [f64; 4] = [0.0, 0.25, 0.5, 0.95];

/// The object of `import --json`.
#[derive(Serialize)]
struct ImportJson<'a> {
    outcome: &'static str,
    title: &'a str,
    nodes: [usize; 2],
    axis: [f64; 2],
    field_on_axis: [f64; 3],
    safety_factors: Vec<SafetyFactor>,
    /// Whether the edge is closed inside the grid.
    has_edge: bool,
    /// Where the table of F is smeared: the normalized flux, and the part of F's variation by which it is off.
    smeared: Option<[f64; 2]>,
    scene: &'a Path,
}

/// The safety factor of a surface.
#[derive(Serialize)]
struct SafetyFactor {
    /// The normalized flux.
    s: f64,
    /// From the field; null where the surface is not closed within the grid.
    #[serde(serialize_with = "optional")]
    q: Option<f64>,
    /// As the file has it.
    #[serde(serialize_with = "optional")]
    in_file: Option<f64>,
}

/// Reads a g-file and writes a scene with its tables; returns the exit code.
///
/// # Errors
/// [`Failure`] when the file is no equilibrium, or the scene exists.
pub fn execute(arguments: &ImportArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    let file = &arguments.file;
    let bytes = fs::read(file).map_err(|source| Failure::File {
        action: "read",
        file: file.clone(),
        source,
    })?;
    let text = String::from_utf8_lossy(&bytes);
    let refused = |error: EquilibriumError| refused(file, &error);
    let equilibrium = Geqdsk::parse(&text)
        .and_then(|read| Equilibrium::new(read, arguments.degree))
        .map_err(refused)?;
    let ions = Ions {
        species: arguments.species,
        energy: arguments.energy,
        pitch: arguments.pitch,
        surface: arguments.surface,
        members: arguments.members,
        seed: arguments.seed,
    };
    let source = file.file_name().unwrap_or_default().to_string_lossy();
    let written = written(&equilibrium, &ions, &source).map_err(refused)?;
    let directory = arguments.out.clone().unwrap_or_else(|| directory_of(file));
    let scene = directory.join("scene.toml");
    files::make_directory(&directory)?;
    let help = "name another directory: --out DIRECTORY";
    let tables = written.files.iter();
    let tables = tables.map(|(name, text)| (directory.join(name), text));
    let all: Vec<(PathBuf, &String)> = tables.chain([(scene.clone(), &written.scene)]).collect();
    for (file, _) in &all {
        files::refuse_existing(file, help)?;
    }
    for (file, text) in all {
        files::write_new(&file, text, help)?;
    }
    let (factors, smeared) = (safety_factors(&equilibrium), equilibrium.smeared());
    if arguments.json {
        console.json(&ImportJson {
            outcome: "written",
            title: &equilibrium.file().title,
            nodes: equilibrium.file().nodes,
            axis: equilibrium.axis(),
            field_on_axis: equilibrium.field(equilibrium.axis()),
            safety_factors: factors,
            has_edge: equilibrium.has_edge(),
            smeared: smeared.map(|smeared| [smeared.surface, smeared.part]),
            scene: &scene,
        });
    } else {
        for line in lines(&equilibrium, &factors) {
            console.result(&line);
        }
    }
    if !equilibrium.has_edge() {
        console.warn(
            "the edge, s = 1, is not closed inside the grid: particles leave the tables before they are lost\n  = change: \
             write the equilibrium on a larger grid",
        );
    }
    if let Some(smeared) = smeared {
        console.warn(&format!(
            "F = R B_phi changes within a few cells of the grid: its table is off by {:.0} % of its variation at s = {:.3}\n  = change: \
             write the equilibrium on a finer grid",
            100.0 * smeared.part,
            smeared.surface
        ));
    }
    console.prose(&format!(
        "wrote {0} and its tables; `leafwise run {0}` follows one ion{1}",
        scene.display(),
        match arguments.members {
            0 => String::new(),
            count => format!(", `leafwise ensemble {}` {count} of them", scene.display()),
        }
    ));
    Ok(exit::DONE)
}

/// The file's name without its ending, unless a file or directory has that name.
fn directory_of(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default();
    let plain = PathBuf::from(stem);
    let mut other = stem.to_owned();
    other.push("-scene");
    if plain.is_file() { other.into() } else { plain }
}

fn refused(file: &Path, error: &EquilibriumError) -> Failure {
    let help = match error {
        EquilibriumError::Table { .. } => {
            "a spline of degree k has more than k nodes along each axis: take a smaller --degree"
        }
        EquilibriumError::Open { .. } => "take a surface nearer to the axis: --surface 0.5",
        EquilibriumError::Odd(_) => "`leafwise import --help` says what each option means",
        _ => "write the equilibrium anew, or repair that line",
    };
    Failure::usage(format!("{}: {error}", file.display()), help)
}

fn safety_factors(equilibrium: &Equilibrium) -> Vec<SafetyFactor> {
    let told = &equilibrium.file().q;
    let of = |s: f64| SafetyFactor {
        s,
        q: equilibrium.safety_factor(s).ok().filter(|q| q.is_finite()),
        in_file: (!told.is_empty()).then(|| {
            let place = s * (told.len() - 1) as f64;
            let below = (place as usize).min(told.len() - 2);
            told[below] + (place - below as f64) * (told[below + 1] - told[below])
        }),
    };
    SURFACES.map(of).into()
}

fn lines(equilibrium: &Equilibrium, factors: &[SafetyFactor]) -> Vec<String> {
    let file = equilibrium.file();
    let ([left, right], [low, high]) = (file.r, file.z);
    let [along_r, along_z] = file.nodes;
    let [r, z] = equilibrium.axis().map(without_dust);
    let [b_r, b_z, b_phi] = equilibrium.field(equilibrium.axis());
    let strength = equilibrium.strength(equilibrium.axis());
    let [axis, edge] = file.psi_range;
    let row = |name: &str, text: String| vec![name.to_owned(), text];
    let mut rows = vec![
        row(
            "grid",
            format!(
                "{along_r} × {along_z} nodes, R from {left} to {right} m, Z from {low} to {high} m"
            ),
        ),
        row(
            "axis",
            format!(
                "R = {r:.6} m, Z = {z:.6} m; the file tells {:.6}, {:.6}",
                file.axis[0], file.axis[1]
            ),
        ),
        row(
            "field there",
            format!(
                "|B| = {strength:.6} T: B_R = {b_r:.1e}, B_Z = {b_z:.1e}, B_phi = {b_phi:.6}, positive where phi grows"
            ),
        ),
        row(
            "flux",
            format!(
                "psi = {axis} on the axis, {edge} at the edge, in Wb/rad; B_R = -(dpsi/dZ)/R, B_Z = (dpsi/dR)/R"
            ),
        ),
    ];
    for (at, factor) in factors.iter().enumerate() {
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
        let name = if at == 0 { "safety factor" } else { "" };
        rows.push(row(
            name,
            format!(
                "s = {:<4}  q = {}; the file tells {}",
                factor.s,
                number(factor.q),
                number(factor.in_file)
            ),
        ));
    }
    words(&rows)
}

/// A length with what is below a tenth of a micrometre as 0, which is not printed as -0.
fn without_dust(length: f64) -> f64 {
    if length.abs() < 1e-7 { 0.0 } else { length }
}
