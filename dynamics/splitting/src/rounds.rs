//! Terms of pairs in rounds: no site is in two pairs of one round, so that the terms of a round commute.

use std::collections::{BTreeMap, BTreeSet};

use leafwise_core::BuildError;
use leafwise_expression::Ring;

use crate::piece::{Atom, Piece};
use crate::probe::Probe;

/// How many terms are tried with one that shares a site with them.
const TRIED: usize = 4;

/// The round of each term that moves two sites; no round of other terms, nor where terms that share a site have a flow
/// together.
///
/// Sites are what moves under the same terms, such as both coordinates of a vortex. The rounds are those of first fit, or of
/// the circle method where these are fewer: N − 1 for all pairs of an even number N.
pub(crate) fn rounds(
    ring: &mut Ring,
    probe: &Probe,
    atoms: &[Atom],
    dimension: usize,
) -> Result<Vec<Option<usize>>, BuildError> {
    let mut movers: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (at, atom) in atoms.iter().enumerate() {
        for variable in atom.field.keys() {
            movers.entry(*variable).or_default().push(at);
        }
    }
    let mut numbers: BTreeMap<&[usize], usize> = BTreeMap::new();
    let mut sites: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); atoms.len()];
    for terms in movers.values() {
        let next = numbers.len();
        let site = *numbers.entry(terms).or_insert(next);
        for at in terms {
            sites[*at].insert(site);
        }
    }
    let pairs: Vec<(usize, [usize; 2])> = (sites.iter().enumerate())
        .filter_map(|(at, own)| {
            let own: Vec<usize> = own.iter().copied().collect();
            Some((at, own.try_into().ok()?))
        })
        .collect();
    let mut of_atoms = vec![None; atoms.len()];
    let shares = |a: [usize; 2], b: [usize; 2]| a.iter().any(|site| b.contains(site));
    let (mut tried, stride) = (0, pairs.len().div_ceil(TRIED).max(1));
    for (k, (at, own)) in pairs.iter().enumerate().step_by(stride) {
        let mut others = pairs[k + 1..].iter().chain(&pairs[..k]);
        let Some((other, _)) = others.find(|(_, other)| shares(*own, *other)) else {
            continue;
        };
        let mut piece = Piece::empty(dimension);
        let whole = piece.add(ring, probe, &atoms[*at])?;
        if whole.is_err() || piece.add(ring, probe, &atoms[*other])?.is_ok() {
            return Ok(of_atoms);
        }
        tried += 1;
    }
    if tried == 0 {
        return Ok(of_atoms);
    }
    let ends: Vec<[usize; 2]> = pairs.iter().map(|(_, ends)| *ends).collect();
    for ((at, _), round) in pairs.iter().zip(coloured(&ends, numbers.len())) {
        of_atoms[*at] = Some(round);
    }
    Ok(of_atoms)
}

/// All pairs of so many sites in rounds, i < j.
pub(crate) fn rounds_of_all(sites: usize) -> Vec<Vec<[usize; 2]>> {
    let pairs = (0..sites).flat_map(|i| (i + 1..sites).map(move |j| [i, j]));
    let pairs: Vec<[usize; 2]> = pairs.collect();
    let mut rounds = Vec::new();
    for (pair, round) in pairs.iter().zip(circle(&pairs, sites)) {
        if rounds.len() <= round {
            rounds.resize(round + 1, Vec::new());
        }
        rounds[round].push(*pair);
    }
    rounds
}

/// A round for each pair of so many sites: by first fit, or by the circle method where it takes fewer.
fn coloured(pairs: &[[usize; 2]], sites: usize) -> Vec<usize> {
    let count = |rounds: &[usize]| rounds.iter().max().map_or(0, |most| most + 1);
    let (fitted, turned) = (first_fit(pairs, sites), circle(pairs, sites));
    match count(&turned) < count(&fitted) {
        true => turned,
        false => fitted,
    }
}

/// The first round in which neither end has a pair.
fn first_fit(pairs: &[[usize; 2]], sites: usize) -> Vec<usize> {
    let mut taken: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); sites];
    let round = |ends: &[usize; 2]| {
        let mut rounds = 0..;
        let free = |round: &usize| ends.iter().all(|end| !taken[*end].contains(round));
        let round = rounds.find(free).unwrap_or(0);
        for end in ends {
            taken[*end].insert(round);
        }
        round
    };
    pairs.iter().map(round).collect()
}

/// The rounds of a tournament in which all meet (E. Lucas, *Récréations mathématiques II* (1883)), numbered as they come.
fn circle(pairs: &[[usize; 2]], sites: usize) -> Vec<usize> {
    // The last of an even number stands in the middle; of an odd number nobody does.
    let rounds = sites.next_multiple_of(2) - 1;
    let mut numbers = BTreeMap::new();
    let round = |ends: &[usize; 2]| {
        let middle = ends.contains(&rounds);
        let other = ends[0].min(ends[1]);
        let round = match middle {
            true => 2 * other % rounds,
            false => (ends[0] + ends[1]) % rounds,
        };
        let next = numbers.len();
        *numbers.entry(round).or_insert(next)
    };
    pairs.iter().map(round).collect()
}

#[cfg(test)]
mod tests {
    use super::{circle, coloured, first_fit};

    fn all(sites: usize) -> Vec<[usize; 2]> {
        let pairs = (0..sites).flat_map(|i| (i + 1..sites).map(move |j| [i, j]));
        pairs.collect()
    }

    /// The chromatic index of a complete graph: N − 1 of an even number of sites, N of an odd one.
    #[test]
    fn all_pairs_take_as_few_rounds_as_there_are() {
        for sites in 2..30 {
            let pairs = all(sites);
            for rounds in [
                circle(&pairs, sites),
                coloured(&pairs, sites),
                first_fit(&pairs, sites),
            ] {
                for (a, one) in pairs.iter().enumerate() {
                    for (b, other) in pairs[..a].iter().enumerate() {
                        let shares = one.iter().any(|site| other.contains(site));
                        assert!(!shares || rounds[a] != rounds[b], "{one:?} {other:?}");
                    }
                }
            }
            let rounds = coloured(&pairs, sites);
            let least = if sites % 2 == 0 { sites - 1 } else { sites };
            let least = if sites == 2 { 1 } else { least };
            assert_eq!(rounds.iter().max(), Some(&(least - 1)), "{sites}");
        }
    }

    /// A ring of neighbours takes two rounds, as many as by the order of its terms.
    #[test]
    fn neighbours_take_two_rounds() {
        let pairs: Vec<[usize; 2]> = (0..8).map(|i| [i, (i + 1) % 8]).collect();
        assert_eq!(coloured(&pairs, 8), [0, 1, 0, 1, 0, 1, 0, 1]);
    }
}
