//! Realization and dynamic approximation combined into a step map.

use std::sync::{Arc, OnceLock};

use leafwise_expression::{AlgebraError, Graph, Kernel, StepSize, Term};

use crate::bisection::{LagrangianBisection, PointMaps};
use crate::code_evaluators::{ChartRatio, NO_MAPS, RealizationMaps, guards_series};
use crate::dynamics::{Correction, DynamicApproximation};
use crate::error::BuildError;
use crate::evaluator::Evaluator;
use crate::generating_shadow::shadow_of;
use crate::lift::LiftedMap;
use crate::one_form::PointCode;
use crate::part::PartParameters;
use crate::realization::{Abilities, Accuracy, MapCode, RealizationData, SourceTarget};
use crate::registry::Registry;
use crate::solution_series::start_of_solves;
use crate::solver::{
    ByTangents, Checked, CorrectionMethod, Differential, Lanes, MakeCheck, MapAbilities,
    MapProperties, NewtonKernel, NewtonStepper, NumericSolver, Poles, ShadowTerms, Solved, StepMap,
    Stepper, Structure, Uncoupled, Walls, by_parameters, check_variables, keeping_signs,
    kept_signs,
};
use crate::step_map::of_one_length;
use crate::system::PoissonSystem;

/// φ̂_{ε,h} = α̂_ε ∘ (β̂_ε|_L)⁻¹ (paper, Definition 2.4 and Algorithm 1): given x_k, find y with
/// β̂(L(y)) = x_k and return x_{k+1} = x_k + (α̂ − β̂)(L(y)).
#[derive(Clone, Debug)]
pub struct Method {
    realization: Arc<dyn RealizationData>,
    dynamics: Arc<dyn DynamicApproximation>,
    bisection: LagrangianBisection,
    path: Path,
    /// Coordinates whose sign every step keeps.
    kept_signs: Vec<usize>,
    /// Poles of the equations of motion, which no step crosses.
    poles: Option<Arc<Poles>>,
    /// Tables of the system, which no step leaves.
    walls: Option<Arc<Walls>>,
    /// The derivatives by parameters of both ends, compiled when the first differential is asked for.
    by_parameters: Arc<OnceLock<Option<Arc<Kernel>>>>,
}

/// A method's two parts as numbers, for fixed parameters, ε and h.
pub struct MethodEvaluators {
    /// α̂ and β̂.
    pub maps: Box<dyn Evaluator>,
    /// y ↦ L(y).
    pub points: Box<dyn Evaluator>,
    /// How far a point reaches into the chart of maps that are code.
    pub chart: Option<ChartRatio>,
}

/// The reason where y ↦ L(y) cannot be evaluated.
const NO_POINTS: &str = "the bisection offers neither code nor numbers";

/// The reason where a bisection is one of a lift that is not there.
const NO_LIFT: &str =
    "it steps in coordinates with a constant tensor, and the realization has no lift into such";

/// Subject of the message where a step has another length than those that the dynamics holds for.
const THE_FUNCTION: &str = "the generating function";

/// How a step is computed.
#[derive(Clone)]
enum Path {
    /// Both parts are code: one kernel for a Newton iteration, or several where its equations are uncoupled.
    Code(NewtonKernel, Option<Uncoupled>),
    /// The realization brought its own solve.
    Fused(Arc<dyn StepMap>),
    /// At least one part computes numbers.
    Evaluators {
        maps: RealizationMaps,
        points: PointMaps,
        /// Whether several trajectories share both evaluators.
        together: bool,
    },
}

impl std::fmt::Debug for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Code(..) => "one kernel",
            Self::Fused(_) => "fused",
            Self::Evaluators { .. } => "evaluators",
        })
    }
}

impl Method {
    /// Composes parts by their names, each with its default parameters, on a system:
    /// `Method::of(&registry, &system, "so3-exponential", "hamilton-jacobi")`.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] for a name that the registry does not have. Further errors are those of the parts
    /// and of [`compose`](Self::compose).
    pub fn of(
        registry: &Registry,
        system: &PoissonSystem,
        realization: &str,
        dynamics: &str,
    ) -> Result<Self, BuildError> {
        let none = PartParameters::new();
        let realization = registry.realization(realization)?.build(system, &none)?;
        let dynamics = registry.dynamics(dynamics)?.build(&none)?;
        Self::compose(system, realization, dynamics)
    }

