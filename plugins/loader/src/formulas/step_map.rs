//! A step map by formulas of its increment.

use std::sync::Arc;

use leafwise_core::part::PartInfo;
use leafwise_core::solver::{CodeStepMap, ExplicitMap};
use leafwise_core::{BuildError, MapProperties, PartParameters, PoissonSystem, StepMap};
use leafwise_expression::{AlgebraError, Expression, Graph, StepSize, Term};

use super::keys::{names, numbered, only, parse, refused, scope, values};
use crate::declaration::{Dimensions, PartDeclaration};
use crate::error::Refusal;
use crate::foreign::promises;

/// Φ(x) − x over the variables x1 … xd, epsilon, h.
#[derive(Clone, Debug)]
pub(super) struct Formulas {
    increment: Vec<Expression>,
}

impl Formulas {
    /// The formulas of a part, its parameters open.
    pub(super) fn read(part: &PartDeclaration) -> Result<Self, Refusal> {
        only(part, &["increment"])?;
        let increment = numbered(part, "increment")?;
        if increment.is_empty() {
            return Err(refused(part, "increment.1", "it is missing"));
        }
        let mut variables = names('x', increment.len());
        variables.extend(["epsilon".to_owned(), "h".to_owned()]);
        let scope = scope(part, &variables);
        let formulas = increment
            .into_iter()
            .map(|formula| parse(part, &scope, formula));
        Ok(Self {
            increment: formulas.collect::<Result<_, _>>()?,
        })
    }
}

/// A part of kind `LW_KIND_STEP_MAP` with formulas.
pub(crate) struct FormulaStepMapPart {
    info: &'static PartInfo,
    formulas: Formulas,
    properties: MapProperties,
}

impl FormulaStepMapPart {
    pub(crate) fn new(part: &PartDeclaration, info: &'static PartInfo) -> Result<Self, Refusal> {
        let order = usize::try_from(part.order).unwrap_or(0);
        Ok(Self {
            info,
            formulas: Formulas::read(part)?,
            properties: promises(order, part.structure, part.flags.self_adjoint()),
        })
    }

    pub(crate) fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        let d = self.formulas.increment.len();
        Dimensions::only(d).check(self.info.name, system.dimension())?;
        let values = values(self.info, parameters)?;
        let mut graph = Graph::new();
        let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let sizes = [StepSize::Epsilon, StepSize::H].map(|size| graph.step_size(size));
        let increment = self
            .formulas
            .increment
            .iter()
            .map(|formula| {
                let formula = formula.with_parameters(&values);
                formula.evaluate_in(&mut graph, &mut |_, at| {
                    Ok(if at < d {
                        x[at].clone()
                    } else {
                        sizes[at - d].clone()
                    })
                })
            })
            .collect::<Result<Vec<Term>, AlgebraError>>()?;
        let parameters = system.parameters().len();
        let map = ExplicitMap::compile(graph, increment, parameters);
        let description = self.info.name.to_owned();
        Ok(Arc::new(CodeStepMap::new(
            description,
            self.properties,
            map,
        )))
    }
}
