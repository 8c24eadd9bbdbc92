//! `leafwise find`: the bracket and the Hamiltonian of equations of motion, the Casimirs of a bracket.
use std::path::Path;

use leafwise::find::{
    Equations, FindError, FoundBracket, Kind, Options, Report, corank, find, named_casimirs_of,
};
use leafwise::scene::compose::compose;
use leafwise::scene::json::object;
use leafwise::scene::{equations_of, with_casimirs, with_system};
use serde::Serialize;

use crate::arguments::{FindArguments, PluginArguments, SceneArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files;
use crate::plugins::Parts;
use crate::scene::read;
use crate::table::{labelled, words};

/// The next step where there is no bracket.
const NEXT: &str = "Next: find the bracket of the equations without friction and drive, then add these as `damping` or `forces` (leafwise explain forces).";

/// The next step where only H is missing.
const NEXT_HAMILTONIAN: &str = "Next: a bracket fits these equations, and only a formula of H is missing: write it in a scene with `bracket` and `hamiltonian`, and let `leafwise check` print its motion.";

/// The degree of Casimirs where none is asked for.
const CASIMIR_DEGREE: usize = 2;

/// The tables that stand below equations of the command line.
const DEFAULT_RUN: &str =
    "\n[method]\nrealization = \"auto\"\ndynamics    = \"auto\"\ntime-step   = 0.05\n";

/// The object of `find --json` for equations.
#[derive(Serialize)]
struct FindJson {
    outcome: &'static str,
    kind: Option<&'static str>,
    #[serde(serialize_with = "object")]
    bracket: Vec<(String, String)>,
    hamiltonian: Option<String>,
    #[serde(serialize_with = "object")]
    casimirs: Vec<(String, String)>,
    /// The dimension of the linear family that the tensor was chosen in.
    family: Option<usize>,
    /// Whether parameters are held as names.
    has_parameters: bool,
    integrals: Vec<String>,
    degree: usize,
    refused: Vec<RefusedJson>,
    /// Equilibrium near which no bracket of any kind exists.
    never: Option<String>,
    /// The `[system]` table.
    system: Option<String>,
}

/// A kind without a bracket.
#[derive(Serialize)]
struct RefusedJson {
    kind: &'static str,
    reason: String,
    is_proved: bool,
}

/// The object of `find --json` for a scene that has a bracket.
#[derive(Serialize)]
struct CasimirsJson {
    outcome: &'static str,
    degree: usize,
    #[serde(serialize_with = "object")]
    casimirs: Vec<(String, String)>,
}

/// Looks for a bracket and prints it; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene or an equation is not valid.
pub fn execute(
    arguments: &FindArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let scene = match &arguments.scene {
        Some(scene) => read(&SceneArguments {
            scene: scene.clone(),
            overrides: Vec::new(),
        })
        .map(|scene| (scene.name, scene.text))?,
        None => ("the command line".to_owned(), written_scene(arguments)?),
    };
    let (name, text) = scene;
    let equations =
        equations_of(&name, &text).map_err(|errors| Failure::Scene(errors.diagnostics()))?;
    let shown = console.shown(false);
    let Some(equations) = equations else {
        return casimirs(arguments, &text, plugins, console);
    };
    let options = Options {
        degree: arguments.degree.map(usize::from),
    };
    let report = while_building(shown, || find(&equations, options)).map_err(refused)?;
    if arguments.json {
        console.json(&json(&equations, &report));
    } else {
        for line in lines(&equations, &report) {
            console.result(&line);
        }
    }
    let Some(bracket) = &report.bracket else {
        return Ok(exit::CHECK_FAILED);
    };
    if let Some(file) = &arguments.out {
        let text = match &arguments.scene {
            Some(_) => with_system(&text, &bracket.fragment()).map_err(|error| {
                Failure::usage(error.to_string(), "name a scene with a [system] table")
            })?,
            None => format!(
                "{}{DEFAULT_RUN}{}",
                bracket.fragment(),
                run_table(&equations)
            ),
        };
        write_scene(file, &text, console)?;
    }
    Ok(exit::DONE)
}

/// Writes a scene to a new file, and says how it is used.
pub(super) fn write_scene(
    file: &Path,
    text: &str,
    console: &mut Console<'_>,
) -> Result<(), Failure> {
    files::write_new(file, text, "name another file: --out NAME.toml")?;
    console.prose(&format!(
        "wrote {0}; `leafwise check {0}` prints its motion, `leafwise run {0}` integrates it",
        file.display()
    ));
    Ok(())
}

fn refused(error: FindError) -> Failure {
    Failure::usage(
        error.to_string(),
        "write equations in numbers, variables and elementary functions; --degree makes the search for integrals smaller",
    )
}

/// A scene's `[system]` table with the equations of the command line.
fn written_scene(arguments: &FindArguments) -> Result<String, Failure> {
    let mut rows = Vec::new();
    for equation in &arguments.equations {
        let Some((name, formula)) = equation.split_once('=') else {
            return Err(Failure::usage(
                format!("the equation `{equation}` has no `=`"),
                "write -e \"q' = p\"",
            ));
        };
        let name = name.trim();
        let name = name.strip_suffix('\'').unwrap_or(name);
        rows.push(format!("{} = {}\n", string(name), string(formula.trim())));
    }
    let mut parameters = Vec::new();
    for parameter in &arguments.parameters {
        let Some((name, value)) = parameter.split_once('=') else {
            return Err(Failure::usage(
                format!("the parameter `{parameter}` has no `=`"),
                "write -p a=0.5",
            ));
        };
        parameters.push(format!("{} = {}", string(name.trim()), value.trim()));
    }
    Ok(format!(
        "[system]\nparameters = {{ {} }}\nbracket = \"find\"\n[system.equations]\n{}",
        parameters.join(", "),
        rows.concat()
    ))
}

/// A string of TOML.
fn string(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// A state of no special value to start from.
fn run_table(equations: &Equations) -> String {
    let count = equations.variables().len();
    let initial = (0..count).map(|i| format!("{}.{}", i % 2, 9 - 2 * (i % 4)));
    format!(
        "\n[run]\ninitial = [{}]\nsteps   = 1000\n",
        initial.collect::<Vec<_>>().join(", ")
    )
}

/// The Casimirs of a scene's bracket.
fn casimirs(
    arguments: &FindArguments,
    text: &str,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let Some(scene) = arguments.scene.clone() else {
        return Ok(exit::USAGE);
    };
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&SceneArguments {
        scene,
        overrides: Vec::new(),
    })?;
    let shown = console.shown(false);
    let composed = while_building(shown, || compose(&document, &parts.registry))?;
    if composed.contact.is_some() {
        return Err(Failure::usage(
            "a contact bracket is not a Poisson bracket, and has no Casimirs",
            "leafwise find -e \"q' = p\" -e \"p' = -q - 0.2*p\" looks for constants of the motion",
        ));
    }
    let system = composed.system.formulas("the search for Casimirs")?;
    let degree = arguments.degree.map_or(CASIMIR_DEGREE, usize::from);
    let rows = while_building(shown, || named_casimirs_of(system, degree)).map_err(refused)?;
    if arguments.json {
        console.json(&CasimirsJson {
            outcome: if rows.is_empty() { "none" } else { "found" },
            degree,
            casimirs: rows.clone(),
        });
    } else if rows.is_empty() {
        console.result(&match corank(system) {
            0 => "The tensor has full rank: only constants commute with all functions".to_owned(),
            _ => format!("No Casimir of degree {degree} or less in the variables"),
        });
    } else {
        let rows: Vec<Vec<String>> = (rows.iter())
            .map(|(name, formula)| vec![format!("  Casimir {name}"), format!("= {formula}")])
            .collect();
        for line in words(&rows) {
            console.result(&line);
        }
    }
    if let Some(file) = arguments.out.as_ref().filter(|_| !rows.is_empty()) {
        let text = with_casimirs(text, &rows).map_err(|error| {
            Failure::usage(error.to_string(), "name a scene with a [system] table")
        })?;
        write_scene(file, &text, console)?;
    }
    Ok(exit::DONE)
}

fn json(equations: &Equations, report: &Report) -> FindJson {
    let bracket = report.bracket.as_ref();
    let refused = report.refused.iter();
    FindJson {
        outcome: if bracket.is_some() { "found" } else { "none" },
        kind: bracket.map(|bracket| bracket.kind.name()),
        bracket: bracket.map_or_else(Vec::new, |bracket| {
            let rows = bracket.rows().into_iter();
            rows.map(|([x, y], entry)| (format!("{x},{y}"), entry))
                .collect()
        }),
        hamiltonian: bracket.map(|bracket| bracket.written(&bracket.hamiltonian)),
        casimirs: bracket.map_or_else(Vec::new, |bracket| {
            let casimirs = bracket.named_casimirs().into_iter();
            casimirs
                .map(|(name, formula)| (name.to_owned(), formula))
                .collect()
        }),
        family: bracket.map(|bracket| bracket.family),
        has_parameters: bracket.is_some_and(|bracket| bracket.has_parameters),
        integrals: integrals(equations, report),
        degree: report.degree,
        refused: refused
            .map(|refused| RefusedJson {
                kind: refused.kind.name(),
                reason: refused.reason.clone(),
                is_proved: refused.is_proved,
            })
            .collect(),
        never: report.never.clone(),
        system: bracket.map(FoundBracket::fragment),
    }
}

fn integrals(equations: &Equations, report: &Report) -> Vec<String> {
    let written = report
        .integrals
        .iter()
        .map(|f| f.written(equations.variables(), &[]));
    written.collect()
}

fn lines(equations: &Equations, report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    match &report.bracket {
        Some(bracket) => {
            lines.push(format!(
                "{} bracket with x' = {{x, H}}: Jacobi's identity and the equations hold exactly",
                title(bracket.kind)
            ));
            lines.push(String::new());
            let row = |left: String, right: String| vec![format!("  {left}"), format!("= {right}")];
            let mut rows: Vec<Vec<String>> = (bracket.rows().into_iter())
                .map(|([x, y], entry)| row(format!("{{{x}, {y}}}"), entry))
                .collect();
            rows.push(row("H".to_owned(), bracket.written(&bracket.hamiltonian)));
            for (name, formula) in bracket.named_casimirs() {
                rows.push(row(format!("Casimir {name}"), formula));
            }
            lines.extend(words(&rows));
            lines.push(String::new());
            lines.push(others(bracket));
            if !bracket.has_parameters && !equations.parameters().is_empty() {
                lines.push("The parameters are replaced by their numbers.".to_owned());
            }
        }
        None => lines.push(match &report.never {
            Some(_) => "No bracket near an equilibrium".to_owned(),
            None => "No bracket of these kinds".to_owned(),
        }),
    }
    if !report.refused.is_empty() {
        lines.push(String::new());
    }
    let reasons: Vec<(String, String)> = (report.refused.iter())
        .map(|refused| {
            let word = if refused.is_proved {
                "none exists"
            } else {
                "none found"
            };
            (
                refused.kind.name().to_owned(),
                format!("{word}: {}", refused.reason),
            )
        })
        .collect();
    let mut texts: Vec<(&str, &str)> = (reasons.iter())
        .map(|(kind, reason)| (kind.as_str(), reason.as_str()))
        .collect();
    if let Some(never) = &report.never {
        texts.push(("of any kind", never));
    }
    lines.extend(labelled(&texts));
    if report.bracket.is_none() {
        lines.push(String::new());
        let lacks_hamiltonian = report.refused.iter().any(|kind| kind.lacks_hamiltonian);
        let next = if lacks_hamiltonian {
            NEXT_HAMILTONIAN
        } else {
            NEXT
        };
        lines.push(next.to_owned());
    }
    let integrals = integrals(equations, report);
    if report.bracket.is_none() && !integrals.is_empty() {
        lines.push(String::new());
        lines.push(format!(
            "First integrals of degree {} or less:",
            report.degree
        ));
        lines.extend(
            integrals
                .into_iter()
                .map(|integral| format!("  {integral}")),
        );
    }
    lines
}

fn title(kind: Kind) -> &'static str {
    match kind {
        Kind::LogCanonical => "Log-canonical",
        Kind::Affine => "Affine",
        Kind::FirstIntegrals => "First integrals give a",
        _ => "Constant",
    }
}

/// How many other brackets there are.
fn others(bracket: &FoundBracket) -> String {
    match (bracket.kind, bracket.family) {
        (Kind::FirstIntegrals, _) => {
            "Any function of the first integrals can replace H or the Casimir.".to_owned()
        }
        (Kind::Affine, 1) => {
            "The motion preserves no other affine tensor, except multiples of this one.".to_owned()
        }
        (Kind::Affine, family) => format!(
            "One of a linear family of dimension {family} that the motion preserves: the sparsest one tried that satisfies Jacobi's identity."
        ),
        (_, family) => format!(
            "One of a linear family of dimension {family}, whose inverses give brackets: the sparsest that was tried."
        ),
    }
}
