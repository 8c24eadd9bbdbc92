//! Parts by name: what they are, what parameters they take, where they come from.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use crate::error::BuildError;
use crate::system::MotionClass;

pub use crate::dimensions::Dimensions;

/// The kinds of part a method is assembled from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartKind {
    /// A Poisson system of the library.
    System,
    /// Realization data R̂_ε: a geometric approximation.
    Realization,
    /// A provider of Lagrangian bisections.
    Dynamics,
    /// A map M → M that needs no bisection.
    Stepper,
    /// A composition of step maps.
    Composition,
}

impl PartKind {
    /// The singular noun used in messages.
    pub fn noun(self) -> &'static str {
        match self {
            Self::System => "system",
            Self::Realization => "realization",
            Self::Dynamics => "dynamic approximation",
            Self::Stepper => "stepper",
            Self::Composition => "composition",
        }
    }
}

/// One parameter of a part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ParameterInfo {
    /// Its name in a scene.
    pub name: &'static str,
    /// Meaning of the parameter and values that are allowed, in words.
    pub summary: &'static str,
    /// The value taken when the scene names none; its type is the parameter's.
    pub default: ParameterDefault,
}

/// The type of a part's parameter with its default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ParameterDefault {
    /// A whole number.
    Integer(i64),
    /// A number.
    Real(f64),
    /// A word.
    Text(&'static str),
    /// A list of formulas, or one text in which `;` separates them.
    Formulas(&'static [&'static str]),
}

impl fmt::Display for ParameterDefault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::Real(value) => value.fmt(f),
            Self::Text(value) => value.fmt(f),
            Self::Formulas([]) => "none".fmt(f),
            Self::Formulas(formulas) => formulas.join(FORMULAS).fmt(f),
        }
    }
}

/// Separator of formulas in one text.
pub const FORMULAS: &str = "; ";

/// A value given to a part's parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ParameterSetting {
    /// A whole number.
    Integer(i64),
    /// A number.
    Real(f64),
    /// A word.
    Text(String),
}

impl fmt::Display for ParameterSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::Real(value) => value.fmt(f),
            Self::Text(value) => value.fmt(f),
        }
    }
}

impl From<i64> for ParameterSetting {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<f64> for ParameterSetting {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl From<&str> for ParameterSetting {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<ParameterDefault> for ParameterSetting {
    fn from(value: ParameterDefault) -> Self {
        match value {
            ParameterDefault::Integer(value) => Self::Integer(value),
            ParameterDefault::Real(value) => Self::Real(value),
            ParameterDefault::Text(value) => Self::Text(value.to_owned()),
            ParameterDefault::Formulas(formulas) => Self::Text(formulas.join(FORMULAS)),
        }
    }
}

/// Values for some of a part's parameters.
pub type Settings = &'static [(&'static str, ParameterDefault)];

/// Role of a realization or a dynamic approximation in a choice left open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Auto {
    /// Exact where it fits: of those that fit, [`exact_realization`](crate::Registry::exact_realization) takes one.
    Exact {
        /// Cheap ones come first.
        rank: u32,
        /// Why it is taken where it fits.
        reason: &'static str,
    },
    /// Fallback: it serves every system without forces, to the order that its parameter `order` names.
    OfOrder,
    /// It serves every system with forces.
    Forces,
}

/// Steppers that are compared and advised alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Poisson maps by exact flows: a step comes apart into a map of order 1 and its adjoint.
    Splitting,
    /// Other Poisson maps.
    Poisson,
    /// Taylor series of the motion.
    Series,
    /// Explicit Runge–Kutta methods.
    Explicit,
    /// Implicit Runge–Kutta methods, which solve dense systems.
    Implicit,
}

/// How comparisons use a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// Lower ranks of a kind are tried first.
    pub rank: u32,
    /// The settings it is tried with.
    pub settings: &'static [Settings],
    /// Of a dynamic approximation, the settings it is tried with over realizations with a [lift](crate::Abilities::lift).
    pub over_lifts: &'static [Settings],
}

impl Compared {
    /// At its defaults.
    pub const fn at(rank: u32) -> Self {
        Self {
            rank,
            settings: &[&[]],
            over_lifts: &[],
        }
    }
}

