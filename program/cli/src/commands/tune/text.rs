//! Text of `leafwise tune` at the terminal: the recommendation, or what keeps every method from it.

use leafwise::core::Structure;
use leafwise::scene::document::RunSection;
use leafwise::trade::{Cost, Judged, Limit, Reached, Recommendation, RunnerUp, Tolerances};

use super::Found;
use crate::console::Console;
use crate::table::{aligned_after, duration, grouped, short};

/// Prints the recommendation, or what keeps every method from it.
pub(super) fn print(found: &Found<'_>, console: &mut Console<'_>) {
    let (bench, reference, tuning) = (found.bench, found.tuner.reference(), found.tuning);
    console.result(&format!(
        "asked to t = {}: {}",
        short(bench.time()),
        asked(&tuning.asked, reference.judged())
    ));
    console.result(&format!(
        "errors against {}; their own is {:.1e}",
        reference.methods.join(" and "),
        reference.error
    ));
    console.result(&if tuning.runs == 0 {
        format!("{} methods fit, none was run", tuning.methods)
    } else {
        format!(
            "tried {} methods in {} runs of {:.1e} {} together",
            tuning.methods,
            grouped(tuning.runs),
            tuning.spent as f64,
            found.tuner.cost().word()
        )
    });
    if found.tuner.cost() == Cost::Evaluations {
        console.warn(&format!(
            "costs are compared {}; an evaluation is a step kernel for one method, all stages \
             for another: `leafwise compare` compares times",
            found.tuner.cost()
        ));
    }
    if let Some(line) = found.clock.ended(found.tuner, tuning) {
        console.warn(&line);
    }
    console.result("");
    match found.recommended() {
        Some(recommended) => print_found(found, recommended, console),
        None => print_missed(found, console),
    }
}

fn asked(asked: &Tolerances, judged: Judged) -> String {
    let relative = if asked.relative { "relative " } else { "" };
    let error = format!("error {}", judged.words());
    let parts = [
        (error.as_str(), asked.error),
        ("energy", asked.energy),
        ("Casimirs", asked.casimirs),
    ];
    let parts: Vec<String> = parts
        .iter()
        .filter_map(|(name, tolerance)| Some(format!("{relative}{name} {:e}", (*tolerance)?)))
        .collect();
    parts.join(", ")
}

fn print_found(found: &Found<'_>, recommended: &Recommendation, console: &mut Console<'_>) {
    let tuning = found.tuning;
    let kind = match (found.any, recommended.measured.is_poisson) {
        (false, _) => "Poisson map",
        (true, true) => "method, a Poisson map",
        (true, false) => "method, not a Poisson map",
    };
    console.result(&format!(
        "the cheapest {kind}: {}, {}",
        console.bold(&recommended.name),
        recommended.setting
    ));
    console.result("");
    for line in aligned_after(&measured(found, recommended), 1) {
        console.result(&format!("  {line}"));
    }
    console.result("");
    if let Some(line) = how_poisson(recommended) {
        console.result(&line);
        console.result("");
    }
    if let Some(any) = tuning
        .any
        .as_ref()
        .filter(|any| any.method != recommended.method)
    {
        console.result(&beside(recommended, any));
        console.result("");
    }
    print_runners_up(found, console);
    console.result(recommended.method.text(recommended.time_step).trim_end());
    match &found.written {
        None => {
            console.result(&end(&found.document.run, recommended.setting.steps));
            console.result("");
            console.result("--write puts it into the scene");
        }
        Some(written) => {
            let (now, before) = (&written.run, &found.document.run);
            console.result(&end(now, now.steps.value));
            if now.record.every != before.record.every {
                console.result(&format!("record      = {{ every = {} }}", now.record.every));
            }
            console.result("");
            console.result(&format!("written into {}", found.document.name));
        }
    }
}

/// Where a run ends, as its table says it.
fn end(run: &RunSection, steps: u64) -> String {
    match &run.until {
        Some(until) => format!("[run]\nuntil       = {}", until.value.literal),
        None => format!("[run]\nsteps       = {steps}"),
    }
}

/// Predicted and measured, line by line.
fn measured(found: &Found<'_>, recommended: &Recommendation) -> Vec<Vec<String>> {
    let (measured, predicted) = (&recommended.measured, recommended.predicted);
    let number = |value: f64| format!("{value:.2e}");
    let or_dash = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), number);
    let row = |label: &str, predicted: Option<f64>, measured: String| {
        vec![label.to_owned(), or_dash(predicted), measured]
    };
    let mut rows = vec![
        vec![String::new(), "predicted".to_owned(), "measured".to_owned()],
        row("error", predicted.map(|p| p.error), number(measured.error)),
    ];
    if found.tuner.reference().judged() == Judged::AtEveryStep {
        rows.push(row("  at the end", None, number(measured.end_error)));
    }
    rows.push(row("energy", None, number(measured.energy_drift)));
    if let Some(drift) = measured.casimir_drift {
        rows.push(row("Casimirs", None, number(drift)));
    }
    rows.push(row(
        found.tuner.cost().word(),
        predicted.map(|p| p.cost),
        or_dash(found.tuner.cost().of(measured)),
    ));
    if let Some(wall) = measured.wall {
        rows.push(row("time (noisy)", None, duration(wall.seconds)));
    }
    rows
}

