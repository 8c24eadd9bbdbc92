//! A declaration as a part of the registry.

use leafwise_core::part::{PATH, PartInfo};
use leafwise_core::registry::{DynamicsPart, Part, RealizationPart, StepperPart, SystemPart};
use leafwise_core::{BuildError, PartKind, PartParameters};

use crate::declaration::{Functions, PartDeclaration, ValuePath};
use crate::error::Refusal;
use crate::foreign::{
    ForeignDynamicsPart, ForeignPart, ForeignRealizationPart, ForeignStepMapPart, ForeignSystemPart,
};
use crate::formulas::{
    FormulaDynamicsPart, FormulaRealizationPart, FormulaStepMapPart, FormulaSystemPart,
};

/// A part by its formulas, by its functions, or by whichever its parameter `path` names.
struct Either<F, N> {
    info: &'static PartInfo,
    formulas: Option<F>,
    numbers: Option<N>,
}

impl<F, N> Either<F, N> {
    fn new(
        declaration: &PartDeclaration,
        info: &'static PartInfo,
        formulas: impl FnOnce(&PartDeclaration, &'static PartInfo) -> Result<F, Refusal>,
        numbers: impl FnOnce(ForeignPart, Functions) -> Option<N>,
    ) -> Result<Self, Refusal> {
        let has_formulas = !declaration.formulas.is_empty();
        Ok(Self {
            info,
            formulas: has_formulas
                .then(|| formulas(declaration, info))
                .transpose()?,
            numbers: declaration.functions.and_then(|functions| {
                numbers(ForeignPart::new(declaration, functions, info), functions)
            }),
        })
    }

    /// The result of formulas or of functions, whichever the part has or its parameter `path`
    /// names.
    fn chosen<T>(
        &self,
        parameters: &PartParameters,
        by_formulas: impl FnOnce(&F) -> Result<T, BuildError>,
        by_numbers: impl FnOnce(&N) -> Result<T, BuildError>,
    ) -> Result<T, BuildError> {
        match (&self.formulas, &self.numbers) {
            (Some(formulas), Some(numbers)) => {
                let word = parameters.word(self.info, PATH, &ValuePath::WORDS)?;
                if word == ValuePath::Numbers.word() {
                    by_numbers(numbers)
                } else {
                    by_formulas(formulas)
                }
            }
            (Some(formulas), None) => by_formulas(formulas),
            (None, numbers) => {
                by_numbers(numbers.as_ref().expect("a part has formulas or functions"))
            }
        }
    }

    /// The same; what the functions of a part refuse, its formulas do not serve either.
    fn served_by_both<T>(
        &self,
        parameters: &PartParameters,
        by_formulas: impl FnOnce(&F) -> Result<T, BuildError>,
        by_numbers: impl Fn(&N) -> Result<T, BuildError>,
    ) -> Result<T, BuildError> {
        if let (Some(_), Some(numbers)) = (&self.formulas, &self.numbers) {
            by_numbers(numbers)?;
        }
        self.chosen(parameters, by_formulas, by_numbers)
    }
}

/// The part of a declaration.
pub(crate) fn part(
    declaration: &PartDeclaration,
    info: &'static PartInfo,
) -> Result<Part, Refusal> {
    Ok(match declaration.kind() {
        PartKind::System => system(declaration, info)?.into(),
        PartKind::Realization => realization(declaration, info)?.into(),
        PartKind::Dynamics => dynamics(declaration, info)?.into(),
        _ => step_map(declaration, info)?.into(),
    })
}

fn system(declaration: &PartDeclaration, info: &'static PartInfo) -> Result<SystemPart, Refusal> {
    let numbers = |part, functions| match functions {
        Functions::System(table) => Some(ForeignSystemPart::new(part, table)),
        _ => None,
    };
    let either = Either::new(declaration, info, FormulaSystemPart::new, numbers)?;
    let fragment = either.formulas.as_ref().map(|part| part.fragment.clone());
    let part = SystemPart::new(info, move |given| {
        either.chosen(given, |part| part.build(given), |part| part.build(given))
    });
    Ok(match fragment {
        Some(fragment) => part.with_fragment(fragment),
        None => part,
    })
}

fn realization(
    declaration: &PartDeclaration,
    info: &'static PartInfo,
) -> Result<RealizationPart, Refusal> {
    let numbers = |part, functions| match functions {
        Functions::Realization(table) => Some(ForeignRealizationPart::new(part, table)),
        _ => None,
    };
    let either = Either::new(declaration, info, FormulaRealizationPart::new, numbers)?;
    Ok(RealizationPart::new(info, move |system, given| {
        either.served_by_both(
            given,
            |part| part.build(system, given),
            |part| part.build(system, given),
        )
    }))
}

fn dynamics(
    declaration: &PartDeclaration,
    info: &'static PartInfo,
) -> Result<DynamicsPart, Refusal> {
    let numbers = |part, functions| match functions {
        Functions::Dynamics(table) => Some(ForeignDynamicsPart::new(part, table)),
        _ => None,
    };
    let either = Either::new(declaration, info, FormulaDynamicsPart::new, numbers)?;
    Ok(DynamicsPart::new(info, move |given| {
        either.served_by_both(given, |part| part.build(given), |part| part.build(given))
    }))
}

fn step_map(
    declaration: &PartDeclaration,
    info: &'static PartInfo,
) -> Result<StepperPart, Refusal> {
    let numbers = |part, functions| match functions {
        Functions::StepMap(table) => Some(ForeignStepMapPart::new(part, table)),
        _ => None,
    };
    let either = Either::new(declaration, info, FormulaStepMapPart::new, numbers)?;
    Ok(StepperPart::new(info, move |system, given| {
        either.served_by_both(
            given,
            |part| part.build(system, given),
            |part| part.build(system, given),
        )
    }))
}
