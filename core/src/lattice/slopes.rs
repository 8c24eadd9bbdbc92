//! Derivatives of sweeps: of tangents by the same stencils, of covectors by the transposed ones.
//!
//! A stage writes o = f(r; λ) at every site, r what it reads there. With S = ∂f/∂r and P = ∂f/∂λ at each site:
//!
//! - tangents: o ← S r + P μ;
//! - covectors: w = o, o ← 0, r ← r + Sᵀw, g ← g + Pᵀw.
//!
//! The second is the transpose of the first, with the same numbers. Code of S and P is written for a class of sites, as
//! the stage's own; their entries are kept for every site. Time and memory are O(N).

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use leafwise_expression::{AlgebraError, Arithmetic, Execution, Graph, Kernel, Term, Workspace};

use super::blocks::{Blocks, RowPart, load};
use super::fields::Fields;
use super::geometry::{LatticeGeometry, PerAxis, Proxy, SiteClass, site_classes};
use super::program::{LatticeProgram, Prepared};
use super::stages::{Field, StageBuilder};
use super::stencil::{Tap, tap_of, terms_of, workspace};

/// Code of the slopes of a program, compiled when it is first asked for.
#[derive(Debug)]
pub struct LatticeSlopes {
    program: Arc<LatticeProgram>,
    proxy: LatticeGeometry,
    width: PerAxis<usize>,
    builder: StageBuilder,
    parameters: usize,
    code: OnceLock<Option<ProgramSlopes>>,
}

#[derive(Debug)]
struct ProgramSlopes {
    stages: Vec<Vec<SlopeStencil>>,
    knows_parameters: bool,
}

/// The slopes of one class of sites in one stage.
#[derive(Debug)]
struct SlopeStencil {
    class: SiteClass,
    /// (field, family) of each output.
    outputs: Vec<(usize, usize)>,
    by_state: SlopeCode<Tap>,
    by_parameters: SlopeCode<usize>,
}

/// The slopes that are not 0, each of an output by a tap or by a parameter.
#[derive(Debug)]
struct SlopeCode<By> {
    /// One output an entry.
    kernel: Kernel,
    taps: Vec<Tap>,
    entries: Vec<(usize, By)>,
}

impl LatticeSlopes {
    /// Those of a program that was compiled of `builder` on `proxy`.
    pub fn new(
        program: &Arc<LatticeProgram>,
        proxy: Proxy<'_>,
        builder: StageBuilder,
        parameters: usize,
    ) -> Self {
        Self {
            program: Arc::clone(program),
            proxy: proxy.geometry.clone(),
            width: proxy.width,
            builder,
            parameters,
            code: OnceLock::new(),
        }
    }

    /// Fields of zeros, for tangents or covectors.
    pub fn empty_fields(&self) -> Fields {
        self.program.empty_fields()
    }

    /// The number of stages.
    pub fn stages(&self) -> usize {
        self.program.stages()
    }

    /// The code, without derivatives by parameters where a formula has none; `None` where it has none by the state.
    fn code(&self) -> Option<&ProgramSlopes> {
        let compile = || {
            let whole = self.compile(self.parameters);
            whole.or_else(|_| self.compile(0)).ok()
        };
        self.code.get_or_init(compile).as_ref()
    }

    /// The code of slopes that numbers were made for.
    fn known(&self) -> &ProgramSlopes {
        self.code().expect("numbers are made of code")
    }

    fn compile(&self, parameters: usize) -> Result<ProgramSlopes, AlgebraError> {
        let geometry = self.program.geometry();
        let proxy = Proxy {
            geometry: &self.proxy,
            width: self.width,
        };
        let classes = site_classes(geometry, proxy);
        let mut graph = self.builder.graph.clone();
        let mut stages = Vec::with_capacity(self.builder.stages.len());
        for stage in &self.builder.stages {
            let mut stencils = Vec::with_capacity(classes.len());
            for class in &classes {
                let (terms, outputs) = terms_of(proxy, *class, &stage.written);
                if terms.is_empty() {
                    continue;
                }
                let inputs = self.builder.graph.inputs_read(&terms);
                let [by_state, by_parameters] = slopes_of(&mut graph, &terms, &inputs, parameters)?;
                let code = (&graph, proxy, *class, self.parameters);
                let tap = |input| tap_of(proxy, *class, input);
                stencils.push(SlopeStencil {
                    class: *class,
                    outputs,
                    by_state: SlopeCode::compile(code, by_state, tap),
                    by_parameters: SlopeCode::compile(code, by_parameters, |index| index),
                });
            }
            stages.push(stencils);
        }
        graph.unless_refused(ProgramSlopes {
            stages,
            knows_parameters: parameters == self.parameters,
        })
    }
}

