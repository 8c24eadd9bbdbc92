//! A lattice in cells of several sites.

use std::ops::Range;

use leafwise_expression::syntax::AXES;

use super::geometry::{LatticeGeometry, PerAxis, SHORTEST};
use super::locality::check_room;
use crate::error::BuildError;

/// A lattice whose code repeats every `period` sites: site s is the s mod period-th site of cell
/// ⌊s/period⌋.
///
/// Each family becomes as many *rows*, its first, second, … sites of all cells. A row is a family of
/// the lattice of cells and lies contiguously in its fields, so that sites with the same code are
/// neighbours in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cells {
    sites: LatticeGeometry,
    period: usize,
    rows: LatticeGeometry,
}

impl Cells {
    /// Groups `sites` into cells of `period`. Returns `None` for a ring whose length is no multiple of it, and where
    /// a cell would be longer than a family. Along several axes a cell is one site.
    ///
    /// # Panics
    /// When `period` is 0.
    pub fn new(sites: LatticeGeometry, period: usize) -> Option<Self> {
        assert!(period > 0, "a cell has a site");
        let fits = |length: usize| {
            length >= period && (!sites.is_periodic() || length.is_multiple_of(period))
        };
        if !sites.families.iter().all(|family| fits(family.1)) {
            return None;
        }
        if period == 1 {
            return Some(Self {
                rows: sites.clone(),
                sites,
                period,
            });
        }
        if sites.axes.len() != 1 {
            return None;
        }
        let families = sites.families.iter();
        let rows = families.flat_map(|(name, length)| {
            (0..period).map(move |r| {
                let name = format!("{name}[{period}i+{r}]");
                (name, (length - r).div_ceil(period))
            })
        });
        let rows = LatticeGeometry::chain(rows.collect(), sites.is_periodic());
        Some(Self {
            sites,
            period,
            rows,
        })
    }

    /// The lattice of sites.
    pub fn sites(&self) -> &LatticeGeometry {
        &self.sites
    }

    /// The sites of a cell.
    pub fn period(&self) -> usize {
        self.period
    }

    /// The lattice of cells, its families the rows.
    pub fn rows(&self) -> &LatticeGeometry {
        &self.rows
    }

    /// The same with so many cells along each axis, the ends as they are; `None` where a family has no cell left.
    fn resized(&self, cells: &[usize]) -> Option<Self> {
        let axes = self.sites.axes.iter().zip(&self.rows.axes);
        let lengths = axes.zip(cells).map(|((sites, rows), cells)| {
            let removed = rows.length.checked_sub(*cells)? * self.period;
            sites.length.checked_sub(removed)
        });
        let lengths: Option<Vec<usize>> = lengths.collect();
        Self::new(self.sites.resized(&lengths?), self.period)
    }

    /// Proxy cells for code that looks at most `looks` cells away along each axis, and the number of cells at an open end that
    /// have code of their own there. All cells where there are no more.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] where that takes too much memory.
    pub fn proxy(&self, looks: PerAxis<usize>) -> Result<(Self, PerAxis<usize>), BuildError> {
        let is_long = self.sites.length() > SHORTEST;
        let short = is_long.then(|| self.rows.proxy(looks)).flatten();
        let short = short.and_then(|(rows, width)| Some((self.resized(&rows.lengths())?, width)));
        let (proxy, width) = short.unwrap_or_else(|| (self.clone(), [0; AXES]));
        let sites = looks.map(|cells| cells.saturating_mul(self.period));
        check_room(&proxy.sites, sites, 1)?;
        Ok((proxy, width))
    }

    /// Where a coordinate of the sites stands among those of the rows.
    pub fn place(&self, coordinate: usize) -> usize {
        let (family, site) = self.sites.locate(coordinate);
        let row = family * self.period + site % self.period;
        let before: usize = self.rows.families[..row].iter().map(|r| r.1).sum();
        before + site / self.period
    }

