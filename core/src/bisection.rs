//! Bisections, Lagrangian where maps are Poisson.

use std::sync::Arc;

use leafwise_expression::Kernel;

use crate::chart::ChartMaps;
use crate::code_evaluators::CodeBisection;
use crate::error::BuildError;
use crate::evaluator::Evaluator;
use crate::generating_function::Generating;
use crate::one_form::{GraphOfOneForm, OneForm, PointCode};
use crate::realization::RealizationData;
use crate::runge_kutta::SmoothMap;

/// A parametrization y ↦ L(y) ∈ S of a Lagrangian bisection, as what it is: y ↦ (y, dŜ(y)) for Hamilton–Jacobi,
/// y ↦ Σ_h(σ(y)) for a collective integrator. Of a one-form θ that is not closed, y ↦ (y, θ(y)) is none, and
/// [`is_lagrangian`](crate::DynamicsProperties::is_lagrangian) says so.
#[derive(Clone, Debug)]
pub enum LagrangianBisection {
    /// y ↦ χ(y, θ(y)), the graph of a one-form in the realization's chart.
    Graph(Arc<GraphBisection>),
    /// y ↦ L(y) as numbers.
    Points {
        /// y ↦ L(y), from the d coordinates y to the d_S coordinates of L(y).
        map: SmoothMap,
        /// Whether D(β̂∘L) is so near the identity that the residual serves as the correction.
        is_near_identity: bool,
    },
    /// The image of the section under a Gauss method in the coordinates of a [`Lift`](crate::lift::Lift), which makes the
    /// whole step: nothing is solved for its start. The realization has such a lift.
    Lifted {
        /// 1 to [`Tableau::MOST_STAGES`](crate::runge_kutta::Tableau::MOST_STAGES).
        stages: usize,
    },
}

/// y ↦ χ(y, θ_{ε,h}(y)), χ the realization's chart about σ; (y, θ(y)) itself on T*M.
#[derive(Clone, Debug)]
pub struct GraphBisection {
    form: OneForm,
    realization: Arc<dyn RealizationData>,
    /// y ↦ χ(y, θ(y)) as numbers, where θ or χ has no code.
    numbers: Option<SmoothMap>,
}

impl GraphBisection {
    /// θ.
    pub fn form(&self) -> &OneForm {
        &self.form
    }

    /// y ↦ χ(y, θ(y)) as code, where θ and χ are code.
    pub(crate) fn code(&self) -> Option<PointCode<'_>> {
        let form = self.form.code().ok()?;
        if self.numbers.is_some() {
            return None;
        }
        Some(Box::new(move |graph, epsilon, h, y| {
            let p = form(graph, epsilon, h, y)?;
            match self.realization.abilities().space.chart_code() {
                None => Ok(y.iter().cloned().chain(p).collect()),
                Some(chart) => chart(graph, epsilon, y, &p),
            }
        }))
    }

    /// The same as numbers, where one of them has no code.
    pub(crate) fn numbers(&self) -> Option<&SmoothMap> {
        self.numbers.as_ref()
    }
}

impl LagrangianBisection {
    /// The graph of a one-form over a realization, for a system with this number of parameters. Messages call the
    /// approximation `dynamics`.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has no chart about its section. A derivative without code gives
    /// [`BuildError::Algebra`].
    pub fn graph(
        form: OneForm,
        realization: &Arc<dyn RealizationData>,
        parameters: usize,
        dynamics: &str,
    ) -> Result<Self, BuildError> {
        let chart_has_code = realization.abilities().space.has_code();
        let numbers = if chart_has_code && form.code().is_ok() {
            None
        } else {
            let chart = ChartMaps::of(realization.as_ref(), parameters)?;
            let chart = chart.ok_or_else(|| BuildError::Incompatible {
                dynamics: dynamics.to_owned(),
                realization: realization.describe(),
                reason: "it has no symplectic chart about its section, which a one-form needs"
                    .to_owned(),
            })?;
            let (d, space) = (realization.dimension(), realization.space_dimension());
            Some(graph_of(form.map(d, parameters)?, chart, [d, space]))
        };
        Ok(Self::Graph(Arc::new(GraphBisection {
            form,
            realization: Arc::clone(realization),
            numbers,
        })))
    }

