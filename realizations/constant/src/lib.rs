//! The exact realization of a Poisson tensor that does not depend on x: x ∓ ½ ε Π p.

use std::sync::Arc;

use leafwise_core::lattice::StageEnds;
use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    BuildError, ChartPoint, ClosedForm, ClosedRealization, PoissonSystem, RealizationData,
    SystemFormulas,
};
use leafwise_expression::{AlgebraError, Arithmetic, Graph, Polynomial, Rational, Ring, Term};

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

/// α_ε = x − ½ ε Π p for a tensor without variables.
///
/// From {x_i, p_j} = δ_ij follow {α_i, α_j} = ε Π_ij, {β_i, β_j} = −ε Π_ij, {α_i, β_j} = 0.
#[derive(Clone, Debug)]
pub struct Constant {
    system: SystemFormulas,
}

impl Constant {
    /// The realization data of a system's tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] with the first entry whose normal form contains variables,
    /// [`BuildError::Algebra`] where an entry has no normal form.
    pub fn realize(system: &PoissonSystem) -> Result<ClosedRealization<Self>, BuildError> {
        let system = system.formulas(INFO.name)?.clone();
        ClosedRealization::new(INFO.name, Self { system })
    }

    /// ½ ε Π p.
    fn half_rows<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Vec<A::Element> {
        let half = Rational::new(1, 2);
        let mut rows = vec![Vec::new(); at.x.len()];
        for ((i, j), entry) in self.system.tensor().keys().zip(at.functions) {
            let entry = algebra.multiply(at.epsilon, entry);
            rows[*i].push((half.clone(), algebra.multiply(&entry, &at.p[*j])));
            rows[*j].push((-&half, algebra.multiply(&entry, &at.p[*i])));
        }
        rows.iter().map(|row| algebra.combine(row)).collect()
    }
}

impl ClosedForm for Constant {
    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    /// Π_ij in the order of the tensor's entries.
    fn functions(&self, ring: &mut Ring) -> Result<Vec<Polynomial>, BuildError> {
        let mut entries = Vec::with_capacity(self.system.tensor().len());
        for (&(i, j), entry) in self.system.tensor() {
            let value = entry.evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))?;
            if value.as_constant().is_none() {
                let [first, second] = [i, j].map(|at| &self.system.variables()[at]);
                return Err(BuildError::DoesNotFit {
                    part: INFO.name,
                    reason: format!(
                        "{{{first}, {second}}} depends on the variables; the tensor must be \
                         constant, parameters allowed"
                    ),
                });
            }
            entries.push(value);
        }
        Ok(entries)
    }

    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let rows = self.half_rows(algebra, at);
        let pairs = at.x.iter().zip(&rows);
        Ok(pairs.map(|(x, row)| algebra.subtract(x, row)).collect())
    }

    fn ends(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<StageEnds, AlgebraError> {
        let offset = self.half_rows(graph, at);
        let minus_two = Rational::from_integer(-2);
        let increment = offset.iter().map(|o| graph.scale(&minus_two, o)).collect();
        Ok(StageEnds { offset, increment })
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(Constant::realize(system)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
