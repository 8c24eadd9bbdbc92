//! Results of an ensemble as JSON: counts of members, statistics, drifts, losses and failures.

use leafwise_core::SolverStatistics;
use leafwise_scene::json::{Double, object};
use serde::Serialize;

use super::plan::ComposedEnsemble;
use super::quantiles::Quantile;
use super::report::EnsembleReport;
use super::statistics::{Deviation, MemberFailure, Summary};
use super::store::columns;
use super::tables::summaries;
use crate::SolverFields;

/// The end of an ensemble's manifest; the object of `ensemble --json`, but for its advice and directory.
#[derive(Clone, Debug, Serialize)]
pub struct EnsembleEnding<'a> {
    members: u64,
    done: u64,
    failed: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped_by: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    crossings: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<u64>,
    time: Double,
    wall_seconds: f64,
    members_per_second: f64,
    #[serde(with = "SolverFields")]
    solver: SolverStatistics,
    #[serde(serialize_with = "object")]
    drift: Vec<(&'a str, Drift)>,
    statistics: Vec<AtTime<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    losses: Vec<LossFields>,
    failures: &'a [MemberFailure],
    #[serde(skip_serializing_if = "Option::is_none")]
    final_states: Option<FinalStatesFields>,
    outcome: &'static str,
}

/// Where the members' last states are, and what the columns hold.
#[derive(Clone, Debug, Serialize)]
struct FinalStatesFields {
    file: &'static str,
    shape: (u64, usize),
    columns: Vec<String>,
}

/// The members that have ended by a time.
#[derive(Clone, Debug, Serialize)]
struct LossFields {
    time: Double,
    stopped: u64,
    members: u64,
    fraction: Double,
    interval: [Double; 2],
}

/// How far an invariant strayed, over all members.
#[derive(Clone, Debug, Serialize)]
struct Drift {
    maximum: Double,
    member: u64,
    mean: Double,
    relative: Double,
}

/// The observables at one time.
#[derive(Clone, Debug, Serialize)]
struct AtTime<'a> {
    time: Double,
    #[serde(flatten, serialize_with = "object")]
    observables: Vec<(&'a str, SummaryFields)>,
}

/// One observable at one time.
#[derive(Clone, Debug, Serialize)]
struct SummaryFields {
    count: u64,
    undefined: u64,
    mean: Double,
    variance: Double,
    standard_error: Double,
    minimum: Double,
    minimum_member: u64,
    maximum: Double,
    maximum_member: u64,
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "object")]
    quantiles: Vec<(String, Double)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rank_error: Option<Double>,
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "object")]
    rank_errors: Vec<(String, Double)>,
}

impl<'a> EnsembleEnding<'a> {
    /// Describes an ensemble that has ended.
    pub fn new(ensemble: &'a ComposedEnsemble, report: &'a EnsembleReport) -> Self {
        let all = &report.reductions;
        let invariants = ensemble.invariant_names().into_iter().enumerate();
        let stop = ensemble.run.plan.events.stop.as_ref();
        let rows: Vec<(f64, &str, &Summary)> = summaries(ensemble, report).collect();
        Self {
            members: ensemble.population.members(),
            done: all.done(),
            failed: all.failed,
            stopped: stop.map(|_| all.stopped),
            stopped_by: stop.map(|stop| stop.text.as_str()),
            crossings: report.crossings,
            steps: ensemble.steps(),
            time: Double(ensemble.end()),
            wall_seconds: report.wall_seconds,
            members_per_second: report.rate(),
            solver: all.statistics,
            drift: invariants
                .map(|(at, name)| (name, Drift::of(report, at)))
                .collect(),
            statistics: rows
                .chunk_by(|a, b| a.0 == b.0)
                .map(|rows| AtTime::of(ensemble, rows))
                .collect(),
            losses: ensemble
                .losses(all)
                .into_iter()
                .map(|loss| LossFields {
                    time: Double(loss.time),
                    stopped: loss.stopped,
                    members: loss.members,
                    fraction: Double(loss.fraction),
                    interval: loss.interval.map(Double),
                })
                .collect(),
            failures: &all.failures,
            final_states: columns(ensemble).map(|(file, columns)| FinalStatesFields {
                file,
                shape: (all.members, columns.len()),
                columns,
            }),
            outcome: report.outcome.word(),
        }
    }
}

impl Drift {
    fn of(report: &EnsembleReport, at: usize) -> Self {
        let all = &report.reductions;
        let whole: &Deviation = &all.whole[at];
        Self {
            maximum: Double(whole.maximum),
            member: whole.member,
            mean: Double(whole.mean()),
            relative: Double(all.relative[at].maximum),
        }
    }
}

impl<'a> AtTime<'a> {
    fn of(ensemble: &ComposedEnsemble, rows: &[(f64, &'a str, &Summary)]) -> Self {
        let fields = |summary| SummaryFields::of(ensemble, summary);
        Self {
            time: Double(rows[0].0),
            observables: rows
                .iter()
                .map(|(_, name, summary)| (*name, fields(summary)))
                .collect(),
        }
    }
}

impl SummaryFields {
    fn of(ensemble: &ComposedEnsemble, summary: &Summary) -> Self {
        let parts = &ensemble.quantiles;
        let quantiles = summary.quantiles(parts);
        let by_part = |value: fn(&Quantile) -> f64| -> Vec<(String, Double)> {
            let named = parts.iter().zip(&quantiles);
            named
                .map(|(p, of)| (format!("{p:?}"), Double(value(of))))
                .collect()
        };
        let errors = quantiles.iter().map(|of| of.rank_error);
        Self {
            count: summary.count,
            undefined: summary.undefined,
            mean: Double(summary.mean),
            variance: Double(summary.variance()),
            standard_error: Double(summary.standard_error()),
            minimum: Double(summary.minimum.0),
            minimum_member: summary.minimum.1,
            maximum: Double(summary.maximum.0),
            maximum_member: summary.maximum.1,
            rank_error: errors.reduce(f64::max).map(Double),
            quantiles: by_part(|of| of.value),
            rank_errors: by_part(|of| of.rank_error),
        }
    }
}
