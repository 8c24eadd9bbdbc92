//! Evaluators made of straight-line code, for parts that meet one that computes numbers.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Kernel, StepSize, Term, Workspace};

use crate::error::{BuildError, StepError};
use crate::evaluator::{Evaluator, is_same, one_by_one};
use crate::one_form::PointCode;
use crate::point_kernel::PointKernel;
use crate::realization::{Accuracy, EndMaps, EndNumbers, MapCode, RealizationData};
use leafwise_solver::judge::{at_most, inside_chart, larger, ratio_in_own_units};

/// The reason where α̂ and β̂ cannot be evaluated.
pub(crate) const NO_MAPS: &str = "it offers neither code nor numbers for its maps";

/// An evaluator of any realization's maps: one compiled from its code, or its own evaluator.
///
/// # Errors
/// Those of [`RealizationMaps::new`].
pub fn realization_evaluator(
    realization: &dyn RealizationData,
    parameters: &[f64],
    epsilon: f64,
) -> Result<Box<dyn Evaluator>, BuildError> {
    Ok(RealizationMaps::new(realization, parameters.len())?.evaluator(parameters, epsilon))
}

/// Whether a realization's guard is of a series that is cut off, and not a radius.
pub(crate) fn guards_series(realization: &dyn RealizationData) -> bool {
    matches!(realization.accuracy(), Accuracy::Order(_))
}

/// The maps of any realization, compiled where they are code.
#[derive(Clone)]
pub struct RealizationMaps {
    ends: CompiledEnds,
}

#[derive(Clone)]
enum CompiledEnds {
    Code(CodeRealization),
    Numbers(EndNumbers),
}

impl std::fmt::Debug for RealizationMaps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self.ends {
            CompiledEnds::Code(_) => "kernels",
            CompiledEnds::Numbers(_) => "numbers",
        })
    }
}

impl RealizationMaps {
    /// The maps for a system with so many parameters.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization offers neither code nor numbers, [`BuildError::Algebra`] where
    /// its code cannot be differentiated.
    pub fn new(realization: &dyn RealizationData, parameters: usize) -> Result<Self, BuildError> {
        let ends = match realization.abilities().ends {
            Some(EndMaps::Numbers(numbers)) => CompiledEnds::Numbers(numbers),
            Some(EndMaps::Code(code)) => {
                let shape = [realization.dimension(), realization.space_dimension()];
                let of_series = guards_series(realization);
                let code = CodeRealization::compile(&code, shape, parameters, of_series)?;
                CompiledEnds::Code(code)
            }
            None => {
                return Err(BuildError::Incompatible {
                    dynamics: "an evaluation".to_owned(),
                    realization: realization.describe(),
                    reason: NO_MAPS.to_owned(),
                });
            }
        };
        Ok(Self { ends })
    }

    /// Whether their Jacobians are offered: those of code are.
    pub fn has_jacobian(&self) -> bool {
        match &self.ends {
            CompiledEnds::Code(_) => true,
            CompiledEnds::Numbers(numbers) => numbers.has_jacobian,
        }
    }

    /// Whether their [Hessians](Evaluator::hessian) are offered, as [`EndNumbers::has_hessian`].
    pub fn has_hessian(&self) -> bool {
        match &self.ends {
            CompiledEnds::Code(_) => false,
            CompiledEnds::Numbers(numbers) => numbers.has_hessian(),
        }
    }

    /// Whether trajectories may share an evaluator, as [`EndNumbers::is_pointwise`].
    pub(crate) fn is_pointwise(&self) -> bool {
        match &self.ends {
            CompiledEnds::Code(_) => true,
            CompiledEnds::Numbers(numbers) => numbers.is_pointwise,
        }
    }

