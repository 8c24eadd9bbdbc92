//! `forces = […]`, `torque = […]`, `damping = { … }` and `friction = […]`: what moves the system beside its Hamiltonian.

use super::error::SceneProblemCause;
use super::field::check_sites_once;
use super::located::Located;
use super::reader::{Item, Problems, Table};
use super::system_schema::{DAMPING, TORQUE};

/// Formulas by the coordinates that they belong to, `"p[i]"` for every site of a family.
pub type ByCoordinate = Vec<(Located<String>, Located<String>)>;

/// Components of a one-form, or of a friction.
#[derive(Clone, Debug, PartialEq)]
pub enum ComponentsSpec {
    /// A formula for each coordinate.
    All(Vec<Located<String>>),
    /// Formulas of some coordinates, 0 for the others.
    Named(ByCoordinate),
}

impl ComponentsSpec {
    /// Its formulas in the order of the text.
    pub fn formulas(&self) -> Vec<&Located<String>> {
        match self {
            Self::All(formulas) => formulas.iter().collect(),
            Self::Named(entries) => entries.iter().map(|(_, formula)| formula).collect(),
        }
    }

    /// Whether every formula is the number 0, or there is none.
    fn is_zero(&self) -> bool {
        let formulas = self.formulas();
        let mut numbers = formulas.iter().map(|formula| formula.value.trim().parse());
        numbers.all(|number| number == Ok(0.0_f64))
    }
}

/// The one-form η beside dH, and the friction f beside Π(dH + η).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForcesSpec {
    /// η_i.
    pub one_form: Option<Located<ComponentsSpec>>,
    /// τ.
    pub torque: Option<Located<TorqueSpec>>,
    /// λ g ẋ_H.
    pub damping: Option<DampingSpec>,
    /// f_i; `None` where each is 0.
    pub friction: Option<Located<ComponentsSpec>>,
}

/// A torque on a body with attitude, by its components.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TorqueSpec {
    /// In the body.
    pub body: Option<[Located<String>; 3]>,
    /// In space.
    pub space: Option<[Located<String>; 3]>,
}

/// A double bracket.
#[derive(Clone, Debug, PartialEq)]
pub struct DampingSpec {
    /// λ.
    pub rate: Located<String>,
    /// g, the identity where not said.
    pub metric: Option<Located<MetricSpec>>,
}

/// A metric by its formulas.
#[derive(Clone, Debug, PartialEq)]
pub enum MetricSpec {
    /// Of a diagonal.
    Diagonal(Vec<Located<String>>),
    /// Of some entries of a diagonal, 0 for the others.
    Named(ByCoordinate),
    /// By rows.
    Rows(Vec<Vec<Located<String>>>),
}

impl MetricSpec {
    /// Its formulas, row after row.
    pub fn formulas(&self) -> Vec<&Located<String>> {
        match self {
            Self::Diagonal(entries) => entries.iter().collect(),
            Self::Named(entries) => entries.iter().map(|(_, formula)| formula).collect(),
            Self::Rows(rows) => rows.iter().flatten().collect(),
        }
    }
}

impl ForcesSpec {
    /// The keys of the scene that give them.
    pub fn keys(&self) -> Vec<&'static str> {
        let keys = [
            (self.one_form.is_some(), "system.forces"),
            (self.torque.is_some(), "system.torque"),
            (self.damping.is_some(), "system.damping"),
            (self.friction.is_some(), "system.friction"),
        ];
        let present = keys.iter().filter(|(is_present, _)| *is_present);
        present.map(|(_, key)| *key).collect()
    }

    /// Every formula in it.
    pub fn formulas(&self) -> Vec<&Located<String>> {
        let one_form = self.one_form.iter();
        let one_form = one_form.flat_map(|one_form| one_form.value.formulas());
        let damping = self.damping.iter().flat_map(|damping| {
            let metric = damping.metric.iter();
            let metric = metric.flat_map(|metric| metric.value.formulas());
            std::iter::once(&damping.rate).chain(metric)
        });
        let torque = self.torque.iter();
        let torque = torque.flat_map(|torque| [&torque.value.body, &torque.value.space]);
        let torque = torque.flatten().flatten();
        let friction = self.friction.iter();
        let friction = friction.flat_map(|friction| friction.value.formulas());
        one_form
            .chain(torque)
            .chain(damping)
            .chain(friction)
            .collect()
    }
}

