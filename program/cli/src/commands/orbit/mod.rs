//! `leafwise orbit`: a periodic orbit near a scene's initial state, and what its neighbours do; its family; an equilibrium.

mod equilibrium;
mod family;

use leafwise::orbit::{Complex, Hold, OrbitError, PeriodicOrbit, close};
use leafwise::scene::compose::{compose, refuse_acts};
use leafwise::scene::json::object;
use serde::Serialize;

use super::check::refuse_no_system;
use super::run::method_line;
use crate::arguments::{OrbitArguments, PluginArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// The object of `orbit --json`.
#[derive(Serialize)]
struct OrbitJson {
    period: f64,
    energy: f64,
    time_step: f64,
    steps: u64,
    /// Turns in the period that was looked for.
    turns: u64,
    closure: f64,
    corrections: usize,
    #[serde(serialize_with = "object")]
    state: Vec<(String, f64)>,
    stable: bool,
    /// Multipliers that are 1 by the time and the integrals.
    trivial: usize,
    /// The real and the imaginary part of each of the others.
    multipliers: Vec<[f64; 2]>,
    pairing: f64,
}

impl OrbitJson {
    fn of(orbit: &PeriodicOrbit, names: &[String]) -> Self {
        let multipliers = orbit.multipliers.iter();
        Self {
            period: orbit.period,
            energy: orbit.energy,
            time_step: orbit.period / orbit.steps as f64,
            steps: orbit.steps,
            turns: orbit.turns,
            closure: orbit.closure,
            corrections: orbit.iterations,
            stable: orbit.is_stable(),
            trivial: orbit.trivial,
            multipliers: multipliers.map(|of| [of.re, of.im]).collect(),
            pairing: orbit.pairing,
            state: names
                .iter()
                .cloned()
                .zip(orbit.state.iter().copied())
                .collect(),
        }
    }
}

/// Closes an orbit and prints its period, a state on it, its multipliers and its stability. Returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, has no periodic orbits, or none closes near its initial state.
pub fn execute(
    arguments: &OrbitArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    refuse_acts(
        &document,
        "no orbit is closed",
        "remove `set` from the section",
    )?;
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    while_building(shown, || {
        refuse_no_system(&document, &run.system, &run.near)
    })?;
    if arguments.equilibrium {
        return equilibrium::execute(&run, arguments.json, console);
    }
    let h = run.plan.epsilon * run.plan.h;
    let period = match (arguments.period, run.plan.until) {
        (Some(period), _) => period,
        (None, Some(until)) => until,
        (None, None) => h * run.plan.steps as f64,
    };
    if !(period > 0.0 && period.is_finite()) {
        return Err(Failure::usage(
            format!("{period} is no period"),
            "give a positive time: --period 6.28",
        ));
    }
    let steps = match arguments.steps {
        Some(steps) => steps,
        None => (period / h.abs()).ceil() as u64,
    };
    let hold = match arguments.hold_period {
        true => Hold::Period,
        false => Hold::Energy,
    };
    if arguments.along.is_some() {
        let called = (arguments, method_line(&run, &parts.registry));
        return family::execute(called, &run, (period, steps, hold), console);
    }
    let orbit = while_building(shown, || close(&run, (period, steps), hold)).map_err(refused)?;
    let names = run.names();
    if arguments.json {
        console.json(&OrbitJson::of(&orbit, &names));
        return Ok(exit::DONE);
    }
    console.result(&format!(
        "A periodic orbit of {}",
        method_line(&run, &parts.registry)
    ));
    console.result("");
    for line in words(&rows(&orbit, &names)) {
        console.result(&line);
    }
    Ok(exit::DONE)
}

fn rows(orbit: &PeriodicOrbit, names: &[String]) -> Vec<Vec<String>> {
    let row = |label: &str, text: String| vec![format!("  {label}"), text];
    let state = names.iter().zip(&orbit.state);
    let state: Vec<String> = state.map(|(name, x)| format!("{name} = {x:?}")).collect();
    let mut rows = vec![
        row("period", format!("{:?}", orbit.period)),
        row("energy", format!("{:?}", orbit.energy)),
        row("state", state.join(", ")),
        row(
            "closes to",
            format!(
                "{:.1e}, after {} corrections, in {} steps",
                orbit.closure, orbit.iterations, orbit.steps
            ),
        ),
        row("stability", stability(orbit)),
    ];
    if orbit.turns > 1 {
        let told = format!(
            "{} of this orbit make up the one that closed first",
            orbit.turns
        );
        rows.insert(1, row("turns", told));
    }
    for multiplier in &orbit.multipliers {
        rows.push(row("multiplier", written(*multiplier)));
    }
    rows.push(row(
        "trivial",
        format!(
            "{} multipliers are 1, by the time and the integrals",
            orbit.trivial
        ),
    ));
    rows
}

fn written(multiplier: Complex) -> String {
    match multiplier.im == 0.0 {
        true => format!("{:.12}", multiplier.re),
        false => format!(
            "{:.12} {} {:.12}i, {:.12} at an angle of {:.12}",
            multiplier.re,
            if multiplier.im < 0.0 { "-" } else { "+" },
            multiplier.im.abs(),
            multiplier.modulus(),
            multiplier.argument()
        ),
    }
}

fn stability(orbit: &PeriodicOrbit) -> String {
    match orbit.multipliers.first() {
        None => "no neighbours in its leaf and energy".to_owned(),
        Some(_) if orbit.is_stable() => {
            "linearly stable: all multipliers lie on the unit circle".to_owned()
        }
        Some(largest) => format!(
            "unstable: neighbours diverge by a factor of {:.6} a turn, e-folding time {:.6}",
            largest.modulus(),
            orbit.period / libm::log(largest.modulus())
        ),
    }
}

fn refused(error: OrbitError) -> Failure {
    let help = match &error {
        OrbitError::NotOffered { help, .. } => help.clone().into_owned(),
        OrbitError::NoParameter { .. } => {
            "name `energy`, `period` or a parameter of the system".to_owned()
        }
        OrbitError::Step(_) => {
            "take more steps, or a method with exact tangents such as hamilton-jacobi".to_owned()
        }
        OrbitError::Shrinks { .. } | OrbitError::Equilibrium { .. } => {
            "begin away from equilibria, where the motion comes back, with a --period near its own"
                .to_owned()
        }
        OrbitError::Multipliers { .. } => {
            "begin at another point of the orbit, away from where neighbours part most".to_owned()
        }
        _ => "begin nearer to the orbit, give its --period, or take more --steps; a section shows where orbits close".to_owned(),
    };
    Failure::usage(error.to_string(), help)
}
