//! Formulas of a part's parameter, parsed.

use leafwise_expression::syntax::{Formula, Scope, SyntaxError};
use leafwise_expression::{Expression, Graph};

use crate::error::BuildError;
use crate::system::PoissonSystem;

/// Formulas of one parameter of a part, separated by `;`.
#[derive(Clone, Copy, Debug)]
pub struct FormulaText<'a> {
    /// The part's name.
    pub part: &'static str,
    /// The parameter's.
    pub parameter: &'static str,
    /// The text.
    pub text: &'a str,
}

impl FormulaText<'_> {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.text.trim().is_empty()
    }

    /// Their number.
    pub fn len(&self) -> usize {
        match self.is_empty() {
            true => 0,
            false => self.text.split(SEPARATOR).count(),
        }
    }

    /// The formulas by the names of `scope`; none of an empty text.
    ///
    /// # Errors
    /// [`BuildError::Formula`] for the first that cannot be read.
    pub fn parse(&self, scope: &Scope) -> Result<Vec<Expression>, BuildError> {
        if self.is_empty() {
            return Ok(Vec::new());
        }
        let formulas = self.text.split(SEPARATOR).enumerate();
        formulas
            .map(|(position, text)| {
                let refused = |span, problem| BuildError::Formula {
                    part: self.part,
                    parameter: self.parameter.to_owned(),
                    position,
                    span,
                    problem,
                };
                let wrong =
                    |error: SyntaxError| refused(Some(error.span.clone()), error.to_string());
                let formula = Formula::parse(text.trim()).map_err(wrong)?;
                let formula = formula.resolve(scope, None).map_err(wrong)?;
                let formula = formula.unwrap_or_else(|| Expression::Sum(Vec::new()));
                let mut graph = Graph::new();
                formula
                    .evaluate_in(&mut graph, &mut |graph, at| Ok(graph.input(at)))
                    .map_err(|error| refused(None, error.to_string()))?;
                Ok(formula)
            })
            .collect()
    }

    /// The same, of which there are d: one for each coordinate.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse), and [`BuildError::Parameter`] for another number.
    pub fn parse_all(&self, scope: &Scope, d: usize) -> Result<Vec<Expression>, BuildError> {
        let formulas = self.parse(scope)?;
        if formulas.len() == d {
            return Ok(formulas);
        }
        Err(BuildError::Parameter {
            part: self.part,
            parameter: self.parameter.to_owned(),
            value: format!("[{} formulas]", formulas.len()),
            expected: format!("{d} formulas"),
        })
    }
}

/// Separator of two formulas in one text.
const SEPARATOR: char = ';';

/// Names that the formulas of a part may use. They are the system's variables, then `further` ones, its parameters, and
/// its names for formulas.
///
/// # Errors
/// [`BuildError::DoesNotFit`] where the system has one of the further names itself. Coordinates that formulas call by
/// an index give the same error.
pub fn scope(
    part: &'static str,
    system: &PoissonSystem,
    further: &[String],
) -> Result<Scope, BuildError> {
    let unfit = |reason| BuildError::DoesNotFit { part, reason };
    let variables = system.variables();
    if let Some(indexed) = variables.iter().find(|name| name.contains('[')) {
        return Err(unfit(format!(
            "its formulas name single variables, and `{indexed}` is one of a family"
        )));
    }
    let parameters = system.parameters().iter();
    let parameters: Vec<&str> = parameters.map(|p| p.name.as_str()).collect();
    let named = system.expressions().map_or(&[][..], |own| own.names());
    let own = variables.iter().map(String::as_str);
    let own = own.chain(parameters.iter().copied());
    let mut own = own.chain(named.iter().map(|(name, _)| name.as_str()));
    if let Some(taken) = own.find(|name| further.iter().any(|other| other == name)) {
        return Err(unfit(format!(
            "its formulas use the name `{taken}`, which the system has given away: rename that one"
        )));
    }
    let scope = Scope::new()
        .with_variables(variables)
        .with_variables(further)
        .with_parameters(&parameters);
    let named = named
        .iter()
        .filter(|(name, _)| Scope::check_name(name).is_ok());
    Ok(named.fold(scope, |scope, (name, formula)| {
        scope.with_definition(name, formula.clone())
    }))
}
