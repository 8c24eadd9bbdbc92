//! The code of one class of sites in one stage, and its sweep over them.

use std::collections::BTreeSet;
use std::ops::Range;

use leafwise_expression::syntax::AXES;
use leafwise_expression::{Aligned, Distance, Execution, Graph, Kernel, Passes, Term, Workspace};

use super::blocks::{BLOCK, Blocks, RowPart, load};
use super::edges::{EdgeSites, blocks_of};
use super::fields::{Fields, stride};
use super::geometry::{LatticeGeometry, PerAxis, Proxy, SiteBox, SiteClass};
use super::ranges::{gaps, rest, total, without};
use super::stages::{Field, Written};
use super::wavefront::{PART, PartSites};
use crate::error::BuildError;

/// Classes of fewer sites go one by one: boundary sites.
const FEW: usize = 4;

/// Where a kernel input of one site stands: a field of a family, `shift` sites away along each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tap {
    pub(super) field: usize,
    pub(super) family: usize,
    pub(super) shift: PerAxis<isize>,
}

/// The code of one class of sites in one stage.
#[derive(Clone, Debug)]
pub(super) struct Stencil {
    pub(super) class: SiteClass,
    pub(super) kernel: Kernel,
    pub(super) taps: Vec<Tap>,
    /// (field, family) of each output.
    pub(super) outputs: Vec<(usize, usize)>,
    inside: Inside,
    /// Whether every number that changes is read at its own site alone.
    is_apart: bool,
}

/// Sites whose inputs and outputs all stand as far from them as everywhere in memory: the kernel takes them in place.
///
/// Along several axes they are rows with other sites between. The kernel runs over these as well. What they hold behind
/// the sweep is found before it, from the numbers that stand there then, and written after it.
#[derive(Clone, Debug, Default)]
struct Inside {
    /// Their rows, in the order of the sites.
    rows: Vec<Range<usize>>,
    /// From the first row to the last, in parts, and what lies before and behind.
    parts: Vec<Part>,
    /// Sites between the rows that are not swept beside them: their numbers are kept, and put back.
    kept: Vec<Range<usize>>,
    /// The other sites of the class, in ranges.
    outside: Vec<Range<usize>>,
    /// Where their inputs stand, and which of the distances each input has.
    beside: Option<(EdgeSites, Vec<usize>)>,
}

/// Sites that are swept together, so that what stands beside a row is found while the row is near.
#[derive(Clone, Debug)]
struct Part {
    sites: Range<usize>,
    /// Whether machine code runs over them.
    is_swept: bool,
    /// The rows among them, by their numbers, the first and the last cut off where the part ends.
    rows: Range<usize>,
    /// The blocks of other sites among them.
    beside: Range<usize>,
}

/// Room for a sweep of one stencil.
#[derive(Clone, Debug)]
pub(super) struct SweepRoom {
    workspace: Workspace,
    /// Numbers between the rows that are swept in place.
    between: Vec<f64>,
    /// Numbers of the other sites of a part.
    beside: Vec<f64>,
    /// Sites of the rows that machine code left.
    left: Vec<Range<usize>>,
    block: Vec<RowPart>,
}

impl Stencil {
    /// The code of a class, `None` where it writes nothing.
    pub(super) fn compile(
        geometry: &LatticeGeometry,
        proxy: Proxy<'_>,
        class: SiteClass,
        graph: &Graph,
        stage: &[Written],
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let (terms, outputs) = terms_of(proxy, class, stage);
        if terms.is_empty() {
            return Ok(None);
        }
        let (kernel, used) = Kernel::compile_used(graph, &terms, parameters);
        let mut taps = Vec::with_capacity(used.len());
        for input in used {
            let tap = tap_of(proxy, class, input);
            check_reach(geometry, proxy, class, tap)?;
            taps.push(tap);
        }
        Ok(Some(Self {
            class,
            kernel,
            inside: Inside::default(),
            is_apart: false,
            taps,
            outputs,
        }))
    }

