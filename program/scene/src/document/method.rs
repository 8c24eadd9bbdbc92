//! The `[method]` table: the parts of the integrator and its step.

use leafwise_core::noise::Noise;
use leafwise_core::part::{FORMULAS, ParameterSetting};
use leafwise_core::{PartKind, Registry};

use super::error::SceneProblemCause;
use super::located::{Located, Number};
use super::reader::{Item, Problems, Table};
use super::schema::{CHOSEN_AT, METHOD};

/// A parameter of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// A number, such as `order = 6`.
    Number(Number),
    /// A word, such as `correction = "none"`.
    Text(String),
    /// A truth value.
    Flag(bool),
    /// A list of formulas, such as `S = ["H"]`.
    Formulas(Vec<Located<String>>),
}

impl ParameterValue {
    /// Formulas in one text; `None` of a truth value.
    pub fn formulas(&self) -> Option<ParameterSetting> {
        Some(ParameterSetting::Text(match self {
            Self::Number(number) => number.literal.clone(),
            Self::Text(text) => text.clone(),
            Self::Formulas(formulas) => {
                let formulas: Vec<&str> = formulas.iter().map(|one| one.value.as_str()).collect();
                formulas.join(FORMULAS)
            }
            Self::Flag(_) => return None,
        }))
    }
}

/// A part by name, with its parameters in the order of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct PartSpec {
    /// The part's id.
    pub name: Located<String>,
    /// Its parameters.
    pub parameters: Vec<(Located<String>, Located<ParameterValue>)>,
}

impl PartSpec {
    /// The formula at this position of a parameter, and where it stands in the string that it is written in.
    pub fn formula(&self, parameter: &str, position: usize) -> Option<(&Located<String>, usize)> {
        let mut given = self.parameters.iter();
        let (_, value) = given.find(|(name, _)| name.value == parameter)?;
        let ParameterValue::Formulas(formulas) = &value.value else {
            return None;
        };
        let formula = formulas.get(position)?;
        let text = &formula.value;
        Some((formula, text.len() - text.trim_start().len()))
    }
}

/// The step: t advances by `epsilon * h`.
#[derive(Clone, Debug, PartialEq)]
pub enum StepSpec {
    /// Both factors.
    Factors {
        /// ε, finite and not zero.
        epsilon: Located<Number>,
        /// h, finite and not zero; negative runs backward in time.
        h: Located<Number>,
    },
    /// Their product alone; only the product matters (paper, Algorithm 1).
    TimeStep(Located<Number>),
}

impl StepSpec {
    /// ε; 1 when only the product is given.
    pub fn epsilon(&self) -> f64 {
        match self {
            Self::Factors { epsilon, .. } => epsilon.value.value,
            Self::TimeStep(_) => 1.0,
        }
    }

    /// h; the whole time step when only the product is given.
    pub fn h(&self) -> f64 {
        match self {
            Self::Factors { h, .. } => h.value.value,
            Self::TimeStep(step) => step.value.value,
        }
    }

    /// The key that sets how long a step is.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Factors { .. } => "h",
            Self::TimeStep(_) => "time-step",
        }
    }

    /// Makes h shorter, of a given time of a step and its part of the one before.
    pub(super) fn shorten(&mut self, time: f64, part: f64) {
        let (number, value) = match self {
            Self::Factors { h, .. } => {
                let value = h.value.value * part;
                (h, value)
            }
            Self::TimeStep(step) => (step, time),
        };
        number.value = Number {
            literal: format!("{value:?}"),
            value,
        };
    }

    /// εh, the time one step advances.
    pub fn time_step(&self) -> f64 {
        self.epsilon() * self.h()
    }
}

/// The `[method]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodSection {
    /// The realization; absent beside a stepper, or to be chosen.
    pub realization: Option<PartSpec>,
    /// The dynamic approximation; absent beside a stepper, or to be chosen.
    pub dynamics: Option<PartSpec>,
    /// A composition of steps; `"none"` reads as absent.
    pub composition: Option<PartSpec>,
    /// A step map in place of realization and dynamics.
    pub stepper: Option<PartSpec>,
    /// The step; of the fictitious time where there is a pace.
    pub step: StepSpec,
    /// dt/dτ, where steps are equal in a fictitious time τ.
    pub pace: Option<Located<String>>,
    /// How noise enters a step, where the scene says.
    pub noise: Option<Located<Noise>>,
    /// `energy = "exact"`, where the scene says so.
    pub exact_energy: Option<Located<()>>,
    /// Values of parameters from which the parts choose what they are made of, in place of the system's:
    /// the pieces of a splitting, the multiples of Casimirs.
    pub chosen_at: Vec<(Located<String>, Located<Number>)>,
}

/// How noise may enter a step.
const NOISE_WORDS: [(&str, Noise); 2] = [("joint", Noise::Joint), ("split", Noise::Split)];

