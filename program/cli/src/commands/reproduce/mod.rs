//! `leafwise reproduce`: the figures and numbers of the paper's section 5, beside what it prints.

mod files;
mod json;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use leafwise::core::Registry;
use leafwise::reproduce::{FIGURES, PaperFigure, ReproduceError, Reproduced, find, reproduce};

use serde::Serialize;

use crate::arguments::ReproduceArguments;
use crate::bar::Steps;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::make_directory;
use crate::table::{duration, labelled};

/// Measures; returns the exit code.
///
/// # Errors
/// [`Failure`] for a figure that the paper does not have, or a file that cannot be written.
pub fn execute(
    arguments: &ReproduceArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let chosen = chosen(&arguments.figures)?;
    if arguments.list {
        list(&chosen, arguments.json, console);
        return Ok(exit::DONE);
    }
    if let Some(directory) = &arguments.out {
        make_directory(directory)?;
    }
    let registry = Registry::with_builtin();
    let started = Instant::now();
    let mut figures = Vec::new();
    for (at, figure) in chosen.iter().enumerate() {
        if interrupt.load(Ordering::Relaxed) {
            return Ok(exit::INTERRUPTED);
        }
        let mut bar = Steps::new("", console.shown(false));
        bar.show(figure.title, at, chosen.len());
        let reproduced = reproduce(figure, &registry);
        bar.finish();
        let reproduced = reproduced?;
        if !arguments.json {
            print(&reproduced, console);
        }
        figures.push(reproduced);
    }
    let seconds = started.elapsed().as_secs_f64();
    let command = command(arguments);
    if let Some(directory) = &arguments.out {
        files::write(directory, &figures, &command, seconds)?;
    }
    if arguments.json {
        console.json(&json::FiguresJson::of(&figures, seconds));
    } else {
        conclude(arguments, &figures, seconds, console);
    }
    Ok(if figures.iter().all(Reproduced::holds) {
        exit::DONE
    } else {
        exit::CHECK_FAILED
    })
}

fn chosen(names: &[String]) -> Result<Vec<&'static PaperFigure>, Failure> {
    if names.is_empty() {
        return Ok(FIGURES.iter().collect());
    }
    let mut chosen: Vec<&PaperFigure> = Vec::new();
    for name in names {
        let unknown = || ReproduceError::UnknownFigure { name: name.clone() };
        let figure = find(name).ok_or_else(unknown)?;
        // A figure that is named twice is measured once.
        if chosen.iter().all(|known| known.number != figure.number) {
            chosen.push(figure);
        }
    }
    Ok(chosen)
}

/// The object of `reproduce --list --json`.
#[derive(Serialize)]
struct Listed<'a> {
    figures: &'a [&'static PaperFigure],
}

fn list(chosen: &[&'static PaperFigure], json: bool, console: &mut Console<'_>) {
    if json {
        console.json(&Listed { figures: chosen });
        return;
    }
    for figure in chosen {
        console.result(&format!("{}  {}", figure.number, figure.id));
        for line in labelled(&[("section", figure.section), ("shows", figure.title)]) {
            console.result(&format!("   {line}"));
        }
    }
}

fn command(arguments: &ReproduceArguments) -> String {
    let mut words = vec!["leafwise reproduce".to_owned()];
    words.extend(arguments.figures.iter().cloned());
    words.push("--out figures".to_owned());
    words.join(" ")
}

/// A figure as a few lines.
fn print(figure: &Reproduced, console: &mut Console<'_>) {
    let paper = figure.paper;
    console.result(&format!(
        "Figure {}, section {}: {}",
        paper.number, paper.section, paper.title
    ));
    for finding in &figure.findings {
        console.result(&format!(
            "  {}: {}",
            finding.claim.quantity,
            finding.verdict()
        ));
        for line in labelled(&[
            ("paper", finding.claim.printed),
            ("here", finding.measured.as_str()),
            ("theory", finding.explanation.as_str()),
        ]) {
            console.result(&format!("    {line}"));
        }
    }
    console.result("");
}

fn conclude(
    arguments: &ReproduceArguments,
    figures: &[Reproduced],
    seconds: f64,
    console: &mut Console<'_>,
) {
    let findings = || figures.iter().flat_map(|figure| &figure.findings);
    let printed = findings()
        .filter(|finding| finding.agrees.is_some())
        .count();
    let agree = findings()
        .filter(|finding| finding.agrees == Some(true))
        .count();
    let hold = findings().filter(|finding| finding.holds).count();
    console.result(&format!(
        "{agree} of {printed} printed statements agree, {hold} of {} measurements are what theory \
         says; measured in {}",
        findings().count(),
        duration(seconds)
    ));
    match &arguments.out {
        Some(directory) => {
            let page = directory.join(files::PAGE);
            console.prose(&format!("the page is {}", page.display()));
        }
        None => console.prose("--out DIR writes the figures, their numbers and a page"),
    }
}
