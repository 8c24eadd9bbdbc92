//! `leafwise tune --shadow`: the step of a scene's own method, from the energy of its shadow.

use leafwise::run::{NoShadowStep, ShadowStep, ShadowVerdict};
use leafwise::scene::compose::{compose, refuse_acts, refuse_noise};
use serde::Serialize;

use crate::arguments::TuneArguments;
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;

/// The object of `tune --shadow --json`.
#[derive(Serialize)]
struct ShadowTuningJson {
    time_step: f64,
    steps: u64,
    #[serde(flatten)]
    verdict: ShadowVerdict,
}

/// Searches for the step; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, or its method has no shadow Hamiltonian as a formula.
pub(super) fn execute(
    arguments: &TuneArguments,
    tolerance: f64,
    parts: &mut Parts,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    refuse_noise(
        &document,
        "no step is found by the shadow energy",
        "remove the noise",
    )?;
    refuse_acts(
        &document,
        "no step is found by the shadow energy",
        "remove `set` from the section",
    )?;
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    if run.method.lattice().is_some() || document.method.pace.is_some() {
        return Err(Failure::usage(
            "--shadow is offered neither on long lattices nor with a pace",
            "give --error or --energy",
        ));
    }
    if let Some(length) = run.table_step() {
        return Err(Failure::usage(
            format!(
                "the generating function holds for steps of {length:?} alone, and no other step is found"
            ),
            "tune the scene whose steps the table puts together",
        ));
    }
    let found = while_building(shown, || ShadowStep::find(&run, tolerance));
    let found = match found {
        Ok(found) => found,
        Err(NoShadowStep::Shadow(no)) => return Err(Failure::usage(no.message, no.help)),
        Err(NoShadowStep::Run(error)) => return Err(error.into()),
        Err(other) => {
            console.prose(&format!(
                "{} no step keeps it so: {other}",
                console.error_word()
            ));
            return Ok(exit::CHECK_FAILED);
        }
    };
    if arguments.json {
        console.json(&ShadowTuningJson {
            time_step: found.time_step,
            steps: found.steps,
            verdict: found.verdict,
        });
    } else {
        // Three digits of a step a little shorter: it keeps no less.
        let short: f64 = format!("{:.2e}", 0.995 * found.time_step)
            .parse()
            .unwrap_or(found.time_step);
        console.result(&format!("time-step = {short:?}"));
        console.result(&format!("{} steps: {}", found.steps, found.verdict.text()));
    }
    Ok(exit::DONE)
}
