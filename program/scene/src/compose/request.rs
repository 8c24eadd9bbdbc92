//! Requests of a scene for parts, and the errors of such requests.

use leafwise_core::part::{ParameterDefault, ParameterSetting, PartInfo, PartKind};
use leafwise_core::{BuildError, PartParameters, Registry};

use super::Refusal;
use super::part_choice::PartChoice;
use crate::document::{Located, ParameterValue, PartSpec, Place, SceneDocument, Source, nearest};

/// Request of the scene for one part, with defaults where the scene leaves the part open.
pub(super) struct Request<'a> {
    pub(super) document: &'a SceneDocument,
    registry: &'a Registry,
    spec: Option<&'a PartSpec>,
    default: &'static str,
    default_order: i64,
}

impl<'a> Request<'a> {
    pub(super) fn new(
        document: &'a SceneDocument,
        registry: &'a Registry,
        spec: Option<&'a PartSpec>,
        default: &'static str,
        default_order: i64,
    ) -> Self {
        Self {
            document,
            registry,
            spec,
            default,
            default_order,
        }
    }

    /// The name to look up, unless the choice is open.
    pub(super) fn named(&self) -> Option<&'a Located<String>> {
        self.spec
            .map(|spec| &spec.name)
            .filter(|name| name.value != "auto")
    }

    /// Whether the scene gives parameters although it names no part.
    pub(super) fn has_parameters(&self) -> bool {
        self.spec.is_some_and(|spec| !spec.parameters.is_empty())
    }

    pub(super) fn name(&self) -> &'a str {
        self.named().map_or(self.default, |name| &name.value)
    }

    pub(super) fn place(&self) -> Place {
        match self.spec {
            Some(spec) => spec.name.place(),
            None => Place {
                source: Source::Scene,
                span: 0..0,
            },
        }
    }

    pub(super) fn unknown(&self, kind: PartKind) -> Refusal {
        match self.spec {
            Some(spec) => unknown_part(self.document, &spec.name, kind, self.registry),
            None => Box::new(self.document.diagnostic(
                &self.place(),
                format!("no {} is called `{}`", kind.noun(), self.default),
                "this program has no such part",
                None,
            )),
        }
    }

    /// The scene's parameters as whole numbers, each one that the part has.
    pub(super) fn parameters(&self, info: &PartInfo) -> Result<PartParameters, Refusal> {
        let mut given = PartParameters::new();
        let mut names_order = false;
        let part = info.name;
        for (key, value) in self.spec.into_iter().flat_map(|spec| &spec.parameters) {
            let known: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
            if !known.contains(&key.value.as_str()) {
                let help = match nearest(&key.value, known.iter().copied()) {
                    Some(name) => format!("did you mean `{name}`?"),
                    None if key.value == "composition" => self.beside_the_stepper(),
                    None if known.is_empty() => "it takes none".to_owned(),
                    None => format!("it takes: {}", known.join(", ")),
                };
                return Err(Box::new(self.document.diagnostic(
                    &key.place(),
                    format!("`{}` has no parameter `{}`", info.name, key.value),
                    "unknown parameter",
                    Some(help),
                )));
            }
            let info = info.parameters.iter().find(|p| p.name == key.value);
            let setting: Option<ParameterSetting> = match (&value.value, info.map(|p| p.default)) {
                (ParameterValue::Number(number), Some(ParameterDefault::Integer(_))) => {
                    number.literal.parse::<i64>().ok().map(Into::into)
                }
                (ParameterValue::Number(number), Some(ParameterDefault::Real(_))) => {
                    Some(number.value.into())
                }
                (ParameterValue::Text(word), Some(ParameterDefault::Text(_))) => {
                    Some(word.as_str().into())
                }
                (value, Some(ParameterDefault::Formulas(_))) => value.formulas(),
                _ => None,
            };
            let Some(setting) = setting else {
                let expected = match info.map(|p| p.default) {
                    Some(ParameterDefault::Text(_)) => "a word in quotes",
                    Some(ParameterDefault::Formulas(_)) => "a list of formulas",
                    Some(ParameterDefault::Real(_)) => "a number",
                    _ => "a whole number",
                };
                return Err(Box::new(self.document.diagnostic(
                    &value.place(),
                    format!("`{}` of `{part}` must be {expected}", key.value),
                    format!("not {expected}"),
                    info.map(|p| p.summary.to_owned()),
                )));
            };
            names_order |= key.value == "order";
            given = given.with(key.value.clone(), setting);
        }
        if self.named().is_none() && !names_order && self.default_order > 0 {
            given = given.with("order", self.default_order);
        }
        Ok(given)
    }

    /// Where a composition stands, with the first one that comparisons try.
    fn beside_the_stepper(&self) -> String {
        let compared = self.registry.compared(PartKind::Composition);
        let example = compared
            .first()
            .map(|info| format!(": composition = \"{}\"", info.name));
        format!(
            "it is written next to the stepper{}",
            example.unwrap_or_default()
        )
    }

    pub(super) fn refused(&self, error: &BuildError) -> Refusal {
        let written = self.spec.into_iter().flat_map(|spec| &spec.parameters);
        if let BuildError::Parameter {
            part,
            parameter,
            value,
            expected,
        } = error
        {
            let place = written
                .filter(|(key, _)| key.value == *parameter)
                .map(|(_, value)| value.place())
                .next();
            return Box::new(self.document.diagnostic(
                &place.unwrap_or_else(|| self.place()),
                format!("{parameter} = {value} is not allowed for `{part}`"),
                "not allowed",
                Some(expected.clone()),
            ));
        }
        if let Some(refusal) = self
            .spec
            .and_then(|spec| formula_refusal(self.document, spec, error))
        {
            return refusal;
        }
        let message = self.registry.explain(error);
        Box::new(
            self.document
                .diagnostic(&self.place(), message, "this part", None),
        )
    }

    pub(super) fn choice(
        &self,
        info: &'static PartInfo,
        given: &PartParameters,
        path: Option<&'static str>,
    ) -> PartChoice {
        let parameters = info
            .parameters
            .iter()
            .map(|p| {
                (
                    p.name,
                    given
                        .setting(info, p.name)
                        .unwrap_or_else(|_| p.default.into()),
                )
            })
            .collect();
        PartChoice {
            kind: info.kind,
            name: info.name,
            parameters,
            is_automatic: self.named().is_none(),
            reason: None,
            origin: self.registry.origin(info.name).cloned(),
            path,
        }
    }
}

