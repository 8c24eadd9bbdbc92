//! How far the templates of a scene look from a site.

use leafwise_core::lattice::TemplateReach;

use super::Refusal;
use super::definitions::scope;
use super::dense::WRITTEN_LIMIT;
use super::geometry::one_site;
use super::keys::{pair, variable};
use super::names::{function, parse, refusal};
use super::sum::summands;
use crate::document::{BracketSpec, ComponentsSpec, Located, MetricSpec, Place, SceneDocument};

/// Reach of a scene's templates: how far its bracket, H and its Casimirs look from a site.
///
/// # Errors
/// The first template that couples sites at any distance. A template that cannot be read.
pub(super) fn reach(
    document: &SceneDocument,
    known: TemplateReach,
) -> Result<TemplateReach, Refusal> {
    let system = &document.system;
    let mut reach = bracket_reach(document, known)?;
    let refused = |formula, error| refusal(document, formula, &error);
    let hamiltonian = &system.hamiltonian;
    reach = reach
        .with_hamiltonian(&parse(document, hamiltonian)?)
        .map_err(|error| refused(hamiltonian, error))?;
    for (_, casimir) in &system.casimirs {
        reach = reach
            .with_casimir(&parse(document, casimir)?)
            .map_err(|error| refused(casimir, error))?;
    }
    for channel in &system.noise {
        reach = reach
            .with_channel(&parse(document, &channel.hamiltonian)?)
            .map_err(|error| refused(&channel.hamiltonian, error))?;
    }
    force_reach(document, reach)
}

/// The same with the forces.
///
/// # Errors
/// A list, whose entries would be as many as there are coordinates. A rate that depends on the state, which couples every site
/// to all. As for the bracket.
fn force_reach(
    document: &SceneDocument,
    mut reach: TemplateReach,
) -> Result<TemplateReach, Refusal> {
    let refuse = |place: Place, message: &str, help: &str| {
        let help = Some(help.to_owned());
        Err(Box::new(document.diagnostic(&place, message, "here", help)))
    };
    let by_site = "on a lattice of this length forces repeat from site to site, and a list names its coordinates one by one";
    let forces = &document.system.forces;
    let mut entries: Vec<_> = Vec::new();
    if let Some(one_form) = &forces.one_form {
        match &one_form.value {
            ComponentsSpec::Named(named) => entries.extend(named),
            ComponentsSpec::All(_) => {
                let help = "write a table with an index: forces = { \"q[i]\" = \"0.1*p[i]\" }";
                return refuse(one_form.place(), by_site, help);
            }
        }
    }
    if let Some(friction) = &forces.friction {
        match &friction.value {
            ComponentsSpec::Named(named) => entries.extend(named),
            ComponentsSpec::All(_) => {
                let help = "write a table with an index: friction = { \"p[i]\" = \"-0.1*p[i]\" }";
                return refuse(friction.place(), by_site, help);
            }
        }
    }
    if let Some(torque) = &forces.torque {
        let help = "write it by coordinates: forces = { \"q[i]\" = \"0.1*p[i]\" }";
        let message = "a torque acts on one body with attitude, and this is a lattice";
        return refuse(torque.place(), message, help);
    }
    if let Some(damping) = &forces.damping {
        let parsed = parse(document, &damping.rate)?;
        let refused = |error| refusal(document, &damping.rate, &error);
        parsed.offsets_from(&[]).map_err(refused)?;
        let one_site = one_site(document);
        let rate = function(document, &scope(document, &one_site, None)?, &damping.rate)?;
        if !rate.variables().is_empty() {
            let message = "on a lattice of this length the rate of the damping is a formula of the parameters: one rate that \
                           depends on the state couples every site to all others";
            let help = "values that differ from site to site belong in the metric: metric = { \"p[i]\" = \"a[i]\" }";
            return refuse(damping.rate.place(), message, help);
        }
        if let Some(metric) = &damping.metric {
            match &metric.value {
                MetricSpec::Named(named) => entries.extend(named),
                MetricSpec::Diagonal(_) | MetricSpec::Rows(_) => {
                    let help = "write a table with an index: metric = { \"q[i]\" = \"1\" }";
                    return refuse(metric.place(), by_site, help);
                }
            }
        }
        // λ g ẋ_H looks as far as tensor and dH together.
        reach.forces = reach.each();
    }
    entries_reach(document, reach, entries)
}

/// The same with components of forces, or entries of a metric, by coordinates.
///
/// # Errors
/// What cannot be read, or names sites one by one.
pub(super) fn entries_reach<'a>(
    document: &SceneDocument,
    mut reach: TemplateReach,
    entries: impl IntoIterator<Item = &'a (Located<String>, Located<String>)>,
) -> Result<TemplateReach, Refusal> {
    for (key, formula) in entries {
        let pattern = variable(document, key)?;
        pattern
            .offsets_from(&pattern.index_names())
            .map_err(|error| refusal(document, key, &error))?;
        reach = reach
            .with_force(&pattern, &parse(document, formula)?)
            .map_err(|error| refusal(document, formula, &error))?;
    }
    Ok(reach)
}

/// The same of the bracket alone, or of a summand's.
pub(super) fn bracket_reach(
    document: &SceneDocument,
    mut reach: TemplateReach,
) -> Result<TemplateReach, Refusal> {
    let bracket = &document.system.bracket;
    match &bracket.value {
        BracketSpec::Entries(written) | BracketSpec::Contact(written) => {
            for (key, formula) in written {
                let (a, b) = pair(document, key)?;
                let names = [a.index_names(), b.index_names()];
                let names = names.into_iter().find(|names| !names.is_empty());
                let names = names.unwrap_or_default();
                let of_pair = a.offsets_from(&names).and_then(|_| b.offsets_from(&names));
                of_pair.map_err(|error| refusal(document, key, &error))?;
                reach = reach
                    .with_entry([&a, &b], &parse(document, formula)?)
                    .map_err(|error| refusal(document, formula, &error))?;
            }
            Ok(reach)
        }
        // The same at every site.
        BracketSpec::LieAlgebra(_) if !document.system.vectors.is_empty() => Ok(reach),
        BracketSpec::Sum(_) => {
            let one_site = one_site(document);
            for summand in summands(document, &one_site)? {
                reach = bracket_reach(&summand.document, reach)?;
            }
            Ok(reach)
        }
        _ => Err(Box::new(document.diagnostic(
            &bracket.place(),
            format!(
                "on a lattice of more than {WRITTEN_LIMIT} coordinates a bracket repeats from site to site, and this one names \
                 its coordinates one by one"
            ),
            "this bracket",
            Some("write its entries with an index, as in \"x[i],x[i+1]\", or shorten the lattice".to_owned()),
        ))),
    }
}