    /// Combines the two approximations for a system and compiles what its steps need. It takes the shortest path: one
    /// fused solve, one kernel, or evaluators.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization lacks what the bisection needs. A formula without code gives
    /// [`BuildError::Algebra`], and formulas in too many variables give [`BuildError::TooManyVariables`]. Forces that
    /// the dynamics does not take give [`BuildError::Forces`].
    pub fn compose(
        system: &PoissonSystem,
        realization: Arc<dyn RealizationData>,
        dynamics: Arc<dyn DynamicApproximation>,
    ) -> Result<Self, BuildError> {
        check_forces(system, dynamics.as_ref())?;
        check_lift(realization.as_ref(), dynamics.as_ref())?;
        let solves = dynamics.properties().correction == Correction::Bisection;
        let is_lifted = realization.abilities().lift.is_some();
        if solves && !is_lifted && system.expressions().is_some() {
            check_variables(system.dimension())?;
        }
        let bisection = dynamics.bisection(system, &realization)?;
        let properties = properties_of(realization.as_ref(), dynamics.as_ref());
        let fused: Option<Arc<dyn StepMap>> = match (&bisection, realization.abilities()) {
            (
                LagrangianBisection::Lifted { stages },
                Abilities {
                    lift: Some(lift), ..
                },
            ) => {
                let name = realization.describe();
                let map = LiftedMap::new(lift, &name, system, *stages, properties)?;
                Some(Arc::new(map))
            }
            (
                LagrangianBisection::Graph(graph),
                Abilities {
                    fused: Some(fused), ..
                },
            ) if solves => Some(fused(system, graph.form(), properties)?),
            _ => None,
        };
        if let Some(fused) = fused {
            let path = Path::Fused(fused);
            return Ok(Self {
                kept_signs: kept_by(system, properties),
                poles: Poles::of(system)?.map(Arc::new),
                walls: Walls::of(system)?.map(Arc::new),
                realization,
                dynamics,
                bisection,
                path,
                by_parameters: Arc::default(),
            });
        }
        Self::compose_generic(system, realization, dynamics, bisection)
    }

    /// The same without a realization's own fused solve: for cross-checks.
    ///
    /// # Errors
    /// Those of [`Method::compose`].
    pub fn compose_unfused(
        system: &PoissonSystem,
        realization: Arc<dyn RealizationData>,
        dynamics: Arc<dyn DynamicApproximation>,
    ) -> Result<Self, BuildError> {
        check_forces(system, dynamics.as_ref())?;
        check_lift(realization.as_ref(), dynamics.as_ref())?;
        let bisection = dynamics.bisection(system, &realization)?;
        Self::compose_generic(system, realization, dynamics, bisection)
    }

