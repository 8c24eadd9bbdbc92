//! Section 5 of the paper, as `leafwise reproduce` measures it.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::Registry;
use leafwise::reproduce::{FIGURES, find, reproduce};

#[test]
fn every_statement_is_measured_and_meets_theory() {
    let registry = Registry::with_builtin();
    let mut differing = Vec::new();
    for figure in &FIGURES {
        let reproduced = reproduce(figure, &registry)
            .unwrap_or_else(|error| panic!("figure {}: {error}", figure.number));
        assert_eq!(reproduced.findings.len(), figure.claims.len());
        for (finding, claim) in reproduced.findings.iter().zip(figure.claims) {
            println!(
                "{}: {}: {}",
                figure.number, claim.quantity, finding.measured
            );
            assert_eq!(finding.claim, claim, "figure {}", figure.number);
            assert!(finding.holds, "figure {}: {finding:?}", figure.number);
            if finding.agrees == Some(false) {
                differing.push(figure.number);
            }
        }
        for panel in &reproduced.panels {
            let series = panel.series.iter().filter(|s| !s.points.is_empty());
            assert!(
                series.count() > 0,
                "figure {}: {}",
                figure.number,
                panel.title
            );
        }
    }
    // The slopes on so(3)*, which vanishing Bernoulli numbers raise by one.
    assert_eq!(differing, [1, 2]);
}

#[test]
fn figures_have_numbers_and_names() {
    for figure in &FIGURES {
        assert_eq!(find(&figure.number.to_string()), Some(figure));
        assert_eq!(find(figure.id), Some(figure));
    }
    assert_eq!(find("0"), None);
}
