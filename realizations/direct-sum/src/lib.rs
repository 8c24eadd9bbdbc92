//! The exact realization of a tensor beside a constant one: Π(x) ⊕ C on (x, y).
//!
//! Where (S₁, α₁, β₁) realizes Π and (S₂, α₂, β₂) realizes C, the products α₁ × α₂ and β₁ × β₂ on S₁ × S₂ realize the direct
//! sum: brackets of functions of different factors vanish. A motion that depends on time is of this kind, with its
//! time and energy as y.

use std::sync::Arc;

use leafwise_constant::Constant;
use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::realization::{
    Accuracy, MapCode, RealizationData, SourceRecursion, SourceSeries, SourceTarget,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    BuildError, ClosedRealization, Convention, PoissonSystem, Registry, SystemFormulas,
};
use leafwise_expression::{DifferentialAlgebra, Expression, Graph, Ring};

static INFO: PartInfo = PartInfo {
    name: "direct-sum",
    summary: "the exact realization of the first coordinates beside x -+ (1/2) epsilon Pi p of the others, whose tensor \
              is constant",
    declares: "exact; self-adjoint",
    domain: "tensors that are the direct sum of one with an exact realization as code in pairs (x, p) and of a constant \
             one of the last coordinates",
    literature: "A. Weinstein, The local structure of Poisson manifolds, J. Differential Geom. 18 (1983): products of \
                 realizations",
    auto: Some(Auto::Exact {
        rank: 4,
        reason: "the tensor is a direct sum with a constant one: a closed form for each",
    }),
    ..PartInfo::of(PartKind::Realization)
};

/// α₁ × α₂ and β₁ × β₂: an exact realization on x_1 … x_k, the constant tensor's on the coordinates behind.
#[derive(Clone, Debug)]
pub struct DirectSum {
    dimension: usize,
    /// Of the first coordinates.
    first: Arc<dyn RealizationData>,
    /// Over all coordinates, with the entries of the last ones alone: it leaves the first ones as they are.
    last: ClosedRealization<Constant>,
}

impl DirectSum {
    /// The realization data of a system's tensor, with the first exact realization of `registry` that fits the tensor
    /// of the first coordinates.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] for a tensor that is no such sum, or where no realization of the first coordinates
    /// has code in pairs (x, p).
    pub fn realize(system: &PoissonSystem, registry: &Registry) -> Result<Self, BuildError> {
        let formulas = system.formulas(INFO.name)?;
        let (k, dimension) = (coordinates_before(formulas), system.dimension());
        let unfit = |reason: &str| BuildError::DoesNotFit {
            part: INFO.name,
            reason: reason.to_owned(),
        };
        if k == 0 || k == dimension {
            return Err(unfit(
                "its tensor is not the direct sum of one that depends on the state and of a constant one of the last \
                 coordinates",
            ));
        }
        let first = restricted(formulas, k, |(i, _)| i < k)?;
        let first = first.with_near(&formulas.near()[..k])?;
        let exact = registry.exact_realization(&first, false);
        let exact = exact
            .ok_or_else(|| unfit("the tensor of its first coordinates has no exact realization"))?;
        let first = exact.realization;
        if first.code().is_none() || !first.points_are_pairs() || first.series().is_none() {
            return Err(unfit(
                "the exact realization of its first coordinates has no code in pairs (x, p)",
            ));
        }
        let last = restricted(formulas, dimension, |(i, _)| i >= k)?;
        Ok(Self {
            dimension,
            first,
            last: Constant::realize(&last)?,
        })
    }

    /// k.
    fn before(&self) -> usize {
        self.first.dimension()
    }
}

/// The least k such that no entry of the tensor joins the coordinates before k and those behind, and no entry depends on
/// those behind.
fn coordinates_before(system: &SystemFormulas) -> usize {
    let mut k = 0;
    loop {
        let joined = system.tensor().iter().filter_map(|(&(i, j), entry)| {
            let reads = entry.variables().last().copied();
            let is_before = i < k || reads.is_some();
            is_before.then(|| 1 + j.max(reads.unwrap_or(0)))
        });
        let next = joined.max().unwrap_or(0).max(k);
        if next == k {
            return k;
        }
        k = next;
    }
}

/// The first so many coordinates with some of the entries, and nothing that moves.
fn restricted(
    system: &SystemFormulas,
    dimension: usize,
    is_kept: impl Fn((usize, usize)) -> bool,
) -> Result<PoissonSystem, BuildError> {
    let entries = system.tensor().iter().filter(|(at, _)| is_kept(**at));
    PoissonSystem::new(
        system.variables()[..dimension].to_vec(),
        system.parameters().to_vec(),
        entries.map(|(at, entry)| (*at, entry.clone())),
        Expression::from(0),
        Vec::new(),
        Convention::HamiltonianFirst,
    )
}

impl RealizationData for DirectSum {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        format!(
            "{} of {} and {}",
            INFO.name,
            self.first.describe(),
            self.last.describe()
        )
    }

    fn code(&self) -> Option<MapCode<'_>> {
        let (first, last) = (self.first.code()?, self.last.code()?);
        let (k, d) = (self.before(), self.dimension);
        Some(Box::new(move |graph, epsilon, z| {
            let own: Vec<_> = z[..k].iter().chain(&z[d..d + k]).cloned().collect();
            let mut ends = first(graph, epsilon, &own)?;
            let rest: SourceTarget = last(graph, epsilon, z)?;
            ends.base.extend_from_slice(&rest.base[k..]);
            ends.offset.extend_from_slice(&rest.offset[k..]);
            ends.increment.extend_from_slice(&rest.increment[k..]);
            Ok(ends)
        }))
    }

    fn is_reversible(&self) -> bool {
        self.first.is_reversible()
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        Some(self)
    }
}

impl SourceSeries for DirectSum {
    fn in_ring(&self, ring: &mut Ring) -> Result<Box<dyn SourceRecursion<Ring>>, BuildError> {
        Ok(Box::new(Recursions {
            before: self.before(),
            first: series_of(self.first.as_ref())?.in_ring(ring)?,
            last: self.last.in_ring(ring)?,
        }))
    }

    fn in_graph(&self, graph: &mut Graph) -> Result<Box<dyn SourceRecursion<Graph>>, BuildError> {
        Ok(Box::new(Recursions {
            before: self.before(),
            first: series_of(self.first.as_ref())?.in_graph(graph)?,
            last: self.last.in_graph(graph)?,
        }))
    }
}

fn series_of(realization: &dyn RealizationData) -> Result<&dyn SourceSeries, BuildError> {
    realization.series().ok_or_else(|| BuildError::DoesNotFit {
        part: INFO.name,
        reason: "the realization of its first coordinates has no series".to_owned(),
    })
}

/// The series of both factors.
struct Recursions<A: DifferentialAlgebra> {
    before: usize,
    first: Box<dyn SourceRecursion<A>>,
    last: Box<dyn SourceRecursion<A>>,
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursions<A> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        let mut source = self.first.push(algebra, p[..self.before].to_vec())?;
        let rest = self.last.push(algebra, p)?;
        source.extend_from_slice(&rest[self.before..]);
        Ok(source)
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(DirectSum::realize(
        system,
        &Registry::with_builtin(),
    )?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
