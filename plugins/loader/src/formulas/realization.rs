//! A realization by formulas in a cotangent chart.

use std::sync::Arc;

use leafwise_core::formulas::{FormulaRealization, RealizationFormulas};
use leafwise_core::part::PartInfo;
use leafwise_core::{
    Accuracy, BuildError, ClosedRealization, PartParameters, PoissonSystem, RealizationData,
};
use leafwise_expression::{Expression, Rational};

use super::keys::{names, numbered, only, parse, refused, scope, values};
use crate::declaration::{Dimensions, Flags, PartDeclaration};
use crate::error::Refusal;

/// The formulas of a part, its parameters open.
pub(super) fn read(part: &PartDeclaration) -> Result<RealizationFormulas, Refusal> {
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
    Ok(RealizationFormulas {
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
fn with_parameters(formulas: &RealizationFormulas, values: &[Rational]) -> RealizationFormulas {
    let all = |formulas: &[Expression]| -> Vec<Expression> {
        let formulas = formulas.iter();
        formulas
            .map(|formula| formula.with_parameters(values))
            .collect()
    };
    RealizationFormulas {
        alpha: all(&formulas.alpha),
        beta: formulas.beta.as_deref().map(all),
        domain: formulas
            .domain
            .as_ref()
            .map(|domain| domain.with_parameters(values)),
    }
}

/// A part of kind `LW_KIND_REALIZATION` with formulas.
pub(crate) struct FormulaRealizationPart {
    info: &'static PartInfo,
    formulas: RealizationFormulas,
    order: usize,
    flags: Flags,
}

impl FormulaRealizationPart {
    pub(crate) fn new(part: &PartDeclaration, info: &'static PartInfo) -> Result<Self, Refusal> {
        Ok(Self {
            info,
            formulas: read(part)?,
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
        Dimensions::only(d).check(self.info.name, system.dimension())?;
        let values = values(self.info, parameters)?;
        let accuracy = match self.flags.is_exact() {
            true => Accuracy::Exact,
            false => Accuracy::Order(self.order),
        };
        let formulas = with_parameters(&self.formulas, &values);
        let form = FormulaRealization::new(formulas, accuracy, self.flags.is_reversible(), &[]);
        Ok(Arc::new(ClosedRealization::new(self.info.name, form)?))
    }
}
