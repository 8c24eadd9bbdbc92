//! The truncated Karasev realization data K̂_ε.

use std::sync::Arc;

use leafwise_core::part::{
    Auto, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters,
};
use leafwise_core::realization::{Abilities, Accuracy, EndMaps, RealizationData, SourceTarget};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::{Arithmetic, Graph, Rational, Term};

use crate::curve::KarasevCurve;
use crate::ends;
use crate::series::KarasevSeries;

static INFO: PartInfo = PartInfo {
    name: TruncatedKarasev::NAME,
    summary: "Karasev's realization truncated after epsilon^n, for any Poisson tensor",
    declares: "order n: the realization error is O(epsilon^(n+1)); self-adjoint",
    domain: "a neighbourhood of p = 0 where the series decays; any tensor that formulas can express",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, \
                 section 3.2; M. V. Karasev, Math. USSR Izv. 28 (1987)",
    parameters: &[ParameterInfo {
        name: "order",
        summary: "the truncation order n, 1 to 40",
        default: ParameterDefault::Integer(4),
    }],
    auto: Some(Auto::OfOrder),
    surveyed: &[
        &[("order", ParameterDefault::Integer(1))],
        &[("order", ParameterDefault::Integer(2))],
        &[("order", ParameterDefault::Integer(3))],
        &[("order", ParameterDefault::Integer(4))],
        &[("order", ParameterDefault::Integer(6))],
        &[("order", ParameterDefault::Integer(8))],
    ],
    ..PartInfo::of(PartKind::Realization)
};

/// Beyond this order round-off of the coefficients exceeds what a further term adds.
const LARGEST_ORDER: i64 = 40;

/// K̂_ε = (S ⊂ T*M, ω_M, τⁿα_ε, τⁿβ_ε, σ): Karasev's realization data truncated after εⁿ (paper, section 3.2).
///
/// Here α̂ = x + Σ_{k=1..n} εᵏ α_(k)(x, p) and β̂(x, p) = α̂(x, −p). So the increment α̂ − β̂ is twice the part of α̂
/// that is odd in p.
#[derive(Clone, Debug)]
pub struct TruncatedKarasev {
    system: SystemFormulas,
    order: usize,
    series: KarasevSeries,
    /// Whether α_(k) = 0 for all k > n.
    is_whole: bool,
}

impl TruncatedKarasev {
    /// The part's name.
    pub const NAME: &str = "karasev-truncated";

    /// The realization data of order n ≥ 1.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] when `order` is 0.
    pub fn new(system: &PoissonSystem, order: usize) -> Result<Self, BuildError> {
        if order == 0 {
            return Err(BuildError::Parameter {
                part: INFO.name,
                parameter: "order".to_owned(),
                value: order.to_string(),
                expected: "the truncation order is at least 1".to_owned(),
            });
        }
        let system = system.formulas(INFO.name)?;
        let series = KarasevSeries::new(system.clone());
        Ok(Self {
            is_whole: ends::is_whole(system, order),
            system: system.clone(),
            order,
            series,
        })
    }

    /// The system whose tensor is realized.
    pub fn system(&self) -> &SystemFormulas {
        &self.system
    }

    /// n.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The coefficients α_(0), …, α_(n) at ε = 1 as code of x and p.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor has no code.
    pub fn coefficients(
        &self,
        graph: &mut Graph,
        x: &[Term],
        p: &[Term],
    ) -> Result<Vec<Vec<Term>>, BuildError> {
        let mut curve = KarasevCurve::new(&self.system, x)?;
        let zero = vec![graph.zero(); p.len()];
        for k in 0..self.order {
            curve.push(graph, if k == 0 { p } else { &zero })?;
        }
        Ok((0..=self.order).map(|k| curve.source(graph, k)).collect())
    }
}

impl RealizationData for TruncatedKarasev {
    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    /// Where the series ends, of a constant tensor after α_(1), nothing is cut off.
    fn accuracy(&self) -> Accuracy {
        match self.is_whole {
            true => Accuracy::Exact,
            false => Accuracy::Order(self.order),
        }
    }

    fn describe(&self) -> String {
        format!("{} n = {}", INFO.name, self.order)
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            stages: Some(Box::new(|builder, epsilon, y, p| {
                self.write_stages(builder, epsilon, y, p)
            })),
            series: Some(self.series.source()),
            ..Abilities::default()
        }
    }
}

impl TruncatedKarasev {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(self.dimension());
        // α_ε(x, p) = α_1(x, εp): the rescaling of the paper's section 3.1.
        let q: Vec<Term> = p.iter().map(|p| graph.multiply(epsilon, p)).collect();
        let alpha = self.coefficients(graph, x, &q)?;
        let mut offset = Vec::with_capacity(x.len());
        let mut increment = Vec::with_capacity(x.len());
        for i in 0..x.len() {
            let (odd, even) = odd_and_even(graph, &alpha, i);
            offset.push(graph.subtract(&even, &odd));
            increment.push(graph.scale(&Rational::from_integer(2), &odd));
        }
        // The last order that does not vanish identically, against the first.
        let last = (2..=self.order)
            .rev()
            .find(|k| alpha[*k].iter().any(|a| !graph.is_zero(a)));
        let guard = last.map(|k| (alpha[1].clone(), alpha[k].clone()));
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment,
            guard,
        })
    }
}

/// The parts of α̂_i − x_i that are odd and even in p.
///
/// One odd part serves both ends: its round-off must be the same in β̂ and in α̂ − β̂. The Casimirs that every
/// truncation conserves would otherwise drift in proportion to time.
pub(crate) fn odd_and_even(graph: &mut Graph, alpha: &[Vec<Term>], i: usize) -> (Term, Term) {
    let mut part = |first: usize| {
        let terms: Vec<_> = (first..alpha.len())
            .step_by(2)
            .map(|k| (Rational::one(), alpha[k][i].clone()))
            .collect();
        graph.combine(&terms)
    };
    (part(1), part(2))
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    let order = parameters.get(&INFO, "order")?;
    if !(1..=LARGEST_ORDER).contains(&order) {
        return Err(BuildError::Parameter {
            part: INFO.name,
            parameter: "order".to_owned(),
            value: order.to_string(),
            expected: format!("the truncation order n lies in 1 to {LARGEST_ORDER}"),
        });
    }
    Ok(Arc::new(TruncatedKarasev::new(system, order as usize)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
