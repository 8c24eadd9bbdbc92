//! The loop over pairs.
//!
//! Sites are cut into tiles. For two of them the code of a pair runs along the sites i of the first, with j = i + k. That is
//! one pass for each k from 0 on. All points of a site stand side by side. The second tile stands behind itself once
//! more, so that j goes round. Within one tile half of the k give all pairs where i and j may change places. One machine
//! code serves all passes: i and j are places of their own. Nothing is copied but tiles. Places beyond the last site
//! repeat others, and a mask of 0 takes away what they give.
//!
//! The order of all sums is that of tiles and of k, whatever the number of points and the width of registers.

use std::ops::Range;
use std::sync::Arc;

use leafwise_expression::{Aligned, Distance, Execution, Kernel, Passes, Workspace};

use super::BodyShape;
use super::pair_code::{PairCode, PairRow};

/// The number of sites of a tile.
const TILE: usize = 32;

/// The number of places that are evaluated at a time where there is no machine code along an array.
const BLOCK: usize = Aligned::LINE;

/// Sums over pairs at so many points, for fixed parameters.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    code: Arc<PairCode>,
    sites: usize,
    /// The number of points.
    points: usize,
    /// Rows that the code reads and writes, each with its start in `room`.
    rows: Vec<(PairRow, usize)>,
    room: Aligned,
    /// The code along `room`, with sites i and j beside the two places.
    kernel: Kernel,
    workspace: Workspace,
    /// Whether the code reads entries of matrices, which are others in each pass.
    has_entries: bool,
    /// The number of places whose mask is 1.
    counted: usize,
}

impl Tiles {
    pub(super) fn new(
        code: &Arc<PairCode>,
        shape: &BodyShape,
        points: usize,
        parameters: &[f64],
    ) -> Self {
        let mut rows = Vec::new();
        let mut end = 0;
        for row in code.rows() {
            rows.push((row, end));
            let tiles = if is_second(row) { 2 } else { 1 };
            // A line between two rows: they do not stand at one place of a page.
            end += tiles * TILE * points + BLOCK;
        }
        let distances = |own: &[PairRow]| -> Vec<Distance> {
            let distance = |row: &PairRow| {
                let start = start_of(&rows, *row) as isize;
                match is_second(*row) {
                    true => Distance::Second(start),
                    false => Distance::First(start),
                }
            };
            own.iter().map(distance).collect()
        };
        let kernel = code.kernel.clone();
        let kernel = kernel.at_distances(&distances(&code.inputs), &distances(&code.outputs));
        let execution = match Execution::default_of_process() {
            // The code runs often.
            Execution::Adaptive => Execution::Compiled,
            chosen => chosen,
        };
        let mut workspace = kernel.workspace_for(BLOCK, execution);
        let spread = |value: &f64| std::iter::repeat_n(*value, BLOCK);
        let parameters: Vec<f64> = parameters.iter().flat_map(spread).collect();
        kernel.prepare(&mut workspace, &parameters, &[1.0; BLOCK], &[1.0; BLOCK]);
        Self {
            code: Arc::clone(code),
            sites: shape.sites,
            points,
            has_entries: rows
                .iter()
                .any(|(row, _)| matches!(row, PairRow::Entry(..))),
            rows,
            room: Aligned::filled(end.next_multiple_of(BLOCK), 0.0),
            kernel,
            workspace,
            counted: 0,
        }
    }

    /// Adds the sums over pairs to `sums`, rows of sites and points, at points x with these weights, a row over the points
    /// each.
    pub(super) fn add(&mut self, x: &[f64], weights: &[f64], sums: &mut [f64]) {
        let sites = self.sites;
        let tile = |start: usize| start..sites.min(start + TILE);
        for first in (0..sites).step_by(TILE).map(tile) {
            self.begin(first.clone(), x, weights);
            for second in (first.start..sites).step_by(TILE).map(tile) {
                self.pairs(first.clone(), second, x, sums);
            }
            let own = first.start * self.points..first.end * self.points;
            for (row, start) in &self.rows {
                if let PairRow::FirstSum(sum) = row {
                    let to = self.row_of(*sum, own.clone());
                    add(&mut sums[to], &self.room[*start..][..own.len()]);
                }
            }
        }
    }

    /// Where the places of a tile stand in rows of all sites.
    fn row_of(&self, row: usize, own: Range<usize>) -> Range<usize> {
        let start = row * self.sites * self.points;
        start + own.start..start + own.end
    }

    /// The number of places that the code runs along for so many sites: what a register takes.
    fn places(&self, sites: usize) -> usize {
        (sites * self.points).next_multiple_of(BLOCK)
    }

    /// Takes the first of two tiles: its coordinates, and sums of 0.
    fn begin(&mut self, first: Range<usize>, x: &[f64], weights: &[f64]) {
        let places = self.places(first.len());
        let points = self.points;
        for at in 0..self.rows.len() {
            let (row, start) = self.rows[at];
            match row {
                PairRow::First(family) => {
                    let own = self.row_of(family, first.start * points..first.end * points);
                    repeat(&x[own], &mut self.room[start..][..places]);
                }
                PairRow::Weight(weight) => {
                    let own = &weights[weight * points..][..points];
                    repeat(own, &mut self.room[start..][..places]);
                }
                PairRow::FirstSum(_) => self.room[start..][..places].fill(0.0),
                PairRow::Mask | PairRow::Second(_) | PairRow::SecondSum(_) | PairRow::Entry(..) => {
                }
            }
        }
    }

