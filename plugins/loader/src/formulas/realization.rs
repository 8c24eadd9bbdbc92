//! A realization by formulas in a cotangent chart.

use std::sync::Arc;

use leafwise_core::part::PartInfo;
use leafwise_core::{
    Accuracy, BuildError, ChartPoint, ClosedForm, ClosedRealization, PartParameters, PoissonSystem,
    RealizationData,
};
use leafwise_expression::{AlgebraError, Arithmetic, Expression, Graph, Rational, Term};

use super::keys::{names, numbered, only, parse, refused, scope, values};
use crate::declaration::{Flags, PartDeclaration};
use crate::error::Refusal;
use crate::foreign::check_dimension;

/// α̂, β̂ and the domain over the variables x1 … xd, p1 … pd, epsilon.
#[derive(Clone, Debug)]
pub(super) struct Formulas {
    pub alpha: Vec<Expression>,
    /// Absent where β̂(x, p) = α̂(x, −p).
    pub beta: Option<Vec<Expression>>,
    pub domain: Option<Expression>,
}

impl Formulas {
    /// The formulas of a part, its parameters open.
    pub(super) fn read(part: &PartDeclaration) -> Result<Self, Refusal> {
        only(part, &["alpha", "beta", "domain"])?;
        let alpha = numbered(part, "alpha")?;
        let beta = numbered(part, "beta")?;
        let d = alpha.len();
        if d == 0 {
            return Err(refused(part, "alpha.1", "it is missing"));
        }
        if !beta.is_empty() && beta.len() != d {
            let problem = format!("there are {} of them and {d} of alpha", beta.len());
            return Err(refused(part, "beta", problem));
        }
        let variables: Vec<String> = names('x', d)
            .into_iter()
            .chain(names('p', d))
            .chain(["epsilon".to_owned()])
            .collect();
        let scope = scope(part, &variables);
        let all = |formulas: Vec<&(String, String)>| -> Result<Vec<Expression>, Refusal> {
            formulas
                .into_iter()
                .map(|formula| parse(part, &scope, formula))
                .collect()
        };
        let domain = part.formulas.iter().find(|(key, _)| key == "domain");
        Ok(Self {
            alpha: all(alpha)?,
            beta: if beta.is_empty() {
                None
            } else {
                Some(all(beta)?)
            },
            domain: domain
                .map(|formula| parse(part, &scope, formula))
                .transpose()?,
        })
    }

    /// The same for values of the parameters.
    fn with_parameters(&self, values: &[Rational]) -> Self {
        let all = |formulas: &[Expression]| -> Vec<Expression> {
            formulas
                .iter()
                .map(|formula| formula.with_parameters(values))
                .collect()
        };
        Self {
            alpha: all(&self.alpha),
            beta: self.beta.as_deref().map(all),
            domain: self
                .domain
                .as_ref()
                .map(|domain| domain.with_parameters(values)),
        }
    }
}

/// A part of kind `LW_KIND_REALIZATION` with formulas.
pub(crate) struct FormulaRealizationPart {
    info: &'static PartInfo,
    formulas: Formulas,
    order: usize,
    flags: Flags,
}

impl FormulaRealizationPart {
    pub(crate) fn new(part: &PartDeclaration, info: &'static PartInfo) -> Result<Self, Refusal> {
        Ok(Self {
            info,
            formulas: Formulas::read(part)?,
            order: usize::try_from(part.order).unwrap_or(0),
            flags: part.flags,
        })
    }

    pub(crate) fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        let d = self.formulas.alpha.len();
        let only = crate::declaration::Dimensions {
            least: d,
            most: Some(d),
        };
        check_dimension(self.info.name, only, system.dimension())?;
        let values = values(self.info, parameters)?;
        let formulas = self.formulas.with_parameters(&values);
        let form = FormulaRealization {
            accuracy: match self.flags.is_exact() {
                true => Accuracy::Exact,
                false => Accuracy::Order(self.order),
            },
            is_reversible: self.flags.is_reversible() || formulas.beta.is_none(),
            has_series: scales(&formulas.alpha),
            formulas,
        };
        Ok(Arc::new(ClosedRealization::new(self.info.name, form)?))
    }
}

/// (T*M ⊃ U, ω, α̂, β̂, σ) by formulas.
#[derive(Clone, Debug)]
struct FormulaRealization {
    accuracy: Accuracy,
    formulas: Formulas,
    is_reversible: bool,
    has_series: bool,
}

/// A momentum and an ε at which formulas are compared.
const SAMPLES: [(f64, f64); 3] = [(0.1, 0.5), (-0.07, 0.25), (0.03, 2.0)];

/// What round-off leaves of equal values of two formulas.
const ROUND_OFF: f64 = 1e-12;

/// Whether α_ε(x, p) = α_1(x, εp), by samples.
fn scales(alpha: &[Expression]) -> bool {
    let d = alpha.len();
    let mut is_seen = false;
    for (size, epsilon) in SAMPLES {
        // States that many domains contain: positive, all different.
        let x: Vec<f64> = (0..d).map(|i| 0.7 + 0.2 * i as f64).collect();
        let p: Vec<f64> = (0..d).map(|i| size / (1.0 + i as f64)).collect();
        let at = |factor: f64, epsilon: f64| -> Vec<f64> {
            let scaled = p.iter().map(|p| factor * p);
            x.iter().copied().chain(scaled).chain([epsilon]).collect()
        };
        let (scaled, own) = (at(epsilon, 1.0), at(1.0, epsilon));
        for formula in alpha {
            let (a, b) = (formula.evaluate(&own, &[]), formula.evaluate(&scaled, &[]));
            if !a.is_finite() || !b.is_finite() {
                continue;
            }
            is_seen = true;
            if (a - b).abs() > ROUND_OFF * (1.0 + a.abs()) {
                return false;
            }
        }
    }
    is_seen
}

/// Formulas of x, p and ε at a point of the chart.
fn write<A: Arithmetic>(
    formulas: &[Expression],
    algebra: &mut A,
    at: &ChartPoint<'_, A::Element>,
) -> Result<Vec<A::Element>, AlgebraError> {
    let d = at.x.len();
    let mut variables = |_: &mut A, index: usize| {
        Ok(match index {
            index if index < d => at.x[index].clone(),
            index if index < 2 * d => at.p[index - d].clone(),
            _ => at.epsilon.clone(),
        })
    };
    let formulas = formulas.iter();
    formulas
        .map(|formula| formula.evaluate_in(algebra, &mut variables))
        .collect()
}

impl ClosedForm for FormulaRealization {
    fn dimension(&self) -> usize {
        self.formulas.alpha.len()
    }

    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        write(&self.formulas.alpha, algebra, at)
    }

    fn target(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<Vec<Term>, AlgebraError> {
        if let Some(beta) = &self.formulas.beta {
            return write(beta, graph, at);
        }
        let minus: Vec<Term> = at.p.iter().map(|p| graph.negate(p)).collect();
        self.source(graph, &ChartPoint { p: &minus, ..*at })
    }

    fn guard(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<Option<(Vec<Term>, Vec<Term>)>, AlgebraError> {
        let Some(domain) = &self.formulas.domain else {
            return Ok(None);
        };
        let reach = write(std::slice::from_ref(domain), graph, at)?;
        let d = self.dimension();
        Ok(Some((vec![graph.one(); d], vec![reach[0].clone(); d])))
    }

    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    fn is_reversible(&self) -> bool {
        self.is_reversible
    }

    fn has_series(&self) -> bool {
        self.has_series
    }
}
