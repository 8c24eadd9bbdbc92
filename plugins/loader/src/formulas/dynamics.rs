//! A dynamic approximation by the coefficients of its generating function.

use std::sync::Arc;

use leafwise_core::dynamics::{Generating, GeneratingFunction};
use leafwise_core::part::PartInfo;
use leafwise_core::{
    BuildError, Correction, DynamicApproximation, GraphBisection, LagrangianBisection, OneForm,
    PartParameters, PoissonSystem, RealizationData,
};
use leafwise_expression::{Expression, Polynomial, Ring};

use super::keys::{names, only, parse, refused, scope, values};
use crate::declaration::{Dimensions, Flags, PartDeclaration};
use crate::error::Refusal;
use crate::foreign::check_dimension;

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
            flags: self.flags,
            dimensions: self.dimensions,
            coefficients: self.formulas.coefficients.iter().map(bound).collect(),
        }))
    }
}

/// graph(dŜ), Ŝ by formulas.
#[derive(Clone, Debug)]
struct FormulaDynamics {
    name: &'static str,
    order: usize,
    flags: Flags,
    dimensions: Dimensions,
    coefficients: Vec<Expression>,
}

impl DynamicApproximation for FormulaDynamics {
    fn order(&self) -> usize {
        self.order
    }

    fn self_adjoint(&self) -> Option<bool> {
        self.flags.self_adjoint()
    }

    fn correction(&self) -> Correction {
        if self.flags.is_uncorrected() {
            Correction::None
        } else {
            Correction::Bisection
        }
    }

    fn describe(&self) -> String {
        format!("{} m = {}", self.name, self.order)
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<Arc<dyn LagrangianBisection>, BuildError> {
        let d = system.dimension();
        check_dimension(self.name, self.dimensions, d)?;
        let beyond = |index: usize| BuildError::DoesNotFit {
            part: self.name,
            reason: format!("it names x{}, and this system has dimension {d}", index + 1),
        };
        let mut ring = Ring::new(d);
        let mut coefficients = Vec::with_capacity(self.coefficients.len());
        let mut gradients = Vec::with_capacity(self.coefficients.len());
        for formula in &self.coefficients {
            if let Some(index) = formula.variables().last().filter(|index| **index >= d) {
                return Err(beyond(*index));
            }
            let s: Polynomial =
                formula.evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))?;
            gradients.push(ring.gradient(&s)?);
            coefficients.push(s);
        }
        let generating = Generating::Polynomials(GeneratingFunction {
            ring,
            coefficients,
            gradients,
        });
        let parameters = system.parameters().len();
        let describe = self.describe();
        let graph = GraphBisection::new(
            OneForm::Differential(generating),
            realization,
            parameters,
            &describe,
        )?;
        Ok(Arc::new(graph))
    }
}
