//! Page of an ensemble's report: the data that it shows.

use std::io;

use leafwise_expression::words::counted;

use super::plan::ComposedEnsemble;
use super::report::{EnsembleReport, percent};
use super::section::{columns, heading};
use super::tables::summaries;
use crate::advice::lines;
use crate::samples::{self, SECTION};
use crate::summary::{MOST_ROWS, section_points, spread};
use crate::{PROGRAM_VERSION, RunOutcome, file_name, method_lines, short, title};
use leafwise_report::{Band, EnsembleData, InvariantSeries, Losses, Outcome, SectionPoints};
use leafwise_scene::document::SceneDocument;

/// Failed members that the page lists.
const MOST_SHOWN: usize = 50;

/// Gathers the report of an ensemble that has ended.
pub(super) fn data(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    report: &EnsembleReport,
    command: &str,
) -> io::Result<EnsembleData> {
    let all = &report.reductions;
    let plan = &ensemble.run.plan;
    let members = ensemble.population.members();
    let end = short(ensemble.end());
    let stop = plan.events.stop.as_ref();
    let stopped = || match stop {
        Some(stop) => format!("{} stopped by {}, ", all.stopped, stop.text),
        None => String::new(),
    };
    let outcome = match &report.outcome {
        RunOutcome::Done | RunOutcome::Stopped(_) | RunOutcome::Failed(_) => Outcome::Done {
            message: format!(
                "{members} members to t = {end}, {}{} failed",
                stopped(),
                all.failed
            ),
        },
        RunOutcome::Interrupted => Outcome::Interrupted {
            message: format!(
                "after {} of {members} members; the same command resumes",
                all.members
            ),
        },
    };
    let line = |label: &str, text: String| (label.to_owned(), text);
    let mut facts = vec![
        line(
            "Members",
            format!(
                "{} of {members}, {}{} failed",
                all.members,
                stopped(),
                all.failed
            ),
        ),
        match ensemble.steps() {
            Some(steps) => line("Steps of each", format!("{steps} to t = {end}")),
            None => line(
                "Steps of each",
                format!(
                    "its own, at the pace {}, to t = {end}",
                    ensemble.run.pace().map_or("", |pace| &pace.text)
                ),
            ),
        },
        line(
            "Integration",
            format!(
                "{:.3} s, {:.0} members a second",
                report.wall_seconds,
                report.rate()
            ),
        ),
        line("Solver", all.statistics.summary()),
    ];
    // What no command has written is in a directory of the moment.
    if !command.is_empty() {
        facts.push(line("Data", report.directory.display().to_string()));
    }
    let losses = ensemble.losses(all);
    if let Some(last) = losses.last() {
        let [low, high] = last.interval.map(percent);
        let text = format!(
            "{} %, between {low} and {high} % with 95 % confidence",
            percent(last.fraction)
        );
        facts.insert(1, line("Stopped", text));
    }
    if let (Some(section), Some(count)) = (&plan.events.section, report.crossings) {
        let (count, which) = (
            counted(count as usize, "crossing"),
            section.direction_in_words(),
        );
        let text = format!("{count} of {}, {which}", section.text);
        let last = facts.len() - usize::from(!command.is_empty());
        facts.insert(last, line("Section", text));
    }
    let names = ensemble.observables();
    let mut bands: Vec<Band> = names.iter().map(|name| Band::new(name)).collect();
    for (at, (time, _, summary)) in summaries(ensemble, report).enumerate() {
        if summary.count == 0 {
            continue;
        }
        let band = &mut bands[at % names.len()];
        band.times.push(time);
        band.means.push(summary.mean);
        band.confidences.push(summary.confidence());
        band.deviations.push(summary.deviation());
        band.ranges.push((summary.minimum.0, summary.maximum.0));
        let quantiles = summary.quantiles(&ensemble.quantiles);
        band.quantiles
            .push(quantiles.iter().map(|of| of.value).collect());
    }
    let ends: Vec<f64> = ensemble
        .window_ends()
        .into_iter()
        .map(|mark| ensemble.clock.time(mark))
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
    Ok(EnsembleData {
        losses: Losses {
            condition: stop.map_or_else(String::new, |stop| stop.text.clone()),
            times: losses.iter().map(|loss| loss.time).collect(),
            fractions: losses.iter().map(|loss| loss.fraction).collect(),
            intervals: losses.iter().map(|loss| loss.interval).collect(),
        },
        section: section(ensemble, report)?,
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
        ranks: report.ranks(ensemble),
        bands,
        drifts: drifts.collect(),
        drift_every: ensemble.course.invariants_every,
        failures: failures.collect(),
    })
}

/// The crossings of all members, to draw.
fn section(
    ensemble: &ComposedEnsemble,
    report: &EnsembleReport,
) -> io::Result<Option<SectionPoints>> {
    let events = &ensemble.run.plan.events;
    let (Some(section), Some(count)) = (&events.section, report.crossings) else {
        return Ok(None);
    };
    let stride = usize::try_from(count.div_ceil(MOST_ROWS)).unwrap_or(1);
    let path = report.directory.join(SECTION);
    let headings = heading(ensemble).len() as u64;
    let rows = samples::read(&path, headings, count, stride.max(1))?;
    let names = columns(ensemble);
    // On the section a coordinate may be held: it varies by round-off alone.
    let largest = (0..names.len()).map(|column| spread(&rows, 2 + column));
    let largest = largest.fold(0.0, f64::max);
    let points = section_points((section, &events.axes), &names, (&rows, 2), |_| largest);
    Ok(points.map(|points| SectionPoints {
        members: rows.iter().map(|row| row[0] as u64).collect(),
        ..points
    }))
}
