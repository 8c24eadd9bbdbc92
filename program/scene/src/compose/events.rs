//! Events that a run watches between its steps: the stop that ends it, and the section that it is recorded on.

use leafwise_core::PoissonSystem;
use leafwise_expression::Expression;
use leafwise_expression::syntax::{EQUAL_MARGIN, Formula, Scope, SyntaxErrorKind};
use leafwise_walk::{Act, Direction, Section, Stop};

use super::Refusal;
use super::acts::{ActTensor, act, tensor_of};
use super::definitions::scope;
use super::extended::Extension;
use super::geometry::geometry;
use super::names::{check_code, function, refusal, with_families};
use super::observables::Observable;
use super::states::RecordedStates;
use crate::document::{BracketSpec, Located, Place, SceneDocument, Source, nearest};

/// Events that a run watches: its stop and its section.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Where the run ends.
    pub stop: Option<Stop>,
    /// The surface whose crossings are recorded.
    pub section: Option<Section>,
    /// The change of the state there, where there is one.
    pub act: Option<Act>,
    /// Whether the motion through it is a Poisson map.
    pub act_tensor: Option<ActTensor>,
    /// The columns of `section.csv` that the report draws over each other, where the scene names them.
    pub axes: Option<[String; 2]>,
}

/// Refuses what a scene is asked for that its events would make something else: `what` is of the motion between them.
///
/// # Errors
/// Where an event of the scene changes the state.
pub fn refuse_acts(document: &SceneDocument, what: &str, help: &str) -> Result<(), Refusal> {
    let section = document.run.section.as_ref();
    match section.and_then(|section| section.set.as_ref()) {
        None => Ok(()),
        Some(set) => Err(Box::new(document.diagnostic(
            &set.place(),
            format!("{what} where events change the state"),
            "here",
            Some(help.to_owned()),
        ))),
    }
}

/// Reads `stop` and `section` of a scene.
pub(super) fn events(document: &SceneDocument, scope: &Scope) -> Result<Events, Refusal> {
    let run = &document.run;
    let stop = match &run.stop {
        Some(text) => Some(Stop {
            text: text.value.trim().to_owned(),
            difference: margin(document, scope, text)?,
        }),
        None => None,
    };
    let section = match &run.section {
        Some(section) => Some(Section {
            text: section.at.value.trim().to_owned(),
            difference: difference(document, scope, &section.at)?,
            direction: section.direction,
        }),
        None => None,
    };
    let axes = run
        .section
        .as_ref()
        .and_then(|section| section.axes.clone());
    let axes = axes.map(|axes| axes.map(|axis| axis.value));
    let act = match &run.section {
        Some(section) => act(document, scope, section)?,
        None => None,
    };
    Ok(Events {
        stop,
        section,
        act_tensor: act.as_ref().map(|_| ActTensor::Unknown),
        act,
        axes,
    })
}

impl Events {
    /// Looks whether the motion through what acts is a Poisson map.
    pub(super) fn look_at_tensor(
        &mut self,
        document: &SceneDocument,
        system: &PoissonSystem,
        initial: &[f64],
    ) {
        // The tensor of a contact scene is that of its homogeneous system.
        let is_contact = matches!(document.system.bracket.value, BracketSpec::Contact(_));
        if let (Some(section), Some(act), false) = (&self.section, &self.act, is_contact) {
            let step = &document.method.step;
            let step = step.epsilon() * step.h();
            let (own, parameters) = (document.system.coordinates(), system.parameter_values());
            let at = (initial, &*parameters);
            self.act_tensor = Some(tensor_of(system, (section, act), at, (own, step)));
        }
    }

    /// The act and what it does to the tensor, in words.
    pub fn act_text(&self) -> Option<String> {
        let (act, tensor) = (self.act.as_ref()?, self.act_tensor?);
        Some(format!("sets {}; {}", act.text, tensor.text()))
    }

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
            moves(document, text, &stop.difference, initial, parameters)?;
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
        if let (Some(section), Some(spec)) = (&self.section, &run.section) {
            defined(document, &spec.at, &section.difference, initial, parameters)?;
            moves(document, &spec.at, &section.difference, initial, parameters)?;
        }
        Ok(())
    }
}

/// Surface `left = right` of a scene, given by `text`, beside the one that the scene may have itself. The run begins at
/// `initial` with these `parameters`. Its lattice is a long one where `is_long`.
///
/// # Errors
/// A text that is no formula. A formula that has no value where the run begins.
pub fn section_of(
    document: &SceneDocument,
    is_long: bool,
    (initial, parameters): (&[f64], &[f64]),
    text: &str,
    direction: Direction,
) -> Result<Section, Refusal> {
    let lattice = geometry(document);
    let given = format!("events = \"{text}\"");
    let place = Place {
        span: given.len() - text.len() - 2..given.len(),
        source: Source::Override(given.into()),
    };
    let text = Located::new(text.to_owned(), place);
    let mut scope = scope(document, &lattice, None)?;
    // No long lattice has the time as a coordinate.
    if !is_long {
        Extension::of(document, &lattice, &mut scope)?;
    }
    let section = Section {
        text: text.value.trim().to_owned(),
        difference: difference(document, &scope, &text)?,
        direction,
    };
    defined(document, &text, &section.difference, initial, parameters)?;
    Ok(section)
}