    /// Adds what the pairs of two tiles give, where the first is begun.
    fn pairs(&mut self, first: Range<usize>, second: Range<usize>, x: &[f64], sums: &mut [f64]) {
        let (points, count) = (self.points, second.len());
        let own = second.start * points..second.end * points;
        let window = self.places(first.len()) + own.len();
        for at in 0..self.rows.len() {
            let (row, start) = self.rows[at];
            match row {
                PairRow::Second(family) => {
                    let own = self.row_of(family, own.clone());
                    repeat(&x[own], &mut self.room[start..][..window]);
                }
                PairRow::SecondSum(_) => self.room[start..][..window].fill(0.0),
                _ => {}
            }
        }
        match (first == second, self.code.is_symmetric) {
            (false, _) => {
                self.count(first.len() * points, first.len());
                self.run(0..count, [&first, &second]);
            }
            (true, true) => {
                self.count(count * points, count);
                let half = count.div_ceil(2);
                self.run(1..half, [&first, &second]);
                if count.is_multiple_of(2) {
                    self.count(count / 2 * points, count);
                    self.run(half..half + 1, [&first, &second]);
                }
            }
            (true, false) => {
                for shift in 1..count {
                    self.count((count - shift) * points, count);
                    self.run(shift..shift + 1, [&first, &second]);
                }
            }
        }
        for (row, start) in &self.rows {
            if let PairRow::SecondSum(sum) = row {
                let to = self.row_of(*sum, own.clone());
                for part in self.room[*start..][..window].chunks(own.len()) {
                    add(&mut sums[to.start..][..part.len()], part);
                }
            }
        }
    }

    /// Lets the first places count alone, of those of so many sites.
    fn count(&mut self, counted: usize, sites: usize) {
        let places = self.places(sites);
        let mask = self.rows.iter().find(|(row, _)| *row == PairRow::Mask);
        if let Some((_, start)) = mask {
            let (ones, zeros) = self.room[*start..][..places].split_at_mut(counted);
            // All places before were 1, and all behind 0.
            if self.counted != counted {
                ones.fill(1.0);
            }
            zeros.fill(0.0);
        }
        self.counted = counted;
    }

    /// Writes the entries of matrices of sites i of the first tile, and j so many sites behind in the second.
    fn enter(&mut self, shift: usize, [first, second]: [&Range<usize>; 2]) {
        let places = self.places(first.len());
        for (row, start) in &self.rows {
            let PairRow::Entry(matrix, entry) = row else {
                continue;
            };
            let matrix = &self.code.matrices[*matrix];
            let own = &mut self.room[*start..][..places];
            let (mut i, mut j) = (first.start, second.start + shift);
            for to in own.chunks_mut(self.points) {
                to.fill(entry.of(matrix, [i, j]));
                i = if i + 1 == first.end {
                    first.start
                } else {
                    i + 1
                };
                j = if j + 1 == second.end {
                    second.start
                } else {
                    j + 1
                };
            }
        }
    }

    /// Runs the code along the sites i of two tiles, with j behind i by each of these numbers of sites.
    fn run(&mut self, shifts: Range<usize>, tiles: [&Range<usize>; 2]) {
        if !self.has_entries {
            return self.passes(shifts, tiles[0].len());
        }
        for shift in shifts {
            self.enter(shift, tiles);
            self.passes(shift..shift + 1, tiles[0].len());
        }
    }

    /// The same for so many sites i, with the entries of matrices as they stand.
    fn passes(&mut self, shifts: Range<usize>, sites: usize) {
        let places = self.places(sites);
        let passes = Passes {
            places: 0..places,
            ahead: shifts.start * self.points,
            stride: self.points,
            count: shifts.len(),
            may_meet: false,
        };
        let (kernel, workspace) = (&self.kernel, &mut self.workspace);
        let reached = kernel.evaluate_along(workspace, &mut self.room, passes);
        if reached == places {
            return;
        }
        for shift in shifts {
            let at = |row: &PairRow, place: usize| {
                let ahead = if is_second(*row) {
                    shift * self.points
                } else {
                    0
                };
                start_of(&self.rows, *row) + place + ahead
            };
            for place in (reached..places).step_by(BLOCK) {
                for (input, row) in self.code.inputs.iter().enumerate() {
                    let from = &self.room[at(row, place)..][..BLOCK];
                    workspace.input_mut(input).copy_from_slice(from);
                }
                kernel.evaluate_in_place(workspace);
                for (output, row) in self.code.outputs.iter().enumerate() {
                    let to = at(row, place);
                    let value = kernel.output(workspace, output);
                    self.room[to..][..BLOCK].copy_from_slice(value);
                }
            }
        }
    }
}

/// Where a row starts.
fn start_of(rows: &[(PairRow, usize)], row: PairRow) -> usize {
    let found = rows.iter().find(|(own, _)| *own == row);
    found.map_or(0, |(_, start)| *start)
}

/// Whether a row is of sites j.
fn is_second(row: PairRow) -> bool {
    matches!(row, PairRow::Second(_) | PairRow::SecondSum(_))
}

/// Fills `to` with `from` again and again.
fn repeat(from: &[f64], to: &mut [f64]) {
    for part in to.chunks_mut(from.len()) {
        part.copy_from_slice(&from[..part.len()]);
    }
}

fn add(to: &mut [f64], from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += from;
    }
}
