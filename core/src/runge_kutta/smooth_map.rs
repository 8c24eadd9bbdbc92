//! Maps and their Jacobians: as kernels, or as numbers of whatever computes them.

use std::sync::Arc;

use leafwise_expression::{Graph, Kernel, Term, Workspace};
use leafwise_solver::batch;

use super::jacobian::Jacobian;
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::point_kernel::PointKernel;

/// A map z ↦ F(z), and z ↦ DF(z) where that is offered.
#[derive(Clone)]
pub struct SmoothMap {
    source: Source,
    inputs: usize,
    outputs: usize,
}

#[derive(Clone)]
enum Source {
    Kernels {
        value: Arc<Kernel>,
        jacobian: Option<Arc<Jacobian>>,
    },
    Numbers {
        make: Arc<MakeMap>,
        has_jacobian: bool,
        is_pointwise: bool,
        side_by_side: Option<Arc<MakeSideBySide>>,
    },
}

type MakeMap = dyn Fn(&[f64], f64, f64) -> Box<dyn Evaluator> + Send + Sync;
type MakeSideBySide = dyn Fn(&[f64], usize) -> Box<dyn Evaluator> + Send + Sync;

/// F at points side by side: a kernel with its workspace, or numbers.
pub(super) enum SideBySide {
    Kernel(Arc<Kernel>, Workspace),
    Numbers(Box<dyn Evaluator>),
}

impl std::fmt::Debug for SmoothMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let source = match &self.source {
            Source::Kernels { .. } => "kernels",
            Source::Numbers { .. } => "numbers",
        };
        f.debug_struct("SmoothMap")
            .field("source", &source)
            .field("inputs", &self.inputs)
            .field("outputs", &self.outputs)
            .finish_non_exhaustive()
    }
}

impl SmoothMap {
    /// The kernels of the values and the Jacobian, for reports; none of a map given by numbers. Forms the Jacobian where no
    /// evaluator has asked for it.
    pub fn kernels(&self) -> Vec<(&'static str, &Kernel)> {
        let jacobian = match &self.source {
            Source::Kernels { jacobian, .. } => jacobian.as_ref().and_then(|own| own.kernel()),
            Source::Numbers { .. } => None,
        };
        let jacobian = jacobian.map(|kernel| ("its Jacobian", kernel.as_ref()));
        let values = self.value_kernel().map(|kernel| ("values", kernel));
        values.into_iter().chain(jacobian).collect()
    }

    /// The kernel of the values alone.
    pub(crate) fn value_kernel(&self) -> Option<&Kernel> {
        match &self.source {
            Source::Kernels { value, .. } => Some(value),
            Source::Numbers { .. } => None,
        }
    }

    /// Compiles `outputs` over the graph's first `inputs` inputs. Their derivatives are compiled when these are first
    /// needed.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a derivative has no code, [`BuildError::TooManyVariables`] for a
    /// Jacobian that no step's equations have.
    pub fn compile(
        graph: impl Into<Arc<Graph>>,
        outputs: &[Term],
        parameters: usize,
        inputs: usize,
    ) -> Result<Self, BuildError> {
        let graph = graph.into();
        let jacobian = Jacobian::new(Arc::clone(&graph), outputs, parameters, inputs).proven()?;
        Ok(Self::compile_values(&graph, outputs, parameters, inputs).with_jacobian(jacobian))
    }

    /// The same where a Jacobian that is refused stops nothing: [`StepError::NoTangent`] says so when it is asked for.
    pub fn compile_unproven(
        graph: impl Into<Arc<Graph>>,
        outputs: &[Term],
        parameters: usize,
        inputs: usize,
    ) -> Self {
        let graph = graph.into();
        let jacobian = Jacobian::new(Arc::clone(&graph), outputs, parameters, inputs);
        Self::compile_values(&graph, outputs, parameters, inputs).with_jacobian(jacobian)
    }

    /// The same without derivatives, for methods that need none.
    pub fn compile_values(
        graph: &Graph,
        outputs: &[Term],
        parameters: usize,
        inputs: usize,
    ) -> Self {
        let value = Kernel::compile(graph, outputs, parameters, inputs);
        Self {
            source: Source::Kernels {
                value: Arc::new(value),
                jacobian: None,
            },
            inputs,
            outputs: outputs.len(),
        }
    }

    fn with_jacobian(mut self, formed: Jacobian) -> Self {
        if let Source::Kernels { jacobian, .. } = &mut self.source {
            *jacobian = Some(Arc::new(formed));
        }
        self
    }

