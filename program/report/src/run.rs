//! The page of a run: how it ended, tables, figures, how to reproduce.

use serde::Serialize;

use super::bodies::bodies_figure;
use super::data::{InvariantSeries, ReportData, Trajectory};
use super::drift::drift_figure;
use super::error::ReportError;
use super::explored::Explored;
use super::figure::Figure;
use super::history::{energy_figure, observable_figure, solver_figure};
use super::lattice::lattice_figures;
use super::orbit::orbit_figure;
use super::planes::plane_figure;
use super::section::section_figure;
use super::structure::structure_figure;
use super::template::render;

/// Recorded formulas that are drawn.
const MOST_OBSERVABLES: usize = 8;

/// The report as one HTML page: nothing fetched, light and dark. Its script turns the orbit and shows values. Without
/// it the same pictures stand still.
///
/// # Errors
/// Only if the drawing library refuses a figure. Values that are not finite, empty series and series of unequal lengths
/// are no errors: they are drawn as far as they go.
pub fn render_report(data: &ReportData) -> Result<String, ReportError> {
    let page = Page {
        data,
        invariants: invariant_rows(data),
        figures: Figures::of(data)?,
        explored: Explored::of(data),
    };
    render("run.html", &page)
}

/// Values for the template `run.html`.
#[derive(Serialize)]
struct Page<'a> {
    data: &'a ReportData,
    invariants: Vec<InvariantRow<'a>>,
    figures: Figures,
    explored: Option<Explored>,
}

/// A row of the table of invariants.
#[derive(Serialize)]
struct InvariantRow<'a> {
    name: &'a str,
    reference: f64,
    drift: Option<f64>,
    relative: Option<f64>,
    growth: Option<f64>,
}

/// The rows of all invariants; an energy that the motion itself changes has no growth of its error.
fn invariant_rows(data: &ReportData) -> Vec<InvariantRow<'_>> {
    let rows = data.invariants.iter().map(InvariantRow::of);
    rows.map(|row| match row.name == "energy" && data.work.is_some() {
        true => InvariantRow {
            growth: None,
            ..row
        },
        false => row,
    })
    .collect()
}

impl<'a> InvariantRow<'a> {
    fn of(series: &'a InvariantSeries) -> Self {
        let drift = largest(&series.deviations);
        let has_scale = series.reference != 0.0;
        Self {
            name: &series.name,
            reference: series.reference,
            drift,
            relative: drift
                .filter(|_| has_scale)
                .map(|drift| drift / series.reference.abs()),
            growth: growth(&series.deviations),
        }
    }
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

/// The pictures: wide ones, the orbit with small ones beside it, or small ones two in a row.
#[derive(Default, Serialize)]
struct Figures {
    wide: Vec<Figure>,
    orbit: Option<Figure>,
    small: Vec<Figure>,
}

impl Figures {
    fn of(data: &ReportData) -> Result<Self, ReportError> {
        let mut figures = Self::default();
        if !data.invariants.is_empty() {
            let drift = drift_figure(
                &data.invariants,
                data.logarithmic_time,
                data.drift_every,
                data.work.as_deref(),
            )?;
            figures.wide.push(drift);
        }
        match &data.trajectory {
            Some(Trajectory::Orbit {
                names,
                times,
                points,
                leaf,
            }) => {
                let mut orbit = orbit_figure(names, times, points, leaf.as_ref())?;
                if names.len() > 1 {
                    // By this the script knows which picture it draws anew.
                    orbit.svg = orbit.svg.replacen("<svg ", "<svg class=\"orbit\" ", 1);
                }
                figures.orbit = Some(orbit);
            }
            Some(Trajectory::Lattice {
                name,
                times,
                spacing,
                fields,
                has_neighbours,
            }) => {
                let fields = lattice_figures(name, times, (*spacing, *has_neighbours), fields)?;
                figures.wide.extend(fields);
            }
            Some(Trajectory::Bodies {
                axes,
                bodies,
                count,
            }) => {
                figures.wide.insert(0, bodies_figure(axes, bodies, *count)?);
            }
            Some(Trajectory::Planes {
                fields,
                slice,
                rest,
            }) => {
                for field in fields {
                    figures.wide.push(plane_figure(field, slice.as_deref())?);
                }
                if let Some(last) = figures.wide.last_mut() {
                    last.notes.extend(rest.clone());
                }
            }
            None => {}
        }
        for factor in &data.structure {
            figures.small.extend(structure_figure(factor)?);
        }
        if let Some(section) = &data.section {
            figures.small.push(section_figure(section)?);
        }
        if let Some(energy) = &data.energy {
            figures
                .small
                .push(energy_figure(energy, data.work.as_deref())?);
        }
        for (name, series) in data.observables.iter().take(MOST_OBSERVABLES) {
            figures.small.push(observable_figure(name, series)?);
        }
        if let Some(solver) = &data.solver {
            figures.small.push(solver_figure(solver)?);
        }
        // Beside many or square ones the orbit would stand in a tall empty card.
        if data.section.is_some() || figures.small.len() > 2 {
            let orbit = figures.orbit.take();
            figures.small.splice(..0, orbit);
        }
        Ok(figures)
    }
}
