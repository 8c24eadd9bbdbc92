//! The page of a sweep: what was measured against one direction of settings, or two.

use serde::Serialize;

use super::axis::Axis;
use super::canvas::{ALARM, AXIS, Anchor, Canvas, GRID, TEXT};
use super::data::Outcome;
use super::error::ReportError;
use super::figure::Figure;
use super::heat::{BAR, color, draw_scale, level};
use super::panel::{Panel, PanelAxis, PanelSeries, Stroke, panel_figure};
use super::template::render;

/// Contents of a sweep's page.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SweepData {
    /// The heading.
    pub title: String,
    /// The program and its version.
    pub version: String,
    /// The command that repeats it.
    pub command: String,
    /// The scene's file name.
    pub scene_name: String,
    /// The scene as run.
    pub scene_text: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Label and value for each line of the summary.
    pub facts: Vec<(String, String)>,
    /// Label and text for each line about the scene's own method.
    pub method: Vec<(String, String)>,
    /// Whether there are one or two directions, so that pictures can be drawn.
    pub is_drawn: bool,
    /// The keys whose values differ.
    #[serde(skip)]
    pub directions: Vec<SweptDirection>,
    /// Measured quantities, with a value for each setting.
    #[serde(skip)]
    pub columns: Vec<SweptColumn>,
    /// Settings that failed, and why.
    pub failures: Vec<(String, String)>,
}

/// A key whose values differ.
#[derive(Clone, Debug, Default)]
pub struct SweptDirection {
    /// The key.
    pub name: String,
    /// Its values, each once: numbers by size, words in the order of the table.
    pub labels: Vec<String>,
    /// The same as numbers, where all are.
    pub numbers: Option<Vec<f64>>,
    /// The place of each setting's value.
    pub places: Vec<usize>,
}

/// Quantity measured of all settings.
#[derive(Clone, Debug, Default)]
pub struct SweptColumn {
    /// Its heading.
    pub name: String,
    /// A value for each setting.
    pub values: Vec<f64>,
    /// Kind of the quantity: drift, observable or cost.
    pub kind: SweptKind,
}

/// Kinds of quantity that a column holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SweptKind {
    /// The largest deviation of an invariant, of which the order of magnitude tells.
    Drift,
    /// A function of the last state.
    #[default]
    Observable,
    /// A count of the whole run.
    Cost,
}

impl SweptKind {
    fn words(self) -> &'static str {
        match self {
            Self::Drift => "The largest deviation over all steps",
            Self::Observable => "The value at the end",
            Self::Cost => "The count of the whole run",
        }
    }
}

impl SweptDirection {
    /// The values of a key in the order of the table.
    pub fn of<'a>(name: &str, cells: impl Iterator<Item = &'a str>) -> Self {
        let cells: Vec<&str> = cells.collect();
        let mut labels: Vec<&str> = Vec::new();
        let mut known = std::collections::BTreeSet::new();
        for cell in &cells {
            if known.insert(*cell) {
                labels.push(cell);
            }
        }
        let number = |label: &&str| label.parse::<f64>().ok().filter(|value| value.is_finite());
        let mut numbers: Option<Vec<f64>> = labels.iter().map(number).collect();
        if let Some(numbers) = &mut numbers {
            let mut order: Vec<usize> = (0..labels.len()).collect();
            order.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
            labels = order.iter().map(|at| labels[*at]).collect();
            *numbers = order.iter().map(|at| numbers[*at]).collect();
        }
        let at: std::collections::BTreeMap<&str, usize> = labels
            .iter()
            .enumerate()
            .map(|(at, label)| (*label, at))
            .collect();
        Self {
            name: name.to_owned(),
            places: cells.iter().map(|cell| at[cell]).collect(),
            labels: labels.into_iter().map(str::to_owned).collect(),
            numbers,
        }
    }

    /// Whether equal ratios lie at equal distances: of values that are all positive and neighbours of about one ratio.
    fn is_logarithmic(&self) -> bool {
        let Some(numbers) = &self.numbers else {
            return false;
        };
        let (Some(first), Some(last)) = (numbers.first(), numbers.last()) else {
            return false;
        };
        if numbers.len() < 3 || *first <= 0.0 || last / first < 3.0 {
            return false;
        }
        let ratios = numbers.windows(2).map(|pair| pair[1] / pair[0]);
        let (low, high) = ratios.fold((f64::INFINITY, 0.0_f64), |(low, high), ratio| {
            (low.min(ratio), high.max(ratio))
        });
        libm::log(high) < 3.0 * libm::log(low)
    }
}

