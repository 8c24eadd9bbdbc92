//! Sites in blocks of as many as a kernel has lanes, and the numbers beside them.

use std::ops::Range;

use super::geometry::{LatticeGeometry, PerAxis};

/// Sites are evaluated this many at a time, as lanes of one kernel.
pub(super) const BLOCK: usize = 32;

/// Sites of one row that stand in lanes one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowPart {
    pub(super) lane: usize,
    pub(super) site: usize,
    pub(super) count: usize,
    place: PerAxis<usize>,
}

/// Ranges of sites cut into blocks of as many as there are lanes.
pub(super) struct Blocks<'a> {
    ranges: &'a [Range<usize>],
    lanes: usize,
    /// The next site, of the first range.
    next: usize,
}

impl<'a> Blocks<'a> {
    pub(super) fn new(ranges: &'a [Range<usize>], lanes: usize) -> Self {
        Self {
            ranges,
            lanes,
            next: ranges.first().map_or(0, |range| range.start),
        }
    }

    /// The rows' parts of the next block; whether there is one.
    pub(super) fn next_into(
        &mut self,
        geometry: &LatticeGeometry,
        block: &mut Vec<RowPart>,
    ) -> bool {
        block.clear();
        let length = geometry.axes.last().map_or(1, |axis| axis.length);
        let mut lane = 0;
        while lane < self.lanes
            && let Some((range, behind)) = self.ranges.split_first()
        {
            let place = geometry.place(self.next);
            let of_row = match geometry.axes.len() {
                0 | 1 => usize::MAX,
                axes => length - place[axes - 1],
            };
            let count = (range.end - self.next).min(self.lanes - lane).min(of_row);
            block.push(RowPart {
                lane,
                site: self.next,
                count,
                place,
            });
            lane += count;
            self.next += count;
            if self.next == range.end {
                self.ranges = behind;
                self.next = behind.first().map_or(0, |range| range.start);
            }
        }
        lane > 0
    }
}

/// Loads the numbers that stand `shift` beside the sites of a block; lanes beyond repeat the first.
pub(super) fn load(
    lanes: &mut [f64],
    field: &[f64],
    geometry: &LatticeGeometry,
    shift: PerAxis<isize>,
    block: &[RowPart],
) {
    let last = geometry.axes.len().saturating_sub(1);
    let length = geometry.axes.last().map_or(1, |axis| axis.length);
    let mut end = 0;
    for part in block {
        let mut row = 0;
        for ((axis, at), shift) in geometry.axes.iter().zip(part.place).zip(shift).take(last) {
            row = row * axis.length + around(at, shift, axis.length);
        }
        let (row, first) = (row * length, around(part.place[last], shift[last], length));
        let own = &mut lanes[part.lane..][..part.count];
        end = part.lane + part.count;
        let before = part.count.min(length - first);
        let from = &field[row + first..];
        if let (Some(to), Some(from)) =
            (own.first_chunk_mut::<BLOCK>(), from.first_chunk::<BLOCK>())
            && before == BLOCK
        {
            *to = *from;
            continue;
        }
        own[..before].copy_from_slice(&from[..before]);
        let mut behind = &mut own[before..];
        // Where the axis closes.
        while !behind.is_empty() {
            let count = behind.len().min(length);
            let (to, rest) = behind.split_at_mut(count);
            to.copy_from_slice(&field[row..row + count]);
            behind = rest;
        }
    }
    let (own, beyond) = lanes.split_at_mut(end);
    beyond.fill(own[0]);
}

/// The place so far from `at` along an axis that closes.
fn around(at: usize, shift: isize, length: usize) -> usize {
    let place = at.wrapping_add_signed(shift);
    match place < length {
        true => place,
        false => (at as isize + shift).rem_euclid(length as isize) as usize,
    }
}
