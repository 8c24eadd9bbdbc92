//! Realization data: the geometric approximation.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Ring, Term};

use crate::error::BuildError;
use crate::evaluator::Evaluator;
use crate::lattice::StageCode;
use crate::lift::Lift;
use crate::one_form::OneForm;
use crate::runge_kutta::SmoothMap;
use crate::solver::{MapProperties, StepMap};
use crate::system::PoissonSystem;
pub use leafwise_solver::SourceTarget;

/// How well R̂_ε approximates realization data of (M, επ).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accuracy {
    /// α̂ is a Poisson map, β̂ anti-Poisson, to round-off.
    Exact,
    /// α̂ = α + O(ε^{n+1}) (paper, section 3.2): the order n.
    Order(usize),
}

/// R̂_ε = (S, ω, α̂_ε, β̂_ε, σ), (approximate) realization data of (M, επ)
/// (paper, Definitions 2.3 and 3.2).
///
/// Points z of S are flat vectors of [`space_dimension`](#method.space_dimension) coordinates; they need not be pairs
/// (x, p). A part that asks for an ability that is missing is refused when a method is composed.
pub trait RealizationData: Send + Sync + std::fmt::Debug {
    /// d, the dimension of M.
    fn dimension(&self) -> usize;
    /// Exact, or the order n.
    fn accuracy(&self) -> Accuracy;
    /// One line for reports: name and order.
    fn describe(&self) -> String;
    /// σ: M → S with α̂∘σ = β̂∘σ = id: x ↦ (x, 0) where points are pairs (x, p).
    fn section(&self, x: &[f64], z: &mut [f64]) {
        let (base, covector) = z.split_at_mut(x.len());
        base.copy_from_slice(x);
        covector.fill(0.0);
    }
    /// α̂ and β̂, and whatever else it offers: `Abilities { ends: …, ..Abilities::default() }`.
    fn abilities(&self) -> Abilities<'_>;
}

/// Abilities of realization data beside its section. By default points are pairs (x, p) with β̂(x, p) = α̂(x, −p), and
/// nothing is offered.
pub struct Abilities<'a> {
    /// Points of S.
    pub space: Space<'a>,
    /// Whether β̂(χ(x, p)) = α̂(χ(x, −p)).
    pub is_reversible: bool,
    /// The maps α̂ and β̂, which only coordinates of a [`lift`](Self::lift) do without.
    pub ends: Option<EndMaps<'a>>,
    /// Coordinates with a constant tensor, in which collective integrators step.
    pub lift: Option<Arc<dyn Lift>>,
    /// Self-contained step map that solves for the realization and the graph of a one-form in one go.
    pub fused: Option<FusedSteps<'a>>,
    /// The maps α̂ and β̂ as sweeps over a lattice.
    pub stages: Option<StageCode<'a>>,
    /// The exact series of α along p(h), from which Hamilton–Jacobi coefficients are computed.
    pub series: Option<SourceSeries<'a>>,
}

impl Default for Abilities<'_> {
    fn default() -> Self {
        Self {
            space: Space::Pairs,
            is_reversible: true,
            ends: None,
            lift: None,
            fused: None,
            stages: None,
            series: None,
        }
    }
}

impl<'a> Abilities<'a> {
    /// The maps α̂ and β̂ as code, where they are.
    pub fn code(self) -> Option<MapCode<'a>> {
        match self.ends {
            Some(EndMaps::Code(code)) => Some(code),
            _ => None,
        }
    }
}

/// Points of S.
pub enum Space<'a> {
    /// Pairs (x, p) with ω canonical and σ(x) = (x, 0).
    Pairs,
    /// Others.
    Points {
        /// d_S, the number of their coordinates.
        coordinates: usize,
        /// Symplectic chart χ: T*M ⊃ U → S about σ. It has χ(x, 0) = σ(x) and inv(x, p) = (x, −p).
        chart: Option<SpaceChart<'a>>,
    },
}

impl<'a> Space<'a> {
    /// Whether its chart has code: that of pairs is the identity.
    pub fn has_code(&self) -> bool {
        match self {
            Self::Pairs => true,
            Self::Points { chart, .. } => matches!(chart, Some(SpaceChart::Code(_))),
        }
    }

    /// The chart χ as code, where points are not pairs.
    pub fn chart_code(self) -> Option<ChartCode<'a>> {
        match self {
            Self::Points {
                chart: Some(SpaceChart::Code(chart)),
                ..
            } => Some(chart),
            _ => None,
        }
    }
}

/// A chart χ of [`Space`].
pub enum SpaceChart<'a> {
    /// As straight-line code.
    Code(ChartCode<'a>),
    /// (x, p) ↦ χ(x, p) as numbers.
    Numbers(SmoothMap),
}

/// The maps α̂ and β̂.
pub enum EndMaps<'a> {
    /// As straight-line code.
    Code(MapCode<'a>),
    /// As numbers.
    Numbers(EndNumbers),
}

/// The maps α̂ and β̂ as numbers.
#[derive(Clone)]
pub struct EndNumbers {
    /// Whether their Jacobians are offered.
    pub has_jacobian: bool,
    /// Whether the result at a point depends on that point alone, bit for bit: trajectories with the same parameters may
    /// then share an evaluator.
    pub is_pointwise: bool,
    make: Arc<MakeEnds>,
    has_hessian: Option<Arc<dyn Fn() -> bool + Send + Sync>>,
}

type MakeEnds = dyn Fn(&[f64], f64) -> Box<dyn Evaluator> + Send + Sync;

