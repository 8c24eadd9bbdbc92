//! Contents of the page `report.html`, from what the directory holds.

use leafwise_expression::words::counted;

use super::drive::Session;
use super::error::RunError;
use super::outcome::{RunOutcome, RunReport};
use super::sampled::columns_of_states;
use super::shown::{rounded, short, value};
use super::structure::structure;
use super::trajectory::trajectory;
use super::whole_states::whole_states;
use crate::advice::lines;
use crate::{PROGRAM_VERSION, plugins};
use leafwise_report::{InvariantSeries, Outcome, Recorded, ReportData, SectionPoints, TimeSeries};
use leafwise_scene::compose::{ComposedRun, Observable};
use leafwise_scene::document::SceneDocument;
use leafwise_walk::{SampleTimes, Section};

/// The most samples that a report is drawn from.
pub(crate) const MOST_ROWS: u64 = 50_000;

/// The part of a column's changes along the run that it has to change by on a section to be drawn over.
const STILL: f64 = 1e-9;

/// Runs of more steps than this are drawn over a logarithmic time axis.
const LONG_RUN: u64 = 200_000;

/// Gathers the report of a run that has ended.
pub(super) fn report_data(
    document: &SceneDocument,
    run: &ComposedRun,
    session: &Session<'_>,
    report: &RunReport,
    command: &str,
) -> Result<ReportData, RunError> {
    let stride = usize::try_from(report.samples.div_ceil(MOST_ROWS))
        .unwrap_or(1)
        .max(1);
    let rows = session.samples().read(stride)?;
    let times: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let width = columns_of_states(session, run);
    let column = |at: usize| -> Vec<f64> {
        rows.iter()
            .map(|row| row.get(at).copied().unwrap_or(f64::NAN))
            .collect()
    };
    let energy = run
        .plan
        .observables
        .iter()
        .position(|o| matches!(o, Observable::Invariant { index: 0, .. }));
    let formulas = run.plan.observables.iter().enumerate();
    let formulas = formulas.filter(|(_, o)| !matches!(o, Observable::Invariant { .. }));
    let windows = session.windows();
    let ends = windows.ends();
    let shadow = run.plan.shadow.map(|shadow| {
        let values = column(1 + width + shadow.at);
        let reference = values.first().copied().unwrap_or(f64::NAN);
        let later = values.iter().skip(1);
        InvariantSeries {
            name: format!("{}, at the samples", run.plan.observables[shadow.at].name()),
            reference,
            times: times.iter().skip(1).copied().collect(),
            deviations: later.map(|value| (value - reference).abs()).collect(),
        }
    });
    let invariants = report
        .invariants
        .iter()
        .enumerate()
        .map(|(index, invariant)| InvariantSeries {
            name: invariant.name.clone(),
            reference: invariant.initial,
            times: ends.clone(),
            deviations: windows.series(index),
        })
        .chain(shadow)
        .collect();
    let evaluations = windows.evaluations_per_step((run.plan.drift_every, report.steps));
    let whole = match run.plan.sites.geometry.families.is_empty() {
        true => Vec::new(),
        false => whole_states(run, session)?,
    };
    let solver = TimeSeries {
        times: ends.iter().take(evaluations.len()).copied().collect(),
        values: evaluations,
    };
    Ok(ReportData {
        title: title(&document.name),
        version: format!("leafwise {PROGRAM_VERSION}"),
        command: command.to_owned(),
        scene_name: file_name(&document.name),
        scene_text: document.text.clone(),
        outcome: outcome(run, report),
        method: method_lines(run),
        advice: lines(&report.advice),
        facts: facts(run, session, report),
        invariants,
        logarithmic_time: report.steps > LONG_RUN,
        drift_every: run.plan.drift_every,
        work: work(run),
        energy: energy.map(|at| TimeSeries {
            times: times.clone(),
            values: column(1 + width + at),
        }),
        observables: formulas
            .map(|(at, observable)| {
                let series = TimeSeries {
                    times: times.clone(),
                    values: column(1 + width + at),
                };
                (observable.name().to_owned(), series)
            })
            .collect(),
        section: section(run, session, &rows)?,
        trajectory: trajectory(run, session, (times.clone(), &whole), &rows, width),
        structure: structure(&run.plan.sites, &whole, report.samples),
        recorded: Some(recorded(run, width, rows)),
        solver: (!solver.times.is_empty()).then_some(solver),
    })
}

/// How the motion itself changes the energy, in words.
fn work(run: &ComposedRun) -> Option<String> {
    let by_forces = run.work_of_forces().filter(|_| !run.keeps_energy);
    let by_events = || Some("changes by the events".to_owned());
    by_forces.or_else(|| run.plan.events.act.as_ref().and_then(|_| by_events()))
}

