//! Where the inputs of sites stand that share code but no distances in memory.

use std::ops::Range;

use leafwise_expression::syntax::AXES;

use super::blocks::BLOCK;
use super::geometry::{LatticeGeometry, PerAxis};

/// The most numbers that are kept, 64 MB of them.
const MOST: usize = 1 << 24;

/// Some sites, such as those at the ends of rows, and where others stand beside each of them, looked up once.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeSites {
    sites: Places,
    /// Their blocks of at most [`BLOCK`] sites.
    blocks: Vec<Range<usize>>,
    /// Distances to the sites whose numbers are read.
    shifts: Vec<PerAxis<isize>>,
    /// For each distance the sites that stand so far from `sites`.
    places: Vec<Places>,
}

/// Where sites stand.
#[derive(Clone, Debug, Default)]
struct Places {
    sites: Vec<u32>,
    /// For each block its first site, where the others follow one after the other and there are [`BLOCK`] of them.
    rows: Vec<Option<u32>>,
}

impl Places {
    fn new(sites: Vec<u32>, blocks: &[Range<usize>]) -> Self {
        let row = |block: &Range<usize>| {
            let own = &sites[block.clone()];
            let is_row = own.len() == BLOCK && own.windows(2).all(|two| two[1] == two[0] + 1);
            is_row.then(|| own[0])
        };
        Self {
            rows: blocks.iter().map(row).collect(),
            sites,
        }
    }
}

/// The blocks of ascending sites, as numbers of so many each: of a row of [`BLOCK`] sites or more its parts are blocks of
/// their own.
pub(super) fn blocks_of<'a>(
    geometry: &LatticeGeometry,
    sites: &'a [usize],
) -> impl Iterator<Item = usize> + use<'a> {
    let length = geometry.axes.last().map_or(1, |axis| axis.length);
    let begins_row = move |sites: &[usize]| {
        let row = sites.get(..BLOCK);
        let place = sites.first().map_or(0, |site| site % length);
        place.is_multiple_of(BLOCK)
            && place + BLOCK <= length
            && row.is_some_and(|row| row[BLOCK - 1] - row[0] == BLOCK - 1)
    };
    let mut left = sites;
    std::iter::from_fn(move || {
        let most = left.len().min(BLOCK);
        let count = match begins_row(left) {
            true => BLOCK,
            false => (1..most)
                .find(|at| begins_row(&left[*at..]))
                .unwrap_or(most),
        };
        left = &left[count..];
        (count > 0).then_some(count)
    })
}

impl EdgeSites {
    /// Looks up the sites that stand at these distances from each of the sites, in groups that share no block; `None` where they
    /// are too many to be kept.
    pub(super) fn find(
        geometry: &LatticeGeometry,
        groups: &[Vec<usize>],
        shifts: impl Iterator<Item = PerAxis<isize>>,
    ) -> Option<Self> {
        let mut distinct: Vec<PerAxis<isize>> = Vec::new();
        for shift in shifts {
            if !distinct.contains(&shift) {
                distinct.push(shift);
            }
        }
        let count: usize = groups.iter().map(Vec::len).sum();
        let largest = geometry.length();
        if count == 0
            || count.saturating_mul(distinct.len() + 1) > MOST
            || u32::try_from(largest).is_err()
        {
            return None;
        }
        let mut start = 0;
        let mut blocks = Vec::new();
        for count in groups.iter().flat_map(|group| blocks_of(geometry, group)) {
            blocks.push(start..start + count);
            start += count;
        }
        let place = |shift: PerAxis<isize>| {
            let beside = |site| geometry.beside(site, shift).unwrap_or(site) as u32;
            let sites = groups.iter().flatten().copied().map(beside);
            Places::new(sites.collect(), &blocks)
        };
        let (sites, places) = (
            place([0; AXES]),
            distinct.iter().map(|shift| place(*shift)).collect(),
        );
        Some(Self {
            sites,
            blocks,
            places,
            shifts: distinct,
        })
    }

    /// Calls `take` with each site of some blocks, which is written, and with each that is read for it.
    pub(super) fn for_each_site(&self, blocks: Range<usize>, mut take: impl FnMut(usize, bool)) {
        for block in &self.blocks[blocks] {
            for (places, is_written) in
                (self.places.iter().map(|places| (places, false))).chain([(&self.sites, true)])
            {
                for site in &places.sites[block.clone()] {
                    take(*site as usize, is_written);
                }
            }
        }
    }