    /// A map of numbers: `make` makes its evaluator for parameters, ε and h.
    pub fn from_numbers(
        inputs: usize,
        outputs: usize,
        has_jacobian: bool,
        make: impl Fn(&[f64], f64, f64) -> Box<dyn Evaluator> + Send + Sync + 'static,
    ) -> Self {
        Self {
            source: Source::Numbers {
                make: Arc::new(make),
                has_jacobian,
                is_pointwise: true,
                side_by_side: None,
            },
            inputs,
            outputs,
        }
    }

    /// The same with F at points side by side: of parameters, and of the number of points.
    #[must_use]
    pub fn with_side_by_side(
        mut self,
        make: impl Fn(&[f64], usize) -> Box<dyn Evaluator> + Send + Sync + 'static,
    ) -> Self {
        if let Source::Numbers { side_by_side, .. } = &mut self.source {
            *side_by_side = Some(Arc::new(make));
        }
        self
    }

    /// The same where an evaluator's result depends on its earlier ones: no two trajectories share it.
    #[must_use]
    pub fn for_one_trajectory(mut self) -> Self {
        if let Source::Numbers { is_pointwise, .. } = &mut self.source {
            *is_pointwise = false;
        }
        self
    }

    /// Whether the result at a point depends on that point alone, bit for bit: trajectories with the same parameters may
    /// then share an evaluator.
    pub fn is_pointwise(&self) -> bool {
        match &self.source {
            Source::Kernels { .. } => true,
            Source::Numbers { is_pointwise, .. } => *is_pointwise,
        }
    }

    /// The number of coordinates of z.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// The number of components of F.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Whether DF is offered.
    pub fn has_jacobian(&self) -> bool {
        match &self.source {
            Source::Kernels { jacobian, .. } => jacobian.is_some(),
            Source::Numbers { has_jacobian, .. } => *has_jacobian,
        }
    }

    /// Whether the code of DF was formed or tried already.
    #[cfg(test)]
    pub(super) fn has_formed_jacobian(&self) -> bool {
        match &self.source {
            Source::Kernels { jacobian, .. } => {
                jacobian.as_ref().is_some_and(|own| own.is_formed())
            }
            Source::Numbers { .. } => false,
        }
    }

    /// An evaluator for fixed parameters, ε and h.
    pub fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> SmoothMapEvaluator {
        SmoothMapEvaluator {
            map: self.clone(),
            evaluator: self.source.evaluator(parameters, epsilon, h),
            parameters: parameters.to_vec(),
            steps: [epsilon, h],
        }
    }
}

impl Source {
    fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> SourceEvaluator {
        match self {
            Self::Kernels { value, jacobian } => {
                SourceEvaluator::Kernels(Box::new(KernelEvaluator {
                    value: PointKernel::new(value, parameters, epsilon, h),
                    jacobian: jacobian.clone(),
                    slopes: None,
                }))
            }
            Self::Numbers { make, .. } => SourceEvaluator::Numbers(make(parameters, epsilon, h)),
        }
    }
}

/// A map at fixed parameters, ε and h.
#[derive(Clone, Copy)]
pub(crate) struct MapAt<'a> {
    /// The map.
    pub map: &'a SmoothMap,
    /// Its parameters.
    pub parameters: &'a [f64],
    /// ε and h.
    pub steps: [f64; 2],
}

impl MapAt<'_> {
    /// F at so many points side by side; `None` of a map of numbers that does not offer it.
    pub(super) fn side_by_side(self, points: usize) -> Option<SideBySide> {
        let value = match &self.map.source {
            Source::Kernels { value, .. } => value,
            Source::Numbers { side_by_side, .. } => {
                let make = side_by_side.as_ref()?;
                return Some(SideBySide::Numbers(make(self.parameters, points)));
            }
        };
        let mut workspace = value.workspace(points);
        let own = |value: &f64| std::iter::repeat_n(*value, points);
        let parameters: Vec<f64> = self.parameters.iter().flat_map(own).collect();
        let [epsilon, h] = self.steps.map(|step| vec![step; points]);
        value.prepare(&mut workspace, &parameters, &epsilon, &h);
        Some(SideBySide::Kernel(Arc::clone(value), workspace))
    }
}

struct KernelEvaluator {
    value: PointKernel,
    jacobian: Option<Arc<Jacobian>>,
    /// The evaluator of DF, from the first call on that asks for it.
    slopes: Option<PointKernel>,
}

