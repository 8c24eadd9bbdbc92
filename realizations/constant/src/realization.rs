//! x ∓ ½ ε Π p.

use std::sync::Arc;

use leafwise_core::lattice::{RealizationStages, StageBuilder, StageEnds};
use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::realization::{
    Accuracy, RealizationCode, RealizationData, SourceSeries, SourceTarget,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use crate::series::ConstantSeries;

static INFO: PartInfo = PartInfo {
    name: "constant",
    summary: "x -+ (1/2) epsilon Pi p, for tensors without variables",
    declares: "exact; self-adjoint",
    domain: "all points; tensors of numbers and parameters",
    literature: "A. Weinstein, The local structure of Poisson manifolds, J. Differential Geom. 18 \
                 (1983); K. Feng, Difference schemes for Hamiltonian formalism and symplectic \
                 geometry, J. Comput. Math. 4 (1986)",
    auto: Some(Auto::Exact {
        rank: 1,
        reason: "the tensor is constant: a closed form",
    }),
    ..PartInfo::of(PartKind::Realization)
};

/// Realization data of a tensor without variables: α_ε = x − ½ ε Π p, β_ε = x + ½ ε Π p.
///
/// From {x_i, p_j} = δ_ij follow {α_i, α_j} = ε Π_ij, {β_i, β_j} = −ε Π_ij, {α_i, β_j} = 0.
#[derive(Clone, Debug)]
pub struct ConstantRealization {
    dimension: usize,
    ring: Ring,
    /// Π_ij for i < j, nonzero.
    entries: Vec<((usize, usize), Polynomial)>,
    series: ConstantSeries,
}

impl ConstantRealization {
    /// The realization data of a system's tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] with the first entry whose normal form contains variables,
    /// [`BuildError::Algebra`] where an entry has no normal form.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        let system = system.formulas(INFO.name)?;
        let mut ring = Ring::new(system.dimension());
        let mut entries = Vec::with_capacity(system.tensor().len());
        for (&(i, j), entry) in system.tensor() {
            let value = entry.evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))?;
            if value.as_constant().is_none() {
                let [first, second] = [i, j].map(|at| &system.variables()[at]);
                return Err(BuildError::DoesNotFit {
                    part: INFO.name,
                    reason: format!(
                        "{{{first}, {second}}} depends on the variables; the tensor must be \
                         constant, parameters allowed"
                    ),
                });
            }
            if !value.is_zero() {
                entries.push(((i, j), value));
            }
        }
        Ok(Self {
            dimension: system.dimension(),
            ring,
            series: ConstantSeries::new(system.clone()),
            entries,
        })
    }

    /// ½ ε Π p as code.
    fn half_row_sums(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        p: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let outputs: Vec<_> = self
            .entries
            .iter()
            .map(|(_, entry)| vec![(epsilon.clone(), entry.clone())])
            .collect();
        let entries = lift(graph, &self.ring, &outputs, &[])?;
        let half = Rational::new(1, 2);
        let mut rows = vec![Vec::new(); self.dimension];
        for (((i, j), _), entry) in self.entries.iter().zip(&entries) {
            rows[*i].push((half.clone(), graph.multiply(entry, &p[*j])));
            rows[*j].push((-&half, graph.multiply(entry, &p[*i])));
        }
        Ok(rows.iter().map(|row| graph.combine(row)).collect())
    }

    fn ends(&self, graph: &mut Graph, epsilon: &Term, p: &[Term]) -> Result<StageEnds, BuildError> {
        let offset = self.half_row_sums(graph, epsilon, p)?;
        let minus_two = Rational::from_integer(-2);
        let increment = offset.iter().map(|o| graph.scale(&minus_two, o)).collect();
        Ok(StageEnds { offset, increment })
    }
}

impl RealizationData for ConstantRealization {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        INFO.name.to_owned()
    }

    fn code(&self) -> Option<&dyn RealizationCode> {
        Some(self)
    }

    fn stages(&self) -> Option<&dyn RealizationStages> {
        Some(self)
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        Some(&self.series)
    }
}

impl RealizationCode for ConstantRealization {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(self.dimension);
        let StageEnds { offset, increment } = self.ends(graph, epsilon, p)?;
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment,
            guard: None,
        })
    }
}

impl RealizationStages for ConstantRealization {
    /// One stage: the rows of Π read p at neighbouring sites.
    fn stages(
        &self,
        builder: &mut StageBuilder,
        epsilon: &Term,
        _y: &[Term],
        p: &[Term],
    ) -> Result<StageEnds, BuildError> {
        self.ends(&mut builder.graph, epsilon, p)
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(ConstantRealization::new(system)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
