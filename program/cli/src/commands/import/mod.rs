//! `leafwise import`: the magnetic field of a tokamak or a stellarator as a scene of guiding centres.
//!
//! - `g_file`: equilibria of EFIT;
//! - `boozer`: fields in Boozer coordinates, and `boozer_file` their files.

mod boozer;
mod boozer_file;
mod g_file;

use std::fs;
use std::path::{Path, PathBuf};

use leafwise::equilibrium::{EquilibriumError, Ions, Written};
use serde::Serialize;
use serde_json::Value;

use crate::arguments::ImportArguments;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files;

/// A scene, and what is said of its field.
struct Imported {
    written: Written,
    lines: Vec<String>,
    json: Value,
    warnings: Vec<String>,
}

/// The object of `import --json`.
#[derive(Serialize)]
struct ImportJson<'a> {
    outcome: &'static str,
    #[serde(flatten)]
    field: &'a Value,
    scene: &'a Path,
    warnings: &'a [String],
}

/// Reads the file of a field and writes a scene with its tables; returns the exit code.
///
/// # Errors
/// [`Failure`] when the file is no field, or the scene exists.
pub fn execute(arguments: &ImportArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    let file = &arguments.file;
    let bytes = fs::read(file).map_err(|source| Failure::File {
        action: "read",
        file: file.clone(),
        source,
    })?;
    let text = String::from_utf8_lossy(&bytes);
    let ions = Ions {
        species: arguments.species,
        energy: arguments.energy,
        pitch: arguments.pitch,
        surface: arguments.surface,
        members: arguments.members,
        seed: arguments.seed,
    };
    let source = file.file_name().unwrap_or_default().to_string_lossy();
    let imported = match text.trim_start().starts_with('{') {
        true => {
            let tables = (arguments.nodes.into(), arguments.degree);
            boozer::imported(file, &text, (&ions, tables), &source)
        }
        false => g_file::imported(&text, (&ions, arguments.degree), &source),
    };
    let imported = imported.map_err(|error| refused(file, &error))?;
    let directory = arguments.out.clone().unwrap_or_else(|| directory_of(file));
    let scene = directory.join("scene.toml");
    files::make_directory(&directory)?;
    let help = "name another directory: --out DIRECTORY";
    let written = &imported.written;
    let tables = written.files.iter();
    let tables = tables.map(|(name, content)| (directory.join(name), content.as_slice()));
    let all: Vec<(PathBuf, &[u8])> = tables
        .chain([(scene.clone(), written.scene.as_bytes())])
        .collect();
    for (file, _) in &all {
        files::refuse_existing(file, help)?;
    }
    for (file, content) in all {
        files::write_new(&file, content, help)?;
    }
    if arguments.json {
        console.json(&ImportJson {
            outcome: "written",
            field: &imported.json,
            scene: &scene,
            warnings: &imported.warnings,
        });
    } else {
        for line in &imported.lines {
            console.result(line);
        }
    }
    for warning in &imported.warnings {
        console.warn(warning);
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
        EquilibriumError::Odd(_) | EquilibriumError::Entry { .. } => {
            "`leafwise import --help` says what each option means, and `leafwise explain boozer` what a field in Boozer \
             coordinates is"
        }
        _ => "write the equilibrium again, or repair that line",
    };
    Failure::usage(format!("{}: {error}", file.display()), help)
}
