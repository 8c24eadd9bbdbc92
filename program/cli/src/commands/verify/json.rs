//! The survey as one object.

use leafwise::scene::json::Double;
use leafwise::verify::{self, Measured, Refused, Sampled, Survey};
use serde::Serialize;

/// The object of `verify --json`.
#[derive(Serialize)]
pub(super) struct SurveyJson<'a> {
    outcome: &'static str,
    seconds: Double,
    rows: Vec<Row<'a>>,
    refused: &'a [Refused],
    sampled: &'a [Sampled],
}

/// One step map on one problem.
#[derive(Serialize)]
struct Row<'a> {
    problem: &'a str,
    map: &'a str,
    is_own: bool,
    met: bool,
    declared: Declared<'a>,
    measured: Option<&'a Measured>,
    failure: Option<&'a str>,
    seconds: Double,
}

/// Declaration of a step map: its order and its structure.
#[derive(Serialize)]
struct Declared<'a> {
    order: usize,
    /// The order that seams and tables may reduce a step to; null where the formulas are smooth.
    smooth_order: Option<usize>,
    structure: &'a str,
}

impl<'a> SurveyJson<'a> {
    pub(super) fn of(survey: &'a Survey, seconds: f64) -> Self {
        Self {
            outcome: if survey.is_met() { "met" } else { "not met" },
            seconds: Double(seconds),
            rows: survey.rows.iter().map(Row::from).collect(),
            refused: &survey.refused,
            sampled: &survey.sampled,
        }
    }
}

impl<'a> From<&'a verify::Row> for Row<'a> {
    fn from(row: &'a verify::Row) -> Self {
        Self {
            problem: &row.problem,
            map: &row.map,
            is_own: row.is_own,
            met: row.is_met(),
            declared: Declared {
                order: row.declared_order,
                smooth_order: row.smooth_order,
                structure: &row.declared_structure,
            },
            measured: row.measured.as_ref(),
            failure: row.failure.as_deref(),
            seconds: Double(row.seconds),
        }
    }
}
