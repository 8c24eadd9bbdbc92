//! The page: banner, tables, figures, how to reproduce.

use super::data::{InvariantSeries, Outcome, ReportData, Trajectory};
use super::drift::drift_figure;
use super::error::ReportError;
use super::figure::Figure;
use super::history::{energy_figure, observable_figure, solver_figure};
use super::html::{escape, number};
use super::lattice::lattice_figures;
use super::orbit::orbit_figure;

/// Recorded formulas that are drawn.
const MOST_OBSERVABLES: usize = 8;

/// The report as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// Only if the drawing library refuses a figure; values that are not finite, empty series and
/// series of unequal lengths are drawn as far as they go.
pub fn render_report(data: &ReportData) -> Result<String, ReportError> {
    let mut page = head(&data.title, &data.scene_name, &data.version);
    page.push_str(&banner(&data.outcome));
    page.push_str(&advice(&data.advice));
    if !data.facts.is_empty() {
        page.push_str(&format!("<h2>Summary</h2>\n{}", two_columns(&data.facts)));
    }
    if !data.invariants.is_empty() {
        page.push_str(&invariant_table(&data.invariants));
    }
    page.push_str(&figures(data)?);
    if !data.method.is_empty() {
        page.push_str(&format!("<h2>Method</h2>\n{}", two_columns(&data.method)));
    }
    page.push_str(&ending(
        &data.scene_name,
        &data.version,
        &data.command,
        &data.scene_text,
    ));
    Ok(page)
}

/// The page up to the end of its header.
pub(super) fn head(title: &str, scene_name: &str, version: &str) -> String {
    let mut page = String::with_capacity(1 << 18);
    page.push_str("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    page.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    page.push_str(&format!("<title>{}</title>\n<style>\n", escape(title)));
    page.push_str(include_str!("style.css"));
    page.push_str("</style>\n</head>\n<body>\n<main>\n");
    page.push_str(&format!(
        "<header>\n<h1>{}</h1>\n<p>{} · {}</p>\n</header>\n",
        escape(title),
        escape(scene_name),
        escape(version)
    ));
    page
}

/// What to change in the scene.
pub(super) fn advice(advice: &[(String, String)]) -> String {
    let section = |(message, change): &(String, String)| {
        format!(
            "<section class=\"banner advice\"><strong>Warning</strong> <span>{}</span>\
             <p>Change: <code>{}</code></p></section>\n",
            escape(message),
            escape(change)
        )
    };
    advice.iter().map(section).collect()
}

pub(super) fn banner(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Done { message } => format!(
            "<section class=\"banner done\"><strong>Done</strong> <span>{}</span></section>\n",
            escape(message)
        ),
        Outcome::Interrupted { message } => format!(
            "<section class=\"banner interrupted\"><strong>Interrupted</strong> \
             <span>{}</span></section>\n",
            escape(message)
        ),
        Outcome::Failed {
            message,
            step,
            time,
            state,
            hint,
        } => {
            let coordinates: Vec<_> = state
                .iter()
                .take(12)
                .map(|(name, value)| format!("{name} = {value:?}"))
                .collect();
            let more = match state.len() {
                0..=12 => String::new(),
                length => format!(", … ({length} coordinates)"),
            };
            format!(
                "<section class=\"banner failed\"><strong>Failed at step {step}</strong> \
                 <span>t = {}</span>\n<p>{}</p>\n<p>State before the step: <code>{}{more}</code></p>\n\
                 <p>Try: {}</p>\n<p>Everything recorded before this step is shown below.</p>\
                 </section>\n",
                number(*time, 8),
                escape(message),
                escape(&coordinates.join(", ")),
                escape(hint)
            )
        }
    }
}

pub(super) fn two_columns(rows: &[(String, String)]) -> String {
    let mut html = "<div class=\"card scroll\"><table class=\"lines\"><tbody>\n".to_owned();
    for (label, value) in rows {
        html.push_str(&format!(
            "<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n",
            escape(label),
            escape(value)
        ));
    }
    html.push_str("</tbody></table></div>\n");
    html
}

