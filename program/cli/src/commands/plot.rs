//! `leafwise plot`: columns of runs as a figure for a paper.

use std::fs;
use std::path::{Path, PathBuf};

use leafwise::report::{Chart, ChartAxis, ChartScale, FieldMaps, PanelSeries, ReportError, Stroke};
use leafwise::run::{MapRequest, NamedState, NoMaps, maps, named_state};
use leafwise::scene::document::nearest;
use leafwise::scene::input::read_text;
use leafwise::scene::table::{Table, place};
use serde::Serialize;

use crate::arguments::{AxisName, PlotArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::files::refuse_existing;

/// The table with a row for each recorded state.
const SAMPLES: &str = "samples.csv";

/// The object of `plot --json`.
#[derive(Serialize)]
struct PlotJson<'a> {
    outcome: &'static str,
    file: &'a Path,
    curves: Vec<CurveJson<'a>>,
}

/// The object of `plot --map --json`.
#[derive(Serialize)]
struct MapsJson<'a> {
    outcome: &'static str,
    file: &'a Path,
    /// The fields and times that are drawn, as "s at t = 2.5".
    maps: Vec<&'a str>,
}

/// A curve of it.
#[derive(Serialize)]
struct CurveJson<'a> {
    name: &'a str,
    points: usize,
    /// Those without a place on the axes.
    left_out: usize,
}

/// Draws the curves into a new file; returns the exit code.
///
/// # Errors
/// [`Failure`] for a table without such columns, a file that exists, and labels that a PDF cannot show.
pub fn execute(arguments: &PlotArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    let out = &arguments.out;
    let ending = out
        .extension()
        .map(|ending| ending.to_string_lossy().to_lowercase());
    let is_pdf = match ending.as_deref() {
        Some("svg") => false,
        Some("pdf") => true,
        _ => {
            let message = format!("{} ends with neither .svg nor .pdf", out.display());
            return Err(Failure::usage(
                message,
                "name the file by its kind: --out figure.pdf",
            ));
        }
    };
    if !arguments.force {
        refuse_existing(out, "name another file, --out FILE, or give --force")?;
    }
    if let Some(field) = &arguments.map {
        let maps = maps_of(arguments, field)?;
        let bytes = match is_pdf {
            true => maps.pdf()?,
            false => maps.svg()?.into_bytes(),
        };
        write(out, bytes)?;
        if arguments.json {
            let titles = maps.maps.iter().map(|map| map.title.as_str());
            console.json(&MapsJson {
                outcome: "written",
                file: out,
                maps: titles.collect(),
            });
        }
        console.prose(&format!("wrote {}", out.display()));
        return Ok(exit::DONE);
    }
    if !arguments.at.is_empty() || arguments.slice.is_some() {
        let message = "--at and --slice choose maps, and there is no --map";
        return Err(Failure::usage(message, "name the field: --map q"));
    }
    for (name, scale) in [
        ("--x-scale", arguments.x_scale),
        ("--y-scale", arguments.y_scale),
    ] {
        if !scale.is_finite() || scale == 0.0 {
            let message = format!("{name} is {scale}, and must be a finite number other than 0");
            return Err(Failure::usage(message, "1000 shows metres in millimetres"));
        }
    }
    let chart = Chart {
        series: curves(arguments)?,
        x: axis(arguments, AxisName::X)?,
        y: axis(arguments, AxisName::Y)?,
        is_equal: arguments.equal,
    };
    if arguments.equal
        && [&chart.x, &chart.y]
            .iter()
            .any(|axis| axis.scale == ChartScale::Logarithmic)
    {
        let message = "--equal has no meaning on a logarithmic axis";
        return Err(Failure::usage(
            message,
            "leave one of --equal and --log out",
        ));
    }
    for series in &chart.series {
        let (lost, all) = (left_out(&chart, series), series.points.len());
        let why = match [&chart.x, &chart.y]
            .iter()
            .any(|axis| axis.scale == ChartScale::Logarithmic)
        {
            true => "their values are not finite numbers, or none above 0 on a logarithmic axis",
            false => "their values are not finite numbers",
        };
        if lost == all {
            return Err(Failure::usage(
                format!("no point of {} is shown: {why}", series.name),
                "leave the curve out, or take another column or axis",
            ));
        }
        if lost > 0 {
            console.warn(&format!(
                "{lost} of {all} points of {} are left out: {why}",
                series.name
            ));
        }
    }
    let bytes = match is_pdf {
        true => chart.pdf().map_err(|error| match error {
            ReportError::Letter { .. } => Failure::usage(
                error.to_string(),
                "name the file .svg, or give --x-label, --y-label or --name",
            ),
            error => error.into(),
        })?,
        false => chart.svg()?.into_bytes(),
    };
    write(out, bytes)?;
    if arguments.json {
        let curves = chart.series.iter().map(|series| CurveJson {
            name: &series.name,
            points: series.points.len(),
            left_out: left_out(&chart, series),
        });
        console.json(&PlotJson {
            outcome: "written",
            file: out,
            curves: curves.collect(),
        });
    }
    console.prose(&format!("wrote {}", out.display()));
    Ok(exit::DONE)
}

