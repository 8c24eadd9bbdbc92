//! Terms of H that are left out at the ends of an open lattice.

use super::Refusal;
use super::definitions::scope;
use super::instantiate::geometry;
use super::names::{parse, refusal};
use crate::document::SceneDocument;

/// A term of H that reaches beyond an open end, and the sites at which it is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The term as it is written.
    pub term: String,
    /// The values of its index, in order.
    pub sites: Vec<usize>,
}

/// Lists the terms of H that are left out at the ends of an open lattice. The list is empty where H is no combination
/// of sums over sites.
///
/// # Errors
/// A formula that cannot be read.
pub fn left_out(document: &SceneDocument) -> Result<Vec<LeftOut>, Refusal> {
    let geometry = geometry(document);
    let hamiltonian = &document.system.hamiltonian;
    let mut found: Vec<LeftOut> = Vec::new();
    if geometry.periodic || geometry.families.is_empty() || document.system.numbers.is_some() {
        return Ok(found);
    }
    let parsed = parse(document, hamiltonian)?;
    let Ok(offsets) = parsed.offsets_of_sums() else {
        return Ok(found);
    };
    let lengths: Vec<usize> = geometry.families.iter().map(|family| family.1).collect();
    let scope = scope(document, &lengths, None)?;
    let (longest, shortest) = (
        geometry.length() as i64,
        lengths.iter().copied().min().unwrap_or(0) as i64,
    );
    let least = offsets
        .iter()
        .map(|offsets| *offsets.start())
        .min()
        .unwrap_or(0);
    let greatest = offsets
        .iter()
        .map(|offsets| *offsets.end())
        .max()
        .unwrap_or(0);
    let first = longest.min(least.saturating_neg()).max(0);
    let last = shortest
        .saturating_sub(greatest.max(0))
        .clamp(first, longest);
    for site in (0..first).chain(last..longest) {
        let site = site as usize;
        let terms = parsed
            .left_out(&scope, site)
            .map_err(|error| refusal(document, hamiltonian, &error))?;
        for term in terms {
            match found.iter_mut().find(|known| known.term == term) {
                Some(known) if known.sites.last() == Some(&site) => {}
                Some(known) => known.sites.push(site),
                None => found.push(LeftOut {
                    term: term.to_owned(),
                    sites: vec![site],
                }),
            }
        }
    }
    Ok(found)
}
