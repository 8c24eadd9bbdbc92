//! The code of an iteration.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Kernel, OperationCount, Term};

use super::at_once::at_once;
use crate::SourceTarget;
use crate::error::BuildError;
use crate::linear::{elimination_operations, substitution_operations};

/// Operations a coordinate of extrapolating the solution from differences of twelve earlier ones.
const EXTRAPOLATION: u64 = 36;

/// Code of one iteration at y, as two kernels. One computes base, unless that is y itself, β̂ − base and α̂ − β̂ alone.
/// The other computes these with the Jacobians D(β̂∘L) and D((α̂ − β̂)∘L). Behind them stands the guard of the chart.
#[derive(Clone, Debug)]
pub struct NewtonKernel {
    pub(super) full: Arc<Kernel>,
    pub(super) residual: Arc<Kernel>,
    pub(super) dimension: usize,
    /// The outputs of base, d or none where it is y.
    pub(super) bases: usize,
    /// Whether the guard is of a series, term by term of each coordinate.
    pub(super) guards_series: bool,
    /// Where a solve starts, beside the solution before it.
    pub(super) start: Option<Arc<Kernel>>,
    /// Whole steps of one and of two evaluations from there, where there is a start, in 2 or 3 coordinates.
    pub(super) at_once: Option<[Arc<Kernel>; 2]>,
}

/// The code of where a solve starts: 2 Σ_{k odd} tᵏ Y_k(x), to be added to the solution before.
pub struct StartCode {
    /// The code.
    pub graph: Graph,
    /// d terms over the inputs x_0 … x_{d−1}.
    pub sums: Vec<Term>,
}

impl StartCode {
    /// Its kernel.
    pub fn kernel(&self, parameters: usize) -> Kernel {
        Kernel::compile(&self.graph, &self.sums, parameters, self.sums.len())
    }

    /// The kernel of some coordinates alone, over the same; `None` where it reads others.
    pub(super) fn share(&self, places: &[usize], parameters: usize) -> Option<Kernel> {
        let sums: Vec<Term> = places.iter().map(|at| self.sums[*at].clone()).collect();
        let mut read = self.graph.inputs_read(&sums).into_iter();
        let is_own = read.all(|input| places.contains(&input));
        is_own.then(|| Kernel::compile_from(&self.graph, &sums, parameters, places))
    }
}

impl NewtonKernel {
    /// Compiles the iteration for source and target code over the inputs y_0 … y_{d−1}.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a derivative has no code.
    pub fn compile(
        graph: &mut Graph,
        ends: &SourceTarget,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let inputs: Vec<usize> = (0..ends.base.len()).collect();
        Self::compile_from(graph, ends, parameters, &inputs)
    }

    /// The same where y is those inputs of the graph, and nothing reads others.
    pub(super) fn compile_from(
        graph: &mut Graph,
        ends: &SourceTarget,
        parameters: usize,
        inputs: &[usize],
    ) -> Result<Self, BuildError> {
        let d = inputs.len();
        let mut outputs: Vec<Term> = Vec::with_capacity(d * (3 + 2 * d) + 2 * d);
        let y: Vec<Term> = inputs.iter().map(|i| graph.input(*i)).collect();
        if ends.base != y {
            outputs.extend_from_slice(&ends.base);
        }
        let bases = outputs.len();
        outputs.extend_from_slice(&ends.offset);
        outputs.extend_from_slice(&ends.increment);
        let guard: Vec<Term> = match &ends.guard {
            Some((first, last)) => first.iter().chain(last).cloned().collect(),
            None => Vec::new(),
        };
        let guarded = [&outputs[..], &guard[..]].concat();
        for i in 0..d {
            for j in inputs {
                let base = graph.derivative(&ends.base[i], *j)?;
                let offset = graph.derivative(&ends.offset[i], *j)?;
                outputs.push(graph.add(&base, &offset));
            }
        }
        for i in 0..d {
            for j in inputs {
                outputs.push(graph.derivative(&ends.increment[i], *j)?);
            }
        }
        outputs.extend(guard);
        let [full, residual] =
            Kernel::compile_both(graph, [&outputs, &guarded], parameters, inputs);
        Ok(Self {
            full: Arc::new(full),
            residual: Arc::new(residual),
            dimension: d,
            bases,
            guards_series: false,
            start: None,
            at_once: None,
        })
    }