    /// The kernels of maps that are code.
    pub(crate) fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        match &self.ends {
            CompiledEnds::Code(code) => code.kernels().to_vec(),
            CompiledEnds::Numbers(_) => Vec::new(),
        }
    }

    /// An evaluator for fixed parameters and ε.
    pub fn evaluator(&self, parameters: &[f64], epsilon: f64) -> Box<dyn Evaluator> {
        match &self.ends {
            CompiledEnds::Code(code) => code.evaluator(parameters, epsilon),
            CompiledEnds::Numbers(numbers) => numbers.evaluator(parameters, epsilon),
        }
    }

    /// The way to the edge of the chart; `None` for maps of numbers, which say it where they fail.
    pub fn chart_ratio(&self, parameters: &[f64], epsilon: f64) -> Option<ChartRatio> {
        match &self.ends {
            CompiledEnds::Code(code) => Some(ChartRatio(code.made(parameters, epsilon))),
            CompiledEnds::Numbers(_) => None,
        }
    }
}

/// How far a point reaches into a realization's chart, by its code.
pub struct ChartRatio(CodeRealizationEvaluator);

impl ChartRatio {
    /// The ratio at z, 1 at the edge: of a truncated series the last term over the first. Maps that hold everywhere have
    /// `None`.
    pub fn at(&mut self, z: &[f64]) -> Option<f64> {
        self.0.evaluate(z);
        self.0.chart_ratio()
    }
}

/// A realization's maps and their tangents as kernels of z.
#[derive(Clone, Debug)]
pub(crate) struct CodeRealization {
    ends: Arc<Kernel>,
    tangents: Arc<Kernel>,
    dimension: usize,
    /// Whether the guard is of a series, term by term of each coordinate.
    guards_series: bool,
}

impl CodeRealization {
    pub(crate) fn compile(
        code: &MapCode<'_>,
        [d, space]: [usize; 2],
        parameters: usize,
        guards_series: bool,
    ) -> Result<Self, BuildError> {
        let mut graph = Graph::compilable();
        let z: Vec<Term> = (0..space).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let code = code(&mut graph, &epsilon, &z)?;
        let mut outputs = [
            code.base.clone(),
            code.offset.clone(),
            code.increment.clone(),
        ]
        .concat();
        if let Some((first, last)) = &code.guard {
            outputs.extend_from_slice(first);
            outputs.extend_from_slice(last);
        }
        let ends = Kernel::compile(&graph, &outputs, parameters, space);
        let mut outputs = Vec::with_capacity(2 * d * space);
        for i in 0..d {
            let target = graph.add(&code.base[i], &code.offset[i]);
            for k in 0..space {
                outputs.push(graph.derivative(&target, k)?);
            }
        }
        for i in 0..d {
            for k in 0..space {
                outputs.push(graph.derivative(&code.increment[i], k)?);
            }
        }
        graph.unless_refused(())?;
        let tangents = Kernel::compile(&graph, &outputs, parameters, space);
        Ok(Self {
            ends: Arc::new(ends),
            tangents: Arc::new(tangents),
            dimension: d,
            guards_series,
        })
    }

    pub(crate) fn kernels(&self) -> [(&'static str, &Kernel); 2] {
        [
            ("source and target", &self.ends),
            ("tangents of source and target", &self.tangents),
        ]
    }

    pub(crate) fn evaluator(&self, parameters: &[f64], epsilon: f64) -> Box<dyn Evaluator> {
        Box::new(self.made(parameters, epsilon))
    }

    fn made(&self, parameters: &[f64], epsilon: f64) -> CodeRealizationEvaluator {
        CodeRealizationEvaluator {
            ends: prepared(&self.ends, parameters, epsilon, 1.0),
            tangents: PointKernel::new(&self.tangents, parameters, epsilon, 1.0),
            x: vec![0.0; self.dimension],
            work: self.ends.step_operations().work(),
            operations: 0,
            code: self.clone(),
        }
    }
}

fn prepared(kernel: &Kernel, parameters: &[f64], epsilon: f64, h: f64) -> Workspace {
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, parameters, &[epsilon], &[h]);
    workspace
}