/// Tensor defect and Casimir drift, in words, of a method that keeps the tensor to an order and is a Poisson map in
/// doubles. Returns `None` for any other method.
fn how_poisson(recommended: &Recommendation) -> Option<String> {
    let measured = &recommended.measured;
    let (Structure::Order(order), Some(defect), true) = (
        recommended.structure,
        measured.tensor_defect,
        measured.is_poisson,
    ) else {
        return None;
    };
    let casimirs = measured.casimir_drift;
    let casimirs = casimirs.map_or_else(String::new, |drift| {
        format!("; Casimirs are kept to the same order at least, here to {drift:.1e}")
    });
    Some(format!(
        "a Poisson map to order {order}, and in doubles at this step: its tensor defect is {defect:.1e}, round-off\
         {casimirs}"
    ))
}

/// The cheapest of all beside the cheapest Poisson map.
fn beside(recommended: &Recommendation, any: &Recommendation) -> String {
    let ratio = recommended.measured.cost() as f64 / any.measured.cost().max(1) as f64;
    let casimirs = any.measured.casimir_drift;
    let casimirs = casimirs.map_or_else(String::new, |drift| format!(", Casimirs {drift:.1e}"));
    format!(
        "the cheapest of all, not a Poisson map: {}, {}: {ratio:.1} times cheaper, error {:.1e}, \
         energy {:.1e}{casimirs}; --any takes it",
        any.name, any.setting, any.measured.error, any.measured.energy_drift,
    )
}

fn print_runners_up(found: &Found<'_>, console: &mut Console<'_>) {
    let tuning = found.tuning;
    let cells = |runner: &RunnerUp| {
        vec![
            if runner.is_poisson { "P" } else { "" }.to_owned(),
            runner.name.clone(),
            runner.setting.to_string(),
            format!("{:.2e}", runner.cost as f64),
            format!("{:.1e}", runner.error),
        ]
    };
    if tuning.runners_up.is_empty() {
        return;
    }
    let headings = [
        "",
        "runners-up",
        "setting",
        found.tuner.cost().word(),
        "error",
    ];
    let mut rows = vec![headings.map(str::to_owned).to_vec()];
    rows.extend(tuning.runners_up.iter().map(cells));
    for line in aligned_after(&rows, 3) {
        console.result(&format!("  {line}"));
    }
    console.result("");
}

fn print_missed(found: &Found<'_>, console: &mut Console<'_>) {
    let tuning = found.tuning;
    let kind = if found.any { "method" } else { "Poisson map" };
    console.result(&match (&tuning.nearest, tuning.limit) {
        (None, Some(Limit::Ended)) => {
            format!("no run was judged: it is not known whether a {kind} meets the bound")
        }
        (Some(_), Some(Limit::Ended)) => format!("no {kind} that was run meets the bound"),
        (None, Some(Limit::Reference)) => {
            format!("it is undecided whether a {kind} meets the bound")
        }
        _ => format!("no {kind} meets the bound"),
    });
    match (&tuning.nearest, tuning.limit) {
        (Some(reached), _) => {
            let lines = nearest(found, reached);
            lines.iter().for_each(|line| console.result(line));
        }
        (None, Some(Limit::Reference)) => console.result(&format!(
            "  the state itself is known to {:.1e} {} only: {}",
            found.tuner.reference().error,
            found.tuner.reference().judged().words(),
            match &tuning.horizon {
                Some(horizon) => horizon.to_string(),
                None => advice(Limit::Reference).to_owned(),
            }
        )),
        (None, Some(Limit::Structure)) => {
            console.result(&format!("  {}", advice(Limit::Structure)));
        }
        (None, Some(Limit::Ended)) => {
            console.result(&format!("  {}", advice(Limit::Ended)));
        }
        (None, limit) => console.result(&format!(
            "  no run came to its end within {:.1e} {}: {}",
            found.tuner.budget() as f64,
            found.tuner.cost().word(),
            advice(limit.unwrap_or(Limit::Budget))
        )),
    }
    if let Some(any) = tuning.any.as_ref().filter(|_| !found.any) {
        console.result(&format!(
            "  {}, {} meets the bound, and is not a Poisson map; --any takes it",
            any.name, any.setting
        ));
    }
}

fn nearest(found: &Found<'_>, reached: &Reached) -> [String; 2] {
    let names = found.bench.invariants();
    let drift = names.iter().zip(&reached.drift);
    let drift: Vec<String> = drift
        .map(|(name, drift)| format!("{name} {drift:.1e}"))
        .collect();
    [
        format!(
            "  the nearest is {}, {}: error {:.1e}, {}",
            reached.name,
            reached.setting,
            reached.error,
            drift.join(", ")
        ),
        format!(
            "  the {} is {:.1} times the bound: {}",
            reached.missed,
            reached.ratio,
            advice(reached.limit)
        ),
    ]
}

/// Advice where no method holds what is asked: the obstacle, and what to try.
pub(super) fn advice(limit: Limit) -> &'static str {
    match limit {
        Limit::Reference => {
            "the motion magnifies round-off too much to decide; shorten it with --time, or raise the bound"
        }
        Limit::RoundOff => {
            "smaller steps no longer help, round-off does not get smaller; shorten the run with \
             --time, or raise the bound"
        }
        Limit::Budget => "it would exceed the operations allowed for a run; raise --budget",
        Limit::Ended => "the time limit was reached first; raise --within",
        Limit::Structure => "none of the methods is a Poisson map; --any takes others",
        Limit::Failure => "its steps fail; choose another method with --only",
    }
}
