//! The code of one class of sites in one stage, and its sweep over them.

use std::ops::Range;

use leafwise_expression::syntax::AXES;
use leafwise_expression::{Aligned, Execution, Graph, Kernel, Term, Workspace};

use super::fields::{Fields, stride};
use super::geometry::{LatticeGeometry, PerAxis, Proxy, SiteBox, SiteClass};
use super::stages::{Field, Written};
use crate::error::BuildError;

/// Sites are evaluated this many at a time, as lanes of one kernel.
const BLOCK: usize = 32;

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
}

/// Sites whose inputs and outputs all stand as far from them as everywhere in memory: the kernel takes them in place.
///
/// Along several axes they are rows with other sites between. The kernel runs over these as well; what it writes there
/// is put back.
#[derive(Clone, Debug, Default)]
struct Inside {
    /// From the first row to the last.
    range: Range<usize>,
    /// Their rows, in the order of the sites.
    rows: Vec<Range<usize>>,
    /// The other sites of the class, in ranges.
    outside: Vec<Range<usize>>,
}

/// Room for a sweep of one stencil.
#[derive(Clone, Debug)]
pub(super) struct SweepRoom {
    workspace: Workspace,
    /// Numbers between the rows that are swept in place.
    between: Vec<f64>,
    /// Sites that are left of these rows.
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
            taps,
            outputs,
        }))
    }

    /// The same with a kernel that reads and writes the fields where they stand.
    pub(super) fn in_place(mut self, geometry: &LatticeGeometry, offsets: &[usize]) -> Self {
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
        let (inputs, outputs): (Vec<isize>, Vec<isize>) = (inputs.collect(), outputs.collect());
        self.kernel = self.kernel.at_distances(&inputs, &outputs);
        let sites = self.sites_inside(geometry);
        self.inside.rows = sites.runs(geometry).collect();
        let (Some(first), Some(last)) = (self.inside.rows.first(), self.inside.rows.last()) else {
            return self;
        };
        // What is written first starts a cache line.
        let offset = offsets[self.outputs[0].1];
        let begin = (offset + first.start).next_multiple_of(Aligned::LINE) - offset;
        self.inside.range = begin.min(last.end)..last.end;
        self.inside.outside = rest(self.class.sites, sites, geometry);
        self
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
        let SweepRoom {
            workspace,
            between,
            left,
            block,
        } = room;
        let Inside {
            range,
            rows,
            outside,
        } = &self.inside;
        self.keep(offsets, fields, between);
        let numbers = fields.all_mut();
        let reached = self
            .kernel
            .evaluate_along(workspace, numbers, range.clone());
        let swept = range.start..range.start + reached;
        self.put_back(offsets, fields, (between, swept.end));
        let mut in_place = 0;
        left.clear();
        for row in rows {
            let own = row.start.max(swept.start)..row.end.min(swept.end);
            let beside = match own.is_empty() {
                true => [row.clone(), 0..0],
                false => {
                    in_place += own.len();
                    [row.start..own.start, own.end..row.end]
                }
            };
            left.extend(beside.into_iter().filter(|range| !range.is_empty()));
        }
        for sites in [&outside[..], &left[..]] {
            let room = (&mut *workspace, &mut *block);
            self.sweep_by_copies(geometry, offsets, room, fields, sites);
        }
        in_place
    }

    /// The ranges between the rows that are swept in place.
    fn gaps(&self) -> impl Iterator<Item = Range<usize>> {
        let pairs = self.inside.rows.windows(2);
        pairs.map(|rows| rows[0].end..rows[1].start)
    }

    /// Keeps the numbers between the rows that are swept in place.
    fn keep(&self, offsets: &[usize], fields: &Fields, between: &mut Vec<f64>) {
        between.clear();
        for gap in self.gaps() {
            for &(field, family) in &self.outputs {
                let field = &fields.get(Field(field))[offsets[family]..];
                between.extend_from_slice(&field[gap.clone()]);
            }
        }
    }

    /// Puts it back, as far as the sweep came.
    fn put_back(&self, offsets: &[usize], fields: &mut Fields, (between, end): (&[f64], usize)) {
        let mut kept = between;
        for gap in self.gaps().take_while(|gap| gap.start < end) {
            for &(field, family) in &self.outputs {
                let (own, behind) = kept.split_at(gap.len());
                kept = behind;
                let field = &mut fields.get_mut(Field(field))[offsets[family]..];
                field[gap.clone()].copy_from_slice(own);
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

/// The sites of a box that are not in an inner one, in ranges.
fn rest(whole: SiteBox, inner: SiteBox, geometry: &LatticeGeometry) -> Vec<Range<usize>> {
    let axes = geometry.axes.len();
    let last = axes.saturating_sub(1);
    let (rows, length) = whole.rows(axes);
    let mut left = Vec::new();
    for place in rows {
        let start = geometry.site(place);
        let mut middle = place;
        middle[last] = inner.start[last];
        let ranges = match inner.sites() > 0 && inner.has(middle) {
            true => {
                let [before, behind] =
                    [inner.start[last], inner.end[last]].map(|at| start + (at - whole.start[last]));
                [start..before, behind..start + length]
            }
            false => [start..start + length, 0..0],
        };
        left.extend(ranges.into_iter().filter(|range| !range.is_empty()));
    }
    left
}

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
            let at = match geometry.axes.len() {
                0 | 1 => 0,
                axes => place[axes - 1],
            };
            let of_row = match geometry.axes.len() {
                0 | 1 => usize::MAX,
                _ => length - at,
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