/// A sweep as one HTML page: no scripts, nothing fetched, light and dark.
///
/// # Errors
/// Only if the drawing library refuses a figure.
pub fn render_sweep(data: &SweepData) -> Result<String, ReportError> {
    let mut figures = Vec::new();
    match data.directions.as_slice() {
        [one] => {
            let drifts: Vec<&SweptColumn> = data
                .columns
                .iter()
                .filter(|c| c.kind == SweptKind::Drift)
                .collect();
            figures.push(curves(one, &drifts)?);
            for column in data.columns.iter().filter(|c| c.kind != SweptKind::Drift) {
                figures.push(curves(one, &[column])?);
            }
        }
        [first, second] => {
            // The direction of more values goes across.
            let (x, y) = match second.labels.len() > first.labels.len() {
                true => (second, first),
                false => (first, second),
            };
            for column in &data.columns {
                figures.push(map(x, y, column)?);
            }
        }
        _ => {}
    }
    render("sweep.html", &Page { data, figures })
}

/// Values for the template `sweep.html`.
#[derive(Serialize)]
struct Page<'a> {
    data: &'a SweepData,
    figures: Vec<Figure>,
}

/// Whether the order of magnitude is what a column tells.
fn is_logarithmic(columns: &[&SweptColumn]) -> bool {
    let values = || columns.iter().flat_map(|column| &column.values);
    let is_drift = columns.iter().all(|column| column.kind == SweptKind::Drift);
    is_drift && values().any(|value| *value > 0.0)
}

/// Columns against one direction.
fn curves(direction: &SweptDirection, columns: &[&SweptColumn]) -> Result<Figure, ReportError> {
    let is_log = is_logarithmic(columns);
    let title = match columns {
        [one] => one.name.clone(),
        _ => "drifts".to_owned(),
    };
    let places: Vec<f64> = match &direction.numbers {
        Some(numbers) => direction.places.iter().map(|at| numbers[*at]).collect(),
        None => direction.places.iter().map(|at| *at as f64 + 1.0).collect(),
    };
    let stroke = match &direction.numbers {
        Some(_) => Stroke::Line,
        None => Stroke::Points,
    };
    let series = columns.iter().map(|column| {
        let points = places.iter().copied().zip(column.values.iter().copied());
        let mut points: Vec<(f64, f64)> = points.collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        PanelSeries {
            name: column.name.clone(),
            points,
            stroke,
        }
    });
    let words: Vec<String> = direction
        .labels
        .iter()
        .zip(1..)
        .map(|(label, number)| format!("{number}: {label}"))
        .collect();
    let mut caption = match (columns, is_log) {
        ([one], false) => format!("{}, against {}.", one.kind.words(), direction.name),
        _ => format!(
            "The largest deviation of each invariant over all steps, against {}.",
            direction.name
        ),
    };
    if direction.numbers.is_none() {
        caption = format!("{caption} The values are {}.", words.join(", "));
    }
    let axis = |title: &str, is_logarithmic| PanelAxis {
        title: title.to_owned(),
        is_logarithmic,
    };
    let zeros = series
        .clone()
        .flat_map(|one| one.points)
        .filter(|(_, y)| *y == 0.0)
        .count();
    let mut figure = panel_figure(&Panel {
        x: axis(&direction.name, direction.is_logarithmic()),
        y: axis(&title, is_log),
        title,
        caption,
        series: series.collect(),
    })?;
    if is_log && zeros > 0 {
        figure.notes.push(format!(
            "{zeros} deviations are 0 and have no place on a logarithmic axis."
        ));
    }
    Ok(figure)
}

