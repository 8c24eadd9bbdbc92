//! A comparison as the data of a page.

use leafwise_core::part::Family;
use leafwise_report::{ComparisonData, Curve, CurvePoint, Plot};
use leafwise_report::{ReportError, render_comparison};
use leafwise_run::PROGRAM_VERSION;
use leafwise_scene::SceneDocument;
use leafwise_scene::document::MethodParts;

use super::compare::{ComparedMethod, Comparison, Point};
use super::measured::{Cost, Measured};
use super::reference::Judged;

/// The families of methods, by colour.
const FAMILIES: [&str; 6] = [
    "Realization and dynamics",
    "Compositions of these",
    "Splitting and its compositions",
    "Explicit baselines",
    "Implicit baselines",
    "The scene's own method",
];

/// A comparison as one self-contained HTML page; `command` is what repeats it.
///
/// # Errors
/// [`ReportError`] if the drawing library refuses a figure.
pub fn comparison_page(
    comparison: &Comparison,
    document: &SceneDocument,
    command: &str,
) -> Result<String, ReportError> {
    let curves = curves(comparison);
    render_comparison(&ComparisonData {
        title: format!("Methods compared: {}", stem(&document.name)),
        scene_name: file_name(&document.name),
        scene_text: document.text.clone(),
        version: format!("leafwise {PROGRAM_VERSION}"),
        command: command.to_owned(),
        facts: facts(comparison),
        families: FAMILIES.map(str::to_owned).to_vec(),
        plots: plots(comparison),
        curves,
        headings: [
            "front",
            "method",
            "setting",
            "operations",
            "error",
            "relative",
            "energy",
            "Casimirs",
            "tensor defect",
            "time",
        ]
        .map(str::to_owned)
        .to_vec(),
        numbers_from: 3,
        rows: rows(comparison),
        reading: format!(
            "* on the front of all methods, P on that of the Poisson maps: no other is cheaper \
             and more accurate, {}. Energy and Casimirs: the largest deviation over every step. ~ \
             marks errors that cannot be distinguished from the reference's own. Times are medians on a \
             machine that does other things too.",
            comparison.cost
        ),
        failures: failures(comparison),
    })
}

/// The pictures of a comparison as SVG files of their own: names without `.svg`, and contents.
///
/// # Errors
/// [`ReportError`] if the drawing library refuses a figure.
pub fn comparison_figures(comparison: &Comparison) -> Result<Vec<(String, String)>, ReportError> {
    let curves = curves(comparison);
    let plots = plots(comparison).into_iter();
    let figures = plots.map(|plot| {
        let name = plot.title.to_lowercase().replace(' ', "-");
        Ok((name, plot.svg(&curves)?))
    });
    figures.collect()
}

fn file_name(path: &str) -> String {
    path.rsplit(['/', '\\']).next().unwrap_or(path).to_owned()
}

fn stem(path: &str) -> String {
    let name = file_name(path);
    name.strip_suffix(".toml").unwrap_or(&name).to_owned()
}

fn facts(comparison: &Comparison) -> Vec<(String, String)> {
    let reference = &comparison.reference;
    let measured = comparison.points.iter().filter(|p| p.outcome.is_ok());
    let rows = [
        ("End time", format!("t = {}", comparison.time)),
        ("Reference", reference.methods.join(" and ")),
        (
            "Its own error",
            format!(
                "{:.1e} (the two methods' distance): errors below {:.1e} cannot be distinguished from it",
                reference.error,
                reference.floor()
            ),
        ),
        (
            "Compared",
            format!(
                "{} methods, {} runs of at most {:.1e} operations each",
                comparison.methods.len(),
                measured.count(),
                comparison.budget as f64
            ),
        ),
        (
            "Cost",
            match comparison.cost {
                Cost::Operations => "operations of the kernels and of the linear algebra around \
                                     them, an elementary function counted as ten"
                    .to_owned(),
                other => format!("compared {other}"),
            },
        ),
        (
            "Error",
            match reference.judged() {
                Judged::AtEveryStep => {
                    "the largest Euclidean distance from the reference over every step"
                }
                Judged::AtTheEnd => "the Euclidean distance from the reference at the end time",
            }
            .to_owned(),
        ),
    ];
    let mut rows = rows.map(|(label, text)| (label.to_owned(), text)).to_vec();
    if let Some(horizon) = &comparison.horizon {
        rows.insert(3, ("Not known better".to_owned(), horizon.to_string()));
    }
    rows
}