fn write(file: &Path, bytes: Vec<u8>) -> Result<(), Failure> {
    fs::write(file, bytes).map_err(|source| Failure::File {
        action: "write",
        file: file.to_owned(),
        source,
    })
}

/// The maps of a field of one run.
fn maps_of(arguments: &PlotArguments, field: &str) -> Result<FieldMaps, Failure> {
    let [directory] = &arguments.runs[..] else {
        let message = format!(
            "--map draws one run, and {} are given",
            arguments.runs.len()
        );
        return Err(Failure::usage(message, "give one run directory"));
    };
    let slice = arguments.slice.as_deref().map(|text| {
        let (axis, site) = text.split_once('=')?;
        Some((axis.trim().to_owned(), site.trim().parse().ok()?))
    });
    if slice == Some(None) {
        let text = arguments.slice.as_deref().unwrap_or_default();
        let message = format!("--slice {text} is no axis with a site");
        return Err(Failure::usage(
            message,
            "write the axis and the site: --slice k=3",
        ));
    }
    let request = MapRequest {
        field: field.to_owned(),
        at: arguments.at.clone(),
        slice: slice.flatten(),
    };
    maps(directory, &request).map_err(|error| {
        let help = match &error {
            NoMaps::NoField { name, fields } => {
                let near = nearest(name, fields.iter().map(String::as_str));
                near.map(|near| format!("did you mean `{near}`?"))
            }
            _ => None,
        };
        Failure::usage(error.to_string(), help.unwrap_or_else(|| error.help()))
    })
}

/// How many points of a curve have no place on the axes.
fn left_out(chart: &Chart, series: &PanelSeries) -> usize {
    let points = series.points.iter();
    let lost = points.filter(|(x, y)| !(chart.x.shows(*x) && chart.y.shows(*y)));
    lost.count()
}

/// An axis with its label and scale.
fn axis(arguments: &PlotArguments, which: AxisName) -> Result<ChartAxis, Failure> {
    let (letter, label, columns) = match which {
        AxisName::X => ("x", &arguments.x_label, arguments.x.clone()),
        AxisName::Y => ("y", &arguments.y_label, arguments.y.clone()),
    };
    let (is_log, is_angle) = (
        arguments.log.contains(&which),
        arguments.angle.contains(&which),
    );
    if is_log && is_angle {
        let message = format!("--log {letter} excludes --angle {letter}");
        return Err(Failure::usage(
            message,
            "an axis is logarithmic or one of angles",
        ));
    }
    let column = match &columns[..] {
        [] => "t".to_owned(),
        columns => columns.join(", "),
    };
    Ok(ChartAxis {
        title: label.clone().unwrap_or(column),
        scale: match (is_log, is_angle) {
            (true, _) => ChartScale::Logarithmic,
            (_, true) => ChartScale::Turn,
            _ => ChartScale::Linear,
        },
    })
}

/// A curve for each column of each run.
fn curves(arguments: &PlotArguments) -> Result<Vec<PanelSeries>, Failure> {
    let count = arguments.runs.len() * arguments.y.len();
    if arguments.name.len() > count {
        let message = format!(
            "{} names are given for {count} curves",
            arguments.name.len()
        );
        return Err(Failure::usage(message, "give --name once for each curve"));
    }
    let (across, up) = (arguments.x.len(), arguments.y.len());
    if across > 1 && across != up {
        let message = format!("{across} columns --x are given for {up} columns --y");
        let help = "give --x once for all curves, or once for each --y: --x \"q.x[0]\" --y \"q.y[0]\" --x \"q.x[1]\" --y \"q.y[1]\"";
        return Err(Failure::usage(message, help));
    }
    let mut series = Vec::with_capacity(count);
    let runs = apart(&arguments.runs);
    for (run, label) in arguments.runs.iter().zip(&runs) {
        let file = match run.is_dir() {
            true => run.join(&arguments.table),
            false => run.clone(),
        };
        let table = read(&file)?;
        let values = |name: &str| values(run, &file, &table, name);
        for (k, y) in arguments.y.iter().enumerate() {
            let x = match arguments.x.get(k).or(arguments.x.last()) {
                Some(name) => values(name)?,
                None => table.rows.iter().map(|row| row[0]).collect(),
            };
            let up = values(y)?;
            let points = x.iter().zip(&up);
            let points = points.map(|(x, y)| (x * arguments.x_scale, y * arguments.y_scale));
            let given = arguments.name.get(series.len()).cloned();
            series.push(PanelSeries {
                name: given.unwrap_or_else(|| named(arguments, label, y)),
                points: points.collect(),
                stroke: if arguments.points {
                    Stroke::Points
                } else {
                    Stroke::Line
                },
            });
        }
    }
    Ok(series)
}