/// The samples under their names.
fn recorded(run: &ComposedRun, width: usize, rows: Vec<Vec<f64>>) -> Recorded {
    let states = run.plan.states.names().into_iter().take(width);
    let observables = run.plan.observables.iter().map(|o| o.name().to_owned());
    Recorded {
        names: (std::iter::once("t".to_owned())
            .chain(states)
            .chain(observables))
        .collect(),
        coordinates: width,
        rows,
    }
}

/// The states on a section to draw: over the axes that the scene names, or else over the first two columns that vary there;
/// `recorded` are the samples.
fn section(
    run: &ComposedRun,
    session: &Session<'_>,
    recorded: &[Vec<f64>],
) -> Result<Option<SectionPoints>, RunError> {
    let events = &run.plan.events;
    let (Some(section), Some(crossings)) = (&events.section, session.crossings()) else {
        return Ok(None);
    };
    let stride = usize::try_from(crossings.count().div_ceil(MOST_ROWS)).unwrap_or(1);
    let rows = crossings.read(stride)?;
    let mut names = match session.has_states_in_samples() {
        true => run.plan.states.names(),
        false => Vec::new(),
    };
    names.extend(run.plan.observables.iter().map(|o| o.name().to_owned()));
    let moves = |column: usize| spread(recorded, 1 + column);
    Ok(section_points(
        (section, &events.axes),
        &names,
        (&rows, 1),
        moves,
    ))
}

/// Points of a section: two of the columns `names` over each other; they begin at the place `first` in rows. The scene
/// asks for two, or they are the first two that vary by more than a small part of what they vary by elsewhere.
pub(crate) fn section_points(
    (section, axes): (&Section, &Option<[String; 2]>),
    names: &[String],
    (rows, first): (&[Vec<f64>], usize),
    elsewhere: impl Fn(usize) -> f64,
) -> Option<SectionPoints> {
    let varies = |column: &usize| spread(rows, first + column) > STILL * elsewhere(*column);
    let axes: Vec<usize> = match axes {
        Some(axes) => (axes.iter())
            .filter_map(|axis| names.iter().position(|name| name == axis))
            .collect(),
        None => (0..names.len()).filter(varies).take(2).collect(),
    };
    let [x, y] = axes[..] else { return None };
    Some(SectionPoints {
        title: format!("{}, {}", section.text, section.direction_in_words()),
        names: [x, y].map(|column| names[column].clone()),
        points: rows
            .iter()
            .map(|row| [value(row, first + x), value(row, first + y)])
            .collect(),
        members: Vec::new(),
    })
}

/// The largest difference of a column's values.
pub(crate) fn spread(rows: &[Vec<f64>], column: usize) -> f64 {
    let values = || rows.iter().map(|row| value(row, column));
    let (least, most) = (values().reduce(f64::min), values().reduce(f64::max));
    most.zip(least).map_or(0.0, |(most, least)| most - least)
}