    /// The same with a kernel that reads and writes the fields where they stand. `is_apart` tells that numbers that change are read
    /// at their own sites alone.
    pub(super) fn in_place(
        mut self,
        geometry: &LatticeGeometry,
        offsets: &[usize],
        is_apart: bool,
    ) -> Self {
        self.is_apart = is_apart;
        self.inside = Inside {
            outside: self.class.sites.runs(geometry).collect(),
            ..Inside::default()
        };
        if self.sites() < FEW {
            return self;
        }
        let stride = stride(geometry.dimension());
        let start = |field: usize, family: usize| (field * stride + offsets[family]) as isize;
        let taps = self.taps.iter();
        let inputs = taps.map(|tap| start(tap.field, tap.family) + geometry.distance(tap.shift));
        let outputs = self.outputs.iter();
        let outputs = outputs.map(|&(field, family)| start(field, family));
        let inputs: Vec<Distance> = inputs.map(Distance::First).collect();
        let outputs: Vec<Distance> = outputs.map(Distance::First).collect();
        self.kernel = self.kernel.at_distances(&inputs, &outputs);
        let sites = self.sites_inside(geometry);
        let rows: Vec<Range<usize>> = sites.runs(geometry).collect();
        let (Some(first), Some(last)) = (rows.first().cloned(), rows.last().cloned()) else {
            return self;
        };
        // Of a thin box most of what the kernel computes would be in vain.
        if 2 * sites.sites() < last.end - first.start {
            return self;
        }
        // What is written first starts a cache line.
        let offset = offsets[self.outputs[0].1];
        let begin = (offset + first.start).next_multiple_of(Aligned::LINE) - offset;
        let range = begin.min(last.end)..last.end;
        self.inside.outside = rest(self.class.sites, sites, geometry);
        self.inside.kept = gaps(&rows).collect();
        self.inside.rows = rows;
        self.part(geometry, range);
        self
    }

    /// Cuts what is swept in place into parts, with the other sites of the class among them.
    fn part(&mut self, geometry: &LatticeGeometry, range: Range<usize>) {
        let starts = range.clone().step_by(PART);
        let swept = starts.map(|start| start..range.end.min(start + PART));
        let before = std::iter::once(0..range.start);
        let behind = std::iter::once(range.end..geometry.length());
        let ranges: Vec<Range<usize>> = before.chain(swept).chain(behind).collect();
        let mut outside = self.inside.outside.iter().cloned().flatten().peekable();
        let groups = ranges.iter().map(|range| {
            let mut own = Vec::new();
            while let Some(site) = outside.next_if(|site| *site < range.end) {
                own.push(site);
            }
            own
        });
        let groups: Vec<Vec<usize>> = groups.collect();
        let beside = self.beside(geometry, &groups);
        let (mut block, is_known) = (0, beside.is_some());
        let last = ranges.len() - 1;
        let parts = ranges.into_iter().zip(&groups).enumerate();
        let parts = parts.map(|(at, (range, sites))| {
            let before = block;
            block += if is_known {
                blocks_of(geometry, sites).count()
            } else {
                0
            };
            let rows = &self.inside.rows;
            let rows = rows.partition_point(|row| row.end <= range.start)
                ..rows.partition_point(|row| row.start < range.end);
            Part {
                sites: range,
                is_swept: at > 0 && at < last,
                rows: rows.start.min(rows.end)..rows.end,
                beside: before..block,
            }
        });
        self.inside.parts = parts.collect();
        if let Some(beside) = beside {
            let own = &self.inside.outside;
            let mut kept = Vec::new();
            without(&self.inside.kept, own, &mut kept);
            self.inside.kept = kept;
            self.inside.beside = Some(beside);
        }
    }

    /// Where the inputs stand of the sites that are not swept in place.
    fn beside(
        &self,
        geometry: &LatticeGeometry,
        groups: &[Vec<usize>],
    ) -> Option<(EdgeSites, Vec<usize>)> {
        let shifts = self.taps.iter().map(|tap| tap.shift);
        let beside = EdgeSites::find(geometry, groups, shifts.clone())?;
        let shifts: Option<Vec<usize>> = shifts.map(|shift| beside.shift(shift)).collect();
        Some((beside, shifts?))
    }