/// Methods with a point on a front, and the scene's own, are numbered.
fn curves(comparison: &Comparison) -> Vec<Curve> {
    let mut number = 0..;
    let on_front = |at: usize| {
        let of_method = comparison.points.iter().filter(|p| p.method == at);
        let mut measured = of_method.filter_map(|p| p.outcome.as_ref().ok());
        measured.any(|m| m.front.all || m.front.poisson)
    };
    let methods = comparison.methods.iter().enumerate();
    let mut curves: Vec<(usize, Curve)> = methods
        .map(|(at, method)| {
            let family = if method.is_own { 5 } else { family(method) };
            let is_shown = method.is_own || on_front(at);
            let curve = Curve {
                name: method.name.clone(),
                family,
                number: is_shown.then_some(0),
            };
            (at, curve)
        })
        .collect();
    // Numbers rise family by family.
    curves.sort_by_key(|(at, curve)| (curve.family, *at));
    for (_, curve) in &mut curves {
        curve.number = curve
            .number
            .and_then(|_| number.next().map(|n: usize| n + 1));
    }
    curves.sort_by_key(|(at, _)| *at);
    curves.into_iter().map(|(_, curve)| curve).collect()
}

/// The place in [`FAMILIES`].
fn family(compared: &ComparedMethod) -> usize {
    let is_composed = compared.method.composition.is_some();
    match (&compared.method.parts, compared.family) {
        (MethodParts::Pair { .. }, _) => usize::from(is_composed),
        (_, Some(Family::Splitting | Family::Poisson)) => 2,
        (_, Some(Family::Series | Family::Explicit)) => 3,
        _ if is_composed => 2,
        _ => 4,
    }
}

/// A picture of one measured quantity against a cost, with the fronts where they are its own.
fn plot(
    comparison: &Comparison,
    [title, cost, error, caption]: [&str; 4],
    of_cost: impl Fn(&Point, &Measured) -> Option<f64>,
    of_error: impl Fn(&Measured) -> Option<f64>,
    fronts: impl Fn(&Measured) -> (bool, bool),
) -> Plot {
    let points = (0..comparison.methods.len()).map(|at| {
        let of_method = comparison.points.iter().filter(|p| p.method == at);
        of_method
            .filter_map(|point| {
                let measured = point.outcome.as_ref().ok()?;
                let (on_front, on_inner_front) = fronts(measured);
                Some(CurvePoint {
                    cost: of_cost(point, measured)?,
                    error: of_error(measured)?,
                    on_front,
                    on_inner_front,
                })
            })
            .collect()
    });
    Plot {
        title: title.to_owned(),
        caption: caption.to_owned(),
        cost: cost.to_owned(),
        error: error.to_owned(),
        points: points.collect(),
        floor: None,
        is_wide: false,
    }
}