fn write_input(workspace: &mut Workspace, values: &[f64]) {
    for (i, value) in values.iter().enumerate() {
        workspace.input_mut(i)[0] = *value;
    }
}

struct CodeRealizationEvaluator {
    code: CodeRealization,
    ends: Workspace,
    tangents: PointKernel,
    /// The base of the last point.
    x: Vec<f64>,
    /// Operations of one evaluation of the ends, and of all so far.
    work: u64,
    operations: u64,
}

impl CodeRealizationEvaluator {
    /// Evaluates the ends at z.
    fn evaluate(&mut self, z: &[f64]) {
        write_input(&mut self.ends, z);
        let d = self.x.len();
        self.x.copy_from_slice(&z[..d]);
        self.code.ends.evaluate_in_place(&mut self.ends);
        self.operations += self.work;
    }

    /// The ratio at the point of the last evaluation.
    fn chart_ratio(&self) -> Option<f64> {
        let from = 3 * self.code.dimension;
        let half = (self.code.ends.outputs() - from) / 2;
        let output = |index: usize| self.code.ends.output(&self.ends, index)[0];
        let size = |from: usize| (from..from + half).fold(0.0, |m, i| larger(m, output(i).abs()));
        let ratio = match (size(from), size(from + half)) {
            _ if half == 0 => return None,
            (_, 0.0) => 0.0,
            (first, last) => last / first,
        };
        if ratio < 1.0 || !self.code.guards_series || half != self.x.len() {
            return Some(ratio);
        }
        let pairs = (0..half).map(|i| [output(from + i), output(from + half + i)]);
        Some(at_most(ratio, ratio_in_own_units(&self.x, pairs)))
    }
}

impl Evaluator for CodeRealizationEvaluator {
    fn values(&mut self, z: &[f64], ends: &mut [f64]) -> Result<(), StepError> {
        one_by_one(self.code.ends.inputs(), z, ends, |z, ends| {
            self.evaluate(z);
            for (index, end) in ends.iter_mut().enumerate() {
                *end = self.code.ends.output(&self.ends, index)[0];
            }
            self.chart_ratio().map_or(Ok(()), inside_chart)?;
            if ends.iter().any(|end| !end.is_finite()) {
                return Err(StepError::NonFinite {
                    what: "an end of the realization",
                });
            }
            Ok(())
        })
    }

    fn jacobians(&mut self, z: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        self.tangents.evaluate(z, tangents);
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations + self.tangents.operations())
    }
}

/// A bisection and its tangent as a kernel of y.
#[derive(Clone, Debug)]
pub(crate) struct CodeBisection {
    kernel: Arc<Kernel>,
    space: usize,
}

impl CodeBisection {
    pub(crate) fn kernel(&self) -> (&'static str, &Kernel) {
        ("points of the bisection", &self.kernel)
    }

    pub(crate) fn compile(
        code: &PointCode<'_>,
        d: usize,
        space: usize,
        parameters: usize,
    ) -> Result<Self, BuildError> {
        let mut graph = Graph::compilable();
        let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let h = graph.step_size(StepSize::H);
        let mut outputs = code(&mut graph, &epsilon, &h, &y)?;
        for i in 0..space {
            let coordinate = outputs[i].clone();
            for j in 0..d {
                outputs.push(graph.derivative(&coordinate, j)?);
            }
        }
        graph.unless_refused(())?;
        let kernel = Kernel::compile(&graph, &outputs, parameters, d);
        Ok(Self {
            kernel: Arc::new(kernel),
            space,
        })
    }

    pub(crate) fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Evaluator> {
        let workspace = prepared(&self.kernel, parameters, epsilon, h);
        Box::new(CodeBisectionEvaluator {
            code: self.clone(),
            workspace,
            y: Vec::with_capacity(self.kernel.inputs()),
            work: self.kernel.step_operations().work(),
            operations: 0,
        })
    }
}

