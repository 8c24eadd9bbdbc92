//! Several sweeps over the sites part by part, each part while it is near.
//!
//! A sweep of a long lattice reads all of its fields from memory. But a part of the next sweep may follow as soon as the
//! parts beside it are swept. So a front goes through the lattice for each sweep, some parts behind that of the sweep before.
//!
//! Numbers are those of one sweep after the other. For a part comes after all parts of earlier sweeps that write what it reads, and
//! after all that read what it writes.

use std::collections::BTreeSet;
use std::ops::Range;

use super::fields::Fields;
use super::geometry::LatticeGeometry;
use super::stages::Field;
use crate::solver::are_finite;

/// The most sites of a part: a few fields of them stay in a cache.
pub(super) const PART: usize = 4096;

/// How many parts of a sweep are tried, from the first that is left.
const TRIED: usize = 96;

/// The sites that a part of a sweep reads and writes, in pieces of so many sites each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartSites {
    read: BTreeSet<usize>,
    written: BTreeSet<usize>,
}

impl PartSites {
    pub(super) fn read(&mut self, sites: Range<usize>) {
        self.read.extend(pieces(sites));
    }

    pub(super) fn write(&mut self, sites: Range<usize>) {
        self.read(sites.clone());
        self.written.extend(pieces(sites));
    }
}

/// Parts of all sweeps of a step in the order of a wave. Before the first sweep a state is read part by part, and behind the last one
/// its increments are looked at.
#[derive(Clone, Debug)]
pub struct Front {
    parts: Vec<SweptPart>,
    /// How many sweeps there are.
    sweeps: usize,
    /// The sites that are read together.
    sites: Vec<Range<usize>>,
    /// The numbers of families of the state, and of sites of each.
    families: usize,
    length: usize,
}

/// Whether what flows lead to is finite, and the state that a step leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finite {
    /// Of the increments, and of the state behind the last flow.
    pub flows: bool,
    /// Of x + Δ.
    pub step: bool,
}

impl Front {
    /// That of sweeps with these parts over a lattice whose state is in the first `families`. There is none where a sweep has no
    /// parts, where families differ in length, and where all sites are one part.
    pub fn of(
        geometry: &LatticeGeometry,
        families: usize,
        sweeps: impl Iterator<Item = Option<Vec<PartSites>>>,
    ) -> Option<Self> {
        let length = geometry.length();
        let is_even = geometry.families.iter().all(|own| own.1 == length);
        if !is_even || length <= PART {
            return None;
        }
        let starts = (0..length).step_by(PART);
        let sites = starts.map(|start| start..length.min(start + PART));
        let sites: Vec<Range<usize>> = sites.collect();
        let beside = sites.iter().map(|sites| {
            let mut part = PartSites::default();
            part.write(sites.clone());
            part
        });
        let beside: Vec<PartSites> = beside.collect();
        let mut all = vec![beside.clone()];
        for parts in sweeps {
            all.push(parts?);
        }
        all.push(beside);
        Some(Self {
            parts: wavefront(&all),
            sweeps: all.len() - 2,
            sites,
            families,
            length,
        })
    }

    /// Takes x into the field of states and zeros into that of sums; `read` adds more for the same sites. Then takes every part of
    /// every sweep by `sweep`, which is given the numbers of both.
    pub fn run(
        &self,
        fields: &mut Fields,
        [state, sum]: [Field; 2],
        x: &[f64],
        mut read: impl FnMut(Range<usize>, &mut Fields),
        mut sweep: impl FnMut(SweptPart, &mut Fields),
    ) -> Finite {
        let mut finite = Finite {
            flows: true,
            step: true,
        };
        let is_finite = |numbers: &[f64]| numbers.iter().fold(true, |all, x| all & x.is_finite());
        for &SweptPart { sweep: at, part } in &self.parts {
            match at.checked_sub(1) {
                None => {
                    for range in self.ranges(part) {
                        fields.get_mut(state)[range.clone()].copy_from_slice(&x[range.clone()]);
                        fields.get_mut(sum)[range].fill(0.0);
                    }
                    read(self.sites[part].clone(), fields);
                }
                Some(at) if at < self.sweeps => sweep(SweptPart { sweep: at, part }, fields),
                Some(_) => {
                    for range in self.ranges(part) {
                        let sums = &fields.get(sum)[range.clone()];
                        finite.flows &= is_finite(&fields.get(state)[range.clone()]);
                        finite.flows &= is_finite(sums);
                        finite.step &= are_finite(&x[range], sums);
                    }
                }
            }
        }
        finite
    }

