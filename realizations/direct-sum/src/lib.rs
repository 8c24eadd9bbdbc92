//! The exact realization of a direct sum Π₁(x₁) ⊕ Π₂(x₂) ⊕ … of tensors.
//!
//! Where (S_k, α_k, β_k) realizes Π_k, the products α₁ × α₂ × … and β₁ × β₂ × … on S₁ × S₂ × … realize the sum.
//! Brackets of functions of different factors vanish. The summands are found in the tensor: coordinates that no entry
//! joins are of different ones. A motion that depends on time is of this kind, its time and energy being a summand.

use std::sync::Arc;

use leafwise_core::lattice::{StageBuilder, StageEnds};
use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::realization::{
    Abilities, Accuracy, EndMaps, MapCode, RealizationData, SourceRecursion, SourceSeries,
    SourceTarget, Space,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, Registry, SystemFormulas};
use leafwise_expression::{AlgebraError, Arithmetic, DifferentialAlgebra, Graph, Term};

static INFO: PartInfo = PartInfo {
    name: "direct-sum",
    summary: "the exact realizations of a tensor's summands side by side, each the cheapest that fits",
    declares: "exact; self-adjoint",
    domain: "tensors that are the direct sum of several, each with an exact realization as code in pairs (x, p)",
    literature: "A. Weinstein, The local structure of Poisson manifolds, J. Differential Geom. 18 (1983): products of \
                 realizations",
    auto: Some(Auto::Exact {
        rank: 4,
        reason: "the tensor is a direct sum: a closed form for each summand",
    }),
    ..PartInfo::of(PartKind::Realization)
};

/// α₁ × α₂ × … and β₁ × β₂ × …: exact where every factor is.
#[derive(Clone, Debug)]
pub struct DirectSum {
    dimension: usize,
    factors: Vec<Factor>,
}

/// The realization of a summand.
#[derive(Clone, Debug)]
struct Factor {
    /// The summand's coordinates.
    places: Vec<usize>,
    realization: Arc<dyn RealizationData>,
}

impl DirectSum {
    /// The realization data of a system's tensor. Each summand takes the first exact realization of `registry` that
    /// fits it.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] for a tensor that is no sum. Returns it too where a summand has no exact
    /// realization with code in pairs (x, p).
    pub fn realize(system: &PoissonSystem, registry: &Registry) -> Result<Self, BuildError> {
        let formulas = system.formulas(INFO.name)?;
        let blocks = formulas.summands();
        if blocks.len() < 2 {
            return Err(unfit(
                "its tensor is not a direct sum: its entries join all coordinates",
            ));
        }
        let factors = blocks.into_iter().map(|places| {
            let realization = cheapest(formulas, &places, registry)?;
            Ok(Factor {
                places,
                realization,
            })
        });
        Ok(Self {
            dimension: system.dimension(),
            factors: factors.collect::<Result<_, BuildError>>()?,
        })
    }
}

fn unfit(reason: impl Into<String>) -> BuildError {
    BuildError::DoesNotFit {
        part: INFO.name,
        reason: reason.into(),
    }
}

/// The first exact realization by rank of the summand of these coordinates.
fn cheapest(
    system: &SystemFormulas,
    places: &[usize],
    registry: &Registry,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    let names = || {
        let names: Vec<&str> = places
            .iter()
            .map(|at| system.variables()[*at].as_str())
            .collect();
        names.join(", ")
    };
    let summand = system.summand(places)?;
    let exact = registry.exact_realization(&summand, false);
    let exact = exact.ok_or_else(|| {
        unfit(format!(
            "its summand of {} has no exact realization",
            names()
        ))
    })?;
    let realization = exact.realization;
    let is_summand = matches!(
        realization.abilities(),
        Abilities {
            ends: Some(EndMaps::Code(_)),
            space: Space::Pairs,
            series: Some(_),
            ..
        }
    );
    match is_summand {
        true => Ok(realization),
        false => Err(unfit(format!(
            "the exact realization of its summand of {} has no code in pairs (x, p)",
            names()
        ))),
    }
}

impl RealizationData for DirectSum {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        let mut counted: Vec<(String, usize)> = Vec::new();
        for factor in &self.factors {
            let name = factor.realization.describe();
            match counted.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += 1,
                None => counted.push((name, 1)),
            }
        }
        let words = counted.into_iter().map(|(name, count)| match count {
            1 => name,
            count => format!("{count} {name}"),
        });
        let words: Vec<String> = words.collect();
        let factors = match words.split_last() {
            Some((last, before)) if !before.is_empty() => {
                format!("{} and {last}", before.join(", "))
            }
            _ => words.concat(),
        };
        format!("{} of {factors}", INFO.name)
    }

    fn abilities(&self) -> Abilities<'_> {
        let is_reversible = |factor: &Factor| factor.realization.abilities().is_reversible;
        Abilities {
            is_reversible: self.factors.iter().all(is_reversible),
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            stages: Some(Box::new(|builder, epsilon, y, p| {
                self.stage(builder, epsilon, y, p)
            })),
            series: Some(SourceSeries {
                in_ring: Box::new(|ring, coordinates| {
                    self.recursion(coordinates, |series, own| (series.in_ring)(ring, own))
                }),
                in_graph: Box::new(|graph, coordinates| {
                    self.recursion(coordinates, |series, own| (series.in_graph)(graph, own))
                }),
            }),
            ..Abilities::default()
        }
    }
}

