//! Stages compiled to stencils, and their sweeps over the sites.

use leafwise_expression::syntax::AXES;
use leafwise_expression::{Execution, Kernel};

use super::fields::Fields;
use super::geometry::{LatticeGeometry, Proxy, site_classes};
use super::stages::{Field, StageBuilder, StageTerms};
use super::stencil::{Stencil, SweepRoom};
use super::wavefront::PartSites;
use crate::error::BuildError;

/// A program over the fields of a lattice.
#[derive(Clone, Debug)]
pub struct LatticeProgram {
    geometry: LatticeGeometry,
    offsets: Vec<usize>,
    fields: usize,
    stages: Vec<Stage>,
}

/// One sweep over all sites.
#[derive(Clone, Debug)]
struct Stage {
    stencils: Vec<Stencil>,
    /// Fields written aside, each with the one it stands for: of those that the stage reads at other
    /// sites than it writes.
    aside: Vec<(usize, usize)>,
}

impl LatticeProgram {
    /// Compiles the stages of `builder`, written on `proxy`, for the lattice `geometry`.
    ///
    /// # Errors
    /// [`BuildError::LooksFurther`] when code looks further than the proxy's width.
    pub fn compile(
        geometry: &LatticeGeometry,
        proxy: Proxy<'_>,
        builder: &StageBuilder,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let classes = site_classes(geometry, proxy);
        let offsets = geometry.offsets();
        let mut fields = builder.fields;
        let mut stages = Vec::with_capacity(builder.stages.len());
        for StageTerms { written, is_apart } in &builder.stages {
            let mut stencils = Vec::with_capacity(classes.len());
            for class in &classes {
                let graph = &builder.graph;
                let stencil =
                    Stencil::compile(geometry, proxy, *class, graph, written, parameters)?;
                stencils.extend(stencil);
            }
            let aside = match is_apart {
                true => Vec::new(),
                false => write_aside(&mut stencils, builder.fields),
            };
            let in_place = |stencil: Stencil| stencil.in_place(geometry, &offsets, *is_apart);
            let stencils = stencils.into_iter().map(in_place).collect();
            fields = fields.max(builder.fields + aside.len());
            stages.push(Stage { stencils, aside });
        }
        Ok(Self {
            geometry: geometry.clone(),
            offsets,
            fields,
            stages,
        })
    }

    /// The lattice.
    pub(crate) fn geometry(&self) -> &LatticeGeometry {
        &self.geometry
    }

    /// Where each family starts in a field.
    pub(super) fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// The number of stages.
    pub fn stages(&self) -> usize {
        self.stages.len()
    }

    /// The operations of one evaluation of all stages, all sites together.
    pub fn operations(&self) -> usize {
        (0..self.stages.len())
            .map(|stage| self.stage_operations(stage))
            .sum()
    }

    /// The same, weighted.
    pub fn work(&self) -> u64 {
        (0..self.stages.len())
            .map(|stage| self.stage_work(stage))
            .sum()
    }

    /// The operations of one stage, all sites together.
    pub fn stage_operations(&self, stage: usize) -> usize {
        let stencils = self.stages[stage].stencils.iter();
        stencils
            .map(|s| s.sites() * s.kernel.step_operations().total())
            .sum()
    }

    /// The same, weighted.
    pub fn stage_work(&self, stage: usize) -> u64 {
        let stencils = self.stages[stage].stencils.iter();
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
        let stencils = self.stages.iter().flat_map(|stage| &stage.stencils);
        stencils.map(|stencil| &stencil.kernel)
    }

    /// The number of fields, one number a coordinate each.
    pub fn fields(&self) -> usize {
        self.fields
    }

    /// Fields of zeros.
    pub fn empty_fields(&self) -> Fields {
        Fields::zeros(self.fields, self.geometry.dimension())
    }

    /// Prepares a stage: its kernels with all that depends on parameters and step sizes alone.
    pub fn prepare(&self, stage: usize, parameters: &[f64], epsilon: f64, h: f64) -> Prepared {
        let execution = Execution::default_of_process();
        self.prepare_for(execution, stage, parameters, [epsilon, h])
    }

    /// The same with kernels that run in a given way.
    pub(super) fn prepare_for(
        &self,
        execution: Execution,
        stage: usize,
        parameters: &[f64],
        sizes: [f64; 2],
    ) -> Prepared {
        let stencils = self.stages[stage].stencils.iter();
        let prepare = |stencil: &Stencil| stencil.prepare(execution, parameters, sizes);
        Prepared(stencils.map(prepare).collect())
    }