/// How a part serves systems of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServesNumbers {
    /// Lower ranks of a kind are named first.
    pub rank: u32,
    /// Limit of its service, as messages put it behind its name: `of order 2`.
    pub limit: &'static str,
}

/// Names that a part has in other programs and in textbooks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Elsewhere {
    /// Each of them; only letters and digits count, large or small.
    pub names: &'static [&'static str],
    /// The method in words, behind `stepper = "rk4" is`.
    pub is: &'static str,
}

/// Declaration of a part: its name, kind, promises, domain, literature and parameters, and how choices and comparisons
/// use it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PartInfo {
    /// Its name in a scene.
    pub name: &'static str,
    /// Its kind.
    pub kind: PartKind,
    /// One line.
    pub summary: &'static str,
    /// Order, exactness, symmetry: what it promises, in words.
    pub declares: &'static str,
    /// Where it is defined: states, tensors, step sizes.
    pub domain: &'static str,
    /// Where it is published.
    pub literature: &'static str,
    /// Its parameters.
    pub parameters: &'static [ParameterInfo],
    /// Where the values of a loaded part may come from, the preferred way first: `expressions`,
    /// `numbers`. Where there are two, its parameter `path` names one of them.
    #[serde(skip)]
    pub paths: &'static [&'static str],
    /// Whether a choice left open may take it.
    #[serde(skip)]
    pub auto: Option<Auto>,
    /// Whether points of S are pairs (x, p), for a realization.
    #[serde(skip)]
    pub points_are_pairs: bool,
    /// Whether it is coordinates with a constant tensor, for a realization.
    #[serde(skip)]
    pub is_lift: bool,
    /// Family of a stepper: the steppers that are compared and advised like it.
    #[serde(skip)]
    pub family: Option<Family>,
    /// Whether it needs no formulas of the system.
    #[serde(skip)]
    pub serves_numbers: Option<ServesNumbers>,
    /// The motions that it integrates: ẋ = {H, x} alone where it is not said, and the part is refused for others.
    #[serde(skip)]
    pub takes: MotionClass,
    /// Whether a scene writes its formulas: it is then looked at when it is composed, as a library's part is.
    #[serde(skip)]
    pub is_written: bool,
    /// Whether comparisons try it by themselves.
    #[serde(skip)]
    pub compared: Option<Compared>,
    /// The settings at which it is one of the methods that errors are measured against.
    #[serde(skip)]
    pub reference: Option<Settings>,
    /// The settings that a full survey tries; its defaults alone where there are none.
    #[serde(skip)]
    pub surveyed: &'static [Settings],
    /// How it is called elsewhere.
    #[serde(skip)]
    pub elsewhere: Option<Elsewhere>,
}

impl PartInfo {
    /// Nothing said: what a part does not mention, as in `..PartInfo::of(PartKind::Realization)`.
    pub const fn of(kind: PartKind) -> Self {
        Self {
            name: "",
            kind,
            summary: "",
            declares: "",
            domain: "",
            literature: "",
            parameters: &[],
            paths: &[],
            auto: None,
            points_are_pairs: true,
            is_lift: false,
            family: None,
            serves_numbers: None,
            takes: MotionClass::Hamiltonian,
            is_written: false,
            compared: None,
            reference: None,
            surveyed: &[],
            elsewhere: None,
        }
    }

    /// Whether it serves every system to the order that its parameter `order` names.
    pub fn is_of_order(&self) -> bool {
        self.auto == Some(Auto::OfOrder)
    }

    /// Where the values of a loaded part come from, for manifests; `None` for built-in parts and
    /// for parameters that it does not have.
    pub fn path(&self, given: &PartParameters) -> Option<&'static str> {
        match self.paths {
            [] => None,
            [only] => Some(only),
            both => given.word(self, PATH, both).ok(),
        }
    }

    /// Whether it is formulas that a library declares and nothing else.
    pub fn is_formulas_alone(&self) -> bool {
        self.paths == ["expressions"]
    }
}

/// The parameter by which a scene asks a part with several [paths](PartInfo::paths) for one of them.
pub const PATH: &str = "path";