/// A name that tells a curve from the others.
fn named(arguments: &PlotArguments, run: &str, y: &str) -> String {
    match (arguments.runs.len(), arguments.y.len()) {
        (1, _) => y.to_owned(),
        (_, 1) => run.to_owned(),
        _ => format!("{run}: {y}"),
    }
}

/// The last parts of paths, as many as tell all of them apart where something does.
fn apart(paths: &[PathBuf]) -> Vec<String> {
    let most = paths.iter().map(|path| path.components().count()).max();
    let of = |count: usize| -> Vec<String> {
        let last = paths.iter().map(|path| {
            let parts: Vec<_> = path.components().collect();
            let own: PathBuf = parts[parts.len().saturating_sub(count)..].iter().collect();
            own.to_string_lossy().into_owned()
        });
        last.collect()
    };
    let differ = |names: &[String]| {
        let mut sorted = names.to_vec();
        sorted.sort();
        sorted.windows(2).all(|pair| pair[0] != pair[1])
    };
    let most = most.unwrap_or(1).max(1);
    (1..=most)
        .map(of)
        .find(|names| differ(names))
        .unwrap_or_else(|| of(most))
}

fn read(file: &Path) -> Result<Table, Failure> {
    let text = read_text(file).map_err(|source| Failure::File {
        action: "read",
        file: file.to_owned(),
        source,
    })?;
    // Values that are none stand in tables of runs, and rows of other lengths in none.
    let whole = |table: Table| {
        let columns = table.columns.as_ref();
        let width = columns.map_or(table.rows[0].len(), Vec::len);
        let odd = table.rows.iter().position(|row| row.len() != width);
        match odd {
            None => Ok(table),
            Some(at) => Err(format!(
                "row {} has {} numbers, and there are {width} columns",
                at + 1,
                table.rows[at].len()
            )),
        }
    };
    Table::read(&text).and_then(whole).map_err(|reason| {
        let help = "a table of numbers with a header line: samples.csv, section.csv, windows.csv of a run directory";
        Failure::usage(format!("{}: {reason}", file.display()), help)
    })
}

/// The values of a column of a run's table, or of a coordinate of its states, which wide ones have in a file of their own.
fn values(run: &Path, file: &Path, table: &Table, name: &str) -> Result<Vec<f64>, Failure> {
    let missing = match column(file, table, name) {
        Ok(at) => return Ok(table.rows.iter().map(|row| row[at]).collect()),
        Err(missing) => missing,
    };
    // Its rows belong to those of this table alone.
    if !run.is_dir() || !file.ends_with(SAMPLES) {
        return Err(missing);
    }
    let named = named_state(run, name).map_err(|source| Failure::File {
        action: "read the states of",
        file: run.to_owned(),
        source,
    })?;
    match named {
        // The last row may be on its way.
        NamedState::Recorded(values) if values.len() >= table.rows.len() => Ok(values),
        NamedState::Recorded(values) => Err(Failure::usage(
            format!(
                "{}: its states have {} rows, and {SAMPLES} has {}",
                run.display(),
                values.len(),
                table.rows.len()
            ),
            "run the scene again",
        )),
        NamedState::NotRecorded => Err(Failure::usage(
            format!(
                "{}: the coordinate `{name}` was not recorded",
                run.display()
            ),
            format!(
                "record it in [run], record = {{ states = [\"{name}\"] }}, and run the scene again"
            ),
        )),
        NamedState::Unknown => Err(missing),
    }
}

fn column(file: &Path, table: &Table, name: &str) -> Result<usize, Failure> {
    let Some(columns) = table.columns.as_deref() else {
        return Err(Failure::usage(
            format!(
                "{}: it has no header line, and so no column `{name}`",
                file.display()
            ),
            "write the names of the columns into its first line",
        ));
    };
    place(columns, name).map_err(|reason| {
        let help = match nearest(name, columns.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("columns: {}", columns.join(", ")),
        };
        Failure::usage(format!("{}: {reason}", file.display()), help)
    })
}