    /// Sites that the parts of a stage read and write, to take them in turn with those of others; `None` where the stage is no
    /// sweep in parts.
    pub fn parts(&self, stage: usize) -> Option<Vec<PartSites>> {
        let Stage { stencils, aside } = &self.stages[stage];
        match (&stencils[..], &aside[..]) {
            ([stencil], []) => stencil.parts(&self.geometry),
            _ => None,
        }
    }

    /// Runs one part of a stage that has [parts](Self::parts).
    pub fn run_part(
        &self,
        (stage, part): (usize, usize),
        prepared: &mut Prepared,
        fields: &mut Fields,
    ) {
        let stencils = self.stages[stage].stencils.iter();
        for (stencil, room) in stencils.zip(&mut prepared.0) {
            stencil.sweep_part(part, &self.geometry, &self.offsets, room, fields);
        }
    }

    /// Runs one stage.
    pub fn run_stage(&self, stage: usize, prepared: &mut Prepared, fields: &mut Fields) {
        self.sweep(stage, prepared, fields);
    }

    /// The same; returns at how many sites in place.
    pub(super) fn sweep(
        &self,
        stage: usize,
        prepared: &mut Prepared,
        fields: &mut Fields,
    ) -> usize {
        let Stage { stencils, aside } = &self.stages[stage];
        let mut in_place = 0;
        for (stencil, workspace) in stencils.iter().zip(&mut prepared.0) {
            in_place += stencil.sweep(&self.geometry, &self.offsets, workspace, fields);
        }
        for &(written, original) in aside {
            for stencil in stencils {
                for &(field, family) in &stencil.outputs {
                    if field == written {
                        let start = self.offsets[family];
                        for row in stencil.class.sites.runs(&self.geometry) {
                            let range = start + row.start..start + row.end;
                            fields.copy(Field(written), Field(original), range);
                        }
                    }
                }
            }
        }
        in_place
    }

    /// An evaluator for all stages with these parameters and step sizes.
    pub fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> LatticeEvaluator {
        let stages = 0..self.stages.len();
        LatticeEvaluator {
            prepared: stages
                .map(|stage| self.prepare(stage, parameters, epsilon, h))
                .collect(),
            fields: self.empty_fields(),
        }
    }

    /// Makes an evaluator one for other parameters or step sizes; the fields stay.
    pub fn prepare_again(
        &self,
        evaluator: &mut LatticeEvaluator,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) {
        for (stage, prepared) in evaluator.prepared.iter_mut().enumerate() {
            *prepared = self.prepare(stage, parameters, epsilon, h);
        }
    }

    /// Runs every stage on the fields of `evaluator`.
    pub fn run(&self, evaluator: &mut LatticeEvaluator) {
        for (stage, prepared) in evaluator.prepared.iter_mut().enumerate() {
            self.run_stage(stage, prepared, &mut evaluator.fields);
        }
    }
}

/// Gives fields that the stage reads at other sites than it writes a place aside, from `fields` on.
fn write_aside(stencils: &mut [Stencil], fields: usize) -> Vec<(usize, usize)> {
    let is_written = |field: usize, family: usize| {
        stencils
            .iter()
            .any(|s| s.outputs.contains(&(field, family)))
    };
    let taps = stencils.iter().flat_map(|s| &s.taps);
    let mut read: Vec<usize> = taps
        .filter(|tap| tap.shift != [0; AXES] && is_written(tap.field, tap.family))
        .map(|tap| tap.field)
        .collect();
    read.sort_unstable();
    read.dedup();
    let aside: Vec<(usize, usize)> = read
        .into_iter()
        .enumerate()
        .map(|(at, field)| (fields + at, field))
        .collect();
    for (field, _) in stencils.iter_mut().flat_map(|s| &mut s.outputs) {
        if let Some((written, _)) = aside.iter().find(|(_, original)| original == field) {
            *field = *written;
        }
    }
    aside
}

/// Stages' kernels with their coefficients for one choice of parameters and step sizes.
#[derive(Clone, Debug)]
pub struct Prepared(Vec<SweepRoom>);

/// The fields and prepared kernels of one trajectory.
#[derive(Clone, Debug)]
pub struct LatticeEvaluator {
    prepared: Vec<Prepared>,
    fields: Fields,
}

impl LatticeEvaluator {
    /// A field's values.
    pub fn field(&self, field: Field) -> &[f64] {
        self.fields.get(field)
    }

    /// A field's values, to be written.
    pub fn field_mut(&mut self, field: Field) -> &mut [f64] {
        self.fields.get_mut(field)
    }
}
