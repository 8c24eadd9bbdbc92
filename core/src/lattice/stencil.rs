//! The code of one class of sites in one stage, and its sweep over them.

use leafwise_expression::{Graph, Kernel, Workspace};

use super::geometry::{LatticeGeometry, Proxy, SiteClass};
use super::stages::Written;
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
        let proxy_offsets = proxy.geometry.offsets();
        let mut terms = Vec::new();
        let mut outputs = Vec::new();
        for (field, values) in stage {
            for (family, (_, length)) in proxy.geometry.families.iter().enumerate() {
                if class.proxy < *length
                    && let Some(term) = &values[proxy_offsets[family] + class.proxy]
                {
                    terms.push(term.clone());
                    outputs.push((field.0, family));
                }
            }
        }
        if terms.is_empty() {
            return Ok(None);
        }
        let (kernel, used) = Kernel::compile_used(graph, &terms, parameters);
        let dimension = proxy.geometry.dimension();
        let translated = geometry.length() != proxy.geometry.length();
        let mut taps = Vec::with_capacity(used.len());
        for input in used {
            let (field, coordinate) = (input / dimension, input % dimension);
            let (family, site) = proxy.geometry.locate(coordinate);
            let shift = proxy.geometry.shift(class.proxy, site);
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
            taps.push(Tap {
                field,
                family,
                shift,
            });
        }
        Ok(Some(Self {
            class,
            kernel,
            taps,
            outputs,
        }))
    }

    /// How many sites it serves.
    pub(super) fn sites(&self) -> usize {
        self.class.end - self.class.start
    }

    /// A workspace for a sweep.
    pub(super) fn prepare(&self, parameters: &[f64], epsilon: f64, h: f64) -> Workspace {
        let lanes = if self.sites() < FEW { 1 } else { BLOCK };
        let mut workspace = self.kernel.workspace(lanes);
        let spread = |value: &f64| std::iter::repeat_n(*value, lanes);
        let parameters: Vec<f64> = parameters.iter().flat_map(spread).collect();
        let sizes = (vec![epsilon; lanes], vec![h; lanes]);
        self.kernel
            .prepare(&mut workspace, &parameters, &sizes.0, &sizes.1);
        workspace
    }

    /// Evaluates the code at each site of the class.
    pub(super) fn sweep(
        &self,
        geometry: &LatticeGeometry,
        offsets: &[usize],
        workspace: &mut Workspace,
        fields: &mut [Vec<f64>],
    ) {
        let lanes = workspace.lanes();
        for site in (self.class.start..self.class.end).step_by(lanes) {
            let count = lanes.min(self.class.end - site);
            for (input, tap) in self.taps.iter().enumerate() {
                let field = &fields[tap.field][offsets[tap.family]..];
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
                let to = &mut fields[field][offsets[family] + site..][..count];
                match (to.first_chunk_mut::<BLOCK>(), values.first_chunk::<BLOCK>()) {
                    (Some(to), Some(values)) => *to = *values,
                    _ => to.copy_from_slice(&values[..count]),
                }
            }
        }
    }
}

/// Loads `count` lanes from `shift` sites beside `site` on; lanes beyond repeat the first.
fn load(
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