/// A path's last part.
pub(crate) fn file_name(path: &str) -> String {
    let name = std::path::Path::new(path).file_name();
    name.map_or_else(
        || path.to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// "rigid_body.toml" as "Rigid body".
pub(crate) fn title(name: &str) -> String {
    let stem = std::path::Path::new(name)
        .file_stem()
        .map(|stem| stem.to_string_lossy());
    let words = stem.unwrap_or_default().replace(['_', '-'], " ");
    let mut letters = words.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => "Run".to_owned(),
    }
}

/// " after t0 = 2" where formulas count the time from another origin than the run.
pub fn after_origin(run: &ComposedRun) -> String {
    let clock = run.plan.layout.clock();
    let origin = clock.map(|clock| run.plan.initial[clock.time]);
    let origin = origin.filter(|t0| *t0 != 0.0);
    origin.map_or_else(String::new, |t0| format!(" after t0 = {}", short(t0)))
}

fn outcome(run: &ComposedRun, report: &RunReport) -> Outcome {
    let at = format!("t = {}", short(report.time));
    match &report.outcome {
        RunOutcome::Done => Outcome::Done {
            message: format!("{} to {at}", counted(report.steps as usize, "step")),
        },
        RunOutcome::Stopped(condition) => Outcome::Done {
            message: format!(
                "stopped at {at}{}: {condition}, after {}",
                after_origin(run),
                counted(report.steps as usize, "step")
            ),
        },
        RunOutcome::Interrupted => {
            let whole = match run.plan.until {
                None => format!("{} of {} steps, at {at}", report.steps, run.plan.steps),
                Some(until) => format!("{} steps, at {at} of {}", report.steps, short(until)),
            };
            Outcome::Interrupted {
                message: format!("after {whole}; the same command resumes the run"),
            }
        }
        RunOutcome::Failed(failure) => Outcome::Failed {
            message: failure.message.clone(),
            step: failure.step,
            time: failure.time,
            state: run
                .names()
                .into_iter()
                .zip(failure.state.iter().copied())
                .collect(),
            hint: failure.hint.clone(),
        },
    }
}

pub(crate) fn method_lines(run: &ComposedRun) -> Vec<(String, String)> {
    let method = &run.method;
    let pace = run.pace();
    let line = |label: &str, text: String| (label.to_owned(), text);
    let mut lines: Vec<_> = method
        .parts(run.system.motion())
        .into_iter()
        .map(|(label, text)| line(label, text))
        .collect();
    lines.extend([
        line(
            "Declared order",
            match method.declared_order() {
                0 => "none in t = εh: its tolerance sets its error".to_owned(),
                order if method.noise().is_some() => format!("{order} in t = εh, of means"),
                order if method.written().is_some() => {
                    format!("{order} in t = εh (a lower bound: Theorem 2)")
                }
                order => format!("{order} in t = εh"),
            },
        ),
        line(
            "Step",
            format!(
                "ε = {}, h = {}: {} advances by {}",
                short(run.plan.epsilon),
                short(run.plan.h),
                if pace.is_some() { "τ" } else { "t" },
                short(run.plan.epsilon * run.plan.h)
            ),
        ),
        line("Tensor", run.tensor_shape().to_string()),
    ]);
    lines.extend(pace.map(|pace| line("Pace", format!("dt/dτ = {}", pace.text))));
    lines.extend(plugins(run).into_iter().map(|library| {
        let parts: Vec<String> = library.parts.keys().cloned().collect();
        line(
            "Library",
            format!(
                "{}: {} {}, sha256 {}",
                parts.join(", "),
                library.path.display(),
                library.version,
                library.sha256
            ),
        )
    }));
    lines.extend(
        method
            .costs()
            .into_iter()
            .map(|(label, cost)| line(label, cost)),
    );
    lines
}

fn facts(run: &ComposedRun, session: &Session<'_>, report: &RunReport) -> Vec<(String, String)> {
    let statistics = &report.statistics;
    let mut facts = vec![
        ("Steps".to_owned(), report.steps.to_string()),
        ("Time reached".to_owned(), short(report.time)),
        ("Solver".to_owned(), statistics.summary()),
        (
            "Integration".to_owned(),
            format!(
                "{} s, {:.0} steps a second",
                rounded(report.wall_seconds, 3),
                report.steps as f64 / report.wall_seconds.max(1e-9)
            ),
        ),
        (
            "Samples".to_owned(),
            match &run.plan.samples {
                SampleTimes::Interval(interval) => {
                    format!("{}, every {} of time", report.samples, short(*interval))
                }
                SampleTimes::Given(_) => format!("{}, at given times", report.samples),
                SampleTimes::Every(1) => format!("{}, at every step", report.samples),
                SampleTimes::Every(every) => format!("{}, every {every} steps", report.samples),
            },
        ),
    ];
    if let (Some(section), Some(count)) = (&run.plan.events.section, report.crossings) {
        let count = counted(count as usize, "crossing");
        let text = format!(
            "{count} of {}, {}",
            section.text,
            section.direction_in_words()
        );
        facts.push(("Section".to_owned(), text));
        let acts = run.plan.events.act_text();
        facts.extend(acts.map(|text| ("Events".to_owned(), text)));
    }
    if let Some(directory) = session.directory() {
        facts.push(("Data".to_owned(), directory.display().to_string()));
    }
    facts.extend(
        report
            .shadow
            .map(|shadow| ("Shadow energy".to_owned(), shadow.text())),
    );
    facts.extend(
        report
            .chaos
            .map(|chaos| ("Motion".to_owned(), chaos.text())),
    );
    facts.extend(run.work_of_forces().map(|text| ("Energy".to_owned(), text)));
    if let Some([least, most]) = report.step_times {
        let text = format!("{} to {}", rounded(least, 4), rounded(most, 4));
        facts.insert(1, ("Steps of t".to_owned(), text));
    }
    let parameters: Vec<String> = run
        .system
        .parameters()
        .iter()
        .map(|parameter| format!("{} = {}", parameter.name, short(parameter.value)))
        .collect();
    if !parameters.is_empty() {
        facts.push(("Parameters".to_owned(), parameters.join(", ")));
    }
    facts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_and_numbers_read_well() {
        assert_eq!(title("scenes/rigid_body.toml"), "Rigid body");
        assert_eq!(short(0.1 * 2.0 * 1000.0), "200");
        assert_eq!(short(0.30000000000000004), "0.3");
        assert_eq!(short(6e-25), "6e-25");
        assert_eq!(rounded(0.005_192_3, 3), "0.00519");
    }
}
