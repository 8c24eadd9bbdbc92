//! `leafwise check`: is the tensor Poisson, are the Casimirs Casimirs?

use leafwise::core::diagnostics::{IdentityCheck, Verdict};
use leafwise::core::system::TensorSource;
use leafwise::core::{PoissonSystem, SystemFormulas};
use leafwise::run::Advice;
use leafwise::run::advice::{JudgedStates, about_the_scene, advise, states_ahead};
use leafwise::scene::SceneDocument;
use leafwise::scene::compose::{Motion, SceneChecks, compose};
use leafwise::scene::json::{Double, doubles, object};
use serde::Serialize;

use super::motion;
use super::run::print_advice;
use crate::arguments::{CheckArguments, PluginArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// The object of `check --json`.
#[derive(Serialize)]
struct CheckJson<'a> {
    outcome: &'static str,
    jacobi: Identity<'a>,
    #[serde(serialize_with = "object")]
    casimirs: Vec<(&'a str, Identity<'a>)>,
    motion: Option<motion::MotionJson>,
    /// How the energy changes where it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    work: Option<String>,
    /// The field of each channel of noise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    noise: Vec<Noise>,
    warnings: &'a [Advice],
}

/// A channel and its field.
#[derive(Serialize)]
struct Noise {
    hamiltonian: String,
    field: motion::MotionJson,
}

/// A check with the names of its worst coordinates.
#[derive(Serialize)]
struct Identity<'a> {
    verdict: Verdict,
    residual: Double,
    floor: Option<Double>,
    worst: Vec<&'a str>,
    #[serde(serialize_with = "doubles")]
    at: &'a [f64],
}

impl<'a> Identity<'a> {
    fn of(check: &'a IdentityCheck, names: &'a [String]) -> Self {
        Self {
            verdict: check.verdict,
            residual: Double(check.residual),
            floor: check.floor.map(Double),
            worst: worst(check, names),
            at: &check.at,
        }
    }
}

/// Checks the scene; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid.
pub fn execute(
    arguments: &CheckArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    let composed = while_building(shown, || compose(&document, &parts.registry))?;
    let names = composed.system.variables();
    let checks = while_building(shown, || SceneChecks::of(&composed.system, &composed.near))?;
    let jacobi = describe(&checks.jacobi, "triple", names);
    let source = composed.system.expressions().map(SystemFormulas::source);
    let jacobi = match (checks.jacobi.verdict, source.map(made_of)) {
        (Verdict::ByConstruction | Verdict::NumericallyZero, Some(Some(reason))) => {
            format!("{jacobi}: {reason}")
        }
        _ => jacobi,
    };
    let mut rows = vec![vec!["  Jacobi identity".to_owned(), jacobi]];
    for (at, casimir) in checks.casimirs.iter().enumerate() {
        let formulas = composed.system.expressions();
        let formula = formulas.and_then(|formulas| formulas.casimirs().get(at));
        let pieces = match formula.is_some_and(|own| own.expression.may_jump()) {
            true => ", on each of its pieces, but not across their jumps",
            false => "",
        };
        let text = describe(&casimir.check, "coordinate", names);
        rows.push(vec![
            format!("  Casimir {}", casimir.name),
            format!("{text}{pieces}"),
        ]);
    }
    if let Some(text) = composed.work_of_forces() {
        rows.push(vec!["  Energy".to_owned(), text]);
    }
    let mut advice = about_the_scene(&document, &composed);
    if checks.pass() {
        let states = states_ahead(&composed);
        advice.extend(advise(
            &composed,
            &parts.registry,
            (&states, JudgedStates::Ahead),
        ));
    }
    if arguments.json {
        let casimirs = checks.casimirs.iter();
        console.json(&CheckJson {
            outcome: if checks.pass() { "passed" } else { "violated" },
            jacobi: Identity::of(&checks.jacobi, names),
            casimirs: casimirs
                .map(|casimir| (casimir.name.as_str(), Identity::of(&casimir.check, names)))
                .collect(),
            motion: Motion::of(&composed).map(motion::MotionJson::from),
            work: composed.work_of_forces(),
            noise: Motion::of_noise(&composed)
                .into_iter()
                .map(|(hamiltonian, field)| Noise {
                    hamiltonian,
                    field: field.into(),
                })
                .collect(),
            warnings: &advice,
        });
    } else {
        let mut motion = motion::lines(&composed);
        motion.extend(motion::ends(&document)?);
        let gap = (!motion.is_empty()).then(String::new);
        for line in words(&rows).into_iter().chain(gap).chain(motion) {
            console.result(&line);
        }
    }
    print_advice(&advice, console);
    if checks.pass() {
        return Ok(exit::DONE);
    }
    if let Some(refusal) = checks.refusal(&document, (&composed.system, &composed.near), false) {
        console.prose("");
        console.prose(&refusal.render(console.color));
    }
    Ok(exit::CHECK_FAILED)
}

/// Refuses what `run` refuses, for commands that no flag makes go on.
///
/// # Errors
/// [`Failure::Scene`] for a bracket that is not Poisson, and a Casimir that is none.
pub(super) fn refuse_no_system(
    document: &SceneDocument,
    system: &PoissonSystem,
    near: &[f64],
) -> Result<(), Failure> {
    let checks = SceneChecks::of(system, near)?;
    let Some(mut refusal) = checks.refusal(document, (system, near), false) else {
        return Ok(());
    };
    if checks.inconsistency.is_none() && checks.jacobi.verdict == Verdict::Violated {
        refusal.help =
            Some("correct the bracket: this command is about Poisson systems alone".to_owned());
    }
    Err(refusal.into())
}

/// Reason why a tensor without entries of its own is Poisson, by what it is made of; `None` for any other tensor.
fn made_of(source: &TensorSource) -> Option<&'static str> {
    match source {
        TensorSource::OneForm => {
            Some("the tensor is the inverse of a differential dϑ, and d(dϑ) = 0")
        }
        TensorSource::TwoForm { .. } => Some("the tensor is the inverse of a closed two-form"),
        TensorSource::Sum { .. } => {
            Some("the tensor is a direct sum, and every summand is Poisson")
        }
        TensorSource::Dirac(_) => Some("the tensor is Dirac's bracket of one that is Poisson"),
        _ => None,
    }
}

fn worst<'a>(check: &IdentityCheck, names: &'a [String]) -> Vec<&'a str> {
    let worst = check.worst.iter();
    worst.map(|index| names[*index].as_str()).collect()
}

fn describe(check: &IdentityCheck, what: &str, names: &[String]) -> String {
    let differences = check.floor.map_or_else(String::new, |floor| {
        format!(" (derivatives are differences, accurate to {floor:.1e})")
    });
    match check.verdict {
        Verdict::Proved => "proved: its normal form is zero".to_owned(),
        Verdict::ByConstruction => "holds by construction".to_owned(),
        Verdict::NumericallyZero => format!(
            "numerically zero: at most {:.1e} of its terms near the initial state{differences}",
            check.residual
        ),
        Verdict::Violated if check.worst.is_empty() => {
            format!("violated: {:.3e} of its terms{differences}", check.residual)
        }
        Verdict::Violated => format!(
            "violated: {:.3e} of its terms at the worst {what} {}{differences}",
            check.residual,
            worst(check, names).join(", ")
        ),
        Verdict::Undecided => "undecided: it has no finite value near the initial state".to_owned(),
    }
}
