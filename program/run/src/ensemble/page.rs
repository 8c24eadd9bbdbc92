//! What the report of an ensemble shows.

use super::plan::ComposedEnsemble;
use super::report::EnsembleReport;
use super::tables::summaries;
use crate::advice::lines;
use crate::{PROGRAM_VERSION, RunOutcome, file_name, method_lines, short, title};
use leafwise_report::{Band, EnsembleData, InvariantSeries, Outcome};
use leafwise_scene::document::SceneDocument;

/// Failed members that the page lists.
const MOST_SHOWN: usize = 50;

/// Gathers the report of an ensemble that has ended.
pub(super) fn data(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    report: &EnsembleReport,
    command: &str,
) -> EnsembleData {
    let all = &report.reductions;
    let plan = &ensemble.run.plan;
    let members = ensemble.population.members();
    let end = short(ensemble.time(plan.steps));
    let outcome = match &report.outcome {
        RunOutcome::Done | RunOutcome::Stopped(_) | RunOutcome::Failed(_) => Outcome::Done {
            message: format!("{members} members to t = {end}, {} failed", all.failed),
        },
        RunOutcome::Interrupted => Outcome::Interrupted {
            message: format!(
                "after {} of {members} members; the same command resumes",
                all.members
            ),
        },
    };
    let line = |label: &str, text: String| (label.to_owned(), text);
    let facts = vec![
        line(
            "Members",
            format!("{} of {members}, {} failed", all.members, all.failed),
        ),
        line("Steps of each", format!("{} to t = {end}", plan.steps)),
        line(
            "Integration",
            format!(
                "{:.3} s, {:.0} members a second",
                report.wall_seconds,
                report.rate()
            ),
        ),
        line("Solver", all.statistics.summary()),
        line("Data", report.directory.display().to_string()),
    ];
    let names = ensemble.observables();
    let mut bands: Vec<Band> = names.iter().map(|name| Band::new(name)).collect();
    for (at, (steps, _, summary)) in summaries(ensemble, report).enumerate() {
        if summary.count == 0 {
            continue;
        }
        let band = &mut bands[at % names.len()];
        band.times.push(ensemble.time(steps));
        band.means.push(summary.mean);
        band.deviations.push(summary.deviation());
        band.ranges.push((summary.minimum.0, summary.maximum.0));
        band.quantiles.push(summary.quantiles(&ensemble.quantiles));
    }
    let ends: Vec<f64> = ensemble
        .window_ends()
        .into_iter()
        .map(|k| ensemble.time(k))
        .collect();
    let invariants = ensemble.invariant_names();
    let drifts = invariants
        .iter()
        .enumerate()
        .map(|(at, name)| InvariantSeries {
            name: (*name).to_owned(),
            reference: all.initial[at].mean,
            times: ends.clone(),
            deviations: all
                .windows
                .iter()
                .skip(at)
                .step_by(invariants.len())
                .map(|deviation| deviation.maximum)
                .collect(),
        });
    let failures = all.failures.iter().take(MOST_SHOWN).map(|failure| {
        let text = format!(
            "step {}, t = {}: {}",
            failure.step,
            short(failure.time),
            failure.message
        );
        (format!("member {}", failure.member), text)
    });
    EnsembleData {
        title: title(&document.name),
        version: format!("leafwise {PROGRAM_VERSION}"),
        command: command.to_owned(),
        scene_name: file_name(&document.name),
        scene_text: document.text.clone(),
        outcome,
        advice: lines(&report.advice),
        facts,
        method: method_lines(&ensemble.run),
        parts: ensemble.quantiles.clone(),
        bands,
        drifts: drifts.collect(),
        drift_every: ensemble.drift_every,
        failures: failures.collect(),
    }
}