/// Reads `[method]`.
pub(super) fn read_method(
    table: &Table<'_>,
    registry: &Registry,
    problems: &mut Problems,
) -> Option<MethodSection> {
    table.only(&METHOD, problems);
    let mut part = |key: &str, kind| match table.get(key) {
        Some(item) => read_part(item, example(registry, kind), problems).map(Some),
        None => Some(None),
    };
    let realization = part("realization", PartKind::Realization);
    let dynamics = part("dynamics", PartKind::Dynamics);
    let composition = part("composition", PartKind::Composition);
    let stepper = part("stepper", PartKind::Stepper);
    let step = read_step(table, problems);
    let pace = match table.get("pace") {
        Some(item) => item.formula(problems).map(Some),
        None => Some(None),
    };
    let noise = match table.get("noise") {
        Some(item) => {
            let word = item.word("noise", &NOISE_WORDS, problems);
            word.map(|noise| Some(Located::new(noise, item.place())))
        }
        None => Some(None),
    };
    let exact_energy = match table.get("energy") {
        Some(item) => {
            let word = item.word("energy", &[("exact", ())], problems);
            word.map(|()| Some(Located::new((), item.place())))
        }
        None => Some(None),
    };
    let chosen_at = match table.get(CHOSEN_AT) {
        Some(item) => item.pairs("a table of numbers", problems, Item::number),
        None => Some(Vec::new()),
    };
    Some(MethodSection {
        realization: realization?,
        dynamics: dynamics?,
        composition: composition?.filter(|part| part.name.value != "none"),
        stepper: stepper?,
        step: step?,
        pace: pace?,
        noise: noise?,
        exact_energy: exact_energy?,
        chosen_at: chosen_at?,
    })
}

fn read_part(item: &Item<'_>, example: &str, problems: &mut Problems) -> Option<PartSpec> {
    if item.is_string() {
        return Some(PartSpec {
            name: item.string(problems)?,
            parameters: Vec::new(),
        });
    }
    let title = item.title.clone();
    let table = item.table(&title, "a name or a table { name = \"…\" }", problems)?;
    let example = format!("{title} = {{ name = \"{example}\" }}");
    let name = table
        .require("name", &example, problems)
        .and_then(|name| name.string(problems));
    let parameters: Vec<_> = table
        .items
        .iter()
        .filter(|item| item.key.value != "name")
        .map(|item| Some((item.key.clone(), read_parameter(item, problems)?)))
        .collect();
    Some(PartSpec {
        name: name?,
        parameters: parameters.into_iter().collect::<Option<_>>()?,
    })
}

/// The name that a message shows: of the part that serves every system, or that is compared first.
fn example(registry: &Registry, kind: PartKind) -> &'static str {
    let compared = || registry.compared(kind).first().copied();
    let part = registry.of_order(kind).ok().or_else(compared);
    part.map_or("auto", |info| info.name)
}

/// The value of a parameter of a part.
pub(super) fn read_parameter(
    item: &Item<'_>,
    problems: &mut Problems,
) -> Option<Located<ParameterValue>> {
    if item.is_string() {
        return item
            .string(problems)
            .map(|text| text.map(ParameterValue::Text));
    }
    if let Some(flag) = item.flag() {
        return Some(Located::new(ParameterValue::Flag(flag), item.place()));
    }
    if item.is_table() {
        item.wrong_type(
            "a number, a word, a list of formulas or a truth value",
            problems,
        );
        return None;
    }
    if item.is_list() {
        let formulas = item.list_of("a list of formulas", problems, Item::formula)?;
        return Some(Located::new(
            ParameterValue::Formulas(formulas),
            item.place(),
        ));
    }
    item.number(problems)
        .map(|number| number.map(ParameterValue::Number))
}

fn read_step(table: &Table<'_>, problems: &mut Problems) -> Option<StepSpec> {
    if let Some(item) = table.get("time-step") {
        return nonzero(item, problems).map(StepSpec::TimeStep);
    }
    if table.get("epsilon").is_none() && table.get("h").is_none() {
        table.require(
            "time-step",
            "time-step = 0.2, or epsilon = 0.1 and h = 2.0",
            problems,
        );
        return None;
    }
    let epsilon = table
        .require("epsilon", "epsilon = 0.1", problems)
        .and_then(|item| nonzero(item, problems));
    let h = table
        .require("h", "h = 2.0", problems)
        .and_then(|item| nonzero(item, problems));
    let (epsilon, h) = (epsilon?, h?);
    let product = epsilon.value.value * h.value.value;
    if !product.is_finite() || product == 0.0 {
        problems.push(
            SceneProblemCause::OutOfRange {
                key: "epsilon*h".to_owned(),
                value: product.to_string(),
                allowed: "finite and not zero".to_owned(),
            },
            h.place(),
        );
        return None;
    }
    Some(StepSpec::Factors { epsilon, h })
}

fn nonzero(item: &Item<'_>, problems: &mut Problems) -> Option<Located<Number>> {
    let number = item.constant(problems)?;
    if number.value.value == 0.0 {
        problems.push(
            SceneProblemCause::OutOfRange {
                key: item.title.clone(),
                value: number.value.literal.clone(),
                allowed: "different from zero".to_owned(),
            },
            number.place(),
        );
        return None;
    }
    Some(number)
}
