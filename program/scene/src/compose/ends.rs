//! Terms that are left out at the ends of an open lattice.

use std::ops::Range;

use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::syntax::Offsets;

use super::Refusal;
use super::definitions::scope;
use super::geometry::geometry;
use super::keys::variable;
use super::names::{parse, refusal};
use crate::document::{ByCoordinate, ComponentsSpec, Located, MetricSpec, SceneDocument};

/// A term that reaches beyond an open end, and the sites at which it is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Whose term it is: `H`, or the key and the coordinate of a force, `forces of p[i]`.
    pub of: String,
    /// The term as it is written.
    pub term: String,
    /// For each axis the values of its index, in order, at which it is left out.
    pub places: Vec<Vec<usize>>,
}

/// Lists the terms that are left out at the ends of an open lattice: of H, of forces, friction and metrics by sites, and of noise.
/// Of H there are none where it is no combination of sums over sites.
///
/// # Errors
/// A formula that cannot be read.
pub fn left_out(document: &SceneDocument) -> Result<Vec<LeftOut>, Refusal> {
    let geometry = geometry(document);
    if geometry.is_periodic() || geometry.families.is_empty() || document.system.numbers.is_some() {
        return Ok(Vec::new());
    }
    let scope = scope(document, &geometry, None)?;
    let mut left_out = Vec::new();
    for Template { of, formula, names } in templates(document)? {
        let parsed = parse(document, formula)?;
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let offsets = match names.is_empty() {
            true => parsed.offsets_of_sums(),
            false => parsed
                .offsets_from(&names)
                .map(|own| own.into_iter().collect()),
        };
        let Ok(offsets) = offsets else { continue };
        let mut found: Vec<(String, Vec<usize>)> = Vec::new();
        for site in near_ends(&geometry, &offsets) {
            let terms = match names.is_empty() {
                true => parsed.left_out(&scope, site),
                false => parsed.left_out_of_summand(&scope, (&names, site)),
            };
            for term in terms.map_err(|error| refusal(document, formula, &error))? {
                match found.iter_mut().find(|(known, _)| known == term) {
                    Some((_, sites)) if sites.last() == Some(&site) => {}
                    Some((_, sites)) => sites.push(site),
                    None => found.push((term.to_owned(), vec![site])),
                }
            }
        }
        left_out.extend(found.into_iter().map(|(term, sites)| LeftOut {
            of: of.clone(),
            term,
            places: places(&geometry, &sites),
        }));
    }
    Ok(left_out)
}

/// A formula of sums over sites, or of a site by the names of its indices.
struct Template<'a> {
    of: String,
    formula: &'a Located<String>,
    names: Vec<String>,
}

/// Formulas by coordinates.
fn named(spec: Option<&Located<ComponentsSpec>>) -> Option<&ByCoordinate> {
    match &spec?.value {
        ComponentsSpec::Named(entries) => Some(entries),
        ComponentsSpec::All(_) => None,
    }
}

/// Those of H, of forces and of noise.
///
/// # Errors
/// A formula that cannot be read.
fn templates(document: &SceneDocument) -> Result<Vec<Template<'_>>, Refusal> {
    let forces = &document.system.forces;
    let metric = (forces.damping.as_ref()).and_then(|own| own.metric.as_ref());
    let metric = metric.and_then(|metric| match &metric.value {
        MetricSpec::Named(entries) => Some(entries),
        _ => None,
    });
    let mut templates = vec![Template {
        of: "H".to_owned(),
        formula: &document.system.hamiltonian,
        names: Vec::new(),
    }];
    for (key, entries) in [
        ("forces", named(forces.one_form.as_ref())),
        ("friction", named(forces.friction.as_ref())),
        ("metric", metric),
    ] {
        for (coordinate, formula) in entries.into_iter().flatten() {
            let pattern = variable(document, coordinate)?;
            let names: Vec<String> = pattern
                .index_names()
                .into_iter()
                .map(str::to_owned)
                .collect();
            if !names.is_empty() {
                templates.push(Template {
                    of: format!("{key} of {}", coordinate.value.trim()),
                    formula,
                    names,
                });
            }
        }
    }
    for spec in &document.system.noise {
        let names = parse(document, &spec.hamiltonian)?
            .free_indices()
            .into_iter()
            .map(str::to_owned)
            .collect();
        templates.push(Template {
            of: "noise".to_owned(),
            formula: &spec.hamiltonian,
            names,
        });
    }
    Ok(templates)
}

/// For each axis the values of its index of which all sites are among these.
fn places(geometry: &LatticeGeometry, sites: &[usize]) -> Vec<Vec<usize>> {
    let along = |(axis, length): (usize, usize)| {
        let mut counts = vec![0; length];
        for site in sites {
            counts[geometry.place(*site)[axis]] += 1;
        }
        let all = geometry.length() / length.max(1);
        (0..length).filter(|at| counts[*at] == all).collect()
    };
    let lengths = geometry.axes.iter().map(|axis| axis.length);
    lengths.enumerate().map(along).collect()
}

/// Sites from which a template names something beyond an end.
fn near_ends<'a>(
    geometry: &'a LatticeGeometry,
    templates: &[Offsets],
) -> impl Iterator<Item = usize> + use<'a> {
    let shortest = geometry.families.iter().map(|family| family.1).min();
    let along = |axis: usize| {
        let ranges = templates.iter().map(|offsets| &offsets.axes()[axis]);
        let least = ranges.clone().map(|range| *range.start()).min();
        let greatest = ranges.map(|range| *range.end()).max();
        let length = match geometry.axes.len() {
            1 => shortest.unwrap_or(0),
            _ => geometry.axes[axis].length,
        } as i64;
        let first = least.unwrap_or(0).saturating_neg().max(0);
        let last = length.saturating_sub(greatest.unwrap_or(0).max(0));
        (axis, first..last)
    };
    let ends = geometry.ends();
    let axes = (0..geometry.axes.len()).filter(|axis| ends[*axis]);
    let inside: Vec<(usize, Range<i64>)> = axes.map(along).collect();
    (0..geometry.length()).filter(move |site| {
        let place = geometry.place(*site);
        let is_inside =
            |(axis, range): &(usize, Range<i64>)| range.contains(&(place[*axis] as i64));
        !inside.iter().all(is_inside)
    })
}
