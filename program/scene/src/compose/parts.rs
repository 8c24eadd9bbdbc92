//! Realization and dynamic approximation by name.

use std::sync::Arc;

use leafwise_core::lattice::LatticeMap;
use leafwise_core::part::{Family, PATH, ParameterDefault, ParameterSetting, PartInfo, PartKind};
use leafwise_core::registry::CompositionPart;
use leafwise_core::{
    BuildError, DynamicApproximation, Origin, PartParameters, PoissonSystem, RealizationData,
    Registry, StepMap,
};
use serde::{Serialize, Serializer};

use super::Refusal;
use super::dense::DENSE_LIMIT;
use super::lattice::{STEPPER_LIMIT, SceneLattice};
use super::system::{ComposedSystem, written_out};
use crate::document::{
    Located, Number, ParameterValue, PartSpec, Place, SceneDocument, Source, nearest,
};
use crate::json::object;

/// The order of the dynamics that a scene leaves open.
const DEFAULT_DYNAMICS_ORDER: i64 = 4;
/// What values alone allow.
const ORDER_OF_NUMBERS: i64 = 2;

/// A part as chosen, with all its parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartChoice {
    /// Realization or dynamics.
    pub kind: PartKind,
    /// The part's name.
    pub name: &'static str,
    /// Every parameter with its value.
    #[serde(serialize_with = "object")]
    pub parameters: Vec<(&'static str, ParameterSetting)>,
    /// Where it comes from.
    pub origin: Option<Origin>,
    /// Whether the scene left the choice open.
    #[serde(rename = "chosen", serialize_with = "chosen")]
    pub is_automatic: bool,
    /// Why it was taken, where it was chosen by the tensor.
    #[serde(skip)]
    pub reason: Option<&'static str>,
    /// Where its values come from, for a loaded part: `expressions` or `numbers`.
    #[serde(skip)]
    pub path: Option<&'static str>,
}

/// Who chose a part, in words.
fn chosen<S: Serializer>(is_automatic: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(if *is_automatic {
        "automatically"
    } else {
        "by the scene"
    })
}

impl PartChoice {
    /// The tolerance of a stepper that chooses substeps of its own by it.
    pub fn tolerance(&self) -> Option<f64> {
        let mut parameters = self.parameters.iter();
        parameters.find_map(|(name, value)| match value {
            ParameterSetting::Real(tolerance)
                if self.kind == PartKind::Stepper && *name == "tolerance" =>
            {
                Some(*tolerance)
            }
            _ => None,
        })
    }

    /// Its parameters, to build it again.
    pub(super) fn given(&self) -> PartParameters {
        let parameters = self.parameters.iter();
        parameters.fold(PartParameters::new(), |given, (name, value)| {
            given.with(*name, value.clone())
        })
    }

    /// The name with the values that tell it from its relatives: numbers, and words that are not the
    /// part's usual ones. Formulas are too long for that.
    pub fn line(&self, registry: &Registry) -> String {
        let parts = registry.parts();
        let info = parts
            .iter()
            .find(|p| p.kind == self.kind && p.name == self.name);
        let is_usual = |name: &str, value: &ParameterSetting| {
            let known = info.and_then(|info| info.parameters.iter().find(|p| p.name == name));
            matches!(value, ParameterSetting::Text(_))
                && known.is_some_and(|p| {
                    let is_formulas = matches!(p.default, ParameterDefault::Formulas(_));
                    is_formulas || ParameterSetting::from(p.default) == *value
                })
        };
        // 0 in place of a number that the part finds itself says nothing.
        let is_open = |value: &ParameterSetting| matches!(value, ParameterSetting::Integer(0));
        let told = self
            .parameters
            .iter()
            .filter(|(name, value)| !is_usual(name, value) && !is_open(value));
        told.fold(self.name.to_owned(), |text, (name, value)| {
            text + &format!(" {name} {value}")
        })
    }
}

/// What the scene's method is built of.
pub(super) struct Parts {
    pub base: Base,
    pub composition: Option<(CompositionPart, PartParameters)>,
    pub choices: Vec<PartChoice>,
}

/// What is stepped, or composed.
pub(super) enum Base {
    /// Realization and dynamics.
    Pair(Arc<dyn RealizationData>, Arc<dyn DynamicApproximation>),
    /// A stepper in their place.
    Stepper(Arc<dyn StepMap>),
    /// A stepper that sweeps over a long lattice.
    Sweeps(Arc<dyn LatticeMap>),
    /// A stepper without sweeps and the long lattice that it needs written out.
    WrittenOut(Arc<dyn StepMap>, Box<ComposedSystem>),
}

