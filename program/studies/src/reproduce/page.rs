//! Figures as the data of a page.

use leafwise_report::ReportError;
use leafwise_report::{Compared, ReproducedFigure, ReproductionData, render_reproduction};
use leafwise_run::PROGRAM_VERSION;

use super::figure::Reproduced;

/// Measured figures as one self-contained HTML page; `command` is what repeats it.
///
/// # Errors
/// [`ReportError`] if the drawing library refuses a figure.
pub fn reproduction_page(figures: &[Reproduced], command: &str) -> Result<String, ReportError> {
    render_reproduction(&ReproductionData {
        title: "The paper's section 5, measured".to_owned(),
        source: "Cabrera, Martín de Diego, Vaquero: Approximating Symplectic Realizations, \
                 arXiv:2409.04342"
            .to_owned(),
        version: format!("leafwise {PROGRAM_VERSION}"),
        command: command.to_owned(),
        introduction: vec![
            "Every figure and number of the paper's section 5 beside the same quantity as this \
             program measures it. Derivatives are exact; an order is fitted with its next term, \
             over a window that the data choose, and its tolerance is derived."
                .to_owned(),
            "“Agrees” means within the tolerance and the last printed digit. Where the two differ, \
             the reason stands with the figure, and the measurement is checked against theory."
                .to_owned(),
        ],
        figures: figures.iter().map(page_figure).collect(),
    })
}

fn page_figure(figure: &Reproduced) -> ReproducedFigure {
    let compared = figure.findings.iter().map(|finding| Compared {
        quantity: finding.claim.quantity.to_owned(),
        printed: finding.claim.printed.to_owned(),
        measured: finding.measured.clone(),
        verdict: finding.verdict().to_owned(),
        is_good: finding.agrees != Some(false) && finding.holds,
        explanation: finding.explanation.clone(),
    });
    ReproducedFigure {
        label: format!("Figure {}", figure.paper.number),
        title: figure.paper.title.to_owned(),
        setting: format!("Section {}. {}", figure.paper.section, figure.paper.setting),
        panels: figure.panels.clone(),
        comparisons: compared.collect(),
        scene: figure.scene.clone(),
    }
}