    /// The same of a form that is odd in h: its map is self-adjoint only with β̂(x, p) = α̂(x, −p) (paper, Proposition 1).
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization has no such chart, and those of [`graph`](Self::graph).
    pub fn odd_graph(
        form: OneForm,
        realization: &Arc<dyn RealizationData>,
        parameters: usize,
        dynamics: &str,
    ) -> Result<Self, BuildError> {
        if !realization.abilities().is_reversible {
            return Err(BuildError::Incompatible {
                dynamics: dynamics.to_owned(),
                realization: realization.describe(),
                reason: "beta(x, p) is not alpha(x, -p) there, so that even coefficients of S do \
                         not vanish"
                    .to_owned(),
            });
        }
        Self::graph(form, realization, parameters, dynamics)
    }

    /// y ↦ L(y) as straight-line code: of a graph whose one-form and chart are code.
    pub fn code(&self) -> Option<PointCode<'_>> {
        match self {
            Self::Graph(graph) => graph.code(),
            _ => None,
        }
    }

    /// The generating function, where L is the graph of dŜ.
    pub fn generating_function(&self) -> Option<&Generating> {
        match self {
            Self::Graph(graph) => match graph.form() {
                OneForm::Differential(generating) => Some(generating),
                _ => None,
            },
            _ => None,
        }
    }

    /// y ↦ L(y) in a space of `space` coordinates over `d`, compiled where it is code; `None` for coordinates of a lift.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the code has no derivative.
    pub(crate) fn points(
        &self,
        [d, space]: [usize; 2],
        parameters: usize,
    ) -> Result<Option<PointMaps>, BuildError> {
        let numbers = match self {
            Self::Graph(graph) => graph.numbers(),
            Self::Points { map, .. } => Some(map),
            Self::Lifted { .. } => None,
        };
        Ok(match (numbers, self.code()) {
            (Some(map), _) => Some(PointMaps::Numbers(map.clone())),
            (None, Some(code)) => {
                let code = CodeBisection::compile(&code, d, space, parameters)?;
                Some(PointMaps::Code(code))
            }
            (None, None) => None,
        })
    }
}

/// y ↦ L(y) in numbers.
#[derive(Clone, Debug)]
pub(crate) enum PointMaps {
    Code(CodeBisection),
    Numbers(SmoothMap),
}

impl PointMaps {
    pub(crate) fn has_jacobian(&self) -> bool {
        match self {
            Self::Code(_) => true,
            Self::Numbers(map) => map.has_jacobian(),
        }
    }

    pub(crate) fn is_pointwise(&self) -> bool {
        match self {
            Self::Code(_) => true,
            Self::Numbers(map) => map.is_pointwise(),
        }
    }

    pub(crate) fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Evaluator> {
        match self {
            Self::Code(code) => code.evaluator(parameters, epsilon, h),
            Self::Numbers(map) => Box::new(map.evaluator(parameters, epsilon, h)),
        }
    }

    pub(crate) fn kernel(&self) -> Option<(&'static str, &Kernel)> {
        match self {
            Self::Code(code) => Some(code.kernel()),
            Self::Numbers(_) => None,
        }
    }
}

/// y ↦ χ(y, θ(y)) in a space of `space` coordinates over `d`.
fn graph_of(form: SmoothMap, chart: ChartMaps, [d, space]: [usize; 2]) -> SmoothMap {
    let has_jacobian = form.has_jacobian() && chart.has_jacobian();
    let is_pointwise = form.is_pointwise() && chart.is_pointwise();
    let graph = SmoothMap::from_numbers(d, space, has_jacobian, move |parameters, epsilon, h| {
        let form = Box::new(form.evaluator(parameters, epsilon, h));
        let chart = chart.evaluator(parameters, epsilon);
        Box::new(GraphOfOneForm::new(form, chart, d, space))
    });
    match is_pointwise {
        true => graph,
        false => graph.for_one_trajectory(),
    }
}
