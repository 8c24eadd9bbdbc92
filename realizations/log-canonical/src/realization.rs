//! x_i exp(∓½ ε Σ_j a_ij x_j p_j).

use std::sync::Arc;

use leafwise_core::lattice::{RealizationStages, StageBuilder, StageEnds};
use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::realization::{
    Accuracy, RealizationCode, RealizationData, SourceSeries, SourceTarget,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Function, Graph, Rational, Ring, Term};

use crate::series::LogCanonicalSeries;
use crate::tensor::{Coefficients, NAME, coefficients};

static INFO: PartInfo = PartInfo {
    name: NAME,
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

/// Realization data of {x_i, x_j} = a_ij x_i x_j: α_i = x_i e^{−u_i}, β_i = x_i e^{u_i} with
/// u_i = ½ ε Σ_j a_ij x_j p_j (S. Li, D. Rupel, *Symplectic groupoids for cluster manifolds*,
/// 2018, for the structure; the chart is the one with β(x, p) = α(x, −p)).
///
/// In y_j = x_j p_j the canonical bracket is {x_i, y_j} = δ_ij x_i, so the x_i e^{−u_i} multiply
/// like exponentials of a Heisenberg algebra. A vanishing or negative coordinate is as good as any.
#[derive(Clone, Debug)]
pub struct LogCanonical {
    dimension: usize,
    ring: Ring,
    /// a_ij for i < j, nonzero, free of variables.
    coefficients: Coefficients,
    series: LogCanonicalSeries,
}

impl LogCanonical {
    /// The realization data of a system's tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] with the first entry whose quotient by x_i x_j has a normal form
    /// with variables, [`BuildError::Algebra`] where an entry has no normal form.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        let system = system.formulas(INFO.name)?;
        let mut ring = Ring::new(system.dimension());
        let coefficients = coefficients(system, &mut ring)?;
        Ok(Self {
            dimension: system.dimension(),
            ring,
            coefficients,
            series: LogCanonicalSeries::new(system.clone()),
        })
    }

    /// β − x and α − β as code.
    ///
    /// With s = sinh(u/2) and c = cosh(u/2) the part of α − x that is odd in p is −2 x s c and the
    /// even one 2 x s²: products, so that nothing cancels, and one odd part for both ends.
    fn ends(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        x: &[Term],
        p: &[Term],
    ) -> Result<StageEnds, BuildError> {
        let outputs: Vec<_> = self
            .coefficients
            .iter()
            .map(|(_, a)| vec![(epsilon.clone(), a.clone())])
            .collect();
        let coefficients = lift(graph, &self.ring, &outputs, &[])?;
        let y: Vec<Term> = x.iter().zip(p).map(|(x, p)| graph.multiply(x, p)).collect();
        let quarter = Rational::new(1, 4);
        let mut halves = vec![Vec::new(); self.dimension];
        for (((i, j), _), a) in self.coefficients.iter().zip(&coefficients) {
            halves[*i].push((quarter.clone(), graph.multiply(a, &y[*j])));
            halves[*j].push((-&quarter, graph.multiply(a, &y[*i])));
        }
        let two = Rational::from_integer(2);
        let mut offset = Vec::with_capacity(x.len());
        let mut increment = Vec::with_capacity(x.len());
        for (x, terms) in x.iter().zip(&halves) {
            let half = graph.combine(terms);
            let sinh = graph.apply(Function::Sinh, &half)?;
            let cosh = graph.apply(Function::Cosh, &half)?;
            let scaled = graph.multiply(x, &sinh);
            let odd = graph.multiply(&scaled, &cosh);
            let even = graph.multiply(&scaled, &sinh);
            offset.push(graph.combine(&[(two.clone(), even), (two.clone(), odd.clone())]));
            increment.push(graph.scale(&Rational::from_integer(-4), &odd));
        }
        Ok(StageEnds { offset, increment })
    }
}

impl RealizationData for LogCanonical {
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

impl RealizationCode for LogCanonical {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(self.dimension);
        let StageEnds { offset, increment } = self.ends(graph, epsilon, x, p)?;
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment,
            guard: None,
        })
    }
}

impl RealizationStages for LogCanonical {
    /// One stage: u_i reads x_j p_j at neighbouring sites.
    fn stages(
        &self,
        builder: &mut StageBuilder,
        epsilon: &Term,
        y: &[Term],
        p: &[Term],
    ) -> Result<StageEnds, BuildError> {
        self.ends(&mut builder.graph, epsilon, y, p)
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(LogCanonical::new(system)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