impl Parts {
    /// The dynamic approximation, unless a stepper stands in its place.
    pub fn dynamics(&self) -> Option<Arc<dyn DynamicApproximation>> {
        match &self.base {
            Base::Pair(_, dynamics) => Some(Arc::clone(dynamics)),
            Base::Stepper(_) | Base::Sweeps(_) | Base::WrittenOut(..) => None,
        }
    }

    /// The realization as chosen, for building it again on another lattice.
    pub fn realization(&self) -> Option<&PartChoice> {
        self.choices
            .iter()
            .find(|choice| choice.kind == PartKind::Realization)
    }
}

/// Builds the parts that `[method]` names, for a system or for the long lattice that it stands for.
///
/// A part that is absent or called `auto` is chosen: Hamilton–Jacobi of order 4 (2 for a system of
/// numbers), the map along leaves where there are forces, and the first exact realization, by rank, that fits the tensor; where none does, or
/// parameters are given with `auto`, Karasev's truncated after the dynamics' order, the smallest n for which Theorem 2 promises it.
pub(super) fn parts(
    document: &SceneDocument,
    system: &PoissonSystem,
    lattice: Option<&SceneLattice<'_>>,
    registry: &Registry,
) -> Result<Parts, Refusal> {
    let mut choices = Vec::new();
    let base = match &document.method.stepper {
        Some(spec) => {
            let request = Request::new(document, Some(spec), "", 0);
            stepper(&request, system, lattice, registry, &mut choices)?
        }
        None => pair(document, system, registry, &mut choices)?,
    };
    let composition = match &document.method.composition {
        None => None,
        Some(spec) => {
            let request = Request::new(document, Some(spec), "", 0);
            let part = registry
                .composition(request.name())
                .map_err(|_| request.unknown(PartKind::Composition, registry))?;
            let given = request.parameters(part.info)?;
            choices.push(request.choice(part.info, &given, None, registry));
            Some((part, given))
        }
    };
    Ok(Parts {
        base,
        composition,
        choices,
    })
}

/// The part that the scene's system comes from, where it is one of the registry's.
pub(super) fn system_choice(document: &SceneDocument, registry: &Registry) -> Option<PartChoice> {
    let library = document.system.library.as_ref()?;
    let part = registry.system(&library.value).ok()?;
    let info = part.info;
    // A built-in system is a text like the scene's own.
    info.paths.first()?;
    let (given, path) = match &document.system.numbers {
        Some(numbers) => (numbers.given.clone(), "numbers"),
        None => {
            let values = document.system.parameters.iter();
            let with = |given: PartParameters,
                        (name, value): &(Located<String>, Located<Number>)| {
                given.with(name.value.clone(), value.value.value)
            };
            (values.fold(PartParameters::new(), with), "expressions")
        }
    };
    let shown = info.parameters.iter().filter(|p| p.name != PATH).map(|p| {
        let value = given.setting(info, p.name);
        (p.name, value.unwrap_or_else(|_| p.default.into()))
    });
    Some(PartChoice {
        kind: info.kind,
        name: info.name,
        parameters: shown.collect(),
        is_automatic: false,
        reason: None,
        origin: registry.origin(info.name).cloned(),
        path: Some(path),
    })
}

