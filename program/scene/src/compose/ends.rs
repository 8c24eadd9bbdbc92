//! Terms of H that are left out at the ends of an open lattice.

use std::ops::Range;

use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::syntax::Offsets;

use super::Refusal;
use super::definitions::scope;
use super::geometry::geometry;
use super::names::{parse, refusal};
use crate::document::SceneDocument;

/// A term of H that reaches beyond an open end, and the sites at which it is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The term as it is written.
    pub term: String,
    /// For each axis the values of its index, in order, at which it is left out.
    pub places: Vec<Vec<usize>>,
}

/// Lists the terms of H that are left out at the ends of an open lattice. The list is empty where H is no combination
/// of sums over sites.
///
/// # Errors
/// A formula that cannot be read.
pub fn left_out(document: &SceneDocument) -> Result<Vec<LeftOut>, Refusal> {
    let geometry = geometry(document);
    let hamiltonian = &document.system.hamiltonian;
    let mut found: Vec<(String, Vec<usize>)> = Vec::new();
    if geometry.is_periodic() || geometry.families.is_empty() || document.system.numbers.is_some() {
        return Ok(Vec::new());
    }
    let parsed = parse(document, hamiltonian)?;
    let Ok(offsets) = parsed.offsets_of_sums() else {
        return Ok(Vec::new());
    };
    let scope = scope(document, &geometry, None)?;
    for site in near_ends(&geometry, &offsets) {
        let terms = parsed
            .left_out(&scope, site)
            .map_err(|error| refusal(document, hamiltonian, &error))?;
        for term in terms {
            match found.iter_mut().find(|(known, _)| known == term) {
                Some((_, sites)) if sites.last() == Some(&site) => {}
                Some((_, sites)) => sites.push(site),
                None => found.push((term.to_owned(), vec![site])),
            }
        }
    }
    let left_out = found.into_iter().map(|(term, sites)| LeftOut {
        term,
        places: places(&geometry, &sites),
    });
    Ok(left_out.collect())
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