/// The forces of a `[system]` table; those of a library system that are not given anew stay.
pub(super) fn read_forces(
    table: &Table<'_>,
    known: ForcesSpec,
    problems: &mut Problems,
) -> Option<ForcesSpec> {
    let one_form = match table.get("forces") {
        Some(item) => Some(read_components(item, problems)?),
        None => known.one_form,
    };
    let friction = match table.get("friction") {
        Some(item) => Some(read_components(item, problems)?),
        None => known.friction,
    };
    let friction = friction.filter(|components| !components.value.is_zero());
    let damping = match table.get("damping") {
        Some(item) => Some(read_damping(item, problems)?),
        None => known.damping,
    };
    let torque = match table.get("torque") {
        Some(item) => Some(Located::new(read_torque(item, problems)?, item.place())),
        None => known.torque,
    };
    Some(ForcesSpec {
        one_form,
        torque,
        damping,
        friction,
    })
}

/// `["0.1*p", "0"]`, or `{ "p[i]" = "0.1*p[i]" }`.
fn read_components(item: &Item<'_>, problems: &mut Problems) -> Option<Located<ComponentsSpec>> {
    let components = match item.is_table() {
        true => ComponentsSpec::Named(read_by_coordinate(item, problems)?),
        false => {
            let expected = "a list of formulas, or a table of formulas by coordinates";
            ComponentsSpec::All(item.list_of(expected, problems, Item::formula)?)
        }
    };
    Some(Located::new(components, item.place()))
}

/// `["0", "0", "0.1"]` in the body, or `{ space = ["0", "0", "0.1"] }`.
fn read_torque(item: &Item<'_>, problems: &mut Problems) -> Option<TorqueSpec> {
    if !item.is_table() {
        let body = Some(read_vector(item, problems)?);
        return Some(TorqueSpec { body, space: None });
    }
    let table = item.table("torque", "three formulas, or a table of them", problems)?;
    table.only(&TORQUE, problems);
    let mut of = |key: &str| match table.get(key) {
        Some(item) => read_vector(item, problems).map(Some),
        None => Some(None),
    };
    let (body, space) = (of("body"), of("space"));
    let torque = TorqueSpec {
        body: body?,
        space: space?,
    };
    if torque == TorqueSpec::default() {
        table.require("body", "body = [\"0\", \"0\", \"0.1\"]", problems);
        return None;
    }
    Some(torque)
}

fn read_vector(item: &Item<'_>, problems: &mut Problems) -> Option<[Located<String>; 3]> {
    let formulas = item.list_of("three formulas", problems, Item::formula)?;
    let count = formulas.len();
    let vector = formulas.try_into().ok();
    if vector.is_none() {
        let cause = SceneProblemCause::Shape {
            what: item.title.clone(),
            found: format!("{count} components"),
            expected: "three formulas".to_owned(),
        };
        problems.push(cause, item.place());
    }
    vector
}

/// `{ rate = "0.1", metric = ["1", "1", "2"] }`.
fn read_damping(item: &Item<'_>, problems: &mut Problems) -> Option<DampingSpec> {
    let table = item.table("damping", "a table", problems)?;
    table.only(&DAMPING, problems);
    let rate = table
        .require("rate", "rate = \"0.1\"", problems)
        .and_then(|item| item.formula(problems));
    let metric = match table.get("metric") {
        Some(item) => Some(Located::new(read_metric(item, problems)?, item.place())),
        None => None,
    };
    Some(DampingSpec {
        rate: rate?,
        metric,
    })
}

/// `{ "p[i]" = "0.1*p[i]" }`.
pub(super) fn read_by_coordinate(item: &Item<'_>, problems: &mut Problems) -> Option<ByCoordinate> {
    let entries = item.pairs("a table of formulas", problems, Item::formula)?;
    check_sites_once(entries.iter().map(|(key, _)| key), problems);
    Some(entries)
}

fn read_metric(item: &Item<'_>, problems: &mut Problems) -> Option<MetricSpec> {
    const EXPECTED: &str =
        "a list of formulas, or of such lists, or a table of formulas by coordinates";
    if item.is_table() {
        return read_by_coordinate(item, problems).map(MetricSpec::Named);
    }
    let entries = item.list(EXPECTED, problems)?;
    if entries.iter().any(Item::is_list) {
        let row = |item: &Item<'_>, problems: &mut Problems| {
            item.list_of("a list of formulas", problems, Item::formula)
        };
        return item.list_of(EXPECTED, problems, row).map(MetricSpec::Rows);
    }
    let entries = item.list_of(EXPECTED, problems, Item::formula);
    entries.map(MetricSpec::Diagonal)
}