/// The stepper that stands in place of realization and dynamics; over a long lattice by sweeps, or
/// written out where it has none and the lattice is not too long for that.
fn stepper(
    request: &Request<'_>,
    system: &PoissonSystem,
    lattice: Option<&SceneLattice<'_>>,
    registry: &Registry,
    choices: &mut Vec<PartChoice>,
) -> Result<Base, Refusal> {
    let part = registry
        .stepper(request.name())
        .map_err(|_| request.unknown(PartKind::Stepper, registry))?;
    let given = request.parameters(part.info)?;
    let refused = |error| request.refused(&error);
    let base = match lattice {
        None => Base::Stepper(part.build(system, &given).map_err(|error| {
            let mut refusal = request.refused(&error);
            let is_unfit = matches!(error, BuildError::DoesNotFit { .. });
            if let Some(pace) = request.document.method.pace.as_ref().filter(|_| is_unfit) {
                let pace = pace.value.trim();
                refusal.message += &format!(
                    "; with a pace the Hamiltonian is (H + e)*({pace}), where t' = {pace}"
                );
                refusal.help = Some("take the pace out, or a realization and dynamics".to_owned());
            }
            refusal
        })?),
        Some(lattice) => match part.build_on_lattice(lattice, &given) {
            Ok(map) => Base::Sweeps(map),
            Err(BuildError::DoesNotFit { .. }) if lattice.dimension() <= STEPPER_LIMIT => {
                let composed = written_out(request.document)?;
                let map = part.build(&composed.system, &given).map_err(refused)?;
                Base::WrittenOut(map, Box::new(composed))
            }
            Err(error) => {
                let mut refusal = request.refused(&error);
                if matches!(error, BuildError::DoesNotFit { .. }) {
                    refusal.help = Some(format!(
                        "a lattice of at most {STEPPER_LIMIT} coordinates is written out for any \
                         stepper; for longer ones name one that sweeps, or a realization and dynamics"
                    ));
                }
                return Err(refusal);
            }
        },
    };
    choices.push(request.choice(part.info, &given, part.info.path(&given), registry));
    Ok(base)
}

fn pair(
    document: &SceneDocument,
    system: &PoissonSystem,
    registry: &Registry,
    choices: &mut Vec<PartChoice>,
) -> Result<Base, Refusal> {
    let (default, order) = if system.has_forces() {
        (registry.of_forces().map_or("auto", |info| info.name), 0)
    } else if system.expressions().is_some() {
        (
            of_order(registry, PartKind::Dynamics),
            DEFAULT_DYNAMICS_ORDER,
        )
    } else {
        (of_order(registry, PartKind::Dynamics), ORDER_OF_NUMBERS)
    };
    let request = Request::new(document, document.method.dynamics.as_ref(), default, order);
    let part = registry
        .dynamics(request.name())
        .map_err(|_| request.unknown(PartKind::Dynamics, registry))?;
    let given = request.parameters(part.info)?;
    let dynamics = part
        .build(&given)
        .map_err(|error| request.refused(&error))?;
    let dynamics_choice = request.choice(part.info, &given, part.info.path(&given), registry);

    let order = i64::try_from(dynamics.order()).unwrap_or(DEFAULT_DYNAMICS_ORDER);
    let request = Request::new(
        document,
        document.method.realization.as_ref(),
        of_order(registry, PartKind::Realization),
        order,
    );
    let is_open = request.named().is_none() && !request.has_parameters();
    let is_long = document.system.coordinates() > DENSE_LIMIT;
    if let Some((realization, choice)) = is_open
        .then(|| exact_realization(system, registry, is_long))
        .flatten()
    {
        choices.push(choice);
        choices.push(dynamics_choice);
        return Ok(Base::Pair(realization, dynamics));
    }
    let part = registry
        .realization(request.name())
        .map_err(|_| request.unknown(PartKind::Realization, registry))?;
    let given = request.parameters(part.info)?;
    let realization = part.build(system, &given).map_err(|error| {
        let mut refusal = request.refused(&error);
        if matches!(error, BuildError::DoesNotFit { .. }) {
            let is_lattice = is_long && !document.system.families.is_empty();
            refusal.help = Some(what_fits(system, registry, dynamics.as_ref(), is_lattice));
        }
        refusal
    })?;
    choices.push(request.choice(part.info, &given, part.info.path(&given), registry));
    choices.push(dynamics_choice);
    Ok(Base::Pair(realization, dynamics))
}

/// The realizations that fit a system and a dynamic approximation, on a long lattice those that can be
/// swept, as a piece of advice.
pub(super) fn what_fits(
    system: &PoissonSystem,
    registry: &Registry,
    dynamics: &dyn DynamicApproximation,
    is_long: bool,
) -> String {
    let fits = |name: &&str| -> Result<bool, BuildError> {
        let part = registry.realization(name)?;
        let realization = part.build(system, &PartParameters::new())?;
        let bisection = dynamics.bisection(system, &realization)?;
        Ok(!is_long || realization.stages().is_some() && bisection.code().is_some())
    };
    let names: Vec<&str> = registry_names(registry, PartKind::Realization)
        .into_iter()
        .filter(|name| matches!(fits(name), Ok(true)))
        .collect();
    match (names.as_slice(), is_long) {
        ([], _) => {
            let splits = registry.family(Family::Splitting);
            let such_as = splits
                .first()
                .map_or(String::new(), |part| format!(" such as {}", part.name));
            format!("a stepper{such_as} may stand in place of both")
        }
        (names, true) => format!(
            "these can be swept over a long lattice: {}",
            names.join(", ")
        ),
        (names, false) => format!("these fit: {}", names.join(", ")),
    }
}

