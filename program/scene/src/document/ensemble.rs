//! The `[ensemble]` table: many initial states or parameter sets at once.

use super::error::SceneProblemCause;
use super::located::{Located, Place};
use super::reader::{Item, Problems, Table};
use super::run::{
    InitialSpec, RecordSpec, read_drift_every, read_initial as read_state, read_observables,
    read_sample_times,
};
use super::schema::{CENTER, DRAWS, ENSEMBLE, ENSEMBLE_RECORD, WAYS};
use super::shape::Key;
use super::system_section::SystemSection;

/// The `[ensemble]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct EnsembleSection {
    /// The table's header.
    pub place: Place,
    /// How many members; as many as a file of states or a grid of parameters has, where not said.
    pub members: Option<Located<u64>>,
    /// Seed of the random numbers, which depend on it and on the member.
    pub seed: u64,
    /// Where members start; all at the scene's initial state where not said.
    pub initial: Option<Located<InitialDraw>>,
    /// Parameters that differ from member to member.
    pub parameters: Vec<(Located<String>, Located<ParameterDraw>)>,
    /// Quantities that are reduced, and every how many steps; only at the start and the end where not said.
    pub record: RecordSpec,
    /// Whether the scene says every how many steps.
    pub has_every: bool,
    /// The quantiles of every observable, between 0 and 1.
    pub quantiles: Vec<f64>,
    /// Whether each member's last state is kept.
    pub final_states: FinalStates,
    /// The run directory, when the scene names one.
    pub out: Option<Located<String>>,
}

/// Where members start.
#[derive(Clone, Debug, PartialEq)]
pub enum InitialDraw {
    /// Drawn about a centre, the scene's initial state where none is given.
    Drawn {
        /// From what.
        distribution: Distribution,
        /// About what. Coordinates that it does not name are those of the scene's initial state.
        center: Option<Located<InitialSpec>>,
    },
    /// The rows of a file, beside the scene.
    File(String),
}

/// A distribution of states about a centre c; lengths are Euclidean.
#[derive(Clone, Debug, PartialEq)]
pub enum Distribution {
    /// Uniform in |x − c| ≤ r.
    Ball(f64),
    /// Uniform in |x_i − c_i| ≤ w_i.
    Box(Vec<f64>),
    /// Independent normal coordinates of these standard deviations.
    Normal(Vec<f64>),
    /// Uniform on |x − c| = r.
    Sphere(f64),
    /// Uniform in the ball of this radius, then moved along the Casimirs' gradients onto the leaf of c.
    Leaf(f64),
}

/// The values that a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterDraw {
    /// Uniform between two numbers.
    Uniform(f64, f64),
    /// Normal, of this mean and standard deviation.
    Normal(f64, f64),
    /// One after the other: a direction of a grid.
    Values(Vec<f64>),
    /// Equidistant ones, both ends among them: from, to, how many.
    Range(f64, f64, u64),
}

impl ParameterDraw {
    /// The points of a direction of a grid; one where it is none.
    pub fn points(&self) -> u64 {
        match self {
            Self::Uniform(..) | Self::Normal(..) => 1,
            Self::Values(values) => values.len() as u64,
            Self::Range(_, _, count) => *count,
        }
    }
}

/// How each member's last state is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FinalStates {
    /// Not at all.
    #[default]
    None,
    /// Decimals, with parameters and observables.
    Csv,
    /// Doubles, the states alone.
    Binary,
    /// A matrix of NumPy's: what the decimals hold.
    Npy,
}