impl KernelEvaluator {
    fn set_parameters(&mut self, parameters: &[f64]) {
        self.value.set_parameters(parameters);
        if let Some(slopes) = &mut self.slopes {
            slopes.set_parameters(parameters);
        }
    }

    #[cold]
    fn begin_slopes(&self) -> Result<PointKernel, StepError> {
        let kernel = self.jacobian.as_ref().and_then(|own| own.kernel());
        Ok(self.value.at_the_same(kernel.ok_or(StepError::NoTangent)?))
    }
}

impl Evaluator for KernelEvaluator {
    #[inline]
    fn values(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.value.evaluate(z, out);
        Ok(())
    }

    #[inline]
    fn jacobians(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        if self.slopes.is_none() {
            self.slopes = Some(self.begin_slopes()?);
        }
        if let Some(slopes) = &mut self.slopes {
            slopes.evaluate(z, out);
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        let slopes = self.slopes.as_ref().map_or(0, PointKernel::operations);
        Some(self.value.operations() + slopes)
    }
}

/// The evaluator of a [`Source`].
enum SourceEvaluator {
    Kernels(Box<KernelEvaluator>),
    Numbers(Box<dyn Evaluator>),
}

impl SourceEvaluator {
    #[inline]
    fn get(&self) -> &dyn Evaluator {
        match self {
            Self::Kernels(own) => own.as_ref(),
            Self::Numbers(own) => own.as_ref(),
        }
    }

    #[inline]
    fn get_mut(&mut self) -> &mut dyn Evaluator {
        match self {
            Self::Kernels(own) => own.as_mut(),
            Self::Numbers(own) => own.as_mut(),
        }
    }
}

/// One thread's evaluator of a [`SmoothMap`].
pub struct SmoothMapEvaluator {
    map: SmoothMap,
    evaluator: SourceEvaluator,
    parameters: Vec<f64>,
    /// ε and h.
    steps: [f64; 2],
}

impl SmoothMapEvaluator {
    /// The map.
    pub fn map(&self) -> &SmoothMap {
        &self.map
    }

    /// Takes other parameters: evaluations have the bits of those of a new evaluator. Kernels stay as they are, an evaluator of
    /// numbers is made anew.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        self.parameters.copy_from_slice(parameters);
        match &mut self.evaluator {
            SourceEvaluator::Kernels(own) => own.set_parameters(parameters),
            SourceEvaluator::Numbers(_) => {
                let [epsilon, h] = self.steps;
                self.evaluator = self.map.source.evaluator(parameters, epsilon, h);
            }
        }
    }

    /// The map with the numbers that it is evaluated for.
    pub(super) fn at(&self) -> MapAt<'_> {
        MapAt {
            map: &self.map,
            parameters: &self.parameters,
            steps: self.steps,
        }
    }

    /// F at several points in one call. Where that fails, F is evaluated at one point after the other. The points
    /// that fail are handed over, with their place in `out` unspecified.
    ///
    /// # Panics
    /// When a slice is not that of a whole number of points.
    pub fn each_value(&mut self, z: &[f64], out: &mut [f64], failed: impl FnMut(usize, StepError)) {
        let shape = (self.map.inputs, self.map.outputs);
        batch(shape, z, out, failed, |z, out| self.values(z, out));
    }

    /// DF at several points, as [`each_value`](Self::each_value).
    ///
    /// # Panics
    /// When a slice is not that of a whole number of points.
    pub fn each_jacobian(
        &mut self,
        z: &[f64],
        out: &mut [f64],
        failed: impl FnMut(usize, StepError),
    ) {
        let shape = (self.map.inputs, self.map.outputs * self.map.inputs);
        batch(shape, z, out, failed, |z, out| self.jacobians(z, out));
    }
}

impl Evaluator for SmoothMapEvaluator {
    #[inline]
    fn values(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluator.get_mut().values(z, out)
    }

    #[inline]
    fn jacobians(&mut self, z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        self.evaluator.get_mut().jacobians(z, out)
    }

    fn approach(&mut self, begins: bool, z: &[f64], out: &mut [f64]) -> Result<bool, StepError> {
        self.evaluator.get_mut().approach(begins, z, out)
    }

    fn operations(&self) -> Option<u64> {
        self.evaluator.get().operations()
    }

    fn restart(&mut self) {
        self.evaluator.get_mut().restart();
    }

    fn memory(&self) -> Vec<f64> {
        self.evaluator.get().memory()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.evaluator.get_mut().restore(memory);
    }
}