    /// The same where the guard may be of a series, whose terms of each coordinate have the unit of that.
    pub fn guarding_series(self, guards_series: bool) -> Self {
        Self {
            guards_series,
            ..self
        }
    }

    /// The same with solves that start from the solution before them and the odd part of the solution's series. In 2 or 3
    /// coordinates each then begins with a Jacobian of its own.
    pub fn starting_from(self, series: Option<Kernel>) -> Self {
        let at_once = match &series {
            Some(series) if matches!(self.dimension, 2 | 3) => {
                let [full, residual] = [&*self.full, &*self.residual];
                let step = |rest: &[&Kernel]| Arc::new(at_once(series, full, rest, self.bases));
                Some([step(&[]), step(&[residual])])
            }
            _ => None,
        };
        Self {
            start: series.map(Arc::new),
            at_once,
            ..self
        }
    }

    /// Operations of one Newton iteration, the linear solve apart.
    pub fn operations(&self) -> OperationCount {
        self.full.step_operations()
    }

    /// Operations of α̂ and β̂ along the bisection alone.
    pub fn residual_operations(&self) -> OperationCount {
        self.residual.step_operations()
    }

    /// Operations once for each choice of parameters and step sizes.
    pub fn coefficient_operations(&self) -> OperationCount {
        self.full.coefficient_operations()
    }

    /// The code of one Newton iteration: outputs base, unless it [is y](Self::base_is_point), β̂ − base, α̂ − β̂,
    /// D(β̂∘L), D((α̂ − β̂)∘L), and the guard's.
    pub fn kernel(&self) -> &Kernel {
        &self.full
    }

    /// The code of one iteration without Jacobians: outputs base, unless it [is y](Self::base_is_point), β̂ − base,
    /// α̂ − β̂, and the guard's.
    pub fn residual_kernel(&self) -> &Kernel {
        &self.residual
    }

    /// Whether base is y, and no output.
    pub fn base_is_point(&self) -> bool {
        self.bases == 0
    }

    /// The code of the start, 2 Σ_{k odd} tᵏ Y_k(x) to be added to the solution before, where there is one.
    pub fn start(&self) -> Option<&Kernel> {
        self.start.as_deref()
    }

    /// All kernels by name.
    pub fn kernels(&self) -> impl Iterator<Item = (&'static str, &Kernel)> {
        let steps = ["step of one evaluation", "step of two evaluations"];
        let at_once = self.at_once.iter().flatten().map(|kernel| &**kernel);
        let always = [
            ("Newton iteration", self.kernel()),
            ("residual alone", self.residual_kernel()),
        ];
        let start = self.start().map(|start| ("start of a solve", start));
        always
            .into_iter()
            .chain(start)
            .chain(steps.into_iter().zip(at_once))
    }

    /// Weighted operations of the start, 0 where it is extrapolated.
    pub fn start_work(&self) -> u64 {
        let start = self.start().map(|start| start.step_operations().work());
        start.unwrap_or(0)
    }

    /// Weighted operations of one Newton iteration with its linear solve.
    pub fn work(&self) -> u64 {
        let d = self.dimension;
        self.operations().work() + elimination_operations(d) + substitution_operations(d)
    }

    /// Cost of an iteration with a new Jacobian over that of one with the kept Jacobian, rounded down. Kernels, linear
    /// algebra and the judgement of the correction count in both.
    pub fn most_chords(&self) -> u32 {
        let judging = self.judging_work();
        u32::try_from((self.work() + judging) / (self.chord_work() + judging)).unwrap_or(u32::MAX)
    }

    /// Most operations that the series of the solution may take as the start of a solve. They are those of
    /// extrapolation and of an iteration: half of one with a new Jacobian, or one with the kept Jacobian if that is more.
    pub fn worth_of_start(&self) -> u64 {
        let new = self.operations().work() / 2;
        let old = self.chord_work() + self.judging_work();
        new.max(old) + EXTRAPOLATION * self.dimension as u64
    }

    /// Operations of judging a correction, 5d² + 25d + 20.
    fn judging_work(&self) -> u64 {
        let d = self.dimension as u64;
        5 * d * d + 25 * d + 20
    }

    /// Weighted operations of an iteration with a Jacobian that is there.
    pub fn chord_work(&self) -> u64 {
        self.residual_operations().work() + substitution_operations(self.dimension)
    }
}
