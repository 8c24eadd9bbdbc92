//! `leafwise verify`: what every part really does, against what it declares.

use std::fs;

use leafwise::core::Registry;
use leafwise::scene::json::json_number;
use leafwise::verify::{Judgement, Measured, Problem, Row, Survey, SurveyOptions, survey};
use serde_json::{Value, json};

use crate::arguments::{SceneArguments, VerifyArguments};
use crate::commands::verify_page::page;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::scene::load;
use crate::table::words;

/// The systems measured when no scene is named: linear, log-canonical, and six-dimensional.
const PROBLEMS: [&str; 3] = ["rigid-body", "lotka-volterra-periodic", "heavy-top"];

/// Lattices of the library are too long to be written out.
const LATTICES: [&str; 2] = ["toda", "volterra-lattice"];

/// Measures; returns the exit code.
///
/// # Errors
/// [`Failure`] when the scene is not valid or the page cannot be written.
pub fn execute(arguments: &VerifyArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    let problems = problems(arguments)?;
    let registry = Registry::with_builtin();
    let options = SurveyOptions {
        full: arguments.full,
    };
    let mut shown = String::new();
    let survey = survey(&registry, &problems, &options, &mut |problem, _| {
        if shown != problem {
            problem.clone_into(&mut shown);
            console.prose(&format!("measuring on {problem} ..."));
        }
    })
    .map_err(|error| {
        Failure::usage(
            error.to_string(),
            "choose an initial state and a step that the system bears",
        )
    })?;
    if let Some(file) = &arguments.html {
        fs::write(file, page(&survey)).map_err(|source| Failure::File {
            action: "write",
            file: file.clone(),
            source,
        })?;
    }
    if arguments.json {
        console.json(&as_json(&survey));
    } else {
        print(&survey, console);
    }
    Ok(if survey.is_met() {
        exit::DONE
    } else {
        exit::CHECK_FAILED
    })
}

fn problems(arguments: &VerifyArguments) -> Result<Vec<Problem>, Failure> {
    if let Some(scene) = &arguments.scene {
        let document = load(&SceneArguments {
            scene: scene.clone(),
            overrides: arguments.overrides.clone(),
        })?;
        let problem = Problem::of_scene(&document)
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

/// The headings of the table and the page.
pub(super) const HEADINGS: [&str; 9] = [
    "",
    "map",
    "order (declared)",
    "defect of a step",
    "structure",
    "self-adjoint",
    "Casimirs",
    "energy, growth",
    "evaluations, ns",
];

/// The cells of a row.
pub(super) fn cells(row: &Row) -> Vec<String> {
    let mark = if row.is_met() { "ok" } else { "FAILS" };
    let mut cells = vec![mark.to_owned(), row.map.clone()];
    let Some(measured) = &row.measured else {
        cells.push(row.failure.clone().unwrap_or_default());
        return cells;
    };
    let order = match measured.order {
        Some(order) => format!("{order:.2}"),
        None if measured.smallest_error < 1e-12 => "round-off".to_owned(),
        None => "not seen".to_owned(),
    };
    cells.extend([
        format!("{order} ({}){}", row.declared_order, flag(measured, 0)),
        measured
            .tensor_defect
            .map_or_else(|| "-".to_owned(), |defect| format!("{defect:.1e}")),
        format!(
            "{} ({}){}",
            match measured.structure_order {
                Some(order) => format!("{order:.2}"),
                None if measured.tensor_defect.is_some() => "round-off".to_owned(),
                None => "-".to_owned(),
            },
            row.declared_structure,
            flag(measured, 1)
        ),
        format!("{:.1e}{}", measured.self_adjointness, flag(measured, 2)),
        format!("{:.1e}", measured.casimir_drift),
        match measured.energy_growth {
            Some(growth) => format!("{:.1e} x{growth:.1}", measured.energy_drift),
            None => format!("{:.1e}", measured.energy_drift),
        },
        format!(
            "{:.2}, {:.0}",
            measured.evaluations_per_step, measured.nanoseconds_per_step
        ),
    ]);
    cells
}

fn flag(measured: &Measured, which: usize) -> &'static str {
    if measured.judgements[which] == Judgement::NotMet {
        " !"
    } else {
        ""
    }
}

fn print(survey: &Survey, console: &mut Console<'_>) {
    let mut problem = "";
    let mut rows: Vec<Vec<String>> = Vec::new();
    let flush = |problem: &str, rows: &mut Vec<Vec<String>>, console: &mut Console<'_>| {
        if rows.is_empty() {
            return;
        }
        console.result("");
        console.result(problem);
        rows.insert(0, HEADINGS.map(str::to_owned).to_vec());
        for line in words(rows) {
            console.result(&format!("  {line}"));
        }
        rows.clear();
    };
    for row in &survey.rows {
        if row.problem != problem {
            flush(problem, &mut rows, console);
            problem = &row.problem;
        }
        rows.push(cells(row));
    }
    flush(problem, &mut rows, console);
    if !survey.refused.is_empty() {
        console.result("");
        console.result("combinations that do not fit");
        for (name, reason) in &survey.refused {
            console.result(&format!("  {name}: {reason}"));
        }
    }
    let failing = survey.rows.iter().filter(|row| !row.is_met()).count();
    console.result("");
    console.result(&match failing {
        0 => format!(
            "every declaration of {} step maps is met",
            survey.rows.len()
        ),
        1 => "one step map does not meet what it declares".to_owned(),
        many => format!("{many} step maps do not meet what they declare"),
    });
}

fn as_json(survey: &Survey) -> Value {
    let rows: Vec<Value> = survey
        .rows
        .iter()
        .map(|row| {
            json!({
                "problem": row.problem,
                "map": row.map,
                "met": row.is_met(),
                "declared": { "order": row.declared_order, "structure": row.declared_structure },
                "measured": row.measured.as_ref().map(measured_json),
                "failure": row.failure,
            })
        })
        .collect();
    let refused: Vec<Value> = survey
        .refused
        .iter()
        .map(|(name, reason)| json!({ "combination": name, "reason": reason }))
        .collect();
    json!({
        "outcome": if survey.is_met() { "met" } else { "not met" },
        "rows": rows,
        "refused": refused,
    })
}

fn measured_json(measured: &Measured) -> Value {
    json!({
        "order": measured.order.map(json_number),
        "order_standard_error": measured.order_error.map(json_number),
        "smallest_error": json_number(measured.smallest_error),
        "structure_order": measured.structure_order.map(json_number),
        "tensor_defect": measured.tensor_defect.map(json_number),
        "self_adjointness": json_number(measured.self_adjointness),
        "casimir_drift": json_number(measured.casimir_drift),
        "energy_drift": json_number(measured.energy_drift),
        "energy_growth": measured.energy_growth.map(json_number),
        "evaluations_per_step": json_number(measured.evaluations_per_step),
        "nanoseconds_per_step": json_number(measured.nanoseconds_per_step),
        "judgements": {
            "order": measured.judgements[0],
            "structure": measured.judgements[1],
            "self_adjoint": measured.judgements[2],
        },
    })
}
