//! Where the inputs of sites stand that share code but no distances in memory.

use leafwise_expression::syntax::AXES;

use super::blocks::BLOCK;
use super::geometry::{LatticeGeometry, PerAxis};

/// The most numbers that are kept, 64 MB of them.
const MOST: usize = 1 << 24;

/// Some sites, such as those at the ends of rows, and where others stand beside each of them, looked up once.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeSites {
    sites: Vec<u32>,
    /// Distances to the sites whose numbers are read.
    shifts: Vec<PerAxis<isize>>,
    /// For each distance the sites that stand so far from `sites`.
    places: Vec<Vec<u32>>,
}

impl EdgeSites {
    /// Looks up the sites that stand at these distances; `None` where they are too many to be kept.
    pub(super) fn find(
        geometry: &LatticeGeometry,
        sites: impl Iterator<Item = usize> + Clone,
        shifts: impl Iterator<Item = PerAxis<isize>>,
    ) -> Option<Self> {
        let mut distinct: Vec<PerAxis<isize>> = Vec::new();
        for shift in shifts {
            if !distinct.contains(&shift) {
                distinct.push(shift);
            }
        }
        let count = sites.clone().count();
        let largest = geometry.length();
        if count == 0
            || count.saturating_mul(distinct.len() + 1) > MOST
            || u32::try_from(largest).is_err()
        {
            return None;
        }
        let place = |shift: PerAxis<isize>| -> Vec<u32> {
            let beside = |site| geometry.beside(site, shift).unwrap_or(site) as u32;
            sites.clone().map(beside).collect()
        };
        Some(Self {
            sites: place([0; AXES]),
            places: distinct.iter().map(|shift| place(*shift)).collect(),
            shifts: distinct,
        })
    }

    /// The number of blocks of at most [`BLOCK`] sites.
    pub(super) fn blocks(&self) -> usize {
        self.sites.len().div_ceil(BLOCK)
    }

    /// The number of a distance.
    pub(super) fn shift(&self, shift: PerAxis<isize>) -> Option<usize> {
        self.shifts.iter().position(|own| *own == shift)
    }

    /// Loads the numbers that stand at a distance, by its number, from the sites of a block; lanes beyond repeat the last one.
    pub(super) fn load(&self, lanes: &mut [f64], field: &[f64], shift: usize, block: usize) {
        let places = Self::of_block(&self.places[shift], block);
        let (own, beyond) = lanes.split_at_mut(places.len());
        for (lane, place) in own.iter_mut().zip(places) {
            *lane = field[*place as usize];
        }
        if let Some(last) = own.last() {
            beyond.fill(*last);
        }
    }

    /// Stores numbers at the sites of a block.
    pub(super) fn store(&self, lanes: &[f64], field: &mut [f64], block: usize) {
        for (lane, site) in lanes.iter().zip(Self::of_block(&self.sites, block)) {
            field[*site as usize] = *lane;
        }
    }

    fn of_block(all: &[u32], block: usize) -> &[u32] {
        &all[block * BLOCK..][..BLOCK.min(all.len() - block * BLOCK)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::geometry::{Axis, LatticeGeometry};
    use super::{BLOCK, EdgeSites};

    /// Numbers of the sites of a torus's surface and of those one behind them along each axis.
    #[test]
    fn numbers_are_those_of_the_places() {
        let axes = [3, 4, 7].map(|length| Axis {
            length,
            periodic: true,
        });
        let geometry = LatticeGeometry::along(["s".to_owned()], axes.to_vec());
        let sites = (0..geometry.length()).filter(|site| site % 7 == 6 || site / 28 == 2);
        let shifts = [[0, 0, 1], [0, 1, 0], [1, 0, 0], [-1, 0, -1], [0, 0, 1]];
        let beside = EdgeSites::find(&geometry, sites.clone(), shifts.into_iter()).expect("few");
        let field: Vec<f64> = (0..geometry.length()).map(|site| site as f64).collect();
        assert!(beside.blocks() > 1 && beside.shift([0, 0, 2]).is_none());
        for shift in shifts {
            let number = beside.shift(shift).expect("looked up");
            let (mut loaded, mut stored) = (Vec::new(), vec![-1.0; field.len()]);
            for block in 0..beside.blocks() {
                let mut lanes = [0.0; BLOCK];
                beside.load(&mut lanes, &field, number, block);
                beside.store(&lanes, &mut stored, block);
                loaded.extend(lanes);
            }
            for (site, number) in sites.clone().zip(loaded) {
                let [i, j, k] = geometry.place(site);
                let place = [(i, 3), (j, 4), (k, 7)].into_iter().zip(shift);
                let place = place.map(|((at, length), by)| (at as isize + by).rem_euclid(length));
                let expected = place.zip([28, 7, 1]).map(|(at, by)| at * by).sum::<isize>();
                assert_eq!(number, expected as f64);
                assert_eq!(stored[site], expected as f64);
            }
            let left = stored.iter().filter(|number| **number == -1.0).count();
            assert_eq!(left, field.len() - sites.clone().count());
        }
    }
}
