//! `leafwise orbit --equilibrium`: an equilibrium in the initial state's leaf, and its stability.

use leafwise::orbit::{Complex, Rest, RestError, Verdict, rest};
use leafwise::scene::compose::ComposedRun;
use leafwise::scene::json::object;
use serde::Serialize;

use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::table::words;

/// The part of a number that is not printed.
const ROUND_OFF: f64 = 1e-13;

/// The object of `orbit --equilibrium --json`.
#[derive(Serialize)]
struct RestJson {
    #[serde(serialize_with = "object")]
    state: Vec<(String, f64)>,
    /// `alone`, `stable`, `spectrally-stable`, `unstable` or `undecided`.
    stability: &'static str,
    energy: f64,
    #[serde(serialize_with = "object")]
    casimirs: Vec<(String, f64)>,
    /// λ with ∇H = Σ λ_c ∇C_c.
    multiples: Option<Vec<f64>>,
    speed: f64,
    corrections: usize,
    /// The leaf's dimension.
    leaf: usize,
    /// The real and the imaginary part of each.
    eigenvalues: Vec<[f64; 2]>,
    curvatures: Vec<f64>,
}

/// Finds the equilibrium and prints it. Returns the exit code.
///
/// # Errors
/// [`Failure`] where there is none near the initial state.
pub(super) fn execute(
    run: &ComposedRun,
    is_json: bool,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let found = rest(run).map_err(refused)?;
    let names = run.names();
    let casimirs = run.system.casimir_names();
    if is_json {
        let casimirs = casimirs.iter().map(|name| (*name).to_owned());
        let eigenvalues = found.eigenvalues.iter();
        console.json(&RestJson {
            stability: verdict(found.verdict).0,
            energy: found.energy,
            speed: found.speed,
            corrections: found.iterations,
            leaf: found.leaf,
            eigenvalues: eigenvalues.map(|of| [of.re, of.im]).collect(),
            curvatures: found.curvatures,
            multiples: found.multiples,
            casimirs: casimirs.zip(found.casimirs).collect(),
            state: names.into_iter().zip(found.state).collect(),
        });
        return Ok(exit::DONE);
    }
    console.result("An equilibrium in the leaf of the initial state");
    console.result("");
    for line in words(&rows(&found, &names, &casimirs)) {
        console.result(&line);
    }
    Ok(exit::DONE)
}

fn rows(found: &Rest, names: &[String], casimirs: &[&str]) -> Vec<Vec<String>> {
    let row = |label: &str, text: String| vec![format!("  {label}"), text];
    let state = names.iter().zip(&found.state);
    let state: Vec<String> = state.map(|(name, x)| format!("{name} = {x:?}")).collect();
    let mut rows = vec![
        row("state", state.join(", ")),
        row(
            "rests to",
            format!(
                "{:.1e}, after {} corrections",
                found.speed, found.iterations
            ),
        ),
        row("energy", format!("{:?}", found.energy)),
        row("stability", verdict(found.verdict).1.to_owned()),
        row("leaf", format!("of dimension {}", found.leaf)),
    ];
    let multiples = found.multiples.iter().flatten();
    for (name, multiple) in casimirs.iter().zip(multiples) {
        rows.push(row("multiple", format!("{multiple:?} of {name}")));
    }
    for eigenvalue in &found.eigenvalues {
        rows.push(row("eigenvalue", written(*eigenvalue)));
    }
    let curvatures = found.curvatures.iter().map(|own| format!("{own:.12}"));
    let curvatures: Vec<String> = curvatures.collect();
    rows.push(row("curvatures", curvatures.join(", ")));
    rows
}

/// A number without the part that is round-off.
fn written(number: Complex) -> String {
    let least = ROUND_OFF * number.modulus();
    match (number.re.abs() <= least, number.im.abs() <= least) {
        (_, true) => format!("{:.12}", number.re),
        (true, false) => format!("{:.12}i", number.im),
        (false, false) => format!("{:.12} {:+.12}i", number.re, number.im),
    }
}

/// A word, and a sentence.
fn verdict(verdict: Verdict) -> (&'static str, &'static str) {
    match verdict {
        Verdict::Alone => ("alone", "its leaf is this point alone"),
        Verdict::Stable => (
            "stable",
            "stable: in its leaf the energy is a strict minimum or maximum here",
        ),
        Verdict::SpectrallyStable => (
            "spectrally-stable",
            "spectrally stable: no neighbour diverges exponentially; the energy is not a strict extremum, and does not decide",
        ),
        Verdict::Unstable => ("unstable", "unstable: neighbours diverge exponentially"),
        Verdict::Undecided => (
            "undecided",
            "undecided: round-off of eigenvalues near 0 hides whether their real parts are 0",
        ),
    }
}

fn refused(error: RestError) -> Failure {
    let help = match &error {
        RestError::NotOffered { help, .. } => help.as_ref(),
        RestError::Build(_) | RestError::NoEigenvalues(_) => {
            "equilibria need derivatives of the tensor and of H"
        }
        _ => "begin nearer to the equilibrium, in its leaf",
    };
    Failure::usage(error.to_string(), help)
}