fn plots(comparison: &Comparison) -> Vec<Plot> {
    let operations = |_: &Point, m: &Measured| Some(m.operations? as f64);
    let wall = |_: &Point, m: &Measured| Some(m.wall?.seconds);
    let error = |m: &Measured| Some(m.error);
    let none = |_: &Measured| (false, false);
    let floor = Some(comparison.reference.floor());
    let error_name = format!("error {}", comparison.reference.judged().words());
    let error_name = error_name.as_str();
    let by_time = comparison.cost == Cost::Time;
    let mut plots = vec![
        Plot {
            floor,
            is_wide: true,
            ..plot(
                comparison,
                [
                    "Error against counted operations",
                    "operations of the whole run",
                    error_name,
                    "Each line is a method, each point a run: finer steps to the right. Cheap and \
                     accurate is below and to the left. The solid staircase is the front of all \
                     methods, the dashed one that of the Poisson maps: what each can give for a \
                     cost.",
                ],
                operations,
                error,
                |m| (m.front.all, m.front.poisson),
            )
        },
        Plot {
            floor,
            is_wide: by_time,
            ..plot(
                comparison,
                [
                    "Error against time",
                    "seconds, the median of repeated runs",
                    error_name,
                    "Wall time without observers; it is noisy, and includes what operations do \
                     not count.",
                ],
                wall,
                error,
                |m| (m.front.wall, by_time && m.front.poisson),
            )
        },
        Plot {
            floor,
            ..plot(
                comparison,
                [
                    "Error against evaluations",
                    "evaluations of the whole run",
                    error_name,
                    "An evaluation means a step kernel for one method, all stages for another: \
                     compare curves of one family.",
                ],
                |_, m| Some(m.evaluations as f64),
                error,
                none,
            )
        },
        plot(
            comparison,
            [
                "Energy",
                "operations of the whole run",
                "max |H − H(0)|",
                "The largest deviation of the energy over every step.",
            ],
            operations,
            |m| Some(m.energy_drift),
            none,
        ),
    ];
    if comparison.invariants.len() > 1 {
        plots.push(plot(
            comparison,
            [
                "Casimirs",
                "operations of the whole run",
                "max |C − C(0)|",
                "The largest deviation of a Casimir over every step: exact Poisson maps keep it \
                 to round-off at any step.",
            ],
            operations,
            |m| m.casimir_drift,
            none,
        ));
    }
    plots.push(plot(
        comparison,
        [
            "Tensor defect",
            "operations of the whole run",
            "|DΦ Π DΦᵀ − Π∘Φ|, relative",
            "How far one step is from a Poisson map. Maps without an exact tangent are not shown.",
        ],
        operations,
        |m| m.tensor_defect,
        none,
    ));
    plots.push(Plot {
        floor,
        ..plot(
            comparison,
            [
                "Orders",
                "time step",
                error_name,
                "Error against the step: the slope is the order, until round-off or the \
                 reference's own error. Methods that choose their own steps are not shown.",
            ],
            |point, _| {
                point
                    .setting
                    .tolerance
                    .is_none()
                    .then_some(point.time_step.abs())
            },
            error,
            none,
        )
    });
    // What no run has (times that were not asked for, tangents that no map offers) is left out.
    plots.retain(|plot| plot.points.iter().any(|points| !points.is_empty()));
    plots
}

fn rows(comparison: &Comparison) -> Vec<Vec<String>> {
    let mut shown: Vec<(&Point, &Measured)> = comparison
        .points
        .iter()
        .filter_map(|point| Some((point, point.outcome.as_ref().ok()?)))
        .filter(|(_, m)| m.front.all || m.front.poisson)
        .collect();
    let cost = |m: &Measured| comparison.cost.of(m).unwrap_or(f64::INFINITY);
    shown.sort_by(|(_, a), (_, b)| cost(a).total_cmp(&cost(b)));
    shown
        .into_iter()
        .map(|(point, m)| {
            let mark = match (m.front.all, m.front.poisson) {
                (true, true) => "* P",
                (true, false) => "*",
                _ => "P",
            };
            let number = |value: f64| format!("{value:.1e}");
            let or_dash = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
            let floor = if m.at_floor { "~" } else { "" };
            vec![
                mark.to_owned(),
                comparison.methods[point.method].name.clone(),
                point.setting.to_string(),
                or_dash(m.operations.map(|count| count as f64)),
                format!("{floor}{:.1e}", m.error),
                number(m.relative_error),
                number(m.energy_drift),
                or_dash(m.casimir_drift),
                or_dash(m.tensor_defect),
                m.wall.map_or_else(
                    || "–".to_owned(),
                    |wall| format!("{:.2} ms", wall.seconds * 1e3),
                ),
            ]
        })
        .collect()
}

fn failures(comparison: &Comparison) -> Vec<(String, String)> {
    let of_points = comparison.points.iter().filter_map(|point| {
        let failure = point.outcome.as_ref().err()?;
        let name = &comparison.methods[point.method].name;
        Some((format!("{name}, {}", point.setting), failure.to_string()))
    });
    of_points
        .chain(comparison.refused.iter().cloned())
        .collect()
}