impl EndNumbers {
    /// Maps whose evaluators `make` makes, one a thread, of parameters and ε.
    pub fn new(
        has_jacobian: bool,
        make: impl Fn(&[f64], f64) -> Box<dyn Evaluator> + Send + Sync + 'static,
    ) -> Self {
        Self {
            has_jacobian,
            is_pointwise: true,
            make: Arc::new(make),
            has_hessian: None,
        }
    }

    /// The same with [Hessians](Evaluator::hessian), which exact tangents of collective integrators need. The closure
    /// tells whether there are: the code of second derivatives may be long, and is written where they are needed.
    #[must_use]
    pub fn with_hessian(mut self, offered: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        self.has_hessian = Some(Arc::new(offered));
        self
    }

    /// Whether Hessians are offered.
    pub fn has_hessian(&self) -> bool {
        self.has_hessian.as_ref().is_some_and(|offered| offered())
    }

    /// The same of evaluators that belong to one trajectory: what they return depends on what they evaluated before.
    #[must_use]
    pub fn for_one_trajectory(mut self) -> Self {
        self.is_pointwise = false;
        self
    }

    /// An evaluator for fixed parameters and ε.
    pub fn evaluator(&self, parameters: &[f64], epsilon: f64) -> Box<dyn Evaluator> {
        (self.make)(parameters, epsilon)
    }
}

/// Steps that solve for a realization and a one-form at once: of a system, θ and the properties that its method promises.
pub type FusedSteps<'a> = Box<
    dyn Fn(&PoissonSystem, &OneForm, MapProperties) -> Result<Arc<dyn StepMap>, BuildError> + 'a,
>;

impl dyn RealizationData + '_ {
    /// d_S, the number of coordinates of a point of S: 2d where points are pairs (x, p).
    pub fn space_dimension(&self) -> usize {
        match self.abilities().space {
            Space::Pairs => 2 * self.dimension(),
            Space::Points { coordinates, .. } => coordinates,
        }
    }

    /// Whether points of S are pairs (x, p) with ω canonical and σ(x) = (x, 0).
    pub fn points_are_pairs(&self) -> bool {
        matches!(self.abilities().space, Space::Pairs)
    }
}

/// α̂_ε and β̂_ε as straight-line code: of a graph, the geometric parameter ε and a point z of S, d_S terms.
///
/// It fails with [`BuildError::Algebra`] where the tensor has no code.
pub type MapCode<'a> =
    Box<dyn Fn(&mut Graph, &Term, &[Term]) -> Result<SourceTarget, BuildError> + 'a>;

/// χ as straight-line code: of a graph, ε, x and p, the coordinates of χ(x, p). A chart may rescale p by ε.
///
/// It fails with [`BuildError::Algebra`] where the chart has no code.
pub type ChartCode<'a> =
    Box<dyn Fn(&mut Graph, &Term, &[Term], &[Term]) -> Result<Vec<Term>, BuildError> + 'a>;

/// α̂ and β̂ at one point of S: β̂ = base + offset, α̂ = β̂ + increment, d numbers each.
///
/// These 3d numbers are what an evaluator of a realization's maps writes at a point z of d_S numbers. Its Jacobians
/// are Dβ̂ and D(α̂ − β̂), row-major d × d_S each, its [Hessian](Evaluator::hessian) that of λ·α̂. At the point of the
/// last call nothing is computed twice.
#[derive(Clone, Copy, Debug)]
pub struct Ends<'a> {
    /// A point near both ends.
    pub base: &'a [f64],
    /// β̂ − base.
    pub offset: &'a [f64],
    /// α̂ − β̂.
    pub increment: &'a [f64],
}

impl<'a> Ends<'a> {
    /// The parts of what an evaluator writes at a point, 3d numbers.
    ///
    /// # Panics
    /// When the length is no multiple of 3.
    pub fn of(values: &'a [f64]) -> Self {
        assert!(values.len().is_multiple_of(3), "base, offset and increment");
        let d = values.len() / 3;
        Self {
            base: &values[..d],
            offset: &values[d..2 * d],
            increment: &values[2 * d..],
        }
    }

    /// β̂_i.
    pub fn target(&self, i: usize) -> f64 {
        self.base[i] + self.offset[i]
    }

    /// α̂_i.
    pub fn source(&self, i: usize) -> f64 {
        self.target(i) + self.increment[i]
    }
}

/// Exact (untruncated) series of α∘χ along p(h) = Σ_{k≥1} pₖ hᵏ at ε = 1. Here χ is a cotangent chart with
/// χ(x, 0) = σ(x) and inv(x, p) = (x, −p).
pub struct SourceSeries<'a> {
    /// As exact polynomials.
    pub in_ring: SeriesStart<'a, Ring>,
    /// As straight-line code.
    pub in_graph: SeriesStart<'a, Graph>,
}

/// Start of a [`SourceSeries`] in an algebra at α₀ = x: the components x₁ … x_d are the algebra's coordinates of these
/// indices.
///
/// It fails with [`BuildError::Algebra`] where the tensor is outside the algebra.
pub type SeriesStart<'a, A> =
    Box<dyn Fn(&mut A, &[usize]) -> Result<SourceRecursion<A>, BuildError> + 'a>;

/// One order of [`SourceSeries`] after the other: of an algebra and pₖ (d components; k = 1 at the first call) the
/// coefficient αₖ of hᵏ in α(x, p(h)).
///
/// It fails with [`BuildError::Algebra`] where the tensor is outside the algebra.
pub type SourceRecursion<A> =
    Box<dyn FnMut(&mut A, Elements<A>) -> Result<Elements<A>, BuildError>>;

type Elements<A> = Vec<<A as Arithmetic>::Element>;
