//! `leafwise tabulate`: many steps of a scene as one step with a generating function.

use leafwise::core::Walk;
use leafwise::learn::{
    FunctionFamily, LearnAdvice, LearnOptions, ManySteps, Region, Tabulated, tabulate,
};
use leafwise::scene::compose::{DENSE_LIMIT, compose, refuse_acts, refuse_noise};
use leafwise::scene::pairs::read_states;
use leafwise::scene::{ComposedRun, SceneDocument, with_hamiltonian, with_plain_run, with_system};

mod cost;
mod json;
mod text;

use self::cost::Cost;
use super::find::write_scene;
use super::fitted::{again, axes, degree, learned_scene, refused, unwritten, with_chart};
use crate::arguments::{PluginArguments, TabulateArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::refuse_existing;
use crate::plugins::Parts;
use crate::pulse::Shown;
use crate::table::short;

/// Steps of the scene's own orbit that are looked at for its range.
const MOST_STEPS: u64 = 10_000;

/// The part of a motion that times of a period, rounded, may change of it.
const ROUNDED: f64 = 1e-10;

/// Makes a table and prints what it is worth; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, or has no table.
pub fn execute(
    arguments: &TabulateArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    if let Some(file) = &arguments.out {
        refuse_existing(file, "name another file: --out NAME.toml")?;
    }
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    refuse_noise(&document, "no table is made", "remove the noise")?;
    refuse_acts(
        &document,
        "no table is made",
        "remove `set` from the section",
    )?;
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    refuse(&document, &run)?;
    let (table_document, table_run) =
        of_states_alone(&mut parts, &document, &run, arguments.steps, shown)?;
    let Some(method) = table_run.method.written() else {
        return Err(Failure::usage(
            "the method of this scene has no realization with a generating function, and no table",
            "name a realization in [method]",
        ));
    };
    let names = table_run.system.variables().to_vec();
    let parameters = run.system.parameter_values();
    let steps = ManySteps {
        map: run.method.map(),
        parameters: &parameters,
        step: (run.plan.epsilon, run.plan.h),
        count: arguments.steps,
        beside: &run.plan.initial[run.plan.layout.beside()],
    };
    let region = match &arguments.states {
        Some(file) => Region::States(read_states(file, &names).map_err(|reason| {
            Failure::usage(reason, "`leafwise explain tabulate` shows what states are")
        })?),
        None => Region::Box(bounds(arguments, &run, &names)?),
    };
    let options = LearnOptions {
        axes: axes(
            &arguments.basis,
            FunctionFamily::Centred,
            &table_run,
            &names,
        )?,
        degree: degree(arguments.degree.as_deref(), &names)?,
        ridge: 0.0,
        has_noise: false,
        finds_hamiltonian: false,
    };
    let realization = method.shared_realization();
    let table = while_building(shown, || {
        let system = &table_run.system;
        tabulate(
            system,
            &realization,
            &steps,
            &region,
            arguments.pairs.map(|count| count as usize),
            &options,
        )
    });
    let table = table.map_err(|error| refused(error, "tabulate"))?;
    let text = learned_scene(
        &table_document,
        &table_run,
        &table.learned,
        (steps.duration(), true),
    )?;
    let written = again(&mut parts, &document, text.clone())?;
    while_building(shown, || compose(&written, &parts.registry))?;
    let cost = while_building(shown, || Cost::of(&table, &steps));
    let mut warnings = warnings(&table, &cost, &steps);
    if run.extension.is_some() {
        warnings.extend(no_period(&table, &steps));
    }
    if arguments.json {
        let object = json::json(&table, &steps, &cost, &warnings, text.clone());
        console.json(&object);
    } else {
        for line in text::lines(&table, &steps, &cost, &region, &names) {
            console.result(&line);
        }
        for warning in &warnings {
            console.warn(warning);
        }
    }
    if let Some(file) = &arguments.out {
        write_scene(file, &text, console)?;
    }
    Ok(exit::DONE)
}

/// Scenes whose steps are no map of the states over a fixed time.
fn refuse(document: &SceneDocument, run: &ComposedRun) -> Result<(), Failure> {
    if run.contact.is_some() {
        return Err(Failure::usage(
            "the map of a contact bracket is not a Poisson map, and a table's generating function cannot represent it",
            "tabulate a scene with a Poisson bracket",
        ));
    }
    if document.method.exact_energy.is_some() {
        return Err(Failure::usage(
            "with energy = \"exact\" each step adds different multiples of Casimirs to H, and its map is not a Poisson map, so that no table represents it",
            "remove method.energy",
        ));
    }
    if run.method.lattice().is_some() {
        return Err(Failure::usage(
            "a lattice that is not written out has no table",
            format!(
                "shorten the lattice with {}",
                document.system.shortening(DENSE_LIMIT)
            ),
        ));
    }

    if run.pace().is_some() {
        return Err(Failure::usage(
            "a scene with a pace has steps of different times, and a table is of one time",
            "remove method.pace from the scene",
        ));
    }
    if run.system.has_forces() {
        return Err(Failure::usage(
            "a motion with forces or friction is not a Hamiltonian flow, and has no generating function",
            run.without_forces(),
        ));
    }
    if !run.plan.layout.sites().is_empty() {
        return Err(Failure::usage(
            "a table has no coordinates for parameters of sites",
            "give a scene without them",
        ));
    }
    Ok(())
}

/// The scene of the same bracket without the time, over a realization with a chart.
fn of_states_alone(
    parts: &mut Parts,
    document: &SceneDocument,
    run: &ComposedRun,
    steps: u64,
    shown: Shown,
) -> Result<(SceneDocument, ComposedRun), Failure> {
    let own = run.system.parameters().iter();
    let parameters: Vec<(String, f64)> = own
        .map(|parameter| (parameter.name.clone(), parameter.value))
        .collect();
    let nothing = "0";
    let text = match with_hamiltonian(&document.text, nothing).map_err(unwritten)? {
        Some(text) => text,
        None => {
            let fragment = match (&document.fragment, run.system.expressions()) {
                (Some((_, fragment)), _) => fragment.clone(),
                (None, Some(system)) => system.fragment(),
                (None, None) => {
                    return Err(Failure::usage(
                        "a system of numbers has no bracket in formulas, and no table",
                        "write its bracket and Hamiltonian as formulas",
                    ));
                }
            };
            let fragment = with_hamiltonian(&fragment, nothing).map_err(unwritten)?;
            with_system(&document.text, &fragment.unwrap_or_default()).map_err(unwritten)?
        }
    };
    let steps = (run.plan.steps / steps).max(1);
    let text = with_plain_run(&text, Some(&parameters), steps).map_err(unwritten)?;
    let document = again(parts, document, text)?;
    with_chart(parts, &document, shown)
}

/// The box of `--box`, and where it names no range that of the scene's own orbit.
fn bounds(
    arguments: &TabulateArguments,
    run: &ComposedRun,
    names: &[String],
) -> Result<Vec<(f64, f64)>, Failure> {
    let mut given: Vec<Option<(f64, f64)>> = vec![None; names.len()];
    for text in &arguments.bounds {
        let unknown = |reason: &str| {
            Failure::usage(
                format!("--box {text}: {reason}"),
                format!("write --box '{}=-1:1'", names[0]),
            )
        };
        let (name, range) = text.split_once('=').ok_or_else(|| unknown("no range"))?;
        let at = names.iter().position(|known| known == name.trim());
        let at = at.ok_or_else(|| unknown("the scene has no such variable"))?;
        let (least, largest) = range.split_once(':').ok_or_else(|| unknown("no range"))?;
        let number = |text: &str| text.trim().parse::<f64>();
        match (number(least), number(largest)) {
            (Ok(_), Ok(_)) if given[at].is_some() => {
                return Err(unknown(&format!("{} has a range already", names[at])));
            }
            (Ok(least), Ok(largest)) => given[at] = Some((least, largest)),
            _ => return Err(unknown("its ends are not numbers")),
        }
    }
    if given.iter().all(Option::is_some) {
        return Ok(given.into_iter().flatten().collect());
    }
    let mut orbit = vec![(f64::INFINITY, f64::NEG_INFINITY); names.len()];
    let mut look = |walk: &Walk| {
        for (range, x) in orbit.iter_mut().zip(walk.state()) {
            *range = (range.0.min(*x), range.1.max(*x));
        }
    };
    let mut walk = run.walk();
    look(&walk);
    let most = run.plan.steps.min(MOST_STEPS).max(arguments.steps);
    let ended = walk.watch(most, look);
    if let Err(error) = ended {
        return Err(Failure::Step {
            step: walk.steps() + 1,
            error,
        });
    }
    let both = given.into_iter().zip(orbit);
    Ok(both.map(|(given, orbit)| given.unwrap_or(orbit)).collect())
}

/// Where a Hamiltonian names the time: whether the same steps, begun where the table ends, lead elsewhere by more than its error.
fn no_period(table: &Tabulated, steps: &ManySteps<'_>) -> Option<String> {
    let mut beside = steps.beside.to_vec();
    let begin = *beside.first()?;
    beside[0] = begin + steps.duration();
    let later = ManySteps {
        beside: &beside,
        ..*steps
    };
    let states: Vec<Vec<f64>> = table.unseen.iter().map(|(x, _)| x.clone()).collect();
    let ends = later.after(&states).into_iter().zip(&table.unseen);
    let apart = ends.flat_map(|(end, (_, first))| {
        let end = end.unwrap_or_else(|| vec![f64::NAN; first.len()]);
        let squares = end.into_iter().zip(first).map(|(a, b)| (a - b) * (a - b));
        squares.collect::<Vec<f64>>()
    });
    let (sum, count) = apart.fold((0.0, 0_u32), |(sum, count), square| {
        (sum + square, count + 1)
    });
    let apart = libm::sqrt(sum / f64::from(count.max(1)));
    let least = table.error.max(ROUNDED * table.learned.motion);
    (apart > least || apart.is_nan()).then(|| {
        format!(
            "the table holds only from t = {}: {} steps from t = {} on differ from it by {}, more than its error; \
             take as many steps as make a whole period of the Hamiltonian, or use the table only once",
            short(begin),
            steps.count,
            short(beside[0]),
            short(apart)
        )
    })
}

/// Things to know: advice of the fit, states that are left out, and where the table does not pay.
fn warnings(table: &Tabulated, cost: &Cost, steps: &ManySteps<'_>) -> Vec<String> {
    let advice = table.learned.advice.iter();
    // The error at unseen states says what is left.
    let told = advice.filter(|advice| !matches!(advice, LearnAdvice::Unexplained { .. }));
    let mut warnings: Vec<String> = told.map(ToString::to_string).collect();
    if table.without_steps > 0 {
        warnings.push(format!(
            "from {} states of the region {} steps do not succeed: they are left out",
            table.without_steps, steps.count
        ));
    }
    if table.failed > 0 {
        warnings.push(format!(
            "the table has no step from {} of {} states that no pair has: take a smaller region, or fewer steps",
            table.failed,
            table.unseen.len()
        ));
    }
    warnings.extend(cost.does_not_pay());
    warnings
}