/// The refusal of a formula that a part is given, underlined where it stands.
pub(super) fn formula_refusal(
    document: &SceneDocument,
    spec: &PartSpec,
    error: &BuildError,
) -> Option<Refusal> {
    let BuildError::Formula {
        part,
        parameter,
        position,
        span,
        problem,
    } = error
    else {
        return None;
    };
    if spec.name.value != *part {
        return None;
    }
    let (formula, offset) = spec.formula(parameter, *position)?;
    let inner = match span {
        Some(span) => span.start + offset..span.end + offset,
        None => 0..formula.value.len(),
    };
    let place = document.place_in_formula(formula, inner);
    Some(Box::new(document.diagnostic(
        &place,
        problem.clone(),
        "here",
        None,
    )))
}

pub(super) fn registry_names(registry: &Registry, kind: PartKind) -> Vec<&'static str> {
    registry
        .parts()
        .into_iter()
        .filter(|info| info.kind == kind)
        .map(|info| info.name)
        .collect()
}

/// Help for the name of a method in other programs: its name here.
fn elsewhere(name: &str, kind: PartKind, registry: &Registry) -> Option<String> {
    let letters = |name: &str| -> String {
        let letters = name.chars().filter(|c| c.is_alphanumeric());
        letters.collect::<String>().to_lowercase()
    };
    let asked = letters(name);
    let mut parts = registry
        .parts()
        .into_iter()
        .filter(|info| info.kind == kind);
    parts.find_map(|info| {
        let elsewhere = info.elsewhere?;
        let is_meant = elsewhere.names.iter().any(|known| letters(known) == asked);
        is_meant.then(|| format!("{} = \"{}\" is {}", kind.noun(), info.name, elsewhere.is))
    })
}

fn unknown_part(
    document: &SceneDocument,
    name: &Located<String>,
    kind: PartKind,
    registry: &Registry,
) -> Refusal {
    let known = registry_names(registry, kind);
    let near = nearest(&name.value, known.iter().copied());
    let elsewhere = elsewhere(&name.value, kind, registry);
    let help = match elsewhere.map(Err).or(near.map(Ok)) {
        Some(Err(help)) => help,
        Some(Ok(near)) => format!("did you mean `{near}`?"),
        None if name.value.contains('/') => format!(
            "a name with a `/` is that of a plugin's part: name its library at the top of the scene, \
             plugins = [\"./lib{}.so\"]",
            name.value.split('/').next().unwrap_or_default()
        ),
        None if known.is_empty() => format!("this program has no {}; remove the line", kind.noun()),
        None => format!("known: {}", known.join(", ")),
    };
    Box::new(document.diagnostic(
        &document.place_in_formula(name, 0..name.value.len()),
        format!("no {} is called `{}`", kind.noun(), name.value),
        "unknown name",
        Some(help),
    ))
}
