//! What a run records: the energy, Casimirs, or any formula of the state.

use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};

use super::Refusal;
use super::instantiate::function;
use super::names::refusal;
use crate::document::{Located, SceneDocument, nearest};

/// One recorded quantity.
#[derive(Clone, Debug)]
pub enum Observable {
    /// An invariant by its place: 0 is the energy, k the k-th Casimir.
    Invariant {
        /// Its name.
        name: String,
        /// Its place.
        index: usize,
    },
    /// A formula of the state, named by its text.
    Formula {
        /// The text.
        name: String,
        /// The function.
        expression: Expression,
    },
}

impl Observable {
    /// The heading of its column.
    pub fn name(&self) -> &str {
        match self {
            Self::Invariant { name, .. } | Self::Formula { name, .. } => name,
        }
    }
}

/// The observables the scene asks for.
pub(super) fn observables(
    document: &SceneDocument,
    scope: &Scope,
) -> Result<Vec<Observable>, Refusal> {
    let mut known = vec!["energy"];
    known.extend(
        document
            .system
            .casimirs
            .iter()
            .map(|(name, _)| name.value.as_str()),
    );
    let mut chosen: Vec<Observable> = Vec::new();
    for asked in &document.run.record.observables {
        if chosen
            .iter()
            .any(|observable| observable.name() == asked.value)
        {
            return Err(Box::new(document.diagnostic(
                &asked.place(),
                format!("`{}` is recorded twice", asked.value),
                "again",
                Some("remove one of them".to_owned()),
            )));
        }
        chosen.push(match known.iter().position(|name| *name == asked.value) {
            Some(index) => Observable::Invariant {
                name: asked.value.clone(),
                index,
            },
            None => formula(document, scope, asked, &known)?,
        });
    }
    Ok(chosen)
}

fn formula(
    document: &SceneDocument,
    scope: &Scope,
    asked: &Located<String>,
    known: &[&str],
) -> Result<Observable, Refusal> {
    let resolved =
        Formula::parse(&asked.value).and_then(|parsed| parsed.resolve(scope, None).map(drop));
    if let Err(error) = resolved {
        let is_name = asked
            .value
            .chars()
            .all(|c| c.is_alphanumeric() || "_-'".contains(c));
        if !is_name {
            return Err(refusal(document, asked, &error));
        }
        let help = match nearest(&asked.value, known.iter().copied()) {
            Some(name) => format!("did you mean `{name}`?"),
            None => format!("record {}, or a formula of the variables", known.join(", ")),
        };
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(asked, 0..asked.value.len()),
            format!("unknown observable `{}`", asked.value),
            "neither an invariant nor a formula of the variables",
            Some(help),
        )));
    }
    let expression = function(document, scope, asked)?;
    Ok(Observable::Formula {
        name: asked.value.clone(),
        expression,
    })
}
