//! Sublattices: colours of spins such that none is in the field of another of its colour.

use std::collections::{BTreeMap, BTreeSet};

use leafwise_core::lattice::{LatticeGeometry, PerAxis};
use leafwise_expression::syntax::AXES;

use super::spins::Spin;

/// The most sublattices of a long lattice.
const MOST: usize = 8;

/// The first colour for each spin that none has which is in its field, or in whose field it is.
pub(super) fn of_written(spins: &[Spin], reads: &[BTreeSet<usize>]) -> Vec<usize> {
    let mut owner = BTreeMap::new();
    for (at, spin) in spins.iter().enumerate() {
        owner.extend(spin.places.iter().map(|place| (*place, at)));
    }
    let mut beside = vec![BTreeSet::new(); spins.len()];
    for (at, read) in reads.iter().enumerate() {
        for other in read.iter().filter_map(|place| owner.get(place)) {
            beside[at].insert(*other);
            beside[*other].insert(at);
        }
    }
    let mut colours: Vec<usize> = Vec::with_capacity(spins.len());
    for own in &beside {
        let taken: BTreeSet<usize> = own
            .iter()
            .filter_map(|o| colours.get(*o).copied())
            .collect();
        let free = (0..).find(|colour| !taken.contains(colour));
        colours.extend(free);
    }
    colours
}

/// Colourings of so many colours that are tried at most.
const MOST_TRIES: usize = 1 << 20;

/// Colours c = (o_g + Σ_k a_k i_k) mod m of the spins of kind g at the sites i of a lattice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Colouring {
    /// m.
    pub(super) count: usize,
    along: PerAxis<usize>,
    kinds: Vec<usize>,
}

/// A spin of the first kind has in its field one of the second, so far away.
pub(super) type Bond = (usize, usize, PerAxis<isize>);

impl Colouring {
    /// The first with the fewest colours, `None` where none of so few as are tried serves.
    pub(super) fn of(
        geometry: &LatticeGeometry,
        kinds: usize,
        bonds: &BTreeSet<Bond>,
    ) -> Option<Self> {
        let axes = geometry.axes.len();
        (1..=MOST).find_map(|count| {
            let numbers = axes + kinds - 1;
            let tries = u32::try_from(numbers)
                .ok()
                .and_then(|n| count.checked_pow(n))?;
            (0..tries.min(MOST_TRIES)).find_map(|mut index| {
                let mut next = || {
                    let digit = index % count;
                    index /= count;
                    digit
                };
                let mut colouring = Self {
                    count,
                    along: [0; AXES],
                    kinds: vec![0; kinds],
                };
                colouring.along[..axes].iter_mut().for_each(|a| *a = next());
                colouring.kinds[1..].iter_mut().for_each(|o| *o = next());
                colouring.serves(geometry, bonds).then_some(colouring)
            })
        })
    }

    fn serves(&self, geometry: &LatticeGeometry, bonds: &BTreeSet<Bond>) -> bool {
        let closes = geometry.axes.iter().zip(self.along);
        let mut closes = closes.filter(|(axis, _)| axis.periodic);
        let count = self.count as isize;
        closes.all(|(axis, a)| (a * axis.length).is_multiple_of(self.count))
            && bonds.iter().all(|(own, other, shift)| {
                let apart = self.kinds[*other] as isize - self.kinds[*own] as isize;
                let along = self.along.iter().zip(shift);
                let sum = along.fold(apart, |sum, (a, shift)| sum + *a as isize * shift);
                sum.rem_euclid(count) != 0
            })
    }

    /// The colour of a spin.
    pub(super) fn of_spin(&self, kind: usize, place: PerAxis<usize>) -> usize {
        let along = self.along.iter().zip(place);
        along.fold(self.kinds[kind], |sum, (a, at)| sum + a * at) % self.count
    }
}