/// Refuses axes that are no columns of `section.csv`.
pub(super) fn check_axes(
    document: &SceneDocument,
    states: &RecordedStates,
    observables: &[Observable],
) -> Result<(), Refusal> {
    let axes = document.run.section.as_ref();
    let axes = axes.and_then(|section| section.axes.as_ref());
    let mut columns = match states.are_in_samples() {
        true => states.names(),
        false => Vec::new(),
    };
    columns.extend(
        observables
            .iter()
            .map(|observable| observable.name().to_owned()),
    );
    for axis in axes.into_iter().flatten() {
        if !columns.contains(&axis.value) {
            return Err(Box::new(document.diagnostic(
                &axis.place(),
                format!("`{}` is not a column of section.csv", axis.value),
                "not recorded",
                Some(
                    match nearest(&axis.value, columns.iter().map(String::as_str)) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!("columns: {}", columns.join(", ")),
                    },
                ),
            )));
        }
    }
    Ok(())
}

/// A condition as `if` takes it, as a number that is positive where it holds and negative elsewhere.
fn margin(
    document: &SceneDocument,
    scope: &Scope,
    text: &Located<String>,
) -> Result<Expression, Refusal> {
    const EXAMPLE: &str =
        "write when the run is to end, as \"q1^2 + q2^2 > 1\", or with `and`, `or` and `not`";
    let whole = text.value.trim();
    if !whole.contains(['<', '>', '=']) {
        let message = format!("`{whole}` compares nothing: it has no <, <=, >, >=");
        return Err(refuse(document, text, message, "no comparison", EXAMPLE));
    }
    let vectors = document.system.named_vectors();
    let condition = Formula::parse_condition(&text.value)
        .and_then(|parsed| parsed.with_sites(&document.system.site_names))
        .and_then(|parsed| parsed.in_components(&vectors))
        .and_then(|parsed| with_families(document, parsed));
    let condition = condition.map_err(|error| match error.kind {
        SyntaxErrorKind::UnexpectedCharacter { character: '=' } => Box::new(document.diagnostic(
            &document.place_in_formula(text, error.span.clone()),
            "two formulas with one of <, <=, >, >= between them are expected",
            "here",
            Some(EXAMPLE.to_owned()),
        )),
        _ => refusal(document, text, &error),
    })?;
    if condition.is_of_points() {
        return Err(refuse(
            document,
            text,
            format!("`{whole}` holds only at single points, which steps pass over"),
            "no end",
            "compare by <, <=, > or >=; `section` finds where both sides are equal",
        ));
    }
    let margin = condition
        .margin(scope)
        .map_err(|error| refusal(document, text, &error))?;
    check_code(document, text, &margin)?;
    Ok(margin)
}

/// Left − right of a surface, or a function of its sign where a root of squares is compared.
fn difference(
    document: &SceneDocument,
    scope: &Scope,
    text: &Located<String>,
) -> Result<Expression, Refusal> {
    const EXAMPLE: &str = "write a surface, as \"q1 = 0\"";
    let whole = text.value.as_str();
    let is_sign = |c: char| "<>=".contains(c);
    // A sign inside parentheses belongs to a double sum, `sum(i < j, …)`, or to a choice.
    let mut depth = 0_usize;
    let mut outside = whole.char_indices().filter_map(|(at, c)| {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            _ => return (depth == 0 && is_sign(c)).then_some(at),
        }
        None
    });
    let Some(start) = outside.next() else {
        let message = format!("`{}` compares nothing: it has no =", whole.trim());
        return Err(refuse(document, text, message, "no comparison", EXAMPLE));
    };
    let length = whole[start..].find(|c| !is_sign(c));
    let end = length.map_or(whole.len(), |length| start + length);
    if &whole[start..end] != "=" || outside.any(|at| at >= end) {
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(text, start..end),
            "two formulas with = between them are expected",
            "here",
            Some(EXAMPLE.to_owned()),
        )));
    }
    // Each side stands at its place in the whole, for messages.
    let side = |text: &Located<String>, side: String| Located::new(side, text.place());
    let left = side(text, whole[..start].to_owned());
    let right = side(text, " ".repeat(end) + &whole[end..]);
    let left = function(document, scope, &left)?;
    let right = function(document, scope, &right)?;
    if let Some(difference) = Expression::compared_magnitude(&left, &right) {
        return Ok(difference);
    }
    let right = Expression::Negate(Box::new(right));
    Ok(Expression::Sum(vec![left, right]))
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

/// Refuses a difference that no state changes: without a coordinate or the time in it, or 0 wherever one looks.
fn moves(
    document: &SceneDocument,
    text: &Located<String>,
    difference: &Expression,
    initial: &[f64],
    parameters: &[f64],
) -> Result<(), Refusal> {
    let whole = text.value.trim();
    let why = if difference.variables().is_empty() {
        "it contains neither a coordinate nor the time"
    } else {
        let is_equal = |difference: f64| difference.abs() <= EQUAL_MARGIN;
        // Near and far, on both sides.
        let scales = [1.0, -1.0, 1e3, -1e3, 1e6];
        let is_zero = |scale: &f64| {
            let moved = initial.iter().zip(1_u32..);
            let state: Vec<f64> = moved
                .map(|(x, at)| x + scale * libm::sin(f64::from(at)))
                .collect();
            is_equal(difference.evaluate(&state, parameters))
        };
        if !is_equal(difference.evaluate(initial, parameters)) || !scales.iter().all(is_zero) {
            return Ok(());
        }
        "both sides are the same wherever the motion is"
    };
    Err(refuse(
        document,
        text,
        format!("`{whole}` never changes: {why}"),
        "nothing happens here",
        "compare a formula of the coordinates with another one, as in \"q1 = 0\" or \"q1 > 1\"",
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
