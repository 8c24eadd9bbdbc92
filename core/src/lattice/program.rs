//! Stages compiled to stencils, and their sweeps over the sites.

use leafwise_expression::{Graph, Kernel, Term, Workspace};

use super::geometry::{LatticeGeometry, SiteClass, site_classes};
use super::stages::{Field, StageBuilder};
use crate::error::BuildError;

/// Interior sites are evaluated this many at a time, as lanes of one kernel.
const BLOCK: usize = 8;

/// Where a kernel input of one site stands: a field of a family, `shift` sites away.
#[derive(Clone, Copy, Debug)]
struct Tap {
    field: usize,
    family: usize,
    shift: isize,
}

/// The code of one class of sites in one stage.
#[derive(Clone, Debug)]
struct Stencil {
    class: SiteClass,
    kernel: Kernel,
    taps: Vec<Tap>,
    /// (field, family) of each output.
    outputs: Vec<(usize, usize)>,
}

impl Stencil {
    /// How many sites it serves.
    fn sites(&self) -> usize {
        self.class.end - self.class.start
    }
}

/// A program over the fields of a lattice.
#[derive(Clone, Debug)]
pub struct LatticeProgram {
    geometry: LatticeGeometry,
    offsets: Vec<usize>,
    fields: usize,
    stages: Vec<Vec<Stencil>>,
}

/// The proxy lattice code is written on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proxy<'a> {
    pub(super) geometry: &'a LatticeGeometry,
    pub(super) width: usize,
}

impl LatticeProgram {
    /// Compiles the stages of `builder`, written on `proxy`, for the lattice `geometry`.
    pub(super) fn compile(
        geometry: &LatticeGeometry,
        proxy: Proxy<'_>,
        builder: &StageBuilder,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let classes = site_classes(
            geometry.length(),
            proxy.geometry.length(),
            proxy.width,
            geometry.periodic,
        );
        let mut stages = Vec::with_capacity(builder.stages.len());
        for stage in &builder.stages {
            let mut stencils = Vec::with_capacity(classes.len());
            for class in &classes {
                let stencil =
                    compile_stencil(geometry, proxy, *class, &builder.graph, stage, parameters)?;
                stencils.extend(stencil);
            }
            stages.push(stencils);
        }
        Ok(Self {
            geometry: geometry.clone(),
            offsets: geometry.offsets(),
            fields: builder.fields,
            stages,
        })
    }

    /// The operations of one evaluation, all sites together.
    pub fn operations(&self) -> usize {
        let stencils = self.stages.iter().flatten();
        stencils
            .map(|s| s.sites() * s.kernel.step_operations().total())
            .sum()
    }

    /// The same, weighted.
    pub fn work(&self) -> u64 {
        let stencils = self.stages.iter().flatten();
        stencils
            .map(|s| s.sites() as u64 * s.kernel.step_operations().work())
            .sum()
    }

    /// Where the longest family starts in a field.
    pub(super) fn longest_start(&self) -> usize {
        let length = self.geometry.length();
        let longest = self.geometry.families.iter().position(|f| f.1 == length);
        self.offsets[longest.unwrap_or(0)]
    }

    /// The kernels of all stages and classes of sites.
    pub fn kernels(&self) -> impl Iterator<Item = &Kernel> {
        self.stages.iter().flatten().map(|stencil| &stencil.kernel)
    }

    /// The number of fields, one number a coordinate each.
    pub fn fields(&self) -> usize {
        self.fields
    }

    /// A worker with these parameters and step sizes.
    pub fn worker(&self, parameters: &[f64], epsilon: f64, h: f64) -> LatticeWorker {
        let prepared = |kernel: &Kernel, lanes: usize| {
            let mut workspace = kernel.workspace(lanes);
            let spread: Vec<f64> = parameters
                .iter()
                .flat_map(|p| std::iter::repeat_n(*p, lanes))
                .collect();
            kernel.prepare(
                &mut workspace,
                &spread,
                &vec![epsilon; lanes],
                &vec![h; lanes],
            );
            workspace
        };
        let workspaces = self
            .stages
            .iter()
            .map(|stage| {
                stage
                    .iter()
                    .map(|s| (prepared(&s.kernel, 1), prepared(&s.kernel, BLOCK)))
                    .collect()
            })
            .collect();
        let dimension = self.geometry.dimension();
        LatticeWorker {
            workspaces,
            fields: vec![vec![0.0; dimension]; self.fields],
        }
    }