    /// Writes one lane of a state over the sites, coordinate j of lane w at `[j*lanes + w]`, into a
    /// field.
    pub fn gather(&self, state: &[f64], lane: usize, lanes: usize, field: &mut [f64]) {
        if self.period * lanes == 1 {
            return field.copy_from_slice(state);
        }
        self.each_row(|start, range| {
            let from = state[start * lanes + lane..]
                .iter()
                .step_by(self.period * lanes);
            field[range]
                .iter_mut()
                .zip(from)
                .for_each(|(to, x)| *to = *x);
        });
    }

    /// Writes a field into one lane of a state over the sites.
    pub fn scatter(&self, field: &[f64], state: &mut [f64], lane: usize, lanes: usize) {
        if self.period * lanes == 1 {
            return state.copy_from_slice(field);
        }
        self.each_row(|start, range| {
            let to = state[start * lanes + lane..]
                .iter_mut()
                .step_by(self.period * lanes);
            to.zip(&field[range]).for_each(|(to, x)| *to = *x);
        });
    }

    /// For each row: its first coordinate among the sites, its range in a field.
    fn each_row(&self, mut visit: impl FnMut(usize, Range<usize>)) {
        let mut place = 0;
        for ((_, length), offset) in self.sites.families.iter().zip(self.sites.offsets()) {
            for row in 0..self.period {
                let cells = (length - row).div_ceil(self.period);
                visit(offset + row, place..place + cells);
                place += cells;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Cells, LatticeGeometry};

    fn geometry(lengths: &[usize], periodic: bool) -> LatticeGeometry {
        let families = lengths.iter().enumerate();
        let families = families.map(|(k, n)| (format!("f{k}"), *n)).collect();
        LatticeGeometry::chain(families, periodic)
    }

    #[test]
    fn a_ring_holds_whole_cells_and_an_open_chain_any_number_of_sites() {
        assert!(Cells::new(geometry(&[9], true), 2).is_none());
        assert!(Cells::new(geometry(&[9], true), 3).is_some());
        let chain = Cells::new(geometry(&[9, 8], false), 2).expect("an open chain");
        let lengths: Vec<usize> = chain.rows().families.iter().map(|row| row.1).collect();
        assert_eq!(lengths, [5, 4, 4, 4]);
    }

    /// Both ends keep their rows: the last site of a family is as far from a whole cell as before.
    #[test]
    fn a_shorter_lattice_of_cells_has_the_same_ends() {
        for (lengths, period) in [(&[101_usize, 100][..], 2), (&[50], 3), (&[7], 1)] {
            let cells = Cells::new(geometry(lengths, false), period).expect("open");
            let short = cells
                .resized(&[cells.rows().length() - 1])
                .expect("shorter");
            assert_eq!(short.rows().length() + 1, cells.rows().length());
            for (own, other) in short.sites().families.iter().zip(&cells.sites().families) {
                assert_eq!(own.1 + period, other.1);
            }
        }
    }

    #[test]
    fn fields_hold_the_coordinates_at_their_places() {
        let cells = Cells::new(geometry(&[7, 6], false), 3).expect("open");
        let dimension = cells.sites().dimension();
        for (lanes, lane) in [(1, 0), (3, 2)] {
            let state: Vec<f64> = (0..dimension * lanes).map(|k| k as f64).collect();
            let mut field = vec![0.0; dimension];
            cells.gather(&state, lane, lanes, &mut field);
            for coordinate in 0..dimension {
                let value = (coordinate * lanes + lane) as f64;
                assert_eq!(field[cells.place(coordinate)], value);
            }
            let mut back = vec![-1.0; dimension * lanes];
            cells.scatter(&field, &mut back, lane, lanes);
            for (k, value) in back.iter().enumerate() {
                let expected = if k % lanes == lane { k as f64 } else { -1.0 };
                assert_eq!(*value, expected);
            }
        }
    }
}