/// The parameters a scene gives to a part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartParameters {
    values: BTreeMap<String, ParameterSetting>,
}

impl PartParameters {
    /// No parameter: every default.
    pub fn new() -> Self {
        Self::default()
    }

    /// These values.
    pub fn of(settings: Settings) -> Self {
        let settings = settings.iter();
        settings.fold(Self::new(), |given, (name, value)| {
            given.with(*name, *value)
        })
    }

    /// The values by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &ParameterSetting)> {
        self.values
            .iter()
            .map(|(name, value)| (name.as_str(), value))
    }

    /// The same with one more.
    pub fn with(mut self, name: impl Into<String>, value: impl Into<ParameterSetting>) -> Self {
        self.values.insert(name.into(), value.into());
        self
    }

    /// Accepts only names of `info`'s parameters: for parts that read none.
    ///
    /// # Errors
    /// [`BuildError::UnknownParameter`] for the first other name.
    pub fn refuse_unknown(&self, info: &PartInfo) -> Result<(), BuildError> {
        let known = |name: &String| info.parameters.iter().any(|p| p.name == name);
        match self.values.keys().find(|name| !known(name)) {
            Some(stranger) => Err(unknown_parameter(info, stranger)),
            None => Ok(()),
        }
    }

    /// Value of a parameter of `info`, its default where none is given.
    ///
    /// # Errors
    /// [`BuildError::UnknownParameter`] for a name, given or asked for, that is not one of `info`'s parameters.
    pub fn setting(&self, info: &PartInfo, name: &str) -> Result<ParameterSetting, BuildError> {
        self.refuse_unknown(info)?;
        let parameter = info.parameters.iter().find(|p| p.name == name);
        let parameter = parameter.ok_or_else(|| unknown_parameter(info, name))?;
        Ok(self
            .values
            .get(name)
            .cloned()
            .unwrap_or_else(|| parameter.default.into()))
    }

    /// A whole number.
    ///
    /// # Errors
    /// Those of [`setting`](Self::setting), and [`BuildError::Parameter`] for another type.
    pub fn get(&self, info: &PartInfo, name: &str) -> Result<i64, BuildError> {
        match self.setting(info, name)? {
            ParameterSetting::Integer(value) => Ok(value),
            other => Err(wrong_type(info, name, &other, "a whole number")),
        }
    }

    /// A number.
    ///
    /// # Errors
    /// Those of [`setting`](Self::setting), and [`BuildError::Parameter`] for another type.
    pub fn real(&self, info: &PartInfo, name: &str) -> Result<f64, BuildError> {
        match self.setting(info, name)? {
            ParameterSetting::Integer(value) => Ok(value as f64),
            ParameterSetting::Real(value) => Ok(value),
            other => Err(wrong_type(info, name, &other, "a number")),
        }
    }

    /// One of the words `allowed`.
    ///
    /// # Errors
    /// Those of [`setting`](Self::setting), and [`BuildError::Parameter`] for anything else.
    pub fn word(
        &self,
        info: &PartInfo,
        name: &str,
        allowed: &[&'static str],
    ) -> Result<&'static str, BuildError> {
        let value = self.setting(info, name)?;
        let expected = || format!("one of {}", allowed.join(", "));
        match &value {
            ParameterSetting::Text(word) => allowed
                .iter()
                .find(|known| *known == word)
                .copied()
                .ok_or_else(|| wrong_type(info, name, &value, &expected())),
            other => Err(wrong_type(info, name, other, &expected())),
        }
    }
}

fn unknown_parameter(info: &PartInfo, parameter: &str) -> BuildError {
    let names: Vec<_> = info.parameters.iter().map(|p| p.name).collect();
    BuildError::UnknownParameter {
        part: info.name,
        parameter: parameter.to_owned(),
        known: if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        },
    }
}

fn wrong_type(info: &PartInfo, name: &str, value: &ParameterSetting, expected: &str) -> BuildError {
    BuildError::Parameter {
        part: info.name,
        parameter: name.to_owned(),
        value: value.to_string(),
        expected: format!("`{name}` is {expected}"),
    }
}