    /// The number of a distance.
    pub(super) fn shift(&self, shift: PerAxis<isize>) -> Option<usize> {
        self.shifts.iter().position(|own| *own == shift)
    }

    /// Loads the numbers that stand at a distance, by its number, from the sites of a block; lanes beyond repeat the last one.
    pub(super) fn load(&self, lanes: &mut [f64], field: &[f64], shift: usize, block: usize) {
        let places = &self.places[shift];
        if let Some(first) = places.rows[block] {
            return lanes[..BLOCK].copy_from_slice(&field[first as usize..][..BLOCK]);
        }
        let places = &places.sites[self.blocks[block].clone()];
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
        if let Some(first) = self.sites.rows[block] {
            return field[first as usize..][..BLOCK].copy_from_slice(&lanes[..BLOCK]);
        }
        let sites = &self.sites.sites[self.blocks[block].clone()];
        for (lane, site) in lanes.iter().zip(sites) {
            field[*site as usize] = *lane;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::geometry::{Axis, LatticeGeometry};
    use super::{BLOCK, EdgeSites, blocks_of};

    /// Numbers of the sites of a torus's surface and of those one behind them along each axis, of rows shorter and longer than
    /// a block.
    #[test]
    fn numbers_are_those_of_the_places() {
        let mut rows = 0;
        for length in [7, BLOCK, 2 * BLOCK + 6] {
            rows += rows_among(length);
        }
        assert!(rows > 20, "{rows}");
    }

    /// Returns how many blocks are parts of a row for some distance.
    fn rows_among(length: usize) -> usize {
        let axes = [3, 4, length].map(|length| Axis {
            length,
            periodic: true,
        });
        let geometry = LatticeGeometry::along(["s".to_owned()], axes.to_vec());
        let plane = 4 * length;
        let sites =
            (0..geometry.length()).filter(|site| site % length == length - 1 || site / plane == 2);
        let shifts = [[0, 0, 1], [0, 1, 0], [1, 0, 0], [-1, 0, -1], [0, 0, 1]];
        let groups: Vec<Vec<usize>> = vec![
            sites.clone().filter(|site| *site < 40).collect(),
            Vec::new(),
            sites.clone().filter(|site| *site >= 40).collect(),
        ];
        let beside = EdgeSites::find(&geometry, &groups, shifts.into_iter()).expect("few");
        let blocks = groups
            .iter()
            .map(|group| blocks_of(&geometry, group).count());
        let blocks: usize = blocks.sum();
        let field: Vec<f64> = (0..geometry.length()).map(|site| site as f64).collect();
        assert!(blocks >= 2 && beside.shift([0, 0, 2]).is_none());
        for shift in shifts {
            let number = beside.shift(shift).expect("looked up");
            let (mut loaded, mut stored) = (Vec::new(), vec![-1.0; field.len()]);
            for block in 0..blocks {
                let mut lanes = [0.0; BLOCK];
                beside.load(&mut lanes, &field, number, block);
                beside.store(&lanes, &mut stored, block);
                loaded.extend_from_slice(&lanes[..beside.blocks[block].len()]);
            }
            assert_eq!(loaded.len(), sites.clone().count());
            for (site, number) in sites.clone().zip(loaded) {
                let [i, j, k] = geometry.place(site);
                let place = [(i, 3), (j, 4), (k, length)].into_iter().zip(shift);
                let place =
                    place.map(|((at, length), by)| (at as isize + by).rem_euclid(length as isize));
                let sizes = [plane as isize, length as isize, 1];
                let expected = place.zip(sizes).map(|(at, by)| at * by).sum::<isize>();
                assert_eq!(number, expected as f64);
                assert_eq!(stored[site], expected as f64);
            }
            let left = stored.iter().filter(|number| **number == -1.0).count();
            assert_eq!(left, field.len() - sites.clone().count());
        }
        let places = beside.places.iter().chain([&beside.sites]);
        places
            .map(|places| places.rows.iter().flatten().count())
            .sum()
    }
}