/// A slope, the number of its output and of what it is by.
type Slope = (Term, usize, usize);

/// Those of terms by the inputs that they read and by the parameters, in reverse mode: stencils are wide.
fn slopes_of(
    graph: &mut Graph,
    terms: &[Term],
    inputs: &[usize],
    parameters: usize,
) -> Result<[Vec<Slope>; 2], AlgebraError> {
    let behind = inputs.last().map_or(0, |last| last + 1);
    let mut slopes = [Vec::new(), Vec::new()];
    for (output, term) in terms.iter().enumerate() {
        let gradients = graph.gradients(term, [behind, parameters])?;
        for (slopes, gradient) in slopes.iter_mut().zip(gradients) {
            let numbered = gradient.into_iter().enumerate();
            slopes.extend(numbered.map(|(by, slope)| (slope, output, by)));
        }
    }
    Ok(slopes)
}

impl<By> SlopeCode<By> {
    fn compile(
        (graph, proxy, class, parameters): (&Graph, Proxy<'_>, SiteClass, usize),
        slopes: Vec<Slope>,
        by: impl Fn(usize) -> By,
    ) -> Self {
        let slopes = slopes.into_iter();
        let (terms, entries): (Vec<Term>, Vec<(usize, By)>) = slopes
            .filter(|(slope, ..)| !graph.is_zero(slope))
            .map(|(slope, output, at)| (slope, (output, by(at))))
            .unzip();
        let (kernel, used) = Kernel::compile_used(graph, &terms, parameters);
        let taps = used.into_iter().map(|input| tap_of(proxy, class, input));
        Self {
            kernel,
            taps: taps.collect(),
            entries,
        }
    }

    /// Operations of the slopes at a site, and of a product with them.
    fn work(&self) -> [u64; 2] {
        [
            self.kernel.step_operations().work(),
            2 * self.entries.len() as u64,
        ]
    }
}

/// Entries of a stencil's slopes, those of one entry at all sites one after the other, and what computes them.
#[derive(Debug)]
struct Entries {
    workspace: Workspace,
    values: Vec<f64>,
    /// The sites of the class, in ranges, and room for those of a block.
    runs: Vec<Range<usize>>,
    block: Vec<RowPart>,
}

impl Entries {
    fn of<By>(
        code: &SlopeCode<By>,
        (geometry, class): (&LatticeGeometry, SiteClass),
        parameters: &[f64],
        sizes: [f64; 2],
    ) -> Self {
        let execution = Execution::default_of_process();
        Self {
            workspace: workspace(&code.kernel, class, execution, parameters, sizes),
            values: Vec::new(),
            runs: class.sites.runs(geometry).collect(),
            block: Vec::new(),
        }
    }

    fn evaluate<By>(
        &mut self,
        code: &SlopeCode<By>,
        program: &LatticeProgram,
        class: SiteClass,
        fields: &Fields,
    ) {
        let (lanes, sites) = (self.workspace.lanes(), class.sites());
        self.values.resize(code.entries.len() * sites, 0.0);
        if code.entries.is_empty() {
            return;
        }
        let geometry = program.geometry();
        let Self { runs, block, .. } = self;
        let mut blocks = Blocks::new(runs, lanes);
        let mut first = 0;
        while blocks.next_into(geometry, block) {
            let count = lanes.min(sites - first);
            for (input, tap) in code.taps.iter().enumerate() {
                load(
                    self.workspace.input_mut(input),
                    &fields.get(Field(tap.field))[program.offsets()[tap.family]..],
                    geometry,
                    tap.shift,
                    block,
                );
            }
            code.kernel.evaluate_in_place(&mut self.workspace);
            for (at, of_sites) in self.values.chunks_exact_mut(sites).enumerate() {
                let lanes = code.kernel.output(&self.workspace, at);
                of_sites[first..first + count].copy_from_slice(&lanes[..count]);
            }
            first += count;
        }
    }
}

/// One stage of a run.
#[derive(Debug)]
struct StageAlong {
    stage: usize,
    prepared: Prepared,
    /// By state and by parameters, of each stencil.
    entries: Vec<(Entries, Entries)>,
}

/// Slopes of all stages of one run after the other, at the numbers that stood in the fields when each began.
#[derive(Debug)]
pub struct SlopesAlong {
    slopes: Arc<LatticeSlopes>,
    stages: Vec<StageAlong>,
    fields: Fields,
    /// Outputs of a stage.
    room: Vec<f64>,
    operations: u64,
}

impl SlopesAlong {
    /// Room for a run of stages with their step sizes; `None` where a stage has no derivative by the state.
    pub fn new(
        slopes: &Arc<LatticeSlopes>,
        stages: impl Iterator<Item = (usize, f64)>,
        parameters: &[f64],
        epsilon: f64,
    ) -> Option<Self> {
        let code = slopes.code()?;
        let make = |(stage, h): (usize, f64)| {
            let sizes = [epsilon, h];
            let of_stencil = |stencil: &SlopeStencil| {
                let class = (slopes.program.geometry(), stencil.class);
                (
                    Entries::of(&stencil.by_state, class, parameters, sizes),
                    Entries::of(&stencil.by_parameters, class, parameters, sizes),
                )
            };
            StageAlong {
                stage,
                prepared: slopes.program.prepare(stage, parameters, epsilon, h),
                entries: code.stages[stage].iter().map(of_stencil).collect(),
            }
        };
        Some(Self {
            stages: stages.map(make).collect(),
            fields: slopes.program.empty_fields(),
            room: Vec::new(),
            operations: 0,
            slopes: Arc::clone(slopes),
        })
    }

