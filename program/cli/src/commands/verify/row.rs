//! A row as text.

use leafwise::verify::{Judgement, KeptEnergy, Measured, MeasuredOrder, Row};

/// The headings of the table and the page.
pub(super) const HEADINGS: [&str; 10] = [
    "",
    "order (declared)",
    "structure (declared)",
    "defect",
    "symmetry",
    "Casimirs",
    "energy, growth",
    "shadow energy",
    "evaluations, ns",
    "map",
];

/// From here on the growth of an energy's error is written by its power of ten.
const MOST_WRITTEN_OUT: f64 = 1e5;

/// The widths of all columns but the last, so that rows can be printed as they come.
const WIDTHS: [usize; 9] = [5, 17, 24, 7, 9, 8, 14, 17, 16];

/// Cells in one line, the last of any length.
pub(super) fn line<C: AsRef<str>>(cells: &[C]) -> String {
    let mut line = String::from("  ");
    for (at, cell) in cells.iter().enumerate() {
        let cell = cell.as_ref();
        line.push_str(cell);
        if let (Some(width), true) = (WIDTHS.get(at), at + 1 < cells.len()) {
            let gap = (width + 2).saturating_sub(cell.chars().count()).max(1);
            line.extend(std::iter::repeat_n(' ', gap));
        }
    }
    line.trim_end().to_owned()
}

/// The cells of a row, one a heading.
pub(super) fn cells(row: &Row) -> Vec<String> {
    let mark = match (row.is_met(), row.is_undecided()) {
        (false, _) => "FAILS",
        (true, true) => "?",
        (true, false) => "ok",
    };
    let mut cells = vec![mark.to_owned()];
    match &row.measured {
        Some(measured) => cells.extend(numbers(row, measured)),
        None => cells.extend(std::iter::repeat_n("-".to_owned(), 8)),
    }
    let note = match (&row.failure, &row.measured) {
        (Some(failure), _) => format!(": every step fails: {failure}"),
        (None, Some(measured)) => match (&measured.broken_solve, &measured.too_large) {
            (Some(broken), _) => format!(": {broken}"),
            (None, Some(_)) => format!(" (from a step of {} on)", measured.time_step),
            (None, None) => String::new(),
        },
        (None, None) => String::new(),
    };
    let own = if row.is_own { " (own)" } else { "" };
    cells.push(format!("{}{own}{note}", row.map));
    cells
}

fn numbers(row: &Row, measured: &Measured) -> [String; 8] {
    let order = match shown(measured.order) {
        Some(order) if !measured.is_flow => order,
        _ if measured.is_flow => "round-off".to_owned(),
        _ => "not seen".to_owned(),
    };
    let structure = match shown(measured.structure) {
        Some(order) => order,
        // Beside a step that is no Poisson map elsewhere, or a Casimir that drifts, one that is says little.
        None if measured.judgements[1] == Judgement::NotMet => "broken".to_owned(),
        None if measured.tensor_defect.is_some() => "round-off".to_owned(),
        None => "-".to_owned(),
    };
    [
        format!(
            "{order} ({}){}",
            row.declared_order,
            flag(measured.judgements[0])
        ),
        format!(
            "{structure} ({}){}",
            row.declared_structure,
            flag(measured.judgements[1])
        ),
        measured
            .tensor_defect
            .map_or_else(|| "-".to_owned(), |defect| format!("{defect:.1e}")),
        format!(
            "{:.1e}{}",
            measured.self_adjointness,
            flag(measured.judgements[2])
        ),
        format!("{:.1e}", measured.casimir_drift),
        match measured.energy_growth {
            Some(growth) if growth < MOST_WRITTEN_OUT => {
                format!("{:.1e} x{growth:.1}", measured.energy_drift)
            }
            Some(growth) => format!("{:.1e} x{growth:.1e}", measured.energy_drift),
            None => format!("{:.1e}", measured.energy_drift),
        },
        measured
            .shadow_energy
            .as_ref()
            .map_or_else(|| "-".to_owned(), kept),
        format!(
            "{:.2}, {:.0}",
            measured.evaluations_per_step, measured.nanoseconds_per_step
        ),
    ]
}

/// The fit, or the lower bound where that decides no order.
fn shown(order: MeasuredOrder) -> Option<String> {
    match (order.exponent, order.tolerance, order.at_least) {
        (Some(exponent), Some(tolerance), _) if tolerance < 1.0 => {
            Some(format!("{exponent:.2} ±{tolerance:.2}"))
        }
        (_, _, Some(slope)) => Some(format!("≥ {slope:.2}")),
        (exponent, _, None) => exponent.map(|exponent| format!("{exponent:.2}")),
    }
}

/// The order to which the shadow energy is kept.
fn kept(energy: &KeptEnergy) -> String {
    let order = shown(energy.order).unwrap_or_else(|| "round-off".to_owned());
    format!("{order} ({}){}", energy.declared, flag(energy.judgement))
}

fn flag(judgement: Judgement) -> &'static str {
    match judgement {
        Judgement::NotMet => " !",
        Judgement::Undecided => " ?",
        Judgement::Met | Judgement::Open => "",
    }
}
