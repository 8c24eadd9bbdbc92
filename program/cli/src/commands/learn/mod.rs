//! `leafwise learn`: a Poisson map from pairs of states one step apart, by least squares.

use leafwise::core::Walk;
use leafwise::learn::{FunctionFamily, LearnAdvice, LearnOptions, Learned, StatePairs, learn};
use leafwise::scene::ComposedRun;
use leafwise::scene::compose::{compose, refuse_noise};
use leafwise::scene::pairs::{read_pairs, read_weights};

mod json;
mod text;

use self::json::json;
use self::text::lines;
use super::find::write_scene;
use super::fitted::{again, axes, degree, learned_scene, refused, with_chart};
use crate::arguments::{LearnArguments, PluginArguments};
use crate::bar::while_building;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::refuse_existing;
use crate::plugins::Parts;

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
    refuse_noise(&document, "no map is learned", "remove the noise")?;
    let (document, run) = with_chart(&mut parts, &document, shown)?;
    let Some(method) = run.method.written() else {
        return Err(Failure::usage(
            "a lattice that is not written out has no map to learn",
            "shorten it",
        ));
    };
    if run.pace().is_some() {
        return Err(Failure::usage(
            "a scene with a pace has steps of different times, and pairs are all one time step apart",
            "remove method.pace from the scene",
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
    let written = again(&mut parts, &document, text.clone())?;
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