    fn compose_generic(
        system: &PoissonSystem,
        realization: Arc<dyn RealizationData>,
        dynamics: Arc<dyn DynamicApproximation>,
        bisection: LagrangianBisection,
    ) -> Result<Self, BuildError> {
        let (d, parameters) = (system.dimension(), system.parameters().len());
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: dynamics.describe(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        let path = match (realization.abilities().code(), bisection.code()) {
            (Some(ends), Some(points))
                if dynamics.properties().correction == Correction::Bisection =>
            {
                let (mut graph, ends) = code_along(d, &ends, &points)?;
                let kernel = graph.unless_refused(()).map_err(BuildError::from);
                let kernel =
                    kernel.and_then(|()| NewtonKernel::compile(&mut graph, &ends, parameters));
                let kernel = kernel.map_err(|error| match error {
                    BuildError::Algebra(too_long @ AlgebraError::CodeTooLong { .. }) => missing(
                        &format!("{too_long}; take lower orders, or a stepper in place of both"),
                    ),
                    other => other,
                })?;
                let start = start_of_solves(
                    realization.as_ref(),
                    &bisection,
                    parameters,
                    kernel.worth_of_start(),
                )?;
                let of_series = guards_series(realization.as_ref());
                let kernel = kernel.guarding_series(of_series);
                let uncoupled = Uncoupled::compile(&mut graph, &ends, start.as_ref(), parameters)?
                    .map(|uncoupled| uncoupled.guarding_series(of_series));
                let start = start.map(|start| start.kernel(parameters));
                Path::Code(kernel.starting_from(start), uncoupled)
            }
            _ => {
                if realization.abilities().ends.is_none() {
                    return Err(missing(NO_MAPS));
                }
                let maps = RealizationMaps::new(realization.as_ref(), parameters)?;
                let space = realization.space_dimension();
                let points =
                    bisection
                        .points([d, space], parameters)?
                        .ok_or_else(|| match bisection {
                            LagrangianBisection::Lifted { .. } => missing(NO_LIFT),
                            _ => missing(NO_POINTS),
                        })?;
                Path::Evaluators {
                    together: maps.is_pointwise() && points.is_pointwise(),
                    maps,
                    points,
                }
            }
        };
        let properties = properties_of(realization.as_ref(), dynamics.as_ref());
        Ok(Self {
            kept_signs: kept_by(system, properties),
            poles: Poles::of(system)?.map(Arc::new),
            walls: Walls::of(system)?.map(Arc::new),
            realization,
            dynamics,
            bisection,
            path,
            by_parameters: Arc::default(),
        })
    }

    /// The geometric approximation R̂_ε.
    pub fn realization(&self) -> &dyn RealizationData {
        self.realization.as_ref()
    }

    /// The geometric approximation, for other methods over it.
    pub fn shared_realization(&self) -> Arc<dyn RealizationData> {
        Arc::clone(&self.realization)
    }

    /// The dynamic approximation.
    pub fn dynamics(&self) -> &dyn DynamicApproximation {
        self.dynamics.as_ref()
    }

    /// The Lagrangian bisection of this system.
    pub fn bisection(&self) -> &LagrangianBisection {
        &self.bisection
    }

    /// The compiled Newton iteration, where both parts are code.
    pub fn newton(&self) -> Option<&NewtonKernel> {
        match &self.path {
            Path::Code(newton, _) => Some(newton),
            _ => None,
        }
    }

    /// Evaluators of α̂, β̂ and of y ↦ L(y), whatever the path of the steps is.
    ///
    /// # Errors
    /// [`BuildError`] where one cannot be compiled or is not offered alone.
    pub fn evaluators(
        &self,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Result<MethodEvaluators, BuildError> {
        let shape = [
            self.realization.dimension(),
            self.realization.space_dimension(),
        ];
        let points = self.bisection.points(shape, parameters.len())?;
        let points = points.ok_or_else(|| BuildError::Incompatible {
            dynamics: self.dynamics.describe(),
            realization: self.realization.describe(),
            reason: NO_POINTS.to_owned(),
        })?;
        let maps = RealizationMaps::new(self.realization.as_ref(), parameters.len())?;
        Ok(MethodEvaluators {
            chart: maps.chart_ratio(parameters, epsilon),
            maps: maps.evaluator(parameters, epsilon),
            points: points.evaluator(parameters, epsilon, h),
        })
    }

    /// The gradient by parameters of both ends; `None` where there are none, and where a formula has no derivative.
    fn slopes_by_parameters(&self, parameters: usize) -> Option<Arc<Kernel>> {
        if parameters == 0 {
            return None;
        }
        let compile = || -> Option<Arc<Kernel>> {
            let (ends, points) = (self.realization.abilities().code()?, self.bisection.code()?);
            let (mut graph, ends) = code_along(self.dimension(), &ends, &points).ok()?;
            by_parameters(&mut graph, &ends, parameters)
                .ok()
                .map(Arc::new)
        };
        self.by_parameters.get_or_init(compile).clone()
    }

    /// How a step is computed, for reports: `one kernel`, `fused` or `evaluators`.
    pub fn path(&self) -> String {
        format!("{:?}", self.path)
    }

    /// Theorem 2's bound min(n, m) on the order in t = εh; m alone over an exact realization.
    pub fn declared_order(&self) -> usize {
        self.properties().order
    }
}

/// y ↦ β̂(L(y)), (α̂ − β̂)(L(y)) as code.
fn code_along(
    d: usize,
    ends: &MapCode<'_>,
    points: &PointCode<'_>,
) -> Result<(Graph, SourceTarget), BuildError> {
    let mut graph = Graph::compilable();
    let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let epsilon = graph.step_size(StepSize::Epsilon);
    let h = graph.step_size(StepSize::H);
    let z = points(&mut graph, &epsilon, &h, &y)?;
    let ends = ends(&mut graph, &epsilon, &z)?;
    Ok((graph, ends))
}

/// Refuses a system with forces to a dynamic approximation that does not take them.
pub(crate) fn check_forces(
    system: &PoissonSystem,
    dynamics: &dyn DynamicApproximation,
) -> Result<(), BuildError> {
    system.unless_beyond(dynamics.properties().takes, &dynamics.describe())
}

/// Refuses coordinates with a constant tensor to a dynamic approximation that needs α̂ and β̂.
fn check_lift(
    realization: &dyn RealizationData,
    dynamics: &dyn DynamicApproximation,
) -> Result<(), BuildError> {
    let abilities = realization.abilities();
    let has_maps = abilities.lift.is_none() || abilities.code().is_some();
    match has_maps || dynamics.properties().serves_lifts {
        true => Ok(()),
        false => Err(BuildError::LiftAlone {
            dynamics: dynamics.describe(),
            realization: realization.describe(),
        }),
    }
}

/// The coordinates whose sign a map with these properties keeps: no leaf crosses where they are 0.
fn kept_by(system: &PoissonSystem, properties: MapProperties) -> Vec<usize> {
    match properties.structure {
        Structure::Exact | Structure::Leaves => kept_signs(system),
        _ => Vec::new(),
    }
}

/// Properties of the map of a realization and a dynamic approximation, as Theorems 1 and 2 promise them. Over an exact
/// realization α̂(z) and β̂(z) lie on one symplectic leaf for any z. There a solved bisection maps along leaves even
/// where it is not Lagrangian (paper, section 2).
pub(crate) fn properties_of(
    realization: &dyn RealizationData,
    dynamics: &dyn DynamicApproximation,
) -> MapProperties {
    let dynamics = dynamics.properties();
    let m = dynamics.order;
    let (order, structure) = match (realization.accuracy(), dynamics.correction) {
        (Accuracy::Exact, Correction::Bisection) => (m, Structure::Exact),
        (Accuracy::Exact, Correction::None) => (m, Structure::Order(m)),
        (Accuracy::Order(n), Correction::Bisection) => (n.min(m), Structure::Order(n)),
        (Accuracy::Order(n), Correction::None) => (n.min(m), Structure::Order(n.min(m))),
    };
    MapProperties {
        order,
        structure: match (dynamics.is_lagrangian, structure) {
            (true, structure) => structure,
            (false, Structure::Exact) => Structure::Leaves,
            (false, _) => Structure::None,
        },
        self_adjoint: dynamics
            .self_adjoint
            .filter(|is_so| !is_so || realization.abilities().is_reversible),
    }
}

impl StepMap for Method {
    fn dimension(&self) -> usize {
        self.realization.dimension()
    }

    fn properties(&self) -> MapProperties {
        match &self.path {
            Path::Fused(map) => map.properties(),
            _ => properties_of(self.realization.as_ref(), self.dynamics.as_ref()),
        }
    }

    fn describe(&self) -> String {
        format!(
            "{} + {}",
            self.realization.describe(),
            self.dynamics.describe()
        )
    }

    fn abilities(&self) -> MapAbilities<'_> {
        let kernels = match &self.path {
            Path::Code(newton, uncoupled) => {
                let parts = match uncoupled {
                    None => vec![newton],
                    Some(uncoupled) => uncoupled.kernels().collect(),
                };
                parts.into_iter().flat_map(NewtonKernel::kernels).collect()
            }
            Path::Fused(map) => map.abilities().kernels,
            Path::Evaluators { maps, points, .. } => {
                maps.kernels().into_iter().chain(points.kernel()).collect()
            }
        };
        let generating = self.bisection.generating_function();
        let shadow = generating.zip(self.realization.abilities().series).map(
            |(generating, series)| -> ShadowTerms<'_> {
                let d = self.dimension();
                Box::new(move |_, last, products| shadow_of(generating, &series, d, last, products))
            },
        );
        MapAbilities {
            kernels,
            shadow,
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let stepper: Box<dyn Stepper> = match &self.path {
            Path::Code(_, Some(uncoupled)) => uncoupled.stepper(lanes, parameters, epsilon, h),
            Path::Code(newton, None) => {
                Box::new(NewtonStepper::new(newton, lanes, parameters, epsilon, h))
            }
            Path::Fused(map) => map.stepper(lanes, parameters, epsilon, h),
            Path::Evaluators {
                maps,
                points,
                together,
            } => {
                let (d, space) = (self.dimension(), self.realization.space_dimension());
                let correction = self.dynamics.properties().correction;
                let is_near = matches!(
                    self.bisection,
                    LagrangianBisection::Points {
                        is_near_identity: true,
                        ..
                    }
                );
                let has_tangents = maps.has_jacobian() && points.has_jacobian();
                let corrections = match (is_near, has_tangents) {
                    (true, _) => CorrectionMethod::Residual,
                    (false, true) => CorrectionMethod::Newton,
                    (false, false) => CorrectionMethod::Acceleration,
                };
                let most = if *together { usize::MAX } else { 1 };
                let solver = |parameters: &[f64], count| {
                    let maps = maps.evaluator(parameters, epsilon);
                    let points = points.evaluator(parameters, epsilon, h);
                    NumericSolver::new((maps, points), (d, space), (correction, corrections), count)
                };
                Box::new(Lanes::together(lanes, most, d, parameters, solver))
            }
        };
        let stepper = keeping_signs(stepper, &self.kept_signs);
        let stepper = match &self.poles {
            None => stepper,
            Some(poles) => Checked::boxed(stepper, Arc::clone(poles).make(lanes, parameters)),
        };
        let stepper = match &self.walls {
            None => stepper,
            Some(walls) => Checked::boxed(stepper, Arc::clone(walls).make(lanes, parameters)),
        };
        match self.dynamics.properties().time_step {
            None => stepper,
            Some(length) => of_one_length(stepper, THE_FUNCTION, length, epsilon * h),
        }
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        let stepper = self.stepper(1, parameters, epsilon, h);
        let Path::Code(newton, _) = &self.path else {
            return Box::new(ByTangents::new(stepper, self.dimension()));
        };
        let by_parameters = self.slopes_by_parameters(parameters.len());
        Box::new(Solved::new(
            stepper,
            newton,
            by_parameters,
            parameters,
            (epsilon, h),
        ))
    }
}
