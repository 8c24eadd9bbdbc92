//! `leafwise verify`: what every part really does, against what it declares.

mod json;
mod live;
mod page;
mod row;

use std::num::NonZeroUsize;
use std::time::Instant;

use leafwise::report::render_survey;
use leafwise::verify::{Problem, Row, Survey, SurveyOptions, survey};

use crate::arguments::{PluginArguments, SceneArguments, VerifyArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files;
use crate::plugins::Parts;
use crate::table::duration;

use live::Live;

/// The systems measured when no scene is named: linear, log-canonical, and six-dimensional.
const PROBLEMS: [&str; 3] = ["rigid-body", "lotka-volterra-periodic", "heavy-top"];

/// Lattices of the library are too long to be written out, and forces between all bodies for methods of high order.
const LATTICES: [&str; 7] = [
    "ablowitz-ladik",
    "gravity",
    "planets",
    "spin-chain",
    "toda",
    "volterra-lattice",
    "vortices",
];

/// Measures; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid or the page cannot be written.
pub fn execute(
    arguments: &VerifyArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let problems = problems(arguments, &mut parts)?;
    let options = SurveyOptions {
        full: arguments.full,
        threads: std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN),
    };
    let started = Instant::now();
    let mut live = Live::new(console, arguments.json);
    let survey = survey(&parts.registry, &problems, &options, &mut live);
    live.finish();
    let seconds = started.elapsed().as_secs_f64();
    let survey = survey.map_err(|error| {
        Failure::usage(
            error.to_string(),
            "choose an initial state and a step for which the motion has values",
        )
    })?;
    if let Some(file) = &arguments.html {
        files::write(file, &render_survey(&page::data(&survey))?)?;
    }
    if arguments.json {
        console.json(&json::SurveyJson::of(&survey, seconds));
    } else {
        conclude(&survey, seconds, console);
    }
    Ok(if survey.is_met() {
        exit::DONE
    } else {
        exit::CHECK_FAILED
    })
}

fn problems(arguments: &VerifyArguments, parts: &mut Parts) -> Result<Vec<Problem>, Failure> {
    if let Some(scene) = &arguments.scene {
        let document = parts.scene(&SceneArguments {
            scene: scene.clone(),
            overrides: arguments.overrides.clone(),
        })?;
        let problem = Problem::with_method(&document, &parts.registry)
            .map_err(|error| Failure::usage(error.to_string(), "correct the scene"))?;
        return Ok(vec![problem]);
    }
    let all: Vec<&str> = if arguments.full {
        let ids = leafwise::systems::all().iter().map(|system| system.id);
        ids.filter(|id| !LATTICES.contains(id)).collect()
    } else {
        PROBLEMS.to_vec()
    };
    all.into_iter()
        .map(|id| {
            Problem::of_library(id).map_err(|error| {
                Failure::usage(error.to_string(), "this is a defect of the library")
            })
        })
        .collect()
}

/// Prints the text below the rows: what does not fit, a reason a line, and the verdict.
fn conclude(survey: &Survey, seconds: f64, console: &mut Console<'_>) {
    let refusals = survey.refusals();
    for of_problem in refusals.chunk_by(|a, b| a.problem == b.problem) {
        console.result("");
        console.result(&format!("what does not fit {}", of_problem[0].problem));
        for refusal in of_problem {
            console.result(&format!("  {}: {}", refusal.who.join(", "), refusal.cause));
        }
    }
    console.result("");
    let count = survey.rows.len();
    let failing = survey.rows.iter().filter(|row| !row.is_met()).count();
    console.result(&match failing {
        0 => format!("no declaration of {count} step maps is broken"),
        1 => format!("one of {count} step maps does not meet what it declares"),
        many => format!("{many} of {count} step maps do not meet what they declare"),
    });
    let undecided = survey.rows.iter().filter(|row| row.is_undecided());
    let (rough, smooth): (Vec<&Row>, Vec<&Row>) = undecided.partition(|row| row.is_rough());
    if !smooth.is_empty() {
        console.result(&format!(
            "{} with a `?` leave an order open: too few errors lie between round-off and the range where powers of the \
             step rule",
            smooth.len()
        ));
    }
    if !rough.is_empty() {
        console.result(&format!(
            "{} with a `?` leave an order open: it holds for smooth formulas, and these have seams or tables of low degree",
            rough.len()
        ));
    }
    let unjudged = |row: &&Row| row.is_rough() && !row.is_undecided();
    if survey.rows.iter().any(|row| unjudged(&row)) {
        console.result(
            "the formulas have seams or tables of low degree: the orders without a `?` are those of the smooth motion \
             about the initial state, and a step across a seam or between cells has a lower one",
        );
    }
    for sampled in &survey.sampled {
        let alone = match sampled.is_own_alone {
            true => "; the scene's own method alone is measured, --full measures all",
            false => "",
        };
        console.result(&format!(
            "{} has {} coordinates: tensor defects are those along {} random covectors, drifts those of fewer steps{alone}",
            sampled.problem, sampled.coordinates, sampled.covectors
        ));
    }
    console.result(&format!("measured in {}", duration(seconds)));
}
