//! States of long families over time, thinned out to what a picture can show.

use leafwise_scene::compose::Sites;
use serde::{Deserialize, Serialize};

/// The most snapshots that are kept; one more and every other is dropped.
const MOST_TIMES: usize = 256;

/// The most sites of a snapshot.
const MOST_SITES: usize = 512;

/// Snapshots of families whose states are too long for `samples.csv`:
/// between 128 and 256 of them whatever the length of the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Snapshots {
    /// Samples from one snapshot to the next.
    pub every: u64,
    /// Samples seen.
    pub seen: u64,
    /// The time of each snapshot.
    pub times: Vec<f64>,
    /// The values, one snapshot after the other.
    pub values: Vec<f64>,
}

/// Sites from one value of a snapshot to the next.
pub(super) fn spacing(sites: &Sites) -> usize {
    length(sites).div_ceil(MOST_SITES).max(1)
}

/// The length of the families that are shown.
fn length(sites: &Sites) -> usize {
    let shown = sites.plane.map_or(0, |[x, _]| x);
    let families = &sites.geometry.families;
    families.get(shown).map_or(0, |family| family.1)
}

/// The coordinates of a snapshot: the places x and then y of bodies, or the first family of a chain. Lattices of several
/// axes have maps instead.
pub(super) fn shown(sites: &Sites) -> Vec<usize> {
    let families = match (sites.plane, &sites.geometry) {
        (Some(plane), _) => plane.to_vec(),
        (None, geometry) if geometry.axes.len() == 1 && !geometry.families.is_empty() => vec![0],
        _ => Vec::new(),
    };
    let every = spacing(sites);
    let coordinates = families.into_iter();
    let coordinates = coordinates.flat_map(|family| sites.coordinates(family).step_by(every));
    coordinates.collect()
}

impl Snapshots {
    /// None yet.
    pub fn new() -> Self {
        Self {
            every: 1,
            seen: 0,
            times: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Takes in the coordinates `shown` of one more sample.
    pub fn push(&mut self, shown: &[usize], time: f64, state: &[f64]) {
        if self.seen.is_multiple_of(self.every) {
            self.times.push(time);
            self.values.extend(shown.iter().map(|at| state[*at]));
        }
        self.seen += 1;
        if self.times.len() == MOST_TIMES {
            self.thin();
        }
    }

    /// Drops every other snapshot.
    fn thin(&mut self) {
        let width = self.values.len() / self.times.len();
        for kept in 0..MOST_TIMES / 2 {
            self.times[kept] = self.times[2 * kept];
            self.values
                .copy_within(2 * kept * width..(2 * kept + 1) * width, kept * width);
        }
        self.times.truncate(MOST_TIMES / 2);
        self.values.truncate(MOST_TIMES / 2 * width);
        self.every *= 2;
    }

    /// The fields, one for each time.
    pub fn fields(&self) -> Vec<Vec<f64>> {
        match self.values.len().checked_div(self.times.len()) {
            Some(width) if width > 0 => self
                .values
                .chunks_exact(width)
                .map(<[f64]>::to_vec)
                .collect(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use leafwise_core::lattice::LatticeGeometry;

    use super::*;

    /// Families of these lengths along one axis.
    fn sites(families: Vec<(&str, usize)>, plane: Option<[usize; 2]>) -> Sites {
        let families = families.into_iter();
        let families = families.map(|(name, length)| (name.to_owned(), length));
        Sites {
            geometry: LatticeGeometry::chain(families.collect(), true),
            first: 0,
            has_neighbours: plane.is_none(),
            plane,
            spins: Vec::new(),
        }
    }

    /// Of bodies both places are kept, of as many bodies as a picture has room for.
    #[test]
    fn a_snapshot_of_bodies_has_the_same_bodies_in_both_places() {
        let mut bodies = sites(vec![("m", 1100), ("x", 1100), ("y", 1100)], Some([1, 2]));
        bodies.first = 3;
        let shown = shown(&bodies);
        assert_eq!(shown.len(), 2 * 367);
        for (k, (x, y)) in shown[..367].iter().zip(&shown[367..]).enumerate() {
            assert_eq!((*x, *y), (3 + 1100 + 3 * k, 3 + 2200 + 3 * k));
        }
    }

    #[test]
    fn a_long_run_of_a_long_lattice_keeps_an_even_selection() {
        let sites = sites([("x", 2000)].to_vec(), None);
        let shown = shown(&sites);
        let mut snapshots = Snapshots::new();
        for sample in 0..5000_u32 {
            let state: Vec<f64> = (0..2000)
                .map(|i| f64::from(sample) + f64::from(i))
                .collect();
            snapshots.push(&shown, f64::from(sample), &state);
        }
        let fields = snapshots.fields();
        assert!(
            (MOST_TIMES / 2..=MOST_TIMES).contains(&fields.len()),
            "{}",
            fields.len()
        );
        assert_eq!(fields[0].len(), 500);
        let step = snapshots.times[1] - snapshots.times[0];
        assert_eq!(step, snapshots.every as f64);
        for (at, (time, field)) in snapshots.times.iter().zip(&fields).enumerate() {
            assert_eq!(*time, at as f64 * step);
            assert_eq!((field[0], field[499]), (*time, *time + 1996.0));
        }
    }
}
