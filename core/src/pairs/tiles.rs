//! The loop over pairs.
//!
//! Sites are cut into tiles. For two of them the code of a pair runs along the sites i of the first, with j = i + k and
//! k from 0 on. All points of a site stand side by side. The second tile stands behind itself once more, so that j goes
//! round. Within one tile half of the k give all pairs where i and j may change places. The code reads and writes at
//! constant distances, with a machine code for each k. Nothing is copied but tiles. Places beyond the last site repeat
//! others, and a mask of 0 takes away what they give.
//!
//! The order of all sums is that of tiles and of k, whatever the number of points and the width of registers.

use std::ops::Range;
use std::sync::Arc;

use leafwise_expression::{Aligned, Execution, Kernel, Workspace};

use super::BodyShape;
use super::pair_code::{PairCode, PairRow};

/// The number of sites of a tile.
const TILE: usize = 32;

/// Operations of a pair above which its code is one for all k: a tile is then turned by k in a copy. Codes of their own take
/// longer to form than copies take for thousands of tiles.
const LONG: u64 = 400;

/// The number of places that are evaluated at a time where there is no machine code along an array.
const BLOCK: usize = Aligned::LINE;

/// Sums over pairs at so many points, for fixed parameters.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    code: Arc<PairCode>,
    sites: usize,
    /// The number of points.
    points: usize,
    parameters: Vec<f64>,
    /// Rows that the code reads and writes, each with its start in `room`.
    rows: Vec<(PairRow, usize)>,
    room: Aligned,
    /// The code with sites j so many sites behind i.
    shifted: Vec<Option<(Kernel, Workspace)>>,
    /// Whether one code serves all of them, with copies of sites j.
    is_turned: bool,
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
        let is_turned = code.kernel.step_operations().work() > LONG;
        for row in code.rows() {
            rows.push((row, end));
            let tiles = match is_second(row) {
                true => 2 + usize::from(is_turned),
                false => 1,
            };
            // A line between two rows: they do not stand at one place of a page.
            end += tiles * TILE * points + BLOCK;
        }
        Self {
            code: Arc::clone(code),
            sites: shape.sites,
            points,
            parameters: parameters.to_vec(),
            rows,
            room: Aligned::filled(end.next_multiple_of(BLOCK), 0.0),
            shifted: vec![None; TILE],
            is_turned,
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
                for shift in 0..count {
                    self.run(shift, [&first, &second]);
                }
            }
            (true, true) => {
                self.count(count * points, count);
                for shift in 1..count.div_ceil(2) {
                    self.run(shift, [&first, &second]);
                }
                if count.is_multiple_of(2) {
                    self.count(count / 2 * points, count);
                    self.run(count / 2, [&first, &second]);
                }
            }
            (true, false) => {
                for shift in 1..count {
                    self.count((count - shift) * points, count);
                    self.run(shift, [&first, &second]);
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

    /// Runs the code with j so many sites behind i, along the sites i of two tiles.
    fn run(&mut self, shift: usize, tiles: [&Range<usize>; 2]) {
        let places = self.places(tiles[0].len());
        self.enter(shift, tiles);
        let own = if self.is_turned { 0 } else { shift };
        if self.shifted[own].is_none() {
            self.shifted[own] = Some(self.shifted_by(own));
        }
        let behind = self.behind(own);
        let (turned, copied) = (self.is_turned, shift * self.points);
        let seconds = self.rows.iter().filter(|(row, _)| is_second(*row));
        for (_, start) in seconds.clone().filter(|_| turned) {
            let from = start + copied;
            self.room.copy_within(from..from + places, start + behind);
        }
        let Some((kernel, workspace)) = &mut self.shifted[own] else {
            return;
        };
        let reached = kernel.evaluate_along(workspace, &mut self.room, 0..places);
        let at = |row: &PairRow, place: usize| {
            let found = self.rows.iter().find(|(own, _)| own == row);
            let start = found.map_or(0, |(_, start)| *start);
            start + place + if is_second(*row) { behind } else { 0 }
        };
        for place in (reached..places).step_by(BLOCK) {
            for (input, row) in self.code.inputs.iter().enumerate() {
                let from = &self.room[at(row, place)..][..BLOCK];
                workspace.input_mut(input).copy_from_slice(from);
            }
            kernel.evaluate_in_place(workspace);
            for (output, row) in self.code.outputs.iter().enumerate() {
                let to = at(row, place);
                self.room[to..][..BLOCK].copy_from_slice(kernel.output(workspace, output));
            }
        }
        let sums = seconds.filter(|(row, _)| matches!(row, PairRow::SecondSum(_)));
        for (_, start) in sums.filter(|_| turned) {
            let from = start + behind;
            self.room.copy_within(from..from + places, start + copied);
        }
    }

    /// How far behind the beginning of their rows the code finds sites j, where they stand so many sites behind i.
    fn behind(&self, shift: usize) -> usize {
        match self.is_turned {
            true => 2 * TILE * self.points,
            false => shift * self.points,
        }
    }

    /// The code for j so many sites behind i.
    fn shifted_by(&self, shift: usize) -> (Kernel, Workspace) {
        let distance = |row: &PairRow| {
            let found = self.rows.iter().find(|(own, _)| own == row);
            let start = found.map_or(0, |(_, start)| *start);
            let behind = if is_second(*row) {
                self.behind(shift)
            } else {
                0
            };
            (start + behind) as isize
        };
        let inputs: Vec<isize> = self.code.inputs.iter().map(distance).collect();
        let outputs: Vec<isize> = self.code.outputs.iter().map(distance).collect();
        let kernel = self.code.kernel.clone().at_distances(&inputs, &outputs);
        let execution = match Execution::default_of_process() {
            // Every code runs often.
            Execution::Adaptive => Execution::Compiled,
            chosen => chosen,
        };
        let mut workspace = kernel.workspace_for(BLOCK, execution);
        let spread = |value: &f64| std::iter::repeat_n(*value, BLOCK);
        let parameters: Vec<f64> = self.parameters.iter().flat_map(spread).collect();
        kernel.prepare(&mut workspace, &parameters, &[1.0; BLOCK], &[1.0; BLOCK]);
        (kernel, workspace)
    }
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