impl DirectSum {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(self.dimension);
        let room = || x.to_vec();
        let mut ends = SourceTarget {
            base: room(),
            offset: room(),
            increment: room(),
            guard: None,
        };
        let mut guards = Vec::new();
        for factor in &self.factors {
            let own = [factor.of(x), factor.of(p)].concat();
            let own = factor.code()?(graph, epsilon, &own)?;
            for (k, at) in factor.places.iter().enumerate() {
                ends.base[*at] = own.base[k].clone();
                ends.offset[*at] = own.offset[k].clone();
                ends.increment[*at] = own.increment[k].clone();
            }
            guards.extend(own.guard);
        }
        ends.guard = joined(graph, guards)?;
        Ok(ends)
    }

    /// One stage: every factor reads its own x and p.
    fn stage(
        &self,
        builder: &mut StageBuilder,
        epsilon: &Term,
        y: &[Term],
        p: &[Term],
    ) -> Result<StageEnds, BuildError> {
        let (mut offset, mut increment) = (y.to_vec(), y.to_vec());
        let mut reaches = vec![None; self.dimension];
        let mut is_guarded = false;
        for factor in &self.factors {
            let (x, p) = (factor.of(y), factor.of(p));
            let ends = factor.code()?(&mut builder.graph, epsilon, &[&x[..], &p].concat())?;
            let (radii, own) = ends.guard.unwrap_or_default();
            if ends.base != x || own.len() > x.len() {
                return Err(unfit("the realization of a summand cannot be swept"));
            }
            is_guarded |= !own.is_empty();
            for (k, at) in factor.places.iter().enumerate() {
                offset[*at] = ends.offset[k].clone();
                increment[*at] = ends.increment[k].clone();
                if let (Some(reach), Some(radius)) = (own.get(k), radii.get(k)) {
                    reaches[*at] = Some(builder.graph.divide(reach, radius)?);
                }
            }
        }
        if is_guarded {
            builder.guard(reaches);
        }
        Ok(StageEnds { offset, increment })
    }
}

/// Radii and reaches, compared by their largest entries.
type Guard = (Vec<Term>, Vec<Term>);

/// A point is inside where it is inside for every factor: with one radius for all the reaches side by side, otherwise
/// the reaches as parts of their radii.
fn joined(graph: &mut Graph, guards: Vec<Guard>) -> Result<Option<Guard>, AlgebraError> {
    if guards.len() < 2 {
        return Ok(guards.into_iter().next());
    }
    let (radii, reaches): (Vec<_>, Vec<_>) = guards.into_iter().unzip();
    let (radii, mut reaches) = (radii.concat(), reaches.concat());
    let first = radii[0].clone();
    let is_first = |graph: &mut Graph, radius: &Term| {
        let difference = graph.subtract(radius, &first);
        graph.is_zero(&difference)
    };
    if radii.iter().all(|radius| is_first(graph, radius)) {
        return Ok(Some((radii, reaches)));
    }
    for (reach, radius) in reaches.iter_mut().zip(&radii) {
        *reach = graph.divide(reach, radius)?;
    }
    let one = graph.one();
    Ok(Some((vec![one; radii.len()], reaches)))
}

impl Factor {
    /// Its maps as code.
    fn code(&self) -> Result<MapCode<'_>, BuildError> {
        let code = self.realization.abilities().code();
        code.ok_or_else(|| unfit("the realization of a summand has no code"))
    }

    /// The summand's share of a list over all coordinates.
    fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.places.iter().map(|at| all[*at].clone()).collect()
    }
}

impl DirectSum {
    /// The series of all factors, each over its own of these coordinates.
    fn recursion<A: DifferentialAlgebra + 'static>(
        &self,
        coordinates: &[usize],
        mut series: impl FnMut(SourceSeries<'_>, &[usize]) -> Result<SourceRecursion<A>, BuildError>,
    ) -> Result<SourceRecursion<A>, BuildError> {
        let mut factors = Vec::with_capacity(self.factors.len());
        for factor in &self.factors {
            let own = factor.realization.abilities().series;
            let own = own.ok_or_else(|| unfit("the realization of a summand has no series"))?;
            factors.push((factor.places.clone(), series(own, &factor.of(coordinates))?));
        }
        Ok(Box::new(move |algebra, p| {
            let mut source = p.clone();
            for (places, series) in &mut factors {
                let own = places.iter().map(|at| p[*at].clone()).collect();
                let own = series(algebra, own)?;
                for (at, coefficient) in places.iter().zip(own) {
                    source[*at] = coefficient;
                }
            }
            Ok(source)
        }))
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