    /// The run's fields: those where it begins, before [`run`](Self::run).
    pub fn fields_mut(&mut self) -> &mut Fields {
        &mut self.fields
    }

    /// Whether derivatives by parameters are known.
    pub fn knows_parameters(&self) -> bool {
        self.slopes.known().knows_parameters
    }

    /// Operations so far.
    pub fn operations(&self) -> u64 {
        self.operations
    }

    /// Runs all stages, with the slopes of each by the state, and `by_parameters` too.
    pub fn run(&mut self, by_parameters: bool) {
        let slopes = Arc::clone(&self.slopes);
        let (program, code) = (&slopes.program, slopes.known());
        for along in &mut self.stages {
            for (stencil, entries) in code.stages[along.stage].iter().zip(&mut along.entries) {
                let (class, sites) = (stencil.class, stencil.class.sites() as u64);
                let (state, parameters) = entries;
                state.evaluate(&stencil.by_state, program, class, &self.fields);
                self.operations += sites * stencil.by_state.work()[0];
                if by_parameters {
                    parameters.evaluate(&stencil.by_parameters, program, class, &self.fields);
                    self.operations += sites * stencil.by_parameters.work()[0];
                }
            }
            program.run_stage(along.stage, &mut along.prepared, &mut self.fields);
            self.operations += program.stage_work(along.stage);
        }
    }

    /// The fields' tangents where the run begins become those where it ends, with μ of the parameters or none.
    pub fn push(&mut self, tangents: &mut Fields, mu: &[f64]) {
        let slopes = Arc::clone(&self.slopes);
        let (program, code) = (&slopes.program, slopes.known());
        for along in &self.stages {
            let stencils = &code.stages[along.stage];
            resize(&mut self.room, stencils);
            let mut rest = &mut self.room[..];
            for (stencil, (state, parameters)) in stencils.iter().zip(&along.entries) {
                let (class, sites) = (stencil.class, stencil.class.sites());
                let (own, behind) = rest.split_at_mut(stencil.outputs.len() * sites);
                rest = behind;
                let by_state = stencil.by_state.entries.iter();
                for ((output, tap), values) in by_state.zip(state.values.chunks_exact(sites)) {
                    let out = &mut own[output * sites..][..sites];
                    for (of_field, of_class) in places(program, class, *tap) {
                        let read = &tangents.get(Field(tap.field))[of_field];
                        let products = values[of_class.clone()].iter().zip(read);
                        let out = &mut out[of_class];
                        out.iter_mut()
                            .zip(products)
                            .for_each(|(o, (s, r))| *o += s * r);
                    }
                }
                self.operations += sites as u64 * stencil.by_state.work()[1];
                if mu.is_empty() {
                    continue;
                }
                let by_parameters = stencil.by_parameters.entries.iter();
                for ((output, at), values) in
                    by_parameters.zip(parameters.values.chunks_exact(sites))
                {
                    let out = &mut own[output * sites..][..sites];
                    out.iter_mut()
                        .zip(values)
                        .for_each(|(o, p)| *o += p * mu[*at]);
                }
                self.operations += sites as u64 * stencil.by_parameters.work()[1];
            }
            for (field, range, own) in outputs(program, stencils) {
                tangents.get_mut(field)[range].copy_from_slice(&self.room[own]);
            }
        }
    }

