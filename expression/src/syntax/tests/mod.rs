mod branches;
mod choices;
mod definitions;
mod edges;
mod families;
mod grammar;
mod margins;
mod properties;
mod refusals;
mod seams;
mod vectors;

use super::{Formula, Scope, SyntaxError};
use crate::expression::Expression;

fn parse(text: &str) -> Formula {
    Formula::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The expression of a formula of the variables x, y, z and the parameters a, b.
fn resolve(text: &str) -> Expression {
    let resolved = parse(text).resolve(&scalars(), None);
    resolved
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .expect("no boundary")
}

fn scalars() -> Scope {
    Scope::new()
        .with_variables(&["x", "y", "z"])
        .with_parameters(&["a", "b"])
}

/// The error of parsing or else of resolving, without an index.
fn refusal(text: &str, scope: &Scope) -> SyntaxError {
    match Formula::parse(text) {
        Err(error) => error,
        Ok(formula) => match formula.resolve(scope, None) {
            Err(error) => error,
            Ok(expression) => panic!("{text} was accepted: {expression:?}"),
        },
    }
}
