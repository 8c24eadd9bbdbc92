//! A field over sites and times, thinned out to what a picture can show.

use leafwise_core::lattice::LatticeGeometry;
use serde::{Deserialize, Serialize};

/// The most snapshots that are kept; one more and every other is dropped.
const MOST_TIMES: usize = 256;

/// The most sites of a snapshot.
const MOST_SITES: usize = 512;

/// Snapshots of the first family of a lattice whose states are too long for `samples.csv`:
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
pub(super) fn spacing(geometry: &LatticeGeometry) -> usize {
    length(geometry).div_ceil(MOST_SITES).max(1)
}

/// The length of the first family.
fn length(geometry: &LatticeGeometry) -> usize {
    geometry.families.first().map_or(0, |family| family.1)
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

    /// Takes in one more sample of a lattice.
    pub fn push(&mut self, geometry: &LatticeGeometry, time: f64, state: &[f64]) {
        if self.seen.is_multiple_of(self.every) {
            self.times.push(time);
            let sites = (0..length(geometry)).step_by(spacing(geometry));
            self.values.extend(sites.map(|site| state[site]));
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
    use super::*;

    #[test]
    fn a_long_run_of_a_long_lattice_keeps_an_even_selection() {
        let geometry = LatticeGeometry::chain(vec![("x".to_owned(), 2000)], true);
        let mut snapshots = Snapshots::new();
        for sample in 0..5000_u32 {
            let state: Vec<f64> = (0..2000)
                .map(|i| f64::from(sample) + f64::from(i))
                .collect();
            snapshots.push(&geometry, f64::from(sample), &state);
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
