//! Is a part what it says? The instruments on one part, built-in or of a plugin.
//!
//! - `finding`: one thing measured, and what it means.
//! - `problems`: what parts are tried on.
//! - `systems`: Jacobi's identity, Casimirs, derivatives against differences.
//! - `realizations`: the section, α̂ Poisson, β̂ anti-Poisson, dual pair, inversion.
//! - `maps`: order, structure, symmetry, and the same bits in every run and on every lane.

mod finding;
mod maps;
mod problems;
mod realizations;
mod systems;

use leafwise_core::part::{PATH, PartInfo};
use leafwise_core::{BuildError, PartKind, PartParameters, Registry};

use crate::verify::Judgement;
pub use finding::Finding;

/// Findings on one part: its measurements, each judged against what the part declares.
#[derive(Clone, Debug)]
pub struct Conformance {
    /// The part.
    pub part: &'static PartInfo,
    /// Everything measured.
    pub findings: Vec<Finding>,
}

impl Conformance {
    /// Whether anything was measured that says what the part is.
    pub fn is_measured(&self) -> bool {
        let judged = |finding: &Finding| finding.judgement != Judgement::Open;
        self.findings.iter().any(judged)
    }

    /// Whether nothing that was declared is broken.
    pub fn is_met(&self) -> bool {
        self.findings.iter().all(Finding::is_met)
    }
}

/// Measures one part of a registry against what it declares, on each of its ways to compute values. A system is
/// measured by itself, a realization by itself and under every dynamic approximation of the registry. A dynamic
/// approximation is measured over exact realizations, a step map on every problem that it serves.
///
/// # Errors
/// [`BuildError::UnknownPart`].
pub fn conformance(registry: &Registry, name: &str) -> Result<Conformance, BuildError> {
    let unknown = || BuildError::UnknownPart {
        kind: "part",
        name: name.to_owned(),
        suggestion: None,
    };
    let mut parts = registry.parts().into_iter();
    let part = parts.find(|info| info.name == name).ok_or_else(unknown)?;
    let mut findings = Vec::new();
    if part.kind == PartKind::System {
        systems::examine(registry, part, &mut findings)?;
        return Ok(Conformance { part, findings });
    }
    let all = problems::all(registry);
    let own = problems::of_plugins(registry);
    for path in paths(part) {
        // Formulas of a map alone do not say for which systems they are meant.
        let is_map = matches!(part.kind, PartKind::Dynamics | PartKind::Stepper);
        let problems = if is_map && part.is_formulas_alone() {
            &own
        } else {
            &all
        };
        let before = findings.len();
        match part.kind {
            PartKind::Realization => {
                realizations::examine(registry, part, path, problems, &mut findings)?;
            }
            PartKind::Dynamics => {
                maps::examine_dynamics(registry, part, path, problems, &mut findings)?;
            }
            _ => maps::examine_stepper(registry, part, path, problems, &mut findings)?,
        }
        if findings.len() == before {
            findings.push(Finding::not_tried(path, problems));
        }
    }
    Ok(Conformance { part, findings })
}

/// The ways in which a part computes values, where it has several.
fn paths(part: &PartInfo) -> Vec<Option<&'static str>> {
    match part.paths {
        [] | [_] => vec![None],
        several => several.iter().copied().map(Some).collect(),
    }
}

/// A part's parameters at their defaults, on one of its paths. An adaptive method shows its order where
/// the tolerance leaves the step alone.
fn parameters(part: &PartInfo, path: Option<&'static str>) -> PartParameters {
    let mut parameters = PartParameters::new();
    if let Some(word) = path {
        parameters = parameters.with(PATH, word);
    }
    if part.parameters.iter().any(|p| p.name == "tolerance") {
        parameters = parameters.with("tolerance", 0.1);
    }
    parameters
}
