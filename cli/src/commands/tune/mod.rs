//! `leafwise tune`: the cheapest method and step that hold what is asked.

mod json;
mod text;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use leafwise::core::Registry;
use leafwise::scene::SceneDocument;
use leafwise::scene::document::MethodTable;
use leafwise::trade::{
    Bench, Recommendation, Tolerances, TradeError, TuneOptions, Tuner, Tuning, parse_method,
};

use super::compare::check;
use crate::arguments::{PluginArguments, TuneArguments};
use crate::bar::Steps;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::{check_writable, replace};
use crate::interrupt::is_raised;
use crate::plugins::Parts;

/// What there is to print.
struct Found<'a> {
    document: &'a SceneDocument,
    bench: &'a Bench<'a>,
    tuner: &'a Tuner<'a>,
    tuning: &'a Tuning,
    /// Whether the cheapest of all methods was asked for.
    any: bool,
    /// Whether it stands in the scene now.
    written: bool,
}

impl Found<'_> {
    /// The method to take: a Poisson map unless any will do.
    fn recommended(&self) -> Option<&Recommendation> {
        let tuning = self.tuning;
        if self.any {
            tuning.any.as_ref()
        } else {
            tuning.poisson.as_ref()
        }
    }
}

/// Searches; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, when there is no reference solution, or when the scene
/// cannot be written.
pub fn execute(
    arguments: &TuneArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let asked = Tolerances {
        error: arguments.error,
        energy: arguments.energy,
        casimirs: arguments.casimir,
        relative: arguments.relative,
    };
    if asked.is_empty() {
        return Err(Failure::usage(
            "nothing is asked of the method",
            "give --error 1e-8, --energy 1e-6, --casimir 1e-12, or several of them",
        ));
    }
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let options = options(arguments, &parts.registry)?;
    let library = parts.library();
    let bench = Bench::new(&document, &parts.registry, &library, arguments.time)?;
    check(&document, &bench)?;
    asked.check(&bench)?;
    if arguments.write {
        check_writable(&arguments.scene.scene)?;
    }
    let mut bar = Steps::unmeasured("methods and reference solution", console.is_terminal);
    let tuner = Tuner::new(&bench, &options)?;
    let tuning = tuner.tune(&asked, &mut |method, runs| {
        bar.tick(method, runs);
        !is_raised(interrupt)
    });
    bar.finish();
    let tuning = match tuning {
        Err(TradeError::Interrupted) => {
            console.prose("interrupted: nothing was written");
            return Ok(exit::INTERRUPTED);
        }
        other => other?,
    };
    let mut found = Found {
        document: &document,
        bench: &bench,
        tuner: &tuner,
        tuning: &tuning,
        any: arguments.any,
        written: false,
    };
    if arguments.write
        && let Some(recommended) = found.recommended()
    {
        replace(&arguments.scene.scene, &rewritten(&found, recommended)?)?;
        found.written = true;
    }
    if arguments.json {
        console.json(&json::object(&found));
    } else {
        text::print(&found, console);
    }
    Ok(match found.recommended() {
        Some(_) => exit::DONE,
        None => exit::CHECK_FAILED,
    })
}

fn options(arguments: &TuneArguments, registry: &Registry) -> Result<TuneOptions, Failure> {
    let read = |texts: &[String]| -> Result<Vec<MethodTable>, Failure> {
        let methods = texts.iter().map(|text| Ok(parse_method(text, registry)?));
        methods.collect()
    };
    Ok(TuneOptions {
        with: read(&arguments.with)?,
        only: read(&arguments.only)?,
        budget: arguments.budget.map(|budget| budget as u64),
    })
}

/// The scene's text with the method, to the scene's own end time.
fn rewritten(found: &Found<'_>, recommended: &Recommendation) -> Result<String, Failure> {
    let plan = &found.bench.own().plan;
    let end = plan.steps as f64 * plan.epsilon * plan.h;
    if end == found.bench.time() {
        return Ok(recommended.scene.clone());
    }
    let steps = (end / recommended.time_step).abs().round() as u64;
    recommended
        .method
        .write_into(&found.document.text, recommended.time_step, steps)
        .map_err(|error| Failure::usage(error.to_string(), "write the method by hand"))
}
