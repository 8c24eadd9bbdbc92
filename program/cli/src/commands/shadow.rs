//! `leafwise shadow`: the energy that a scene's method keeps.

use leafwise::run::ShadowVerdict;
use leafwise::scene::compose::{
    DENSE_LIMIT, NoShadow, ShadowEnergy, compose, refuse_acts, refuse_noise,
};
use leafwise::scene::json::object;
use serde::Serialize;

use super::check::refuse_no_system;
use super::run::{drift, method_line};
use crate::arguments::{PluginArguments, ShadowArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// Steps that are followed where none are asked for.
const STEPS: u64 = 10_000;

/// The longest formula that is printed of what is known as code alone, in its parts.
const LONGEST: usize = 500;

/// Placeholder for a formula that is longer than `LONGEST`.
const TOO_LONG: &str = "(code, too long for a formula)";

/// The name of the coordinate conjugate to the time.
const CONJUGATE: &str = "e";

/// The object of `shadow --json`.
#[derive(Serialize)]
struct ShadowJson {
    time_step: f64,
    #[serde(flatten)]
    verdict: ShadowVerdict,
    steps: u64,
    /// Of one evaluation of H, and of H~.
    operations: [u64; 2],
    /// k with the formula of F_k.
    #[serde(serialize_with = "object")]
    terms: Vec<(usize, String)>,
}

/// Prints the terms of H̃ and how well they are kept. Returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid or its method has no shadow Hamiltonian as a formula.
pub fn execute(
    arguments: &ShadowArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    refuse_noise(
        &document,
        "there is no shadow Hamiltonian",
        "remove the noise: with noise every step follows another Hamiltonian",
    )?;
    refuse_acts(
        &document,
        "no shadow Hamiltonian is kept",
        "remove `set` from the section",
    )?;
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    while_building(shown, || {
        refuse_no_system(&document, &run.system, &run.near)
    })?;
    let refused = |no: NoShadow| Failure::usage(no.message, no.help);
    if run.method.lattice().is_some() || document.method.pace.is_some() {
        return Err(refused(NoShadow {
            message:
                "a long lattice, or a scene with a pace, has no formula of its shadow Hamiltonian"
                    .to_owned(),
            help: match run.method.lattice() {
                Some(_) => format!(
                    "shorten the lattice with {}",
                    document.system.shortening(DENSE_LIMIT)
                ),
                None => "leave the pace out".to_owned(),
            },
        }));
    }
    let t = run.plan.epsilon * run.plan.h;
    let shadow = while_building(shown, || {
        ShadowEnergy::of(&run.system, run.method.map(), t, arguments.order)
    });
    let shadow = shadow.map_err(refused)?;
    let most = arguments.steps.unwrap_or(run.plan.steps.min(STEPS));
    let (verdict, steps, failure) = ShadowVerdict::measured(&run, &shadow, most)?;
    if let Some(failure) = failure {
        return Err(Failure::Step {
            step: steps + 1,
            error: failure,
        });
    }
    let mut variables = run.system.variables().to_vec();
    // Behind the time stands its conjugate, which no formula of a scene names.
    let clock = run.plan.layout.clock();
    if let Some(clock) = clock {
        CONJUGATE.clone_into(&mut variables[clock.energy]);
    }
    let parameters = run.system.parameters().iter();
    let parameters: Vec<String> = parameters.map(|parameter| parameter.name.clone()).collect();
    let terms = shadow.shadow.terms().into_iter();
    let terms: Vec<(usize, String)> = terms
        .filter(|k| *k <= shadow.order)
        .map(|k| {
            let formula = shadow.shadow.formula(k, LONGEST);
            let text = formula.map(|formula| formula.written(&variables, &parameters));
            (k, text.unwrap_or_else(|| TOO_LONG.to_owned()))
        })
        .collect();
    if arguments.json {
        console.json(&ShadowJson {
            time_step: t,
            verdict,
            steps,
            operations: shadow.operations,
            terms,
        });
        return Ok(exit::DONE);
    }
    let step = if clock.is_some() { "h" } else { "t" };
    let powers = terms.iter().map(|(k, _)| match k {
        1 => "F_1".to_owned(),
        2 => format!("{step} F_2"),
        k => format!("{step}^{} F_{k}", k - 1),
    });
    let sum: Vec<String> = powers.collect();
    console.result(&format!(
        "H~ = {}, {step} = {t}, of {}",
        sum.join(" + "),
        method_line(&run, &parts.registry)
    ));
    console.result("");
    let rows: Vec<_> = terms
        .iter()
        .map(|(k, formula)| vec![format!("  F_{k}"), formula.clone()])
        .collect();
    for line in words(&rows) {
        console.result(&line);
    }
    if clock.is_some() {
        console.result("");
        console.result("e is conjugate to the time: e' = -dH/dt, and H + e is constant");
    }
    console.result("");
    let changes = [
        ("energy", verdict.energy),
        ("shadow energy", verdict.shadow),
    ];
    let rows: Vec<_> = changes
        .iter()
        .zip(shadow.operations)
        .map(|((name, change), operations)| {
            let operations = format!("{operations} operations");
            vec![format!("  {name}"), drift(*change), operations]
        })
        .collect();
    console.result(&format!("Largest changes over {steps} steps:"));
    for line in words(&rows) {
        console.result(&line);
    }
    console.result("");
    console.result(&verdict.text());
    Ok(exit::DONE)
}
