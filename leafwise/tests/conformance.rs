//! Built-in parts through the suite that parts of plugins go through.

use leafwise::conformance::conformance;
use leafwise::core::{PartKind, Registry};
use leafwise::verify::Judgement;

/// Every part of a kind is measured on something, and is what it declares.
fn all_are_met(kind: PartKind) {
    let registry = Registry::with_builtin();
    for part in registry.parts().into_iter().filter(|p| p.kind == kind) {
        let report = conformance(&registry, part.name).expect("a part of the registry");
        let broken = report.findings.iter().filter(|f| !f.is_met());
        let broken: Vec<_> = broken.collect();
        assert!(broken.is_empty(), "{}: {broken:#?}", part.name);
        let met = report.findings.iter();
        let met = met.filter(|f| f.judgement == Judgement::Met).count();
        assert!(met > 2, "{}: {:#?}", part.name, report.findings);
    }
}

#[test]
fn every_realization_is_what_it_declares() {
    all_are_met(PartKind::Realization);
}

#[test]
fn every_dynamic_approximation_is_what_it_declares() {
    all_are_met(PartKind::Dynamics);
}

#[test]
fn every_stepper_is_what_it_declares() {
    all_are_met(PartKind::Stepper);
}
