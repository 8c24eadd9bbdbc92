//! `leafwise compare`: cost against accuracy, over methods, orders and steps.

mod csv;
pub(super) mod json;
mod table;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use leafwise::core::Registry;
use leafwise::scene::SceneDocument;
use leafwise::scene::document::MethodTable;
use leafwise::trade::{
    Bench, CompareOptions, Comparison, Grid, Judged, compare, comparison_figures, comparison_page,
    parse_method,
};

use super::check::refuse_no_system;
use crate::arguments::{CompareArguments, PluginArguments};
use crate::bar::Steps;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::{check_writable, make_directory, write, write_json};
use crate::interrupt::is_raised;
use crate::plugins::Parts;

/// Measures; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid, when there is no reference solution, or when a file
/// cannot be written.
pub fn execute(
    arguments: &CompareArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let options = options(arguments, &parts.registry)?;
    let bench = Bench::new(&document, &parts.registry, arguments.time)?;
    check(&document, &bench)?;
    if let Some(directory) = &arguments.out {
        make_directory(directory)?;
    }
    if let Some(file) = &arguments.csv {
        check_writable(file)?;
    }
    let mut bar = Steps::new("reference solution", console.shown(false));
    let comparison = compare(&bench, &options, &mut |method, at, count| {
        match count {
            0 => bar.say(format!("forming {method}")),
            _ => bar.show(method, at, count),
        }
        !is_raised(interrupt)
    });
    bar.finish();
    let comparison = comparison?;
    write_files(arguments, &document, &comparison)?;
    if arguments.json {
        console.json(&json::ComparisonJson::of(&document, &comparison));
    } else {
        table::print(&comparison, arguments.all, console);
    }
    warn(&comparison, &options, console);
    if let Some(directory) = &arguments.out {
        let page = directory.join(PAGE);
        console.prose(&format!("the page is {}", page.display()));
    }
    Ok(if is_raised(interrupt) {
        exit::INTERRUPTED
    } else {
        exit::DONE
    })
}

/// Files of a directory of results: page, table and JSON object.
const PAGE: &str = "compare.html";
const TABLE: &str = "compare.csv";
const OBJECT: &str = "compare.json";

fn options(arguments: &CompareArguments, registry: &Registry) -> Result<CompareOptions, Failure> {
    let read = |texts: &[String]| -> Result<Vec<MethodTable>, Failure> {
        let methods = texts.iter().map(|text| Ok(parse_method(text, registry)?));
        methods.collect()
    };
    let orders = (!arguments.orders.is_empty()).then(|| arguments.orders.clone());
    Ok(CompareOptions {
        with: read(&arguments.with)?,
        only: read(&arguments.only)?,
        orders,
        steps: arguments.steps.as_deref().map(Grid::parse).transpose()?,
        budget: arguments.budget.map(|budget| budget as u64),
        repetitions: arguments.repeat,
        judged: Judged::at_the_end(arguments.at_end),
    })
}

/// Refuses what `run` refuses.
pub(super) fn check(document: &SceneDocument, bench: &Bench<'_>) -> Result<(), Failure> {
    let own = bench.own();
    refuse_no_system(document, &own.system, &own.near)
}

/// Says what else keeps the table from what was asked: an end state that is not known, methods
/// that were named and do not fit.
fn warn(comparison: &Comparison, options: &CompareOptions, console: &mut Console<'_>) {
    if let Some(horizon) = &comparison.horizon {
        console.warn(&format!(
            "the state {} is known to {:.1e} of {:.1e} only: {horizon}",
            comparison.reference.judged().words(),
            comparison.reference.error,
            comparison.reference.norm()
        ));
    }
    let named: Vec<String> = options
        .with
        .iter()
        .chain(&options.only)
        .map(MethodTable::to_string)
        .collect();
    for (name, reason) in &comparison.refused {
        if named.contains(name) {
            console.warn(&format!("{name} is left out: {reason}"));
        }
    }
}

fn write_files(
    arguments: &CompareArguments,
    document: &SceneDocument,
    comparison: &Comparison,
) -> Result<(), Failure> {
    if let Some(file) = &arguments.csv {
        write(file, csv::table(comparison).as_str())?;
    }
    let Some(directory) = &arguments.out else {
        return Ok(());
    };
    let page = comparison_page(comparison, document, &command(arguments))?;
    write(&directory.join(PAGE), &page)?;
    for (name, figure) in comparison_figures(comparison)? {
        write(&directory.join(format!("{name}.svg")), &figure)?;
    }
    write(&directory.join(TABLE), csv::table(comparison).as_str())?;
    write_json(
        &directory.join(OBJECT),
        &json::ComparisonJson::of(document, comparison),
    )
}

/// The command that repeats the comparison of the scene as compared, overrides already in it.
fn command(arguments: &CompareArguments) -> String {
    let file = arguments.scene.scene.file_name();
    let file = file.map(|name| name.to_string_lossy().into_owned());
    let mut command = format!("leafwise compare {}", file.unwrap_or_default());
    if arguments.at_end {
        command.push_str(" --at-end");
    }
    let mut option = |name: &str, value: Option<String>| {
        if let Some(value) = value.filter(|value| !value.is_empty()) {
            command.push_str(&format!(" {name} {value}"));
        }
    };
    let orders: Vec<String> = arguments.orders.iter().map(usize::to_string).collect();
    option("--with", Some(arguments.with.join(",")));
    option("--only", Some(arguments.only.join(",")));
    option("--orders", Some(orders.join(",")));
    option("--steps", arguments.steps.clone());
    option("--time", arguments.time.map(|time| time.to_string()));
    option(
        "--budget",
        arguments.budget.map(|budget| format!("{budget:e}")),
    );
    command
}
