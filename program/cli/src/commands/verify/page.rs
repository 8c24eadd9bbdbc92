//! The survey as the data of a page.

use leafwise::report::{ErrorLine, RefusedParts, SurveyData, SurveyedMap, SurveyedProblem};
use leafwise::run::PROGRAM_VERSION;
use leafwise::verify::{Row, Survey};

use super::row::{HEADINGS, cells};

/// Errors and a table for each problem, then what does not fit.
pub(super) fn data(survey: &Survey) -> SurveyData {
    let problems = survey.rows.chunk_by(|a, b| a.problem == b.problem);
    let refusals = survey.refusals();
    let refused = refusals.chunk_by(|a, b| a.problem == b.problem);
    SurveyData {
        title: "Measured behaviour of every part, against its declaration".to_owned(),
        version: format!("leafwise {PROGRAM_VERSION}"),
        headings: HEADINGS.map(str::to_owned).to_vec(),
        problems: problems.map(problem).collect(),
        refused: refused
            .map(|of_problem| RefusedParts {
                name: of_problem[0].problem.to_owned(),
                causes: of_problem
                    .iter()
                    .map(|refusal| (refusal.who.join(", "), refusal.cause.to_owned()))
                    .collect(),
            })
            .collect(),
    }
}

fn problem(rows: &[Row]) -> SurveyedProblem {
    let line = |row: &Row| {
        Some(ErrorLine {
            map: row.map.clone(),
            order: row.declared_order,
            points: row.measured.as_ref()?.errors.clone(),
        })
    };
    SurveyedProblem {
        name: rows
            .first()
            .map_or_else(String::new, |row| row.problem.clone()),
        lines: rows.iter().filter_map(line).collect(),
        rows: rows
            .iter()
            .map(|row| SurveyedMap {
                cells: cells(row),
                is_met: row.is_met(),
            })
            .collect(),
    }
}
