//! Built-in parts through the suite that parts of plugins go through.

use leafwise::conformance::{Finding, conformance};
use leafwise::core::{PartInfo, PartKind, Registry};
use leafwise::verify::Judgement;

/// What no problem can be given: a vector potential is the user's to choose.
const NEEDS_A_PARAMETER: &str = "darboux-magnetic";

/// Whether a problem can be given to the part. What a scene writes is measured there (`leafwise verify SCENE`).
fn has_defaults(part: &PartInfo) -> bool {
    part.name != NEEDS_A_PARAMETER && !part.is_written
}

/// Every part of a kind is measured on something, and is what it declares.
fn all_are_met(kind: PartKind) {
    let registry = Registry::with_builtin();
    let of_kind = |part: &&PartInfo| part.kind == kind && has_defaults(part);
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
    let registry = Registry::with_builtin();
    let is_system = |part: &PartInfo| part.kind == PartKind::System;
    let mut parts = registry.parts();
    parts.retain(|part| !has_defaults(part) && !is_system(part));
    assert_eq!(parts.len(), 3, "{parts:?}");
    for part in parts {
        let report = conformance(&registry, part.name).expect("a part");
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
