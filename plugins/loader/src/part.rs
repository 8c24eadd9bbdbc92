//! A declaration as a part of the registry.

use std::sync::Arc;

use leafwise_core::part::PartInfo;
use leafwise_core::registry::{DynamicsPart, Part, RealizationPart, StepperPart, SystemPart};
use leafwise_core::solver::StepMap;
use leafwise_core::{
    BuildError, DynamicApproximation, PartKind, PartParameters, PoissonSystem, RealizationData,
};

use crate::declaration::{Functions, PartDeclaration, ValuePath};
use crate::error::Refusal;
use crate::foreign::{
    ForeignDynamicsPart, ForeignPart, ForeignRealizationPart, ForeignStepMapPart, ForeignSystemPart,
};
use crate::formulas::{
    FormulaDynamicsPart, FormulaRealizationPart, FormulaStepMapPart, FormulaSystemPart,
};
use crate::handshake::PATH;

/// A part of one kind by its formulas, by its functions, or by whichever its parameter `path` names.
struct Either<P: ?Sized> {
    info: &'static PartInfo,
    formulas: Option<Arc<P>>,
    numbers: Option<Arc<P>>,
}

impl<P: ?Sized> Either<P> {
    fn path(&self, parameters: &PartParameters) -> Result<ValuePath, BuildError> {
        match (&self.formulas, &self.numbers) {
            (Some(_), Some(_)) => {
                let words = [ValuePath::Expressions, ValuePath::Numbers].map(ValuePath::word);
                let word = parameters.word(self.info, PATH, &words)?;
                Ok(if word == ValuePath::Numbers.word() {
                    ValuePath::Numbers
                } else {
                    ValuePath::Expressions
                })
            }
            (Some(_), None) => Ok(ValuePath::Expressions),
            (None, _) => Ok(ValuePath::Numbers),
        }
    }

    fn chosen(&self, parameters: &PartParameters) -> Result<&P, BuildError> {
        let part = match self.path(parameters)? {
            ValuePath::Expressions => &self.formulas,
            ValuePath::Numbers => &self.numbers,
        };
        Ok(part.as_deref().expect("a part has formulas or functions"))
    }

    fn word(&self, parameters: &PartParameters) -> Option<&'static str> {
        self.path(parameters).ok().map(ValuePath::word)
    }
}

macro_rules! either {
    ($($kind:ident => $result:ty, ($($name:ident: $argument:ty),*);)*) => {$(
        impl $kind for Either<dyn $kind> {
            fn info(&self) -> &'static PartInfo {
                self.info
            }

            fn build(
                &self,
                $($name: $argument,)*
                parameters: &PartParameters,
            ) -> Result<$result, BuildError> {
                // What the functions of a part refuse, its formulas do not serve either.
                if let (Some(_), Some(numbers)) = (&self.formulas, &self.numbers) {
                    numbers.build($($name,)* parameters)?;
                }
                self.chosen(parameters)?.build($($name,)* parameters)
            }

            fn path(&self, parameters: &PartParameters) -> Option<&'static str> {
                self.word(parameters)
            }
        }
    )*};
}

impl SystemPart for Either<dyn SystemPart> {
    fn info(&self) -> &'static PartInfo {
        self.info
    }

    fn build(&self, parameters: &PartParameters) -> Result<PoissonSystem, BuildError> {
        self.chosen(parameters)?.build(parameters)
    }

    fn fragment(&self) -> Option<&str> {
        self.formulas.as_ref()?.fragment()
    }

    fn has_numbers(&self) -> bool {
        self.numbers.is_some()
    }

    fn path(&self, parameters: &PartParameters) -> Option<&'static str> {
        self.word(parameters)
    }
}

either! {
    RealizationPart => Arc<dyn RealizationData>, (system: &PoissonSystem);
    DynamicsPart => Arc<dyn DynamicApproximation>, ();
    StepperPart => Arc<dyn StepMap>, (system: &PoissonSystem);
}

/// The part of a declaration.
pub(crate) fn part(
    declaration: &PartDeclaration,
    info: &'static PartInfo,
) -> Result<Part, Refusal> {
    let foreign = |functions| ForeignPart::new(declaration, functions, info);
    let has_formulas = !declaration.formulas.is_empty();
    let functions = declaration.functions;
    macro_rules! kind {
        ($kind:ident, $trait:ident, $formulas:expr, $table:ident, $foreign:ident) => {{
            let formulas: Option<Arc<dyn $trait>> = if has_formulas {
                Some(Arc::new($formulas))
            } else {
                None
            };
            let numbers: Option<Arc<dyn $trait>> = match functions {
                Some(Functions::$table(table)) => {
                    let part = foreign(Functions::$table(table));
                    Some(Arc::new($foreign::new(part, table)))
                }
                _ => None,
            };
            Part::$kind(Arc::new(Either {
                info,
                formulas,
                numbers,
            }))
        }};
    }
    Ok(match declaration.kind() {
        PartKind::System => kind!(
            System,
            SystemPart,
            FormulaSystemPart::new(declaration, info)?,
            System,
            ForeignSystemPart
        ),
        PartKind::Realization => kind!(
            Realization,
            RealizationPart,
            FormulaRealizationPart::new(declaration, info)?,
            Realization,
            ForeignRealizationPart
        ),
        PartKind::Dynamics => kind!(
            Dynamics,
            DynamicsPart,
            FormulaDynamicsPart::new(declaration, info)?,
            Dynamics,
            ForeignDynamicsPart
        ),
        _ => kind!(
            Stepper,
            StepperPart,
            FormulaStepMapPart::new(declaration, info)?,
            StepMap,
            ForeignStepMapPart
        ),
    })
}