/// The first exact realization, by rank, that fits the tensor; on a long lattice, one that can be swept.
pub fn exact_realization(
    system: &PoissonSystem,
    registry: &Registry,
    is_long: bool,
) -> Option<(Arc<dyn RealizationData>, PartChoice)> {
    let exact = registry.exact_realization(system, is_long)?;
    let info = exact.info;
    let parameters = info.parameters.iter().map(|p| (p.name, p.default.into()));
    let choice = PartChoice {
        kind: PartKind::Realization,
        name: info.name,
        parameters: parameters.collect(),
        is_automatic: true,
        reason: Some(exact.reason),
        origin: registry.origin(info.name).cloned(),
        path: None,
    };
    Some((exact.realization, choice))
}

/// The part that stands in for one that the scene leaves open, where no exact one fits.
fn of_order(registry: &Registry, kind: PartKind) -> &'static str {
    registry.of_order(kind).map_or("auto", |info| info.name)
}

/// What the scene asks of one part.
struct Request<'a> {
    document: &'a SceneDocument,
    spec: Option<&'a PartSpec>,
    default: &'static str,
    default_order: i64,
}

impl<'a> Request<'a> {
    fn new(
        document: &'a SceneDocument,
        spec: Option<&'a PartSpec>,
        default: &'static str,
        default_order: i64,
    ) -> Self {
        Self {
            document,
            spec,
            default,
            default_order,
        }
    }

    /// The name to look up, unless the choice is open.
    fn named(&self) -> Option<&'a Located<String>> {
        self.spec
            .map(|spec| &spec.name)
            .filter(|name| name.value != "auto")
    }

    /// Whether the scene gives parameters although it names no part.
    fn has_parameters(&self) -> bool {
        self.spec.is_some_and(|spec| !spec.parameters.is_empty())
    }

    fn name(&self) -> &'a str {
        self.named().map_or(self.default, |name| &name.value)
    }

    fn place(&self) -> Place {
        match self.spec {
            Some(spec) => spec.name.place(),
            None => Place {
                source: Source::Scene,
                span: 0..0,
            },
        }
    }

    fn unknown(&self, kind: PartKind, registry: &Registry) -> Refusal {
        let known = registry_names(registry, kind);
        match self.spec {
            Some(spec) => unknown_part(self.document, &spec.name, kind, &known),
            None => Box::new(self.document.diagnostic(
                &self.place(),
                format!("no {} is called `{}`", kind.noun(), self.default),
                "this program has no such part",
                None,
            )),
        }
    }

    /// The scene's parameters as whole numbers, each one that the part has.
    fn parameters(&self, info: &PartInfo) -> Result<PartParameters, Refusal> {
        let mut given = PartParameters::new();
        let mut names_order = false;
        let part = info.name;
        for (key, value) in self.spec.into_iter().flat_map(|spec| &spec.parameters) {
            let known: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
            if !known.contains(&key.value.as_str()) {
                let help = match nearest(&key.value, known.iter().copied()) {
                    Some(name) => format!("did you mean `{name}`?"),
                    None if key.value == "composition" => {
                        "it stands beside the stepper: composition = \"suzuki-4\"".to_owned()
                    }
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

    fn refused(&self, error: &BuildError) -> Refusal {
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
        Box::new(
            self.document
                .diagnostic(&self.place(), error.to_string(), "this part", None),
        )
    }

    fn choice(
        &self,
        info: &'static PartInfo,
        given: &PartParameters,
        path: Option<&'static str>,
        registry: &Registry,
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
            origin: registry.origin(info.name).cloned(),
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

fn registry_names(registry: &Registry, kind: PartKind) -> Vec<&'static str> {
    registry
        .parts()
        .into_iter()
        .filter(|info| info.kind == kind)
        .map(|info| info.name)
        .collect()
}

fn unknown_part(
    document: &SceneDocument,
    name: &Located<String>,
    kind: PartKind,
    known: &[&str],
) -> Refusal {
    let help = match nearest(&name.value, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
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