    /// The fields' covectors where the run ends become those where it begins; adds what the parameters have to
    /// `gradient`, which may be empty.
    pub fn pull(&mut self, covectors: &mut Fields, gradient: &mut [f64]) {
        let slopes = Arc::clone(&self.slopes);
        let (program, code) = (&slopes.program, slopes.known());
        for along in self.stages.iter().rev() {
            let stencils = &code.stages[along.stage];
            resize(&mut self.room, stencils);
            for (field, range, own) in outputs(program, stencils) {
                let written = &mut covectors.get_mut(field)[range];
                self.room[own].copy_from_slice(written);
                written.fill(0.0);
            }
            let mut rest = &self.room[..];
            for (stencil, (state, parameters)) in stencils.iter().zip(&along.entries) {
                let (class, sites) = (stencil.class, stencil.class.sites());
                let (own, behind) = rest.split_at(stencil.outputs.len() * sites);
                rest = behind;
                let by_state = stencil.by_state.entries.iter();
                for ((output, tap), values) in by_state.zip(state.values.chunks_exact(sites)) {
                    let out = &own[output * sites..][..sites];
                    for (of_field, of_class) in places(program, class, *tap) {
                        let read = &mut covectors.get_mut(Field(tap.field))[of_field];
                        let products = values[of_class.clone()].iter().zip(&out[of_class]);
                        read.iter_mut()
                            .zip(products)
                            .for_each(|(r, (s, o))| *r += s * o);
                    }
                }
                self.operations += sites as u64 * stencil.by_state.work()[1];
                if gradient.is_empty() {
                    continue;
                }
                let by_parameters = stencil.by_parameters.entries.iter();
                for ((output, at), values) in
                    by_parameters.zip(parameters.values.chunks_exact(sites))
                {
                    let out = &own[output * sites..][..sites];
                    let products = values.iter().zip(out).map(|(p, o)| p * o);
                    gradient[*at] += products.sum::<f64>();
                }
                self.operations += sites as u64 * stencil.by_parameters.work()[1];
            }
        }
    }
}

/// Makes room for the outputs of a stage, all 0.
fn resize(room: &mut Vec<f64>, stencils: &[SlopeStencil]) {
    let sizes = stencils.iter().map(|s| s.outputs.len() * s.class.sites());
    room.clear();
    room.resize(sizes.sum(), 0.0);
}

/// Where each output of a stage stands: in a field, and in the room.
fn outputs<'a>(
    program: &'a LatticeProgram,
    stencils: &'a [SlopeStencil],
) -> impl Iterator<Item = (Field, Range<usize>, Range<usize>)> + 'a {
    let each = stencils.iter().flat_map(|stencil| {
        let outputs = stencil.outputs.iter();
        outputs.map(|(field, family)| (*field, *family, stencil.class))
    });
    let runs = each.flat_map(|(field, family, class)| {
        let start = program.offsets()[family];
        let runs = class.sites.runs(program.geometry());
        runs.map(move |run| (Field(field), start + run.start..start + run.end))
    });
    runs.scan(0, |next, (field, range)| {
        let first = *next;
        *next += range.len();
        Some((field, range, first..*next))
    })
}

/// Where a tap of all sites of a class stands in its field, each range with the sites that it is of, two a row where
/// an axis closes.
fn places(
    program: &LatticeProgram,
    class: SiteClass,
    tap: Tap,
) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
    let (geometry, offset) = (program.geometry(), program.offsets()[tap.family]);
    let axes = geometry.axes.len();
    let length = geometry.axes.last().map_or(1, |axis| axis.length);
    let (rows, sites) = class.sites.rows(axes);
    rows.enumerate().flat_map(move |(row, place)| {
        let here = geometry.site(place);
        // A class reads no site beyond an end.
        let first = geometry.beside(here, tap.shift).unwrap_or(here);
        let (row_start, at) = (first - first % length, first % length);
        let before = sites.min(length - at);
        let of_row = row * sites;
        [(first, 0..before), (row_start, before..sites)].map(|(from, of_class)| {
            let from = offset + from;
            (
                from..from + of_class.len(),
                of_row + of_class.start..of_row + of_class.end,
            )
        })
    })
}