/// A column over two directions, in colours.
fn map(
    x: &SweptDirection,
    y: &SweptDirection,
    column: &SweptColumn,
) -> Result<Figure, ReportError> {
    let (width, height) = (480.0, 340.0);
    let is_log = is_logarithmic(&[column]);
    let shown = |value: f64| value.is_finite() && (!is_log || value > 0.0);
    let values = column.values.iter().copied().filter(|value| shown(*value));
    let axis = match is_log {
        true => Axis::logarithmic(values),
        false => Axis::linear(values, 0.0),
    };
    let mut canvas = Canvas::new(width, height);
    let edges @ [left, top, right, bottom] = [74.0, 34.0, width - BAR, height - 50.0];
    let across = |k: usize| left + (right - left) * k as f64 / x.labels.len() as f64;
    let up = |k: usize| bottom - (bottom - top) * k as f64 / y.labels.len() as f64;
    let mut cells = vec![None; x.labels.len() * y.labels.len()];
    for ((i, j), value) in x.places.iter().zip(&y.places).zip(&column.values) {
        cells[j * x.labels.len() + i] = Some(*value);
    }
    let (mut broken, mut zeros) = (0, 0);
    for (at, cell) in cells.iter().enumerate() {
        let (i, j) = (at % x.labels.len(), at / x.labels.len());
        let ink = match cell {
            None => GRID,
            Some(value) if !value.is_finite() => {
                broken += 1;
                ALARM
            }
            Some(value) => {
                zeros += usize::from(!shown(*value));
                color(level(axis, *value))
            }
        };
        canvas.cell((across(i), up(j + 1)), (across(i + 1), up(j)), ink);
    }
    canvas.path(
        &[
            (left, top),
            (left, bottom),
            (right, bottom),
            (right, top),
            (left, top),
        ],
        AXIS,
        1.0,
    );
    for (place, label) in ticks(x, ((right - left) / 56.0) as usize) {
        let at = (across(place) + across(place + 1)) / 2.0;
        canvas.path(&[(at, bottom), (at, bottom + 4.0)], AXIS, 1.0);
        canvas.label_within(&label, (at, bottom + 15.0), Anchor::Middle);
    }
    for (place, label) in ticks(y, ((bottom - top) / 24.0) as usize) {
        let at = (up(place) + up(place + 1)) / 2.0;
        canvas.path(&[(left - 4.0, at), (left, at)], AXIS, 1.0);
        canvas.label_within(&label, (left - 8.0, at), Anchor::End);
    }
    canvas.label(
        &x.name,
        ((left + right) / 2.0, bottom + 36.0),
        Anchor::Middle,
    );
    canvas.label_in(&y.name, (12.0, top - 17.0), Anchor::Start, TEXT, 13.0);
    draw_scale(&mut canvas, edges, axis, "");
    let mut notes = Vec::new();
    if broken > 0 {
        notes.push(format!("{broken} settings have no finite value (red)."));
    }
    if zeros > 0 {
        notes.push(format!("{zeros} deviations are 0, drawn as the least."));
    }
    Ok(Figure {
        title: column.name.clone(),
        svg: canvas.finish(&format!("{} over both directions", column.name))?,
        legend: Vec::new(),
        caption: format!("{}, a cell for each setting.", column.kind.words()),
        colors: Vec::new(),
        notes,
    })
}

/// Places with labels, at most about so many, evenly spread.
fn ticks(direction: &SweptDirection, most: usize) -> Vec<(usize, String)> {
    let count = direction.labels.len();
    let stride = count.div_ceil(most.max(1)).max(1);
    let label = |at: usize| match &direction.numbers {
        Some(numbers) => super::number::number(numbers[at], 3),
        None => direction.labels[at].clone(),
    };
    (0..count)
        .step_by(stride)
        .map(|at| (at, label(at)))
        .collect()
}