    /// Coordinates of the sites that are read together.
    fn ranges(&self, part: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let (sites, length) = (self.sites[part].clone(), self.length);
        (0..self.families).map(move |family| {
            let first = family * length;
            first + sites.start..first + sites.end
        })
    }
}

fn pieces(sites: Range<usize>) -> Range<usize> {
    match sites.is_empty() {
        true => 0..0,
        false => sites.start / PART..sites.end.div_ceil(PART),
    }
}

/// A part of a sweep, each by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweptPart {
    /// The sweep.
    pub sweep: usize,
    /// The part of it.
    pub part: usize,
}

/// The order in which parts of several sweeps are taken: of those that may come next one of the latest sweep.
///
/// `sweeps` lists the parts of each sweep.
pub fn wavefront(sweeps: &[Vec<PartSites>]) -> Vec<SweptPart> {
    let mut left = Left::of(sweeps);
    let count: usize = sweeps.iter().map(Vec::len).sum();
    let mut order = Vec::with_capacity(count);
    while order.len() < count {
        let next = (0..sweeps.len()).rev().find_map(|sweep| {
            let tried = left.parts[sweep].iter().take(TRIED);
            let mut tried = tried.filter(|part| left.is_next(sweep, &sweeps[sweep][**part]));
            tried.next().map(|part| SweptPart { sweep, part: *part })
        });
        // The first part of the earliest sweep that is left may always come next.
        let Some(next) = next else { break };
        left.take(next, &sweeps[next.sweep][next.part]);
        order.push(next);
    }
    order
}

/// Parts that are left, and how many of each sweep read and write a piece.
struct Left {
    parts: Vec<BTreeSet<usize>>,
    /// Of each piece, for each sweep.
    reading: Vec<Vec<usize>>,
    writing: Vec<Vec<usize>>,
    /// The earliest sweep with a part left that reads a piece, and that writes it.
    read: Vec<usize>,
    written: Vec<usize>,
}

impl Left {
    fn of(sweeps: &[Vec<PartSites>]) -> Self {
        let all = sweeps.iter().flatten();
        let pieces = all.flat_map(|part| part.read.last()).max();
        let pieces = pieces.map_or(0, |last| last + 1);
        let mut left = Self {
            parts: sweeps.iter().map(|own| (0..own.len()).collect()).collect(),
            reading: vec![vec![0; sweeps.len()]; pieces],
            writing: vec![vec![0; sweeps.len()]; pieces],
            read: vec![0; pieces],
            written: vec![0; pieces],
        };
        for (sweep, parts) in sweeps.iter().enumerate() {
            for part in parts {
                part.read
                    .iter()
                    .for_each(|at| left.reading[*at][sweep] += 1);
                part.written
                    .iter()
                    .for_each(|at| left.writing[*at][sweep] += 1);
            }
        }
        (0..pieces).for_each(|piece| left.go_on(piece));
        left
    }

    /// Whether no earlier sweep has a part left that writes what this one reads, or reads what it writes.
    fn is_next(&self, sweep: usize, part: &PartSites) -> bool {
        part.read.iter().all(|at| self.written[*at] >= sweep)
            && part.written.iter().all(|at| self.read[*at] >= sweep)
    }

    fn take(&mut self, SweptPart { sweep, part }: SweptPart, sites: &PartSites) {
        self.parts[sweep].remove(&part);
        for at in &sites.read {
            self.reading[*at][sweep] -= 1;
        }
        for at in &sites.written {
            self.writing[*at][sweep] -= 1;
        }
        sites.read.iter().for_each(|at| self.go_on(*at));
    }

    fn go_on(&mut self, piece: usize) {
        for (first, counts) in [
            (&mut self.read[piece], &self.reading[piece]),
            (&mut self.written[piece], &self.writing[piece]),
        ] {
            while counts.get(*first) == Some(&0) {
                *first += 1;
            }
        }
    }
}
