//! Formulas by key: `alpha.1`, `alpha.2`, …

use leafwise_core::part::ParameterSetting;
use leafwise_core::part::PartInfo;
use leafwise_core::{BuildError, PartParameters};
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Expression, Rational};

use crate::declaration::PartDeclaration;
use crate::error::Refusal;
use crate::foreign::own_settings;

/// The refusal of one formula of a part.
pub(super) fn refused(part: &PartDeclaration, key: &str, problem: impl Into<String>) -> Refusal {
    Refusal::Formula {
        part: part.id().to_owned(),
        key: key.to_owned(),
        problem: problem.into(),
    }
}

/// The part's formulas with keys `family.1` … `family.d`, all of them.
pub(super) fn numbered<'a>(
    part: &'a PartDeclaration,
    family: &str,
) -> Result<Vec<&'a (String, String)>, Refusal> {
    let own: Vec<&(String, String)> = part
        .formulas
        .iter()
        .filter(|(key, _)| key.split('.').next() == Some(family))
        .collect();
    (1..=own.len())
        .map(|number| {
            let key = format!("{family}.{number}");
            let found = own.iter().find(|(own, _)| *own == key).copied();
            found.ok_or_else(|| {
                let all = format!("{family}.1 to {family}.{}", own.len());
                refused(part, &key, format!("it is missing; the keys are {all}"))
            })
        })
        .collect()
}

/// Refuses every key that does not begin with one of these words.
pub(super) fn only(part: &PartDeclaration, words: &[&str]) -> Result<(), Refusal> {
    let known = |key: &str| {
        key.split('.')
            .next()
            .is_some_and(|first| words.contains(&first))
    };
    match part.formulas.iter().find(|(key, _)| !known(key)) {
        None => Ok(()),
        Some((key, _)) => {
            let shown = words.join(", ");
            Err(refused(
                part,
                key,
                format!("no such key here; they begin with {shown}"),
            ))
        }
    }
}

/// Names of variables x1, x2, ….
pub(super) fn names(letter: char, count: usize) -> Vec<String> {
    (1..=count).map(|i| format!("{letter}{i}")).collect()
}

/// Names that formulas of a part may use: these variables and its own numeric parameters.
pub(super) fn scope(part: &PartDeclaration, variables: &[String]) -> Scope {
    let parameters: Vec<&str> = part
        .description
        .parameters
        .iter()
        .filter(|parameter| !matches!(parameter.default, ParameterSetting::Text(_)))
        .map(|parameter| parameter.name.as_str())
        .collect();
    Scope::new()
        .with_variables(variables)
        .with_parameters(&parameters)
}

/// One formula with its names resolved.
pub(super) fn parse(
    part: &PartDeclaration,
    scope: &Scope,
    (key, text): &(String, String),
) -> Result<Expression, Refusal> {
    let wrong = |error: leafwise_expression::syntax::SyntaxError| {
        let column = text
            .get(..error.span.start)
            .map_or(0, |before| before.chars().count());
        refused(
            part,
            key,
            format!("{error} (column {} of `{text}`)", column + 1),
        )
    };
    let expression = Formula::parse(text)
        .map_err(wrong)?
        .resolve(scope, None)
        .map_err(wrong)?;
    Ok(expression.unwrap_or_else(|| Expression::Sum(Vec::new())))
}

/// The values of the part's own numeric parameters, exactly: a double stands for the shortest decimal
/// that reads as it.
pub(super) fn values(
    info: &PartInfo,
    parameters: &PartParameters,
) -> Result<Vec<Rational>, BuildError> {
    let settings = own_settings(info, parameters)?;
    settings
        .into_iter()
        .filter_map(|(name, setting)| match setting {
            ParameterSetting::Integer(value) => Some(Ok(Rational::from_integer(value))),
            ParameterSetting::Real(value) => Some(
                Rational::parse_decimal(&format!("{value:e}")).map_err(|error| {
                    BuildError::Parameter {
                        part: info.name,
                        parameter: name,
                        value: value.to_string(),
                        expected: error.to_string(),
                    }
                }),
            ),
            ParameterSetting::Text(_) => None,
        })
        .collect()
}
