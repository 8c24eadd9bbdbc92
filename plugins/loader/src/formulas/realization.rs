//! A realization by formulas in a cotangent chart.

use std::sync::Arc;

use leafwise_core::part::PartInfo;
use leafwise_core::realization::{RealizationCode, SourceSeries, SourceTarget};
use leafwise_core::{Accuracy, BuildError, PartParameters, PoissonSystem, RealizationData};
use leafwise_expression::{AlgebraError, Arithmetic, Expression, Graph, Rational, Term};

use super::keys::{names, numbered, only, parse, refused, scope, values};
use super::series::FormulaSeries;
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
        let is_reversible = self.flags.is_reversible() || formulas.beta.is_none();
        Ok(Arc::new(FormulaRealization {
            name: self.info.name,
            accuracy: if self.flags.is_exact() {
                Accuracy::Exact
            } else {
                Accuracy::Order(self.order)
            },
            series: is_reversible
                .then(|| FormulaSeries::new(&formulas.alpha))
                .flatten(),
            is_reversible,
            formulas,
        }))
    }
}

/// (T*M ⊃ U, ω, α̂, β̂, σ) by formulas.
#[derive(Clone, Debug)]
struct FormulaRealization {
    name: &'static str,
    accuracy: Accuracy,
    formulas: Formulas,
    series: Option<FormulaSeries>,
    is_reversible: bool,
}

impl RealizationData for FormulaRealization {
    fn dimension(&self) -> usize {
        self.formulas.alpha.len()
    }

    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    fn describe(&self) -> String {
        match self.accuracy {
            Accuracy::Exact => self.name.to_owned(),
            Accuracy::Order(n) => format!("{} n = {n}", self.name),
        }
    }

    fn code(&self) -> Option<&dyn RealizationCode> {
        Some(self)
    }

    fn is_reversible(&self) -> bool {
        self.is_reversible
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        self.series
            .as_ref()
            .map(|series| series as &dyn SourceSeries)
    }
}

impl RealizationCode for FormulaRealization {
    /// Base x. Sums of code collect like terms, so that x drops out of β̂ − x and what α̂ and β̂ have
    /// in common drops out of α̂ − β̂ wherever the formulas are sums.
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let d = self.dimension();
        let write = |graph: &mut Graph, formulas: &[Expression], p: &[Term]| {
            let mut variables = |_: &mut Graph, at: usize| -> Result<Term, AlgebraError> {
                Ok(match at {
                    at if at < d => z[at].clone(),
                    at if at < 2 * d => p[at - d].clone(),
                    _ => epsilon.clone(),
                })
            };
            formulas
                .iter()
                .map(|formula| formula.evaluate_in(graph, &mut variables))
                .collect::<Result<Vec<Term>, AlgebraError>>()
        };
        let p = &z[d..];
        let alpha = write(graph, &self.formulas.alpha, p)?;
        let beta = match &self.formulas.beta {
            Some(beta) => write(graph, beta, p)?,
            None => {
                let minus: Vec<Term> = p.iter().map(|p| graph.negate(p)).collect();
                write(graph, &self.formulas.alpha, &minus)?
            }
        };
        let one = Rational::one();
        let mut difference = |a: &[Term], b: &[Term]| -> Vec<Term> {
            a.iter()
                .zip(b)
                .map(|(a, b)| graph.combine(&[(one.clone(), a.clone()), (-&one, b.clone())]))
                .collect()
        };
        let base = z[..d].to_vec();
        let offset = difference(&beta, &base);
        let increment = difference(&alpha, &beta);
        let guard = match &self.formulas.domain {
            None => None,
            Some(domain) => {
                let reach = write(graph, std::slice::from_ref(domain), p)?;
                Some((vec![graph.one(); d], vec![reach[0].clone(); d]))
            }
        };
        Ok(SourceTarget {
            base,
            offset,
            increment,
            guard,
        })
    }
}
