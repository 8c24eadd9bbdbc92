//! A dynamic approximation by the coefficients of its generating function.

use std::sync::Arc;

use leafwise_core::formulas::FormulaDynamics;
use leafwise_core::part::PartInfo;
use leafwise_core::{BuildError, Correction, DynamicApproximation, PartParameters};
use leafwise_expression::Expression;

use super::keys::{names, only, parse, refused, scope, values};
use crate::declaration::{Dimensions, Flags, PartDeclaration};
use crate::error::Refusal;

/// S_1, S_3, …, a missing one being 0.
#[derive(Clone, Debug)]
pub(super) struct Formulas {
    coefficients: Vec<Expression>,
}

/// Coefficients beyond this one make no difference in doubles.
const LAST: usize = 99;

/// Without dim_max formulas may name so many variables.
const MOST_VARIABLES: usize = 64;

impl Formulas {
    /// The formulas of a part, its parameters open.
    pub(super) fn read(part: &PartDeclaration) -> Result<Self, Refusal> {
        only(part, &["S"])?;
        let dimension = part.dimensions.most.unwrap_or(MOST_VARIABLES);
        let scope = scope(part, &names('x', dimension));
        let mut coefficients = Vec::new();
        for formula in &part.formulas {
            let number = formula
                .0
                .strip_prefix("S.")
                .and_then(|l| l.parse::<usize>().ok());
            let l = number.filter(|l| l % 2 == 1 && *l <= LAST).ok_or_else(|| {
                let problem = format!("the coefficients are S.1, S.3, ..., at most S.{LAST}");
                refused(part, &formula.0, problem)
            })?;
            let place = (l - 1) / 2;
            if coefficients.len() <= place {
                coefficients.resize(place + 1, Expression::Sum(Vec::new()));
            }
            coefficients[place] = parse(part, &scope, formula)?;
        }
        Ok(Self { coefficients })
    }
}

/// A part of kind `LW_KIND_DYNAMICS` with formulas.
pub(crate) struct FormulaDynamicsPart {
    info: &'static PartInfo,
    formulas: Formulas,
    order: usize,
    flags: Flags,
    dimensions: Dimensions,
}

impl FormulaDynamicsPart {
    pub(crate) fn new(part: &PartDeclaration, info: &'static PartInfo) -> Result<Self, Refusal> {
        Ok(Self {
            info,
            formulas: Formulas::read(part)?,
            order: usize::try_from(part.order).unwrap_or(0),
            flags: part.flags,
            dimensions: part.dimensions,
        })
    }

    pub(crate) fn build(
        &self,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        let values = values(self.info, parameters)?;
        let bound = |formula: &Expression| formula.with_parameters(&values);
        Ok(Arc::new(FormulaDynamics {
            name: self.info.name,
            order: self.order,
            self_adjoint: self.flags.self_adjoint(),
            correction: match self.flags.is_uncorrected() {
                true => Correction::None,
                false => Correction::Bisection,
            },
            dimensions: self.dimensions,
            coefficients: self.formulas.coefficients.iter().map(bound).collect(),
        }))
    }
}