struct CodeBisectionEvaluator {
    code: CodeBisection,
    workspace: Workspace,
    /// The point that the kernel was evaluated at last; empty before.
    y: Vec<f64>,
    /// Operations of one evaluation, and of all so far.
    work: u64,
    operations: u64,
}

impl CodeBisectionEvaluator {
    fn evaluate(&mut self, y: &[f64]) {
        self.y.clear();
        self.y.extend_from_slice(y);
        write_input(&mut self.workspace, y);
        self.code.kernel.evaluate_in_place(&mut self.workspace);
        self.operations += self.work;
    }

    /// The kernel's outputs from `first` on.
    fn read(&self, first: usize, out: &mut [f64]) {
        for (index, value) in out.iter_mut().enumerate() {
            *value = self.code.kernel.output(&self.workspace, first + index)[0];
        }
    }
}

impl Evaluator for CodeBisectionEvaluator {
    fn values(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        one_by_one(self.code.kernel.inputs(), y, z, |y, z| {
            self.evaluate(y);
            self.read(0, z);
            Ok(())
        })
    }

    /// The kernel holds both: what was evaluated for the point is not evaluated again.
    fn jacobians(&mut self, y: &[f64], tangents: &mut [f64]) -> Result<(), StepError> {
        one_by_one(self.code.kernel.inputs(), y, tangents, |y, tangent| {
            if !is_same(&self.y, y) {
                self.evaluate(y);
            }
            self.read(self.code.space, tangent);
            Ok(())
        })
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}

#[cfg(test)]
mod tests {
    use leafwise_expression::Function;

    use super::*;
    use crate::realization::SourceTarget;

    /// β̂ = α̂ = x with a guard of two components, its radius √r beside √p reached.
    fn guarded(graph: &mut Graph, _: &Term, z: &[Term]) -> Result<SourceTarget, BuildError> {
        let zero = graph.zero();
        let reach = graph.apply(Function::Sqrt, &z[2])?;
        let radius = graph.apply(Function::Sqrt, &z[3])?;
        Ok(SourceTarget {
            base: z[..2].to_vec(),
            offset: vec![zero.clone(), zero.clone()],
            increment: vec![zero.clone(), zero.clone()],
            guard: Some((vec![radius, zero.clone()], vec![reach, zero])),
        })
    }

    #[test]
    fn a_guard_of_code_that_is_no_number_is_outside_the_chart() {
        let code: MapCode<'_> = Box::new(guarded);
        let code = CodeRealization::compile(&code, [2, 4], 0, false).expect("a kernel");
        let mut evaluator = code.evaluator(&[], 1.0);
        let mut ratio = ChartRatio(code.made(&[], 1.0));
        let mut ends = [0.0; 6];
        let mut at = |reach: f64, radius: f64| {
            let z = [3.0, 5.0, reach, radius];
            let found = evaluator.values(&z, &mut ends);
            (found, ratio.at(&z).expect("a guard"))
        };
        assert_eq!(at(1.0, 4.0), (Ok(()), 0.5));
        assert_eq!(at(0.0, 0.0), (Ok(()), 0.0));
        assert_eq!(
            at(4.0, 1.0),
            (Err(StepError::LeftChart { ratio: 2.0 }), 2.0)
        );
        for (reach, radius) in [
            (-1.0, 4.0),
            (1.0, -4.0),
            (f64::NAN, 4.0),
            (f64::INFINITY, f64::INFINITY),
        ] {
            let (found, ratio) = at(reach, radius);
            assert!(ratio.is_nan(), "{reach} of {radius}: {ratio}");
            let what = "the distance to the edge of the realization's chart";
            assert_eq!(
                found,
                Err(StepError::NonFinite { what }),
                "{reach} of {radius}"
            );
        }
    }
}