fn invariant_table(invariants: &[InvariantSeries]) -> String {
    let mut html = "<h2>Invariants</h2>\n<div class=\"card scroll\"><table>\n<thead><tr>\
                    <th scope=\"col\">Invariant</th>\
                    <th scope=\"col\" class=\"number\">I(0)</th>\
                    <th scope=\"col\" class=\"number\">max |I − I(0)|</th>\
                    <th scope=\"col\" class=\"number\">relative</th>\
                    <th scope=\"col\" class=\"number\">growth</th></tr></thead>\n<tbody>\n"
        .to_owned();
    for series in invariants {
        let drift = largest(&series.deviations);
        let relative = match drift {
            Some(drift) if series.reference != 0.0 => number(drift / series.reference.abs(), 3),
            _ => "–".to_owned(),
        };
        html.push_str(&format!(
            "<tr><th scope=\"row\" class=\"name\">{}</th><td class=\"number\">{}</td>\
             <td class=\"number\">{}</td><td class=\"number\">{relative}</td>\
             <td class=\"number\">{}</td></tr>\n",
            escape(&series.name),
            number(series.reference, 12),
            drift.map_or_else(|| "–".to_owned(), |drift| number(drift, 3)),
            growth(&series.deviations).map_or_else(|| "–".to_owned(), |ratio| number(ratio, 3)),
        ));
    }
    html.push_str(
        "</tbody></table>\n<p class=\"reading\">Maxima over every step. Growth is the maximum over \
         the last tenth of the run divided by that over the first: near 1, the error is bounded. \
         A relative drift has no meaning where I(0) = 0.</p></div>\n",
    );
    html
}

/// The largest deviation; NaN or infinite if one is.
fn largest(deviations: &[f64]) -> Option<f64> {
    let wilder = |a: f64, b: f64| {
        if a.is_nan() || b.is_nan() {
            f64::NAN
        } else {
            a.max(b)
        }
    };
    deviations.iter().map(|value| value.abs()).reduce(wilder)
}

/// (max over the last tenth)/(max over the first tenth), where both mean something.
fn growth(deviations: &[f64]) -> Option<f64> {
    let tenth = deviations.len() / 10;
    if tenth == 0 {
        return None;
    }
    let first = largest(&deviations[..tenth])?;
    let last = largest(&deviations[deviations.len() - tenth..])?;
    (first > 0.0).then_some(last / first)
}

fn figures(data: &ReportData) -> Result<String, ReportError> {
    let mut wide: Vec<Figure> = Vec::new();
    let mut orbit = None;
    let mut small: Vec<Figure> = Vec::new();
    if !data.invariants.is_empty() {
        wide.push(drift_figure(&data.invariants, data.logarithmic_time)?);
    }
    match &data.trajectory {
        Some(Trajectory::Orbit {
            names,
            times,
            points,
            leaf,
        }) => {
            orbit = Some(orbit_figure(names, times, points, leaf.as_ref())?);
        }
        Some(Trajectory::Lattice {
            name,
            times,
            spacing,
            fields,
        }) => {
            wide.extend(lattice_figures(name, times, *spacing, fields)?);
        }
        None => {}
    }
    if let Some(energy) = &data.energy {
        small.push(energy_figure(energy)?);
    }
    for (name, series) in data.observables.iter().take(MOST_OBSERVABLES) {
        small.push(observable_figure(name, series)?);
    }
    if let Some(solver) = &data.solver {
        small.push(solver_figure(solver)?);
    }
    if wide.is_empty() && orbit.is_none() && small.is_empty() {
        return Ok(String::new());
    }
    let html = |list: &[Figure]| list.iter().map(Figure::html).collect::<String>();
    let pair = match (orbit, small.is_empty()) {
        (Some(orbit), false) => format!(
            "<div class=\"pair\">\n{}<div class=\"stack\">\n{}</div>\n</div>\n",
            orbit.html(),
            html(&small)
        ),
        (Some(orbit), true) => format!("<div class=\"pair\">\n{}</div>\n", orbit.html()),
        (None, false) => format!("<div class=\"pair\">\n{}</div>\n", html(&small)),
        (None, true) => String::new(),
    };
    Ok(format!(
        "<h2>Figures</h2>\n<div class=\"figures\">\n{}{pair}</div>\n",
        html(&wide)
    ))
}

/// How to repeat what a page shows, and the end of the page.
pub(super) fn ending(scene_name: &str, version: &str, command: &str, scene_text: &str) -> String {
    format!(
        "<h2>How to reproduce</h2>\n<div class=\"card\">\n<p>Save the scene below as \
         <code>{name}</code> and run, with {version}:</p>\n<pre><code>{command}</code></pre>\n\
         <details open><summary>{name}</summary>\n<pre><code>{scene}</code></pre></details>\n\
         </div>\n<footer>Written by {version}.</footer>\n</main>\n</body>\n</html>\n",
        name = escape(scene_name),
        version = escape(version),
        command = escape(command),
        scene = escape(scene_text)
    )
}
