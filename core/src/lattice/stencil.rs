//! The code of one class of sites in one stage, and its sweep over them.

use std::ops::Range;

use leafwise_expression::{Aligned, Execution, Graph, Kernel, Term, Workspace};

use super::fields::{Fields, stride};
use super::geometry::{LatticeGeometry, Proxy, SiteClass};
use super::stages::{Field, Written};
use crate::error::BuildError;

/// Sites are evaluated this many at a time, as lanes of one kernel.
const BLOCK: usize = 32;

/// Classes of fewer sites go one by one: boundary sites.
const FEW: usize = 4;

/// Where a kernel input of one site stands: a field of a family, `shift` sites away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tap {
    pub(super) field: usize,
    pub(super) family: usize,
    pub(super) shift: isize,
}

/// The code of one class of sites in one stage.
#[derive(Clone, Debug)]
pub(super) struct Stencil {
    pub(super) class: SiteClass,
    pub(super) kernel: Kernel,
    pub(super) taps: Vec<Tap>,
    /// (field, family) of each output.
    pub(super) outputs: Vec<(usize, usize)>,
    /// The sites whose inputs and outputs all stand in their families, none beyond an end: the kernel takes them in place.
    inside: Range<usize>,
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
        let translated = geometry.length() != proxy.geometry.length();
        let mut taps = Vec::with_capacity(used.len());
        for input in used {
            let tap = tap_of(proxy, class, input);
            let Tap { family, shift, .. } = tap;
            let [first, last] =
                [class.start, class.end - 1].map(|site| site.wrapping_add_signed(shift));
            let is_there = |site| geometry.periodic || site < geometry.families[family].1;
            let is_foreseen =
                shift.unsigned_abs() <= proxy.width && is_there(first) && is_there(last);
            if translated && !is_foreseen {
                return Err(BuildError::LooksFurther {
                    reach: shift.unsigned_abs(),
                    foreseen: proxy.width,
                });
            }
            taps.push(tap);
        }
        Ok(Some(Self {
            class,
            kernel,
            inside: 0..0,
            taps,
            outputs,
        }))
    }

    /// The same with a kernel that reads and writes the fields where they stand.
    pub(super) fn in_place(mut self, geometry: &LatticeGeometry, offsets: &[usize]) -> Self {
        if self.sites() < FEW {
            return self;
        }
        let stride = stride(geometry.dimension());
        let start = |field: usize, family: usize| (field * stride + offsets[family]) as isize;
        let taps = self.taps.iter();
        let inputs = taps.map(|tap| start(tap.field, tap.family) + tap.shift);
        let outputs = self.outputs.iter();
        let outputs = outputs.map(|&(field, family)| start(field, family));
        let (inputs, outputs): (Vec<isize>, Vec<isize>) = (inputs.collect(), outputs.collect());
        let (mut first, mut end) = (self.class.start, self.class.end);
        let read = self.taps.iter().map(|tap| (tap.family, tap.shift));
        let written = self.outputs.iter().map(|(_, family)| (*family, 0));
        for (family, shift) in read.chain(written) {
            let length = geometry.families[family].1;
            first = first.max(0_usize.saturating_add_signed(-shift));
            end = end.min(length.saturating_add_signed(-shift));
        }
        // What is written first starts a cache line.
        let offset = offsets[self.outputs[0].1];
        first = (offset + first).next_multiple_of(Aligned::LINE) - offset;
        self.inside = first.min(end)..end;
        self.kernel = self.kernel.at_distances(&inputs, &outputs);
        self
    }

    /// How many sites it serves.
    pub(super) fn sites(&self) -> usize {
        self.class.sites()
    }

    /// A workspace for a sweep with these parameters, ε and h.
    pub(super) fn prepare(
        &self,
        execution: Execution,
        parameters: &[f64],
        sizes: [f64; 2],
    ) -> Workspace {
        workspace(&self.kernel, self.class, execution, parameters, sizes)
    }

    /// Evaluates the code at each site of the class; returns at how many of them in place.
    pub(super) fn sweep(
        &self,
        geometry: &LatticeGeometry,
        offsets: &[usize],
        workspace: &mut Workspace,
        fields: &mut Fields,
    ) -> usize {
        let inside = self.inside.clone();
        let numbers = fields.all_mut();
        let in_place = self.kernel.evaluate_along(workspace, numbers, inside);
        let first = match in_place {
            0 => self.class.start,
            _ => self.inside.start,
        };
        for sites in [self.class.start..first, first + in_place..self.class.end] {
            self.sweep_by_copies(geometry, offsets, workspace, fields, sites);
        }
        in_place
    }

    /// Evaluates the code at sites of the class on copies of its inputs and outputs.
    fn sweep_by_copies(
        &self,
        geometry: &LatticeGeometry,
        offsets: &[usize],
        workspace: &mut Workspace,
        fields: &mut Fields,
        sites: Range<usize>,
    ) {
        let lanes = workspace.lanes();
        for site in sites.clone().step_by(lanes) {
            let count = lanes.min(sites.end - site);
            for (input, tap) in self.taps.iter().enumerate() {
                let field = &fields.get(Field(tap.field))[offsets[tap.family]..];
                load(
                    workspace.input_mut(input),
                    field,
                    geometry,
                    site,
                    tap.shift,
                    count,
                );
            }
            self.kernel.evaluate_in_place(workspace);
            for (output, &(field, family)) in self.outputs.iter().enumerate() {
                let values = self.kernel.output(workspace, output);
                let to = &mut fields.get_mut(Field(field))[offsets[family] + site..][..count];
                match (to.first_chunk_mut::<BLOCK>(), values.first_chunk::<BLOCK>()) {
                    (Some(to), Some(values)) => *to = *values,
                    _ => to.copy_from_slice(&values[..count]),
                }
            }
        }
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

/// Loads `count` lanes from `shift` sites beside `site` on; lanes beyond repeat the first.
pub(super) fn load(
    lanes: &mut [f64],
    field: &[f64],
    geometry: &LatticeGeometry,
    site: usize,
    shift: isize,
    count: usize,
) {
    let length = geometry.length();
    let first = site.wrapping_add_signed(shift);
    let is_inside = first < length && first + count <= length;
    if is_inside && count == BLOCK {
        let from = field[first..].first_chunk::<BLOCK>();
        if let (Some(to), Some(from)) = (lanes.first_chunk_mut::<BLOCK>(), from) {
            *to = *from;
        }
        return;
    }
    let (own, beyond) = lanes.split_at_mut(count);
    if is_inside {
        own.copy_from_slice(&field[first..first + count]);
    } else {
        let first = (site as isize + shift).rem_euclid(length as isize) as usize;
        for (lane, slot) in own.iter_mut().enumerate() {
            *slot = field[(first + lane) % length];
        }
    }
    beyond.fill(own[0]);
}
