//! The comparison at the terminal.

use leafwise::expression::words::counted;
use leafwise::trade::{Comparison, Measured, Point, TrialFailure};

use crate::console::Console;
use crate::table::{aligned_after, duration, short};

const HEADINGS: [&str; 9] = [
    "front",
    "method",
    "setting",
    "operations",
    "error",
    "energy",
    "Casimirs",
    "defect",
    "time",
];

/// Prints the points on a front, or all of them.
pub(super) fn print(comparison: &Comparison, all: bool, console: &mut Console<'_>) {
    let reference = &comparison.reference;
    console.result(&format!(
        "to t = {}, errors {} against {}",
        short(comparison.time),
        reference.judged().words(),
        reference.methods.join(" and ")
    ));
    console.result(&format!(
        "the reference's own error is {:.1e}: errors below {:.1e} (~) cannot be distinguished from it",
        reference.error,
        reference.floor()
    ));
    let mut shown: Vec<&Point> = comparison
        .points
        .iter()
        .filter(|p| all || on_front(p))
        .collect();
    if !all {
        let cost = |point: &Point| {
            let cost = point
                .outcome
                .as_ref()
                .ok()
                .and_then(|m| comparison.cost.of(m));
            cost.unwrap_or(f64::INFINITY)
        };
        shown.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    }
    let mut rows = vec![HEADINGS.map(str::to_owned).to_vec()];
    rows.extend(shown.iter().map(|point| cells(comparison, point)));
    console.result("");
    let reasons =
        std::iter::once(None).chain(shown.iter().map(|point| point.outcome.as_ref().err()));
    for (line, reason) in aligned_after(&rows, 3).into_iter().zip(reasons) {
        // A reason is longer than any column.
        let reason = reason.map_or_else(String::new, |reason| format!("  {reason}"));
        console.result(&format!("  {line}{reason}"));
    }
    if shown.is_empty() {
        console.result(nothing_to_show(comparison));
    }
    console.result("");
    console.result(&format!(
        "front: * no method is cheaper and more accurate; P no Poisson map is cheaper and more accurate, {}",
        comparison.cost
    ));
    let failures = comparison
        .points
        .iter()
        .filter_map(|p| p.outcome.as_ref().err());
    let (stopped, failed): (Vec<_>, Vec<_>) = failures.partition(|f| f.is_over_budget());
    console.result(&format!(
        "{} of {}: {} stopped, beyond {:.1e} operations; {} failed{}",
        counted(comparison.points.len(), "point"),
        counted(comparison.methods.len(), "method"),
        stopped.len(),
        comparison.budget as f64,
        failed.len(),
        if all { "" } else { "; --all shows every one" }
    ));
    if let Some((often, example)) = commonest(&failed) {
        console.result(&format!("failed most often, {often} of them: {example}"));
    }
    if all && !comparison.refused.is_empty() {
        console.result("");
        console.result("methods that do not fit");
        for (name, reason) in &comparison.refused {
            console.result(&format!("  {name}: {reason}"));
        }
    }
}

/// The commonest kind of failure: how often, and the first of its kind.
fn commonest<'a>(failed: &[&'a TrialFailure]) -> Option<(usize, &'a TrialFailure)> {
    let alike = |failure: &TrialFailure| {
        let kind = failure.kind();
        failed.iter().filter(|other| other.kind() == kind).count()
    };
    let first_of_most = |best: Option<(usize, &'a TrialFailure)>, failure: &&'a TrialFailure| {
        let often = alike(failure);
        match best {
            Some((most, _)) if most >= often => best,
            _ => Some((often, *failure)),
        }
    };
    failed.iter().fold(None, first_of_most)
}

fn on_front(point: &Point) -> bool {
    let front = point.outcome.as_ref().map(|measured| measured.front);
    front.is_ok_and(|front| front.all || front.poisson)
}

/// Why no point is on a front.
fn nothing_to_show(comparison: &Comparison) -> &'static str {
    let measured = comparison
        .points
        .iter()
        .filter_map(|p| p.outcome.as_ref().ok());
    let costs: Vec<Option<f64>> = measured.map(|m| comparison.cost.of(m)).collect();
    if comparison.horizon.is_some() {
        "  the state is not known well enough: no run can be judged by it"
    } else if !costs.is_empty() && costs.iter().all(Option::is_none) {
        "  no run's cost is known: --repeat 3 measures times"
    } else {
        "  no run's error is below a tenth of the state: finer --steps, a shorter --time"
    }
}

fn cells(comparison: &Comparison, point: &Point) -> Vec<String> {
    let method = &comparison.methods[point.method];
    let own = if method.is_own { " (own)" } else { "" };
    let name = format!("{}{own}", method.name);
    match &point.outcome {
        Ok(measured) => {
            let mut cells = vec![mark(measured), name, point.setting.to_string()];
            cells.extend(measured_cells(measured));
            cells
        }
        Err(_) => vec![String::new(), name, point.setting.to_string()],
    }
}

fn mark(measured: &Measured) -> String {
    let front = measured.front;
    let marks = [(front.all, '*'), (front.poisson, 'P')];
    marks.iter().filter(|m| m.0).map(|m| m.1).collect()
}

fn measured_cells(measured: &Measured) -> [String; 6] {
    let floor = if measured.at_floor { "~" } else { "" };
    [
        measured
            .operations
            .map_or_else(|| "-".to_owned(), |count| format!("{:.2e}", count as f64)),
        format!("{floor}{:.1e}", measured.error),
        format!("{:.1e}", measured.energy_drift),
        measured
            .casimir_drift
            .map_or_else(|| "-".to_owned(), |drift| format!("{drift:.1e}")),
        measured
            .tensor_defect
            .map_or_else(|| "-".to_owned(), |defect| format!("{defect:.1e}")),
        measured
            .wall
            .map_or_else(|| "-".to_owned(), |wall| duration(wall.seconds)),
    ]
}
