//! What a run watches between its steps: where it ends.

use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::lattice::DENSE_LIMIT;
use super::names::function;
use crate::document::{Located, SceneDocument};

/// Where a run ends before its last step: left > right, or another comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// As the scene writes it.
    pub text: String,
    /// The larger side less the smaller one.
    pub difference: Expression,
    /// Whether it holds where both sides are equal.
    pub is_closed: bool,
}

impl Stop {
    /// Whether it holds where the [`difference`](Self::difference) has this value.
    pub fn holds(&self, difference: f64) -> bool {
        difference > 0.0 || (self.is_closed && difference == 0.0)
    }
}

/// What is watched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Where the run ends.
    pub stop: Option<Stop>,
}

/// Reads `stop` of a scene.
pub(super) fn events(document: &SceneDocument, scope: &Scope) -> Result<Events, Refusal> {
    let run = &document.run;
    let stop = match &run.stop {
        Some(text) => {
            let (difference, sign) = difference(document, scope, text, &["<", "<=", ">", ">="])?;
            Some(Stop {
                text: text.value.trim().to_owned(),
                difference: match sign.starts_with('<') {
                    true => Expression::Negate(Box::new(difference)),
                    false => difference,
                },
                is_closed: sign.ends_with('='),
            })
        }
        None => None,
    };
    Ok(Events { stop })
}

impl Events {
    /// Refuses what has no value where the run begins, and a run that would make no step.
    pub(super) fn check(
        &self,
        document: &SceneDocument,
        initial: &[f64],
        parameters: &[f64],
    ) -> Result<(), Refusal> {
        let run = &document.run;
        if let (Some(stop), Some(text)) = (&self.stop, &run.stop) {
            let value = defined(document, text, &stop.difference, initial, parameters)?;
            if stop.holds(value) {
                return Err(refuse(
                    document,
                    text,
                    format!(
                        "`{}` holds at the initial state: the run would make no step",
                        stop.text
                    ),
                    "at the initial state",
                    "begin where it does not hold, or turn the comparison round",
                ));
            }
        }
        Ok(())
    }
}

/// Refuses events where sites of a lattice are stepped by templates.
pub(super) fn refuse_on_a_long_lattice(document: &SceneDocument) -> Result<(), Refusal> {
    let run = &document.run;
    let watched = run.stop.as_ref().map(|stop| ("stop", stop));
    let Some((key, text)) = watched else {
        return Ok(());
    };
    Err(refuse(
        document,
        text,
        format!("`{key}` is not offered on a lattice of more than {DENSE_LIMIT} coordinates"),
        "here",
        "shorten the lattice, or record the formula as an observable",
    ))
}

/// Left − right of a comparison with one of `signs`, and its sign.
fn difference<'a>(
    document: &SceneDocument,
    scope: &Scope,
    text: &'a Located<String>,
    signs: &[&str],
) -> Result<(Expression, &'a str), Refusal> {
    let whole = text.value.as_str();
    let is_sign = |c: char| "<>=".contains(c);
    let listed = signs.join(", ");
    let example = match signs.len() {
        1 => "write a surface, as \"q1 = 0\"",
        _ => "write when the run is to end, as \"q1^2 + q2^2 > 1\"",
    };
    let Some(start) = whole.find(is_sign) else {
        let message = format!("`{}` compares nothing: it has no {listed}", whole.trim());
        return Err(refuse(document, text, message, "no comparison", example));
    };
    let length = whole[start..].find(|c| !is_sign(c));
    let end = length.map_or(whole.len(), |length| start + length);
    let sign = &whole[start..end];
    if !signs.contains(&sign) || whole[end..].contains(is_sign) {
        let message = format!("two formulas with one of {listed} between them are expected");
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(text, start..end),
            message,
            "here",
            Some(example.to_owned()),
        )));
    }
    // Each side stands at its place in the whole, for messages.
    let side = |text: &Located<String>, side: String| Located::new(side, text.place());
    let left = side(text, whole[..start].to_owned());
    let right = side(text, " ".repeat(end) + &whole[end..]);
    let left = function(document, scope, &left)?;
    let right = Expression::Negate(Box::new(function(document, scope, &right)?));
    Ok((Expression::Sum(vec![left, right]), sign))
}

/// The value of a difference at the initial state.
fn defined(
    document: &SceneDocument,
    text: &Located<String>,
    difference: &Expression,
    initial: &[f64],
    parameters: &[f64],
) -> Result<f64, Refusal> {
    let value = difference.evaluate(initial, parameters);
    if !value.is_nan() {
        return Ok(value);
    }
    Err(refuse(
        document,
        text,
        format!("`{}` has no value at the initial state", text.value.trim()),
        "at the initial state",
        "check `initial` and the formula: no ln or root of a negative number, no division of zero by zero",
    ))
}

fn refuse(
    document: &SceneDocument,
    text: &Located<String>,
    message: String,
    label: &str,
    help: &str,
) -> Refusal {
    let place = document.place_in_formula(text, 0..text.value.len());
    Box::new(document.diagnostic(&place, message, label, Some(help.to_owned())))
}
