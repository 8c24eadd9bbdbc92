//! `leafwise learn`: a Poisson map from pairs of states one step apart, by least squares.

use leafwise::core::Walk;
use leafwise::generating_function::{NAME as DYNAMICS, TIME_STEP};
use leafwise::learn::{
    FunctionFamily, LearnAdvice, LearnError, LearnOptions, Learned, StatePairs, learn,
};
use leafwise::scene::compose::{compose, refuse_noise};
use leafwise::scene::pairs::{read_pairs, read_weights};
use leafwise::scene::{
    ComposedRun, MethodParts, MethodTable, PartUse, SceneDocument, with_hamiltonian, with_system,
};

mod basis;
mod json;
mod text;

pub(super) use self::basis::{axes, degree};
use self::json::json;
use self::text::lines;
use super::find::write_scene;
use crate::arguments::{LearnArguments, PluginArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::refuse_existing;
use crate::plugins::Parts;
use crate::pulse::Shown;
use crate::scene::SceneText;

/// Steps of the learned map that are looked at for whether they leave the pairs.
const MOST_STEPS: u64 = 1000;

/// A state whose leverage is this many times the largest of the pairs is far from them.
const FAR: f64 = 4.0;

/// Learns and prints what was learned; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, or nothing is learned from the pairs.
pub fn execute(
    arguments: &LearnArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    if let Some(file) = &arguments.out {
        refuse_existing(file, "name another file: --out NAME.toml")?;
    }
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let shown = console.shown(false);
    let base = arguments.scene.scene.parent();
    let base = base.unwrap_or(std::path::Path::new(".")).to_owned();
    refuse_noise(&document, "no map is learned", "take the noise out")?;
    let (document, run) = with_chart(&mut parts, &document, &base, shown)?;
    let Some(method) = run.method.written() else {
        return Err(Failure::usage(
            "a lattice that is not written out has no map to learn",
            "shorten it",
        ));
    };
    if run.pace().is_some() {
        return Err(Failure::usage(
            "a scene with a pace has steps of different times, and pairs are all one time step apart",
            "take method.pace out of the scene",
        ));
    }
    if run.is_extended() {
        return Err(Failure::usage(
            "a system whose Hamiltonian or bracket names the time, or parameters of sites, has no map of its states alone to learn",
            "give a scene without them",
        ));
    }
    let names = run.system.variables().to_vec();
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let table = read_pairs(&arguments.pairs, &names, epsilon * h).map_err(unread)?;
    let weights = match &arguments.weights {
        Some(file) => Some(read_weights(file).map_err(unread)?),
        None => table.weights,
    };
    let family = FunctionFamily::Polynomial;
    let axes = axes(&arguments.basis, family, &run, &names)?;
    let options = LearnOptions {
        axes,
        degree: degree(arguments.degree.as_deref(), &names)?,
        ridge: arguments.ridge,
        has_noise: arguments.noisy,
        finds_hamiltonian: true,
    };
    let pairs = StatePairs::new(names.len(), &table.before, &table.after, weights.as_deref());
    let pairs = pairs.map_err(|error| refused(error, "learn"))?;
    let realization = method.shared_realization();
    let learned = while_building(shown, || {
        learn(&run.system, &realization, (epsilon, h), &pairs, &options)
    });
    let mut learned = learned.map_err(|error| refused(error, "learn"))?;
    let text = learned_scene(&document, &run, &learned, (epsilon * h, false))?;
    let written = parts.document(SceneText::again(&document, text.clone()), &base)?;
    let composed = while_building(shown, || compose(&written, &parts.registry))?;
    let mut warnings: Vec<String> = learned.advice.iter().map(ToString::to_string).collect();
    warnings.extend(far(&mut learned, &composed));
    let is_poor = learned.advice.iter().any(|advice| {
        matches!(
            advice,
            LearnAdvice::Unexplained { .. } | LearnAdvice::OffLeaf { .. }
        )
    });
    if arguments.json {
        console.json(&json(
            &learned,
            epsilon * h,
            &warnings,
            text.clone(),
            is_poor,
        ));
    } else {
        for line in lines(&learned) {
            console.result(&line);
        }
        for warning in &warnings {
            console.warn(warning);
        }
    }
    if let Some(file) = &arguments.out {
        write_scene(file, &text, console)?;
    }
    Ok(match is_poor {
        true => exit::CHECK_FAILED,
        false => exit::DONE,
    })
}

/// The scene over a realization with a chart: its own where it names one, else the one that fits the tensor.
pub(super) fn with_chart(
    parts: &mut Parts,
    document: &SceneDocument,
    base: &std::path::Path,
    shown: Shown,
) -> Result<(SceneDocument, ComposedRun), Failure> {
    let run = while_building(shown, || compose(document, &parts.registry))?;
    if run.system.has_forces() {
        return Err(Failure::usage(
            "a motion with forces is the flow of no Hamiltonian, and no generating function makes it",
            "take the forces out of the scene, and out of the data",
        ));
    }
    let own = run.method.written().filter(|method| {
        let abilities = method.realization().abilities();
        abilities.ends.is_some() && abilities.lift.is_none()
    });
    let named = MethodTable::of_choices(&run.plan.parts).and_then(|table| match table.parts {
        MethodParts::Pair { realization, .. } if own.is_some() => Some(realization),
        _ => None,
    });
    let realization = named.unwrap_or_else(|| PartUse::named("auto"));
    let table = MethodTable::pair(realization, PartUse::named(DYNAMICS).with("order", 2_i64));
    let text = table.write_into(
        &document.text,
        run.plan.epsilon * run.plan.h,
        run.plan.steps,
    );
    let text = text.map_err(unwritten)?;
    let document = parts.document(SceneText::again(document, text), base)?;
    let run = while_building(shown, || compose(&document, &parts.registry))?;
    Ok((document, run))
}

/// The scene of the learned map of this time step: H, and Ŝ by S_1 = H and what is beside it. A table holds for this step alone.
pub(super) fn learned_scene(
    document: &SceneDocument,
    run: &ComposedRun,
    learned: &Learned,
    (time_step, is_table): (f64, bool),
) -> Result<String, Failure> {
    let text = match with_hamiltonian(&document.text, &learned.hamiltonian).map_err(unwritten)? {
        Some(text) => text,
        None => {
            let system = run.system.formulas("learning")?;
            let fragment = with_hamiltonian(&system.fragment(), &learned.hamiltonian);
            let fragment = fragment.map_err(unwritten)?.unwrap_or_default();
            with_system(&document.text, &fragment).map_err(unwritten)?
        }
    };
    let coefficients: Vec<&str> = std::iter::once("H")
        .chain(learned.further.as_deref())
        .collect();
    let mut table = MethodTable::of_choices(&run.plan.parts)
        .ok_or_else(|| Failure::usage("a stepper has no map to learn", "name a realization"))?;
    if let MethodParts::Pair { dynamics, .. } = &mut table.parts {
        *dynamics = PartUse::named(DYNAMICS)
            .with("S", coefficients.join("; ").as_str())
            .with("order", 2_i64);
        if is_table {
            *dynamics = dynamics.clone().with(TIME_STEP, time_step.abs());
        }
    }
    table
        .write_into(&text, time_step, run.plan.steps)
        .map_err(unwritten)
}

/// Where the learned map leaves the states of the pairs, from the scene's initial state on.
fn far(learned: &mut Learned, run: &ComposedRun) -> Option<String> {
    let steps = run.plan.steps.min(MOST_STEPS);
    let parameters = run.system.parameter_values();
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let mut walk = Walk::new(run.method.map(), &parameters, epsilon, h, &run.plan.initial);
    let most = FAR * learned.largest_leverage.max(f64::MIN_POSITIVE);
    let mut first = None;
    let mut last = run.plan.initial.clone();
    // Of each state by its own step: the last one is of the step before.
    let ended = walk.watch(steps, |walk| {
        if first.is_none() && learned.leverage_between(&last, walk.state()) > most {
            first = Some(walk.steps() - 1);
        }
        last.copy_from_slice(walk.state());
    });
    if first.is_none() && learned.leverage(&last) > most {
        first = Some(walk.steps());
    }
    let told = match (first, ended) {
        (Some(0), _) => "the scene's initial state is".to_owned(),
        (Some(step), _) => format!("from the scene's initial state on, step {step} is"),
        (None, Err(error)) => {
            return Some(format!(
                "the learned map ends after {} steps from the scene's initial state: {error}",
                walk.steps()
            ));
        }
        (None, Ok(())) => return None,
    };
    Some(format!(
        "{told} far from the pairs, where the learned map extrapolates: its leverage is above {FAR} times the largest of a pair; give pairs from there, or a lower degree"
    ))
}

fn unread(reason: String) -> Failure {
    Failure::usage(reason, "`leafwise explain learn` shows files of pairs")
}

pub(super) fn unwritten(error: leafwise::scene::RewriteError) -> Failure {
    Failure::usage(
        error.to_string(),
        "name a scene with [system], [method] and [run]",
    )
}

/// A refusal whose help names the page of the command.
pub(super) fn refused(error: LearnError, command: &str) -> Failure {
    match error {
        LearnError::Build(error) => error.into(),
        error => Failure::usage(
            error.to_string(),
            format!("`leafwise explain {command}` says what is fitted to pairs"),
        ),
    }
}