    /// The sites of the class whose inputs and outputs all stand in their families, with no end of an axis between.
    fn sites_inside(&self, geometry: &LatticeGeometry) -> SiteBox {
        let mut sites = self.class.sites;
        let read = self.taps.iter().map(|tap| (tap.family, tap.shift));
        let written = self.outputs.iter().map(|(_, family)| (*family, [0; AXES]));
        for (family, shift) in read.chain(written) {
            for (at, axis) in geometry.axes.iter().enumerate() {
                // Along one axis a family may be shorter than the others.
                let length = match geometry.axes.len() {
                    1 => geometry.families[family].1,
                    _ => axis.length,
                };
                let first = 0_usize.saturating_add_signed(-shift[at]);
                sites.start[at] = sites.start[at].max(first);
                sites.end[at] = sites.end[at].min(length.saturating_add_signed(-shift[at]));
                sites.start[at] = sites.start[at].min(sites.end[at]);
            }
        }
        sites
    }

    /// How many sites it serves.
    pub(super) fn sites(&self) -> usize {
        self.class.sites()
    }

    /// Room for a sweep with these parameters, ε and h.
    pub(super) fn prepare(
        &self,
        execution: Execution,
        parameters: &[f64],
        sizes: [f64; 2],
    ) -> SweepRoom {
        let workspace = workspace(&self.kernel, self.class, execution, parameters, sizes);
        SweepRoom {
            workspace,
            between: Vec::new(),
            beside: Vec::new(),
            left: Vec::new(),
            block: Vec::new(),
        }
    }

    /// Evaluates the code at each site of the class; returns at how many of them in place.
    pub(super) fn sweep(
        &self,
        geometry: &LatticeGeometry,
        offsets: &[usize],
        room: &mut SweepRoom,
        fields: &mut Fields,
    ) -> usize {
        let mut between = std::mem::take(&mut room.between);
        self.keep(offsets, fields, &mut between);
        let parts = 0..self.inside.parts.len();
        let in_place = parts.map(|part| self.sweep_part(part, geometry, offsets, room, fields));
        let in_place = in_place.sum();
        self.put_back(offsets, fields, &between);
        room.between = between;
        if self.inside.beside.is_none() {
            let outside = &self.inside.outside;
            let room = (&mut room.workspace, &mut room.block);
            self.sweep_by_copies(geometry, offsets, room, fields, outside);
        }
        in_place
    }

    /// The same at the sites of one part, where [parts](Self::parts) go in any order.
    pub(super) fn sweep_part(
        &self,
        part: usize,
        geometry: &LatticeGeometry,
        offsets: &[usize],
        room: &mut SweepRoom,
        fields: &mut Fields,
    ) -> usize {
        let SweepRoom {
            workspace,
            beside,
            left,
            block,
            ..
        } = room;
        let part = &self.inside.parts[part];
        beside.clear();
        self.find_beside(part.beside.clone(), offsets, (workspace, beside), fields);
        let reached = match part.is_swept {
            true => {
                let numbers = fields.all_mut();
                let pass = Passes {
                    may_meet: self.is_apart,
                    ..part.sites.clone().into()
                };
                self.kernel.evaluate_along(workspace, numbers, pass)
            }
            false => 0,
        };
        self.write_beside(part.beside.clone(), offsets, beside, fields);
        let behind = part.sites.start + reached..part.sites.end;
        let within = |row: &Range<usize>, sites: &Range<usize>| {
            row.start.max(sites.start)..row.end.min(sites.end)
        };
        left.clear();
        if !behind.is_empty() {
            let rows = self.inside.rows[part.rows.clone()].iter();
            let rows = rows.map(|row| within(row, &behind));
            left.extend(rows.filter(|row| !row.is_empty()));
            let room = (&mut *workspace, &mut *block);
            self.sweep_by_copies(geometry, offsets, room, fields, left);
        }
        let rows = self.inside.rows[part.rows.clone()].iter();
        let all: usize = rows.map(|row| within(row, &part.sites).len()).sum();
        all - total(left)
    }