impl FinalStates {
    const WORDS: [(&'static str, Self); 4] = [
        ("none", Self::None),
        ("csv", Self::Csv),
        ("binary", Self::Binary),
        ("npy", Self::Npy),
    ];
}

/// Reads `[ensemble]`; `system` fixes the dimension, the parameters and the default observables.
pub(super) fn read_ensemble(
    table: &Table<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<EnsembleSection> {
    table.only(&ENSEMBLE, problems);
    let members = optional(table, "members", problems, |item, problems| {
        item.whole(1, problems)
    });
    let seed = optional(table, "seed", problems, |item, problems| {
        item.whole(0, problems)
    });
    let initial = optional(table, "initial", problems, |item, problems| {
        let draw = read_initial(item, system, problems)?;
        Some(Located::new(draw, item.place()))
    });
    let parameters = match table.get("parameters") {
        Some(item) => read_parameters(item, system, problems),
        None => Some(Vec::new()),
    };
    let record = read_record(table, system, problems);
    let final_states = optional(table, "final-states", problems, read_final_states);
    let out = optional(table, "out", problems, |item, problems| {
        item.string(problems)
    });
    let (record, has_every, quantiles) = record?;
    Some(EnsembleSection {
        place: table.place.clone(),
        members: members?,
        seed: seed?.map_or(0, |seed| seed.value),
        initial: initial?,
        parameters: parameters?,
        record,
        has_every,
        quantiles,
        final_states: final_states?.unwrap_or_default(),
        out: out?,
    })
}

/// `None` for a value that is wrong, `Some(None)` for one that is not there.
fn optional<T>(
    table: &Table<'_>,
    key: &str,
    problems: &mut Problems,
    read: impl FnOnce(&Item<'_>, &mut Problems) -> Option<T>,
) -> Option<Option<T>> {
    match table.get(key) {
        Some(item) => read(item, problems).map(Some),
        None => Some(None),
    }
}

fn read_initial(
    item: &Item<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<InitialDraw> {
    let table = item.table("initial", "a table such as { ball = 0.1 }", problems)?;
    table.only(&DRAWS, problems);
    let chosen = one_of(&table, &DRAWS, "initial = { ball = 0.1 }", problems)?;
    let dimension = system.map(SystemSection::coordinates);
    let center = optional(&table, CENTER, problems, |item, problems| {
        read_state(item, system, problems)
    })?;
    let distribution = match chosen.key.value.as_str() {
        "ball" => Distribution::Ball(positive(chosen, problems)?),
        "sphere" => Distribution::Sphere(positive(chosen, problems)?),
        "leaf" => {
            if let Some(system) = system.filter(|system| system.casimirs.is_empty()) {
                let hint = if system.library.is_some() {
                    "this library system has none: take ball instead"
                } else {
                    "declare casimirs in [system], or take ball instead"
                };
                problems.push(
                    SceneProblemCause::Conflict {
                        first: "a system without Casimirs".to_owned(),
                        second: "leaf".to_owned(),
                        advice: hint.to_owned(),
                    },
                    chosen.key.place(),
                );
                return None;
            }
            Distribution::Leaf(positive(chosen, problems)?)
        }
        "box" => Distribution::Box(lengths(chosen, dimension, problems)?),
        "normal" => Distribution::Normal(lengths(chosen, dimension, problems)?),
        _ => {
            return Some(InitialDraw::File(chosen.string(problems)?.value));
        }
    };
    Some(InitialDraw::Drawn {
        distribution,
        center,
    })
}

/// The one entry that a scene chooses of `keys`; where only others stand, the first is missing.
fn one_of<'t, 'a>(
    table: &'t Table<'a>,
    keys: &[Key],
    example: &str,
    problems: &mut Problems,
) -> Option<&'t Item<'a>> {
    if table.items.iter().all(|item| item.key.value == CENTER) {
        table.require(keys[0].name, example, problems);
    }
    table.choice(keys)
}

fn positive(item: &Item<'_>, problems: &mut Problems) -> Option<f64> {
    let number = item.number(problems)?;
    if number.value.value > 0.0 {
        return Some(number.value.value);
    }
    out_of_range(item, &number.value.literal, "a positive number", problems);
    None
}

fn out_of_range(item: &Item<'_>, value: &str, allowed: &str, problems: &mut Problems) {
    problems.push(
        SceneProblemCause::OutOfRange {
            key: item.title.clone(),
            value: value.to_owned(),
            allowed: allowed.to_owned(),
        },
        item.place(),
    );
}

/// One number for each coordinate.
fn vector(item: &Item<'_>, dimension: Option<usize>, problems: &mut Problems) -> Option<Vec<f64>> {
    let numbers = item.list_of("a list of numbers", problems, Item::number)?;
    if let Some(dimension) = dimension.filter(|dimension| *dimension != numbers.len()) {
        problems.push(
            SceneProblemCause::Shape {
                what: item.title.clone(),
                found: format!("{} entries", numbers.len()),
                expected: format!("{dimension}, one for each variable"),
            },
            item.place(),
        );
        return None;
    }
    Some(numbers.iter().map(|number| number.value.value).collect())
}

/// One number for all coordinates, or one for each; not negative.
fn lengths(item: &Item<'_>, dimension: Option<usize>, problems: &mut Problems) -> Option<Vec<f64>> {
    let lengths = if item.is_list() {
        vector(item, dimension, problems)?
    } else {
        vec![item.number(problems)?.value.value; dimension.unwrap_or(1)]
    };
    match lengths.iter().find(|length| **length < 0.0) {
        None => Some(lengths),
        Some(length) => {
            out_of_range(item, &format!("{length:?}"), "positive or 0", problems);
            None
        }
    }
}

type Draws = Vec<(Located<String>, Located<ParameterDraw>)>;

fn read_parameters(
    item: &Item<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<Draws> {
    let expected = "a table such as { I1 = { uniform = [0.9, 1.1] } }";
    let draws = item.pairs(expected, problems, read_parameter)?;
    let mut are_known = true;
    for (name, _) in &draws {
        let Some(system) = system else { continue };
        let known = || {
            system
                .parameters
                .iter()
                .map(|(name, _)| name.value.as_str())
        };
        if !known().any(|known| known == name.value) {
            let mut define = system.define.iter();
            let is_formula = define.any(|(own, _)| own.value == name.value);
            let kind = match is_formula {
                true => "parameter with an independent value (it is a formula of others)",
                false => "parameter of this system",
            };
            let cause = SceneProblemCause::unknown(kind, &name.value, known());
            problems.push(cause, name.place());
            are_known = false;
        }
    }
    are_known.then_some(draws)
}

fn read_parameter(item: &Item<'_>, problems: &mut Problems) -> Option<Located<ParameterDraw>> {
    let title = item.key.value.clone();
    let table = item.table(&title, "a table such as { uniform = [0.9, 1.1] }", problems)?;
    table.only(&WAYS, problems);
    let chosen = one_of(&table, &WAYS, "uniform = [0.9, 1.1]", problems)?;
    let numbers = chosen.list_of("a list of numbers", problems, Item::number)?;
    let values: Vec<f64> = numbers.iter().map(|number| number.value.value).collect();
    let mut refuse_at = |place: Place, expected: &str| {
        problems.push(
            SceneProblemCause::Shape {
                what: chosen.title.clone(),
                found: format!("{values:?}"),
                expected: expected.to_owned(),
            },
            place,
        );
        None
    };
    let mut refuse = |expected: &str| refuse_at(chosen.place(), expected);
    let draw = match (chosen.key.value.as_str(), &values[..]) {
        ("uniform", &[from, to]) if from <= to => ParameterDraw::Uniform(from, to),
        ("uniform", _) => return refuse("[from, to], the smaller first"),
        ("normal", &[mean, deviation]) if deviation >= 0.0 => {
            ParameterDraw::Normal(mean, deviation)
        }
        ("normal", _) => return refuse("[mean, standard deviation]"),
        ("range", &[from, to, count]) if is_count(count) => {
            ParameterDraw::Range(from, to, count as u64)
        }
        ("range", &[_, _, _]) => {
            let expected = "[from, to, count], count a whole number of at least 2";
            return refuse_at(numbers[2].place(), expected);
        }
        ("range", _) => return refuse("[from, to, count]"),
        (_, []) => return refuse("at least one value"),
        _ => ParameterDraw::Values(values.clone()),
    };
    Some(Located::new(draw, item.place()))
}

/// The largest grid in one direction.
const MOST_POINTS: f64 = 1e9;

fn is_count(count: f64) -> bool {
    (2.0..=MOST_POINTS).contains(&count) && libm::floor(count) == count
}

type Record = (RecordSpec, bool, Vec<f64>);

fn read_record(
    table: &Table<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<Record> {
    let Some(item) = table.get("record") else {
        let observables = read_observables(None, &table.place, system, problems)?;
        let every = u64::MAX;
        let states = None;
        let record = RecordSpec {
            every,
            interval: None,
            times: None,
            observables,
            states,
            drift_every: 1,
        };
        return Some((record, false, Vec::new()));
    };
    let record = item.table("record", "a table", problems)?;
    record.only(&ENSEMBLE_RECORD, problems);
    let whole = |item: &Item<'_>, problems: &mut Problems| item.whole(1, problems);
    let every = optional(&record, "every", problems, whole);
    let times = read_sample_times(&record, problems);
    let drift_every = read_drift_every(&record, problems);
    let observables = read_observables(Some(&record), &table.place, system, problems);
    let quantiles = match record.get("quantiles") {
        Some(list) => list.list_of("a list of numbers", problems, read_quantile),
        None => Some(Vec::new()),
    };
    let every = every?;
    let (interval, times) = times?;
    let record = RecordSpec {
        every: every.as_ref().map_or(u64::MAX, |every| every.value),
        interval,
        times,
        observables: observables?,
        states: None,
        drift_every: drift_every?,
    };
    Some((record, every.is_some(), quantiles?))
}

fn read_quantile(item: &Item<'_>, problems: &mut Problems) -> Option<f64> {
    let number = item.number(problems)?.value;
    if (0.0..=1.0).contains(&number.value) {
        return Some(number.value);
    }
    out_of_range(item, &number.literal, "between 0 and 1", problems);
    None
}

fn read_final_states(item: &Item<'_>, problems: &mut Problems) -> Option<FinalStates> {
    item.word("form of final states", &FinalStates::WORDS, problems)
}
