//! Lines that `learn` prints.

use leafwise::learn::Learned;

use crate::table::words;

/// Functions that are printed.
const MOST_ROWS: usize = 12;

/// The learned map as lines.
pub(super) fn lines(learned: &Learned) -> Vec<String> {
    let mut lines = vec![
        format!(
            "Degree {}: {} functions, {} of them determined by {} equations from {} pairs",
            learned.degree,
            learned.functions.len(),
            learned.determined,
            learned.equations,
            learned.pairs
        ),
        String::new(),
    ];
    let row = |name: &str, value: f64, meaning: &str| {
        vec![
            format!("  {name}"),
            format!("{value:.1e}"),
            meaning.to_owned(),
        ]
    };
    let mut rows = vec![
        row("motion", learned.motion, "x' - x, root mean square"),
        row(
            "residual",
            learned.residual,
            "the part along leaves that is not fitted",
        ),
    ];
    if let Some(off) = learned.off_leaf {
        rows.push(row(
            "off leaves",
            off,
            "the part that no Hamiltonian can produce",
        ));
    }
    rows.push(row(
        "step error",
        learned.step_error,
        "standard error of a learned step, by the residuals",
    ));
    rows.push(row(
        "energy error",
        learned.energy_error,
        "error of H less its mean, over the pairs",
    ));
    if let Some(error) = learned.hamiltonian_error {
        rows.push(row(
            "flow of H",
            error,
            "part of the learned map's velocity that H does not produce",
        ));
    }
    lines.extend(words(&rows));
    if !learned.degrees.is_empty() {
        lines.push(String::new());
        lines.push("Degrees by pairs that were held out:".to_owned());
        let rows: Vec<Vec<String>> = (learned.degrees.iter())
            .map(|(degree, error)| vec![format!("  {degree}"), format!("{error:.1e}")])
            .collect();
        lines.extend(words(&rows));
    }
    lines.push(String::new());
    lines.push("H, largest coefficients first:".to_owned());
    let mut functions: Vec<_> = learned.functions.iter().collect();
    functions.sort_by(|a, b| b.hamiltonian.abs().total_cmp(&a.hamiltonian.abs()));
    let rows: Vec<Vec<String>> = (functions.iter().take(MOST_ROWS))
        .map(|own| {
            vec![
                format!("  {}", own.formula),
                format!("{:.10}", own.hamiltonian),
                format!("± {:.1e}", own.error),
            ]
        })
        .collect();
    lines.extend(words(&rows));
    if functions.len() > MOST_ROWS {
        lines.push(format!("  … and {} more", functions.len() - MOST_ROWS));
    }
    lines
}