    /// Sites that each part reads and writes; `None` where parts are not all there is.
    pub(super) fn parts(&self, geometry: &LatticeGeometry) -> Option<Vec<PartSites>> {
        let beside = self.inside.beside.as_ref();
        let is_apart = beside.is_none() && !self.inside.outside.is_empty();
        if is_apart || self.inside.parts.is_empty() || !self.inside.kept.is_empty() {
            return None;
        }
        let length = geometry.length();
        let distances = self.taps.iter().map(|tap| geometry.distance(tap.shift));
        let distances: BTreeSet<isize> = distances.collect();
        let parts = self.inside.parts.iter().map(|part| {
            let mut sites = PartSites::default();
            let is_empty = part.sites.is_empty() || !part.is_swept && part.rows.is_empty();
            if !is_empty {
                sites.write(part.sites.clone());
                for distance in &distances {
                    let [start, end] = [part.sites.start, part.sites.end]
                        .map(|at| at.saturating_add_signed(*distance).min(length));
                    sites.read(start..end);
                }
            }
            if let Some((beside, _)) = beside {
                beside.for_each_site(part.beside.clone(), |site, is_written| match is_written {
                    true => sites.write(site..site + 1),
                    false => sites.read(site..site + 1),
                });
            }
            sites
        });
        Some(parts.collect())
    }

    /// Evaluates the code on copies of the inputs of sites that are not swept in place.
    fn find_beside(
        &self,
        blocks: Range<usize>,
        offsets: &[usize],
        (workspace, found): (&mut Workspace, &mut Vec<f64>),
        fields: &Fields,
    ) {
        let Some((beside, shifts)) = &self.inside.beside else {
            return;
        };
        for block in blocks {
            for (input, (tap, shift)) in self.taps.iter().zip(shifts).enumerate() {
                let field = &fields.get(Field(tap.field))[offsets[tap.family]..];
                beside.load(workspace.input_mut(input), field, *shift, block);
            }
            self.kernel.evaluate_in_place(workspace);
            for output in 0..self.outputs.len() {
                found.extend_from_slice(self.kernel.output(workspace, output));
            }
        }
    }

    /// Writes what was found at them.
    fn write_beside(
        &self,
        blocks: Range<usize>,
        offsets: &[usize],
        found: &[f64],
        fields: &mut Fields,
    ) {
        let Some((beside, _)) = &self.inside.beside else {
            return;
        };
        let mut found = found.chunks_exact(BLOCK);
        for block in blocks {
            for (&(field, family), values) in self.outputs.iter().zip(&mut found) {
                let field = &mut fields.get_mut(Field(field))[offsets[family]..];
                beside.store(values, field, block);
            }
        }
    }

    /// Keeps the numbers of the sites between rows that nothing is found for.
    fn keep(&self, offsets: &[usize], fields: &Fields, between: &mut Vec<f64>) {
        between.clear();
        for gap in &self.inside.kept {
            for &(field, family) in &self.outputs {
                let field = &fields.get(Field(field))[offsets[family]..];
                // Gaps are mostly of two sites: a call to copy them takes longer than they do.
                for number in &field[gap.clone()] {
                    between.push(*number);
                }
            }
        }
    }

    /// Puts them back.
    fn put_back(&self, offsets: &[usize], fields: &mut Fields, between: &[f64]) {
        let mut kept = between;
        for gap in &self.inside.kept {
            for &(field, family) in &self.outputs {
                let (own, behind) = kept.split_at(gap.len());
                kept = behind;
                let field = &mut fields.get_mut(Field(field))[offsets[family]..];
                for (to, number) in field[gap.clone()].iter_mut().zip(own) {
                    *to = *number;
                }
            }
        }
    }

