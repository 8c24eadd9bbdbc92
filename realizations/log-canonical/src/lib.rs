//! The exact realization of a log-canonical Poisson tensor.
//!
//! The bracket is {x_i, x_j} = a_ij x_i x_j, as in every Lotka–Volterra system. With u_i = ½ ε Σ_j a_ij x_j p_j,
//! α_i = x_i e^{−u_i}, β_i = x_i e^{u_i}, and σ(x) = (x, 0). The chart is not Karasev's: the two agree to first order
//! in ε only.

use std::sync::Arc;

use leafwise_core::lattice::StageEnds;
use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    BuildError, ChartPoint, ClosedForm, ClosedRealization, PoissonSystem, RealizationData,
    SystemFormulas,
};
use leafwise_expression::pairs::{EXPONENTIAL_MINUS_1, EXPONENTIAL_MINUS_1_MIRRORED};
use leafwise_expression::{
    AlgebraError, Arithmetic, Function, Graph, Polynomial, Rational, Ring, Term,
};

static INFO: PartInfo = PartInfo {
    name: "log-canonical",
    summary: "x exp(-+ (1/2) epsilon sum_j a_ij x_j p_j), for {x_i, x_j} = a_ij x_i x_j",
    declares: "exact; self-adjoint",
    domain: "all points where the exponentials are finite; a_ij of numbers and parameters",
    literature: "S. Li, D. Rupel, Symplectic groupoids for cluster manifolds, arXiv:1807.03450 \
                 (2018)",
    auto: Some(Auto::Exact {
        rank: 2,
        reason: "the tensor is log-canonical: a closed form",
    }),
    ..PartInfo::of(PartKind::Realization)
};

/// α_i = x_i e^{−u_i} with u_i = ½ ε Σ_j a_ij x_j p_j, for {x_i, x_j} = a_ij x_i x_j
/// (S. Li, D. Rupel, *Symplectic groupoids for cluster manifolds*, 2018, for the structure; the chart is the
/// one with β(x, p) = α(x, −p)).
///
/// In y_j = x_j p_j the canonical bracket is {x_i, y_j} = δ_ij x_i, so the x_i e^{−u_i} multiply
/// like exponentials of a Heisenberg algebra. A vanishing or negative coordinate is as good as any.
#[derive(Clone, Debug)]
pub struct LogCanonical {
    system: SystemFormulas,
}

impl LogCanonical {
    /// The realization data of a system's tensor.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] with the first entry whose quotient by x_i x_j has a normal form with
    /// variables. Returns [`BuildError::Algebra`] where an entry has no normal form.
    pub fn realize(system: &PoissonSystem) -> Result<ClosedRealization<Self>, BuildError> {
        let system = system.formulas(INFO.name)?.clone();
        ClosedRealization::new(INFO.name, Self { system })
    }

    /// The a_ij of a system's tensor as polynomials without variables, in the order of its entries.
    ///
    /// # Errors
    /// Those of [`realize`](Self::realize).
    pub fn coefficients(
        system: &SystemFormulas,
        ring: &mut Ring,
    ) -> Result<Vec<Polynomial>, BuildError> {
        let system = system.clone();
        Self { system }.functions(ring)
    }

    /// `factor`·u_i.
    fn exponents<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
        factor: &Rational,
    ) -> Vec<A::Element> {
        let pairs = at.x.iter().zip(at.p);
        // p = ∂S holds 1/x where H holds ln x, and x p does not.
        let y: Vec<_> = pairs.map(|(x, p)| algebra.multiply_reduced(x, p)).collect();
        let half = &Rational::new(1, 2) * factor;
        let mut rows = vec![Vec::new(); y.len()];
        for ((i, j), a) in self.system.tensor().keys().zip(at.functions) {
            let a = algebra.multiply(at.epsilon, a);
            rows[*i].push((half.clone(), algebra.multiply(&a, &y[*j])));
            rows[*j].push((-&half, algebra.multiply(&a, &y[*i])));
        }
        rows.iter().map(|row| algebra.combine(row)).collect()
    }
}

impl ClosedForm for LogCanonical {
    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    /// a_ij = {x_i, x_j}/(x_i x_j) in the order of the tensor's entries.
    fn functions(&self, ring: &mut Ring) -> Result<Vec<Polynomial>, BuildError> {
        let mut coefficients = Vec::with_capacity(self.system.tensor().len());
        for (&(i, j), entry) in self.system.tensor() {
            let value = entry.evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))?;
            let (first, second) = (ring.variable(i), ring.variable(j));
            let product = ring.multiply(&first, &second);
            let a = ring.divide(&value, &product)?;
            if a.as_constant().is_none() {
                let [first, second] = [i, j].map(|at| &self.system.variables()[at]);
                return Err(BuildError::DoesNotFit {
                    part: INFO.name,
                    reason: format!(
                        "{{{first}, {second}}} is not {first}*{second} times a function of the \
                         parameters"
                    ),
                });
            }
            coefficients.push(a);
        }
        Ok(coefficients)
    }

    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let exponents = self.exponents(algebra, at, &-Rational::one());
        let pairs = at.x.iter().zip(&exponents);
        pairs
            .map(|(x, exponent)| {
                let factor = algebra.apply(Function::Exp, exponent)?;
                Ok(algebra.multiply(x, &factor))
            })
            .collect()
    }

    /// β − x = x (eᵘ − 1) and α − β = x ((e⁻ᵘ − 1) − (eᵘ − 1)), whose terms have one sign: nothing cancels.
    fn ends(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<StageEnds, AlgebraError> {
        let exponents = self.exponents(graph, at, &Rational::one());
        let mut offset = Vec::with_capacity(at.x.len());
        let mut increment = Vec::with_capacity(at.x.len());
        for (x, u) in at.x.iter().zip(&exponents) {
            let up = graph.apply_analytic(EXPONENTIAL_MINUS_1, 0, u);
            let down = graph.apply_analytic(EXPONENTIAL_MINUS_1_MIRRORED, 0, u);
            let between = graph.subtract(&down, &up);
            offset.push(graph.multiply(x, &up));
            increment.push(graph.multiply(x, &between));
        }
        Ok(StageEnds { offset, increment })
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(LogCanonical::realize(system)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
