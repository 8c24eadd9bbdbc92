//! Built-in parts through the suite that parts of plugins go through.

use leafwise::conformance::{Finding, conformance};
use leafwise::core::{PartInfo, PartKind, Registry};
use leafwise::verify::Judgement;

/// What no problem can be given: a vector potential and the formulas of a realization are the user's to choose.
const NEED_A_PARAMETER: [&str; 2] = ["closed-form", "darboux-magnetic"];

/// Every part of a kind is measured on something, and is what it declares.
fn all_are_met(kind: PartKind) {
    let registry = Registry::with_builtin();
    let of_kind = |part: &&PartInfo| part.kind == kind && !NEED_A_PARAMETER.contains(&part.name);
    for part in registry.parts().into_iter().filter(of_kind) {
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

/// A part that none of the problems fits is not called good: what was not measured is open.
#[test]
fn a_part_that_fits_no_problem_is_open() {
    for part in NEED_A_PARAMETER {
        let report = conformance(&Registry::with_builtin(), part).expect("a part");
        let open = |f: &Finding| f.judgement == Judgement::Open;
        assert!(!report.findings.is_empty() && report.findings.iter().all(open));
    }
}

#[test]
fn every_dynamic_approximation_is_what_it_declares() {
    all_are_met(PartKind::Dynamics);
}

#[test]
fn every_stepper_is_what_it_declares() {
    all_are_met(PartKind::Stepper);
}