    /// Evaluates the code at sites of the class on copies of its inputs and outputs, as many together as there are
    /// lanes.
    fn sweep_by_copies(
        &self,
        geometry: &LatticeGeometry,
        offsets: &[usize],
        (workspace, block): (&mut Workspace, &mut Vec<RowPart>),
        fields: &mut Fields,
        sites: &[Range<usize>],
    ) {
        let mut blocks = Blocks::new(sites, workspace.lanes());
        while blocks.next_into(geometry, block) {
            for (input, tap) in self.taps.iter().enumerate() {
                let field = &fields.get(Field(tap.field))[offsets[tap.family]..];
                load(
                    workspace.input_mut(input),
                    field,
                    geometry,
                    tap.shift,
                    block,
                );
            }
            self.kernel.evaluate_in_place(workspace);
            for (output, &(field, family)) in self.outputs.iter().enumerate() {
                let values = self.kernel.output(workspace, output);
                let to = &mut fields.get_mut(Field(field))[offsets[family]..];
                for part in block.iter() {
                    let to = &mut to[part.site..][..part.count];
                    let values = &values[part.lane..][..part.count];
                    match (to.first_chunk_mut::<BLOCK>(), values.first_chunk::<BLOCK>()) {
                        (Some(to), Some(values)) => *to = *values,
                        _ => to.copy_from_slice(values),
                    }
                }
            }
        }
    }
}

/// Refuses code that looks further than the proxy has room for.
fn check_reach(
    geometry: &LatticeGeometry,
    proxy: Proxy<'_>,
    class: SiteClass,
    tap: Tap,
) -> Result<(), BuildError> {
    for (at, axis) in geometry.axes.iter().enumerate() {
        let (shift, width) = (tap.shift[at], proxy.width[at]);
        if axis.length == proxy.geometry.axes[at].length {
            continue;
        }
        let length = match geometry.axes.len() {
            1 => geometry.families[tap.family].1,
            _ => axis.length,
        };
        let ends = [class.sites.start[at], class.sites.end[at] - 1];
        let mut ends = ends.into_iter().map(|at| at.wrapping_add_signed(shift));
        let is_there = axis.periodic || ends.all(|place| place < length);
        if shift.unsigned_abs() > width || !is_there {
            return Err(BuildError::LooksFurther {
                reach: shift.unsigned_abs(),
                foreseen: width,
            });
        }
    }
    Ok(())
}

/// The terms that a stage writes at the sites of a class, with the field and family of each.
pub(super) fn terms_of(
    proxy: Proxy<'_>,
    class: SiteClass,
    stage: &[Written],
) -> (Vec<Term>, Vec<(usize, usize)>) {
    let offsets = proxy.geometry.offsets();
    let (mut terms, mut outputs) = (Vec::new(), Vec::new());
    for (field, values) in stage {
        for (family, (_, length)) in proxy.geometry.families.iter().enumerate() {
            if class.proxy < *length
                && let Some(term) = &values[offsets[family] + class.proxy]
            {
                terms.push(term.clone());
                outputs.push((field.0, family));
            }
        }
    }
    (terms, outputs)
}

/// Where an input of the code of a class stands.
pub(super) fn tap_of(proxy: Proxy<'_>, class: SiteClass, input: usize) -> Tap {
    let dimension = proxy.geometry.dimension();
    let (family, site) = proxy.geometry.locate(input % dimension);
    Tap {
        field: input / dimension,
        family,
        shift: proxy.geometry.shift(class.proxy, site),
    }
}

/// A workspace for the sites of a class with these parameters, ε and h.
pub(super) fn workspace(
    kernel: &Kernel,
    class: SiteClass,
    execution: Execution,
    parameters: &[f64],
    sizes: [f64; 2],
) -> Workspace {
    let lanes = if class.sites() < FEW { 1 } else { BLOCK };
    let mut workspace = kernel.workspace_for(lanes, execution);
    let spread = |value: &f64| std::iter::repeat_n(*value, lanes);
    let parameters: Vec<f64> = parameters.iter().flat_map(spread).collect();
    let [epsilon, h] = sizes.map(|size| vec![size; lanes]);
    kernel.prepare(&mut workspace, &parameters, &epsilon, &h);
    workspace
}
