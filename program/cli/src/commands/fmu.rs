//! `leafwise fmu`: a scene as a functional mock-up unit, FMI 3.0 for co-simulation.

use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::fs;
use std::path::{Path, PathBuf};

use leafwise::scene::SceneDocument;
use leafwise::scene::compose::{ComposedRun, compose};
use serde::Serialize;

use super::check::refuse_no_system;
use crate::arguments::{FmuArguments, PluginArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::{refuse_existing, write_new};
use crate::fmu::{Archive, IDENTIFIER, SCENE, description, token, variables};
use crate::plugins::Parts;
use crate::scene::SceneText;

/// The remedy where a file exists.
const OTHER: &str = "name another file: --out NAME.fmu";

/// The object of `fmu --json`.
#[derive(Serialize)]
struct FmuJson<'a> {
    file: &'a Path,
    /// The library within.
    library: &'a Path,
    platform: String,
    token: String,
    /// The time of a step: communication steps are multiples of it.
    time_step: f64,
    /// Names of the variables, in their numbers' order.
    variables: Vec<String>,
}

/// Writes the unit; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, is no unit's, or the library is not found.
pub fn execute(
    arguments: &FmuArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let out = &arguments.out;
    refuse_existing(out, OTHER)?;
    let library = match &arguments.library {
        Some(library) => library.clone(),
        None => beside_the_program()?,
    };
    let binary = fs::read(&library).map_err(|source| Failure::File {
        action: "read",
        file: library.clone(),
        source,
    })?;
    let platform = platform()?;
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    while_building(shown, || {
        refuse_no_system(&document, &run.system, &run.near)
    })?;
    refuse(&run)?;
    let text = alone(&document)?;
    let step = run.plan.epsilon * run.plan.h;
    let own = variables(&run);
    let name = out.file_stem().unwrap_or_default().to_string_lossy();
    let stop = run.plan.until.unwrap_or(step * run.plan.steps as f64);
    let token = token(&text);
    let described = description((&name, &token), (step, stop), &own);
    let within = format!("binaries/{platform}/{IDENTIFIER}{DLL_SUFFIX}");
    let archive = Archive::default().with("modelDescription.xml", described.as_bytes());
    let archive = archive.and_then(|archive| archive.with(&within, &binary));
    let archive =
        archive.and_then(|archive| archive.with(&format!("resources/{SCENE}"), text.as_bytes()));
    let archive = archive.ok_or_else(|| {
        Failure::usage(
            "the unit would be larger than 4 GiB",
            "give a smaller --library",
        )
    })?;
    write_new(out, archive.finish(), OTHER)?;
    if arguments.json {
        console.json(&FmuJson {
            file: out,
            library: &library,
            platform,
            token,
            time_step: step,
            variables: own.into_iter().map(|variable| variable.name).collect(),
        });
    } else {
        console.prose(&format!(
            "wrote {}, FMI 3.0 for co-simulation on {platform}: {} variables, communication steps are multiples of {step:?}",
            out.display(),
            own.len()
        ));
    }
    Ok(exit::DONE)
}

/// The library in the folder of the program.
fn beside_the_program() -> Result<PathBuf, Failure> {
    let name = format!("{DLL_PREFIX}{IDENTIFIER}{DLL_SUFFIX}");
    let program = std::env::current_exe().unwrap_or_default();
    let library = program.with_file_name(&name);
    if library.is_file() {
        return Ok(library);
    }
    Err(Failure::usage(
        format!(
            "there is no {name} in the program's folder, {}",
            program.with_file_name("").display()
        ),
        "build it by `cargo build --release -p leafwise-c`, or name it: --library FILE",
    ))
}

/// The name that FMI 3.0 gives this platform.
fn platform() -> Result<String, Failure> {
    let system = match OS {
        "linux" | "windows" => OS,
        "macos" => "darwin",
        other => {
            return Err(Failure::usage(
                format!("FMI 3.0 has no name for the platform {other}"),
                "make the unit on Linux, macOS or Windows",
            ));
        }
    };
    Ok(format!("{ARCH}-{system}"))
}

/// Refuses what has no equal steps of the time from a state.
fn refuse(run: &ComposedRun) -> Result<(), Failure> {
    let help = "leave it out of the scene";
    let equal = run.has_equal_steps();
    equal.map_err(|uneven| Failure::usage(uneven.to_string(), help))?;
    if run.is_extended() {
        return Err(Failure::usage(
            "a unit needs a system whose H does not name the time, without parameters of sites and contact brackets",
            "make one of a system without them",
        ));
    }
    Ok(())
}

/// The text, which must say all: neither files nor plugins are in a unit.
fn alone(document: &SceneDocument) -> Result<String, Failure> {
    let files = document.files();
    if !files.is_empty() {
        return Err(Failure::usage(
            format!(
                "a unit holds only the text of its scene, and this one reads {}",
                files.join(", ")
            ),
            "write what its files hold as formulas",
        ));
    }
    let text = document.text.clone();
    let mut parts = Parts::new(&PluginArguments {
        no_plugins: true,
        ..PluginArguments::default()
    })?;
    let folder = Path::new("resources-of-a-unit");
    let scene = SceneText {
        name: folder.join(SCENE).display().to_string(),
        text: text.clone(),
        overrides: Vec::new(),
    };
    let composed = parts.document(scene, folder).ok();
    let composed = composed.and_then(|document| compose(&document, &parts.registry).ok());
    if composed.is_none() {
        return Err(Failure::usage(
            "a unit holds only the text of its scene, and this one takes parts of plugins",
            "take a method of built-in parts: leafwise list --no-plugins",
        ));
    }
    Ok(text)
}