    /// Runs every stage on the fields of `worker`.
    pub fn run(&self, worker: &mut LatticeWorker) {
        for (stencils, workspaces) in self.stages.iter().zip(&mut worker.workspaces) {
            for (stencil, (single, block)) in stencils.iter().zip(workspaces) {
                let SiteClass { start, end, .. } = stencil.class;
                let mut site = start;
                while site + BLOCK <= end {
                    self.sweep(stencil, block, &mut worker.fields, site);
                    site += BLOCK;
                }
                while site < end {
                    self.sweep(stencil, single, &mut worker.fields, site);
                    site += 1;
                }
            }
        }
    }

    /// Evaluates a stencil at as many sites from `site` on as the workspace has lanes.
    fn sweep(
        &self,
        stencil: &Stencil,
        workspace: &mut Workspace,
        fields: &mut [Vec<f64>],
        site: usize,
    ) {
        let lanes = workspace.lanes();
        let length = self.geometry.length();
        for (input, tap) in stencil.taps.iter().enumerate() {
            let field = &fields[tap.field][self.offsets[tap.family]..];
            let slots = workspace.input_mut(input);
            let first = site.wrapping_add_signed(tap.shift);
            if first < length && first + lanes <= length {
                slots.copy_from_slice(&field[first..first + lanes]);
            } else {
                let first = (site as isize + tap.shift).rem_euclid(length as isize) as usize;
                for (lane, slot) in slots.iter_mut().enumerate() {
                    *slot = field[(first + lane) % length];
                }
            }
        }
        stencil.kernel.evaluate_in_place(workspace);
        for (output, &(field, family)) in stencil.outputs.iter().enumerate() {
            let start = self.offsets[family] + site;
            fields[field][start..start + lanes]
                .copy_from_slice(stencil.kernel.output(workspace, output));
        }
    }
}

/// The fields and prepared kernels of one trajectory.
#[derive(Clone, Debug)]
pub struct LatticeWorker {
    workspaces: Vec<Vec<(Workspace, Workspace)>>,
    fields: Vec<Vec<f64>>,
}

impl LatticeWorker {
    /// A field's values.
    pub fn field(&self, field: Field) -> &[f64] {
        &self.fields[field.0]
    }

    /// A field's values, to be written.
    pub fn field_mut(&mut self, field: Field) -> &mut [f64] {
        &mut self.fields[field.0]
    }
}

/// The code of a class in one stage, `None` where it writes nothing.
fn compile_stencil(
    geometry: &LatticeGeometry,
    proxy: Proxy<'_>,
    class: SiteClass,
    graph: &Graph,
    stage: &[(Field, Vec<Term>)],
    parameters: usize,
) -> Result<Option<Stencil>, BuildError> {
    let proxy_offsets = proxy.geometry.offsets();
    let mut terms = Vec::new();
    let mut outputs = Vec::new();
    for (field, values) in stage {
        for (family, (_, length)) in proxy.geometry.families.iter().enumerate() {
            if class.proxy < *length {
                terms.push(values[proxy_offsets[family] + class.proxy].clone());
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
        let shift = shift(proxy.geometry, class.proxy, site);
        if translated && shift.unsigned_abs() > proxy.width {
            return Err(BuildError::NotLocal {
                reach: shift.unsigned_abs(),
            });
        }
        taps.push(Tap {
            field,
            family,
            shift,
        });
    }
    Ok(Some(Stencil {
        class,
        kernel,
        taps,
        outputs,
    }))
}

/// How far `site` is from `here`, the shorter way round on a ring.
pub(super) fn shift(geometry: &LatticeGeometry, here: usize, site: usize) -> isize {
    let difference = site as isize - here as isize;
    if !geometry.periodic {
        return difference;
    }
    let length = geometry.length() as isize;
    (difference + length / 2).rem_euclid(length) - length / 2
}
