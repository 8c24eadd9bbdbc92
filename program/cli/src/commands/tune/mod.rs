//! `leafwise tune`: the cheapest method and step that hold what is asked.

mod clock;
mod json;
mod shadow;
mod text;

use std::fs;

use leafwise::core::Registry;
use leafwise::core::system::MotionClass;
use leafwise::scene::SceneDocument;
use leafwise::scene::document::MethodTable;
use leafwise::trade::{
    Bench, Judged, Recommendation, Stage, Tolerances, TuneOptions, Tuner, Tuning, parse_method,
};

use clock::Clock;

use super::compare::check;
use crate::arguments::{PluginArguments, TuneArguments};
use crate::bar::Steps;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::{check_writable, replace_unchanged};
use crate::plugins::Parts;

/// Findings of a search, with all that printing them needs.
struct Found<'a> {
    document: &'a SceneDocument,
    bench: &'a Bench<'a>,
    tuner: &'a Tuner<'a>,
    tuning: &'a Tuning,
    clock: &'a Clock,
    /// Whether the cheapest of all methods was asked for; with forces, where no method is a Poisson map, it always is.
    any: bool,
    /// The scene in which it stands now.
    written: Option<SceneDocument>,
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
) -> Result<u8, Failure> {
    if let Some(tolerance) = arguments.shadow {
        return shadow::execute(arguments, tolerance, &mut Parts::new(plugins)?, console);
    }
    let asked = Tolerances {
        error: arguments.error,
        energy: arguments.energy,
        casimirs: arguments.casimir,
        relative: arguments.relative,
    };
    if asked.is_empty() {
        return Err(Failure::usage(
            "no bound is given for the method",
            "give --error 1e-8, --energy 1e-6, --casimir 1e-12, or several of them; or --shadow 1e-10 alone",
        ));
    }
    let mut parts = Parts::new(plugins)?;
    let file = &arguments.scene.scene;
    let before = if arguments.write {
        fs::read(file).unwrap_or_default()
    } else {
        Vec::new()
    };
    let document = parts.scene(&arguments.scene)?;
    let options = options(arguments, &parts.registry)?;
    let bench = Bench::new(&document, &parts.registry, arguments.time)?;
    check(&document, &bench)?;
    let motion = bench.own().system.motion();
    let is_forced = motion != MotionClass::Hamiltonian;
    if motion == MotionClass::OffLeaves && (asked.energy.is_some() || asked.casimirs.is_some()) {
        return Err(Failure::usage(
            "friction changes the energy and the Casimirs, which then do not measure a method",
            "give only --error 1e-8",
        ));
    }
    if is_forced && asked.energy.is_some() {
        return Err(Failure::usage(
            "the energy of a system with forces is not conserved",
            "give --error 1e-8, or --casimir 1e-12",
        ));
    }
    asked.check(&bench)?;
    if arguments.write {
        check_writable(file)?;
    }
    let mut bar = Steps::unmeasured("methods", console.shown(false));
    let mut clock = Clock::new(arguments.within);
    let mut show = |stage: Stage<'_>| {
        tell(&mut bar, stage);
        clock.allows(stage)
    };
    // Nothing is there to be saved: an interruption ends the program at once, wherever it is.
    let tuner = Tuner::new(&bench, &options, &mut show)?;
    let tuning = tuner.tune(&asked, &mut show);
    bar.finish();
    let tuning = tuning?;
    let mut found = Found {
        document: &document,
        bench: &bench,
        tuner: &tuner,
        tuning: &tuning,
        clock: &clock,
        any: arguments.any || is_forced,
        written: None,
    };
    let mut is_changed = false;
    if arguments.write
        && let Some(recommended) = found.recommended()
    {
        let text = rewritten(&found, recommended)?;
        let written = SceneDocument::parse(&document.name, &text, &parts.registry)
            .map_err(|error| Failure::usage(error.to_string(), "write the method by hand"))?;
        is_changed = !replace_unchanged(file, &before, &text)?;
        found.written = (!is_changed).then_some(written);
    }
    if arguments.json {
        console.json(&json::TuningJson::of(&found));
    } else {
        text::print(&found, console);
    }
    if is_changed {
        console.prose(&format!(
            "{} {} was changed meanwhile, and is left as it is\n  = help: write the method found into it by \
             hand, or run the command again",
            console.error_word(),
            file.display()
        ));
        return Ok(exit::RUN_FAILED);
    }
    Ok(match found.recommended() {
        Some(_) => exit::DONE,
        None => exit::CHECK_FAILED,
    })
}

/// Shows what goes on: forming a method may take longer than all its runs.
fn tell(bar: &mut Steps, stage: Stage<'_>) {
    match stage {
        Stage::Building { method } => bar.say(format!("forming {method}")),
        Stage::Reference => bar.say("reference solution".to_owned()),
        Stage::Running { method, runs } => bar.tick(method, runs),
    }
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
        judged: Judged::at_the_end(arguments.at_end),
    })
}

/// The scene's text with the method, to the scene's own end time.
fn rewritten(found: &Found<'_>, recommended: &Recommendation) -> Result<String, Failure> {
    let plan = &found.bench.own().plan;
    let end = plan.steps as f64 * plan.epsilon * plan.h;
    if plan.until.is_some() || end == found.bench.extent() {
        return Ok(recommended.scene.clone());
    }
    let steps = (end / recommended.time_step).abs().round() as u64;
    recommended
        .method
        .write_into(&found.document.text, recommended.time_step, steps)
        .map_err(|error| Failure::usage(error.to_string(), "write the method by hand"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulse::Shown;

    #[test]
    fn what_is_formed_is_shown_until_it_runs() {
        let mut bar = Steps::unmeasured("methods", Shown::Nothing);
        let mut shown = |stage| {
            tell(&mut bar, stage);
            bar.shown()
        };
        let (method, runs) = ("gauss 4", 7);
        assert_eq!(
            shown(Stage::Building { method }),
            (0, "forming gauss 4".to_owned())
        );
        assert_eq!(
            shown(Stage::Reference),
            (0, "reference solution".to_owned())
        );
        assert_eq!(
            shown(Stage::Running { method, runs }),
            (7, "gauss 4".to_owned())
        );
        // The count of runs stays while the next is formed.
        assert_eq!(
            shown(Stage::Building { method: "rk4" }),
            (7, "forming rk4".to_owned())
        );
    }
}
