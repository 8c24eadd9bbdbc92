//! The `[run]` table: where to start, how far to go, what to keep.

use std::collections::BTreeSet;

use leafwise_walk::Direction;

use super::error::SceneProblemCause;
use super::field::{FieldSpec, check_sites_once, read_field};
use super::forces::{ByCoordinate, read_by_coordinate};
use super::located::{Located, Number, Place};
use super::method::MethodSection;
use super::observable::ObservableSpec;
use super::reader::{Item, Problems, Table};
use super::schema::{RECORD, RUN, SECTION};
use super::system_section::SystemSection;
use super::vector_formulas::{by_components, check_components_once, observe_vectors, read_vector};

/// The initial state.
#[derive(Clone, Debug, PartialEq)]
pub enum InitialSpec {
    /// One number for each coordinate of the state.
    Vector(Vec<Located<Number>>),
    /// Values that each variable or family begins with, as `"x[i]" = "1 + 0.1*sin(2*pi*i/N)"`.
    Fields(Fields),
}

/// Values that variables and families begin with, each under its name.
type Fields = Vec<(Located<String>, FieldSpec)>;

/// Records to keep of the run: sample times, observables and coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordSpec {
    /// Every how many steps a sample is kept; at least 1.
    pub every: u64,
    /// Interval of time between two samples, in place of steps.
    pub interval: Option<Located<Number>>,
    /// The times of all samples, in place of steps.
    pub times: Option<Located<Vec<Located<Number>>>>,
    /// Observables; energy and all Casimirs unless the scene says otherwise.
    pub observables: Vec<ObservableSpec>,
    /// The coordinates that are recorded, by names and slices; where not said, all of a small system.
    pub states: Option<Vec<Located<String>>>,
    /// Every how many steps energy and Casimirs are looked at; at least 1.
    pub drift_every: u64,
}

/// In `states`, every coordinate.
pub const ALL_STATES: &str = "all";

const DIRECTIONS: [(&str, Direction); 3] = [
    ("up", Direction::Up),
    ("down", Direction::Down),
    ("both", Direction::Both),
];

/// A surface whose crossings are recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionSpec {
    /// The surface: `left = right`.
    pub at: Located<String>,
    /// Which crossings.
    pub direction: Direction,
    /// The columns that the report draws over each other, where the scene names them.
    pub axes: Option<[Located<String>; 2]>,
    /// Values that coordinates take there, by formulas of the state before.
    pub set: Option<Located<ByCoordinate>>,
}

/// The `[run]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSection {
    /// The initial state.
    pub initial: Located<InitialSpec>,
    /// The number of steps; as many as there are where the run ends at a time.
    pub steps: Located<u64>,
    /// The time at the end, in place of a number of steps; beside a pace alone, where it is not known how many that takes.
    pub until: Option<Located<Number>>,
    /// Time of formulas at the initial state, from which all other times count; 0 where the scene does not say.
    pub t0: Option<Located<Number>>,
    /// The time `until` that the scene gives where `steps` equal steps come to it.
    pub comes_to: Option<Located<Number>>,
    /// The step that the scene gives, where steps are shortened to come to that time.
    pub shortened: Option<f64>,
    /// Where the run ends before: a comparison of two formulas.
    pub stop: Option<Located<String>>,
    /// A surface whose crossings are recorded.
    pub section: Option<SectionSpec>,
    /// Seed of the random numbers of noise.
    pub seed: u64,
    /// Which member's of the seed they are.
    pub member: u64,
    /// Where the scene asks that the error of its states is estimated when it is done.
    pub estimates_error: Option<Located<()>>,
    /// Records to keep.
    pub record: RecordSpec,
    /// The run directory, when the scene names one.
    pub out: Option<Located<String>>,
}

/// Reads `[run]`; `system` fixes the dimension and the default observables.
pub(super) fn read_run(
    table: &Table<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<RunSection> {
    table.only(&RUN, problems);
    let initial = table
        .require("initial", "initial = [1, 3, 3]", problems)
        .and_then(|item| read_initial(item, system, problems));
    let (steps, until) = read_end(table, problems);
    let t0 = match table.get("t0") {
        Some(item) => item.number(problems).map(Some),
        None => Some(None),
    };
    let stop = match table.get("stop") {
        Some(item) => item.string(problems).map(Some),
        None => Some(None),
    };
    let section = match table.get("section") {
        Some(item) => read_section(item, system, problems).map(Some),
        None => Some(None),
    };
    let mut number = |key: &str| match table.get(key) {
        Some(item) => item.whole(0, problems).map(|number| number.value),
        None => Some(0),
    };
    let (seed, member) = (number("seed"), number("member"));
    let estimates_error = match table.get("error") {
        Some(item) => {
            let word = item.word("error", &[("estimate", ())], problems);
            word.map(|()| Some(Located::new((), item.place())))
        }
        None => Some(None),
    };
    let record = read_record(table, system, problems);
    let out = match table.get("out") {
        Some(item) => item.string(problems).map(Some),
        None => Some(None),
    };
    Some(RunSection {
        initial: initial?,
        steps: steps?,
        until: until?,
        t0: t0?,
        comes_to: None,
        shortened: None,
        stop: stop?,
        section: section?,
        seed: seed?,
        member: member?,
        estimates_error: estimates_error?,
        record: record?,
        out: out?,
    })
}

/// `steps`, or `until` alone.
fn read_end(
    table: &Table<'_>,
    problems: &mut Problems,
) -> (Option<Located<u64>>, Option<Option<Located<Number>>>) {
    let Some(item) = table.get("until") else {
        let steps = table.require("steps", "steps = 1000", problems);
        return (steps.and_then(|item| item.whole(0, problems)), Some(None));
    };
    let until = item.constant(problems);
    let steps = until
        .as_ref()
        .map(|until| Located::new(u64::MAX, until.place()));
    (steps, until.map(Some))
}

/// How far a number of steps may be from a whole one, relative to it: what the rounding of a quotient of decimals leaves.
const WHOLE: f64 = 8.0 * f64::EPSILON;

/// Makes a number of steps of a time at the end, where all steps are alike. It is the least of steps that are not longer
/// than the scene's; these are shortened until a whole number of them ends there.
pub(super) fn count_steps(
    run: &mut RunSection,
    method: &mut MethodSection,
    problems: &mut Problems,
) {
    let Some(until) = run.until.clone().filter(|_| method.pace.is_none()) else {
        return;
    };
    let step = method.step.time_step();
    let steps = until.value.value / step;
    // A time that is never come to is refused where others are.
    if steps <= 0.0 {
        return;
    }
    let whole = libm::round(steps);
    let is_whole = whole >= 1.0 && (steps - whole).abs() <= WHOLE * whole;
    let count = if is_whole { whole } else { libm::ceil(steps) };
    if count > MOST_STEPS {
        let cause = SceneProblemCause::TooManySteps {
            until: until.value.literal.clone(),
            step,
        };
        problems.push(cause, until.place());
        return;
    }
    if !is_whole {
        run.shortened = Some(step);
        method
            .step
            .shorten(until.value.value / count, steps / count);
    }
    run.steps.value = count as u64;
    run.until = None;
    run.comes_to = Some(until);
}

/// Steps are counted by doubles while their number is known.
const MOST_STEPS: f64 = 9e15;

fn read_section(
    item: &Item<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<SectionSpec> {
    let expected = "a table such as { at = \"q1 = 0\", direction = \"up\" }";
    let table = item.table("section", expected, problems)?;
    table.only(&SECTION, problems);
    let at = table
        .require("at", "at = \"q1 = 0\"", problems)
        .and_then(|item| item.string(problems));
    let direction = match table.get("direction") {
        Some(item) => item.word("direction", &DIRECTIONS, problems),
        None => Some(Direction::default()),
    };
    let axes = match table.get("axes") {
        Some(item) => read_axes(item, problems).map(Some),
        None => Some(None),
    };
    let set = match table.get("set") {
        Some(item) => read_by_coordinate(item, problems).map(|entries| {
            let entries = match system {
                Some(system) => by_components(system, &entries, problems),
                None => entries,
            };
            Some(Located::new(entries, item.place()))
        }),
        None => Some(None),
    };
    Some(SectionSpec {
        at: at?,
        direction: direction?,
        axes: axes?,
        set: set?,
    })
}

fn read_axes(item: &Item<'_>, problems: &mut Problems) -> Option<[Located<String>; 2]> {
    let names = item.list_of("two names, as [\"q2\", \"p2\"]", problems, Item::string)?;
    let found = format!("{} entries", names.len());
    let axes = <[Located<String>; 2]>::try_from(names).ok();
    if axes.is_none() {
        problems.push(
            SceneProblemCause::Shape {
                what: item.title.clone(),
                found,
                expected: "two names".to_owned(),
            },
            item.place(),
        );
    }
    axes
}

/// A number for each variable, or a formula for each variable, vector or family.
pub(super) fn read_initial(
    item: &Item<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<Located<InitialSpec>> {
    let expected = "a list of numbers or a table of formulas";
    if item.is_table() {
        let table = item.table(&item.title, expected, problems)?;
        let mut fields = Some(Vec::new());
        let own = table.items.iter();
        let entries: Vec<_> = own.flat_map(|own| components_of(own, system)).collect();
        let mut names = BTreeSet::new();
        for entry in &entries {
            if !names.insert(&entry.key.value) {
                let name = entry.key.value.clone();
                problems.push(SceneProblemCause::Duplicate { name }, entry.key.place());
            }
            let read = match read_vector(entry, system, problems) {
                Some(components) => Some(components),
                None => read_field(entry, problems).map(|field| vec![(entry.key.clone(), field)]),
            };
            fields = fields.zip(read).map(|(mut fields, read)| {
                fields.extend(read);
                fields
            });
        }
        if let Some(system) = system {
            let keys = entries.iter().map(|entry| &entry.key);
            check_components_once(system, keys, problems);
        }
        let fields = fields?;
        check_sites_once(fields.iter().map(|(key, _)| key), problems);
        return Some(Located::new(InitialSpec::Fields(fields), item.place()));
    }
    if let Some(fields) = formulas_by_variables(item, system, problems) {
        return Some(Located::new(InitialSpec::Fields(fields?), item.place()));
    }
    let numbers = item.list_of(expected, problems, Item::constant)?;
    if let Some(dimension) = system.map(SystemSection::coordinates)
        && dimension != numbers.len()
    {
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
    Some(Located::new(InitialSpec::Vector(numbers), item.place()))
}

/// The components of a vector that are written with points and without quotes, `r.x = 1`, which is a table in TOML; any other
/// entry itself.
fn components_of<'a>(entry: &Item<'a>, system: Option<&SystemSection>) -> Vec<Item<'a>> {
    let variables = system.map_or(&[][..], |system| &system.variables);
    let parts = match entry.is_table() {
        true => entry.table(&entry.title, "a table", &mut Problems::default()),
        false => None,
    };
    let parts = parts.map_or_else(Vec::new, |table| table.items);
    let named = parts.into_iter().map(|mut part| {
        let name = format!("{}.{}", entry.key.value, part.key.value);
        let is_known = variables.iter().any(|variable| variable.value == name);
        part.key.value.clone_from(&name);
        part.title = name;
        is_known.then_some(part)
    });
    let named: Option<Vec<_>> = named.collect();
    match named {
        Some(named) if !named.is_empty() => named,
        _ => vec![entry.clone()],
    }
}

/// Formulas and numbers in a list, by the variables in their order. `None` for a list of numbers alone, and for entries that are
/// not one for each variable.
fn formulas_by_variables(
    item: &Item<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<Option<Fields>> {
    let system = system?;
    let entries = item
        .list("a list", &mut Problems::default())
        .unwrap_or_default();
    let are_variables = entries.len() == system.variables.len()
        && entries.len() == system.coordinates()
        && entries.iter().any(Item::names_others);
    if !are_variables {
        return None;
    }
    let fields = system.variables.iter().zip(&entries).map(|(name, entry)| {
        let formula = entry.formula(problems)?;
        let name = Located::new(name.value.clone(), entry.place());
        Some((name, FieldSpec::Formula(formula)))
    });
    let fields: Vec<_> = fields.collect();
    Some(fields.into_iter().collect())
}

fn read_record(
    table: &Table<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<RecordSpec> {
    let Some(item) = table.get("record") else {
        return Some(RecordSpec {
            every: 1,
            interval: None,
            times: None,
            observables: read_observables(None, &table.place, system, problems)?,
            states: None,
            drift_every: 1,
        });
    };
    let record = item.table("record", "a table", problems)?;
    record.only(&RECORD, problems);
    let every = match record.get("every") {
        Some(every) => every.whole(1, problems).map(|every| every.value),
        None => Some(1),
    };
    let drift_every = read_drift_every(&record, problems);
    let times = read_sample_times(&record, problems);
    let observables = read_observables(Some(&record), &table.place, system, problems);
    let states = match record.get("states") {
        Some(one) if one.is_string() => one.string(problems).map(|one| Some(vec![one])),
        Some(list) => {
            let expected = "\"all\" or a list such as [\"q[0]\", \"q[::100]\", \"p\"]";
            list.list_of(expected, problems, Item::string).map(Some)
        }
        None => Some(None),
    };
    let (interval, times) = times?;
    Some(RecordSpec {
        every: every?,
        interval,
        times,
        observables: observables?,
        states: states?,
        drift_every: drift_every?,
    })
}

/// `drift-every`, of a `record` table.
pub(super) fn read_drift_every(record: &Table<'_>, problems: &mut Problems) -> Option<u64> {
    match record.get("drift-every") {
        Some(every) => every.whole(1, problems).map(|every| every.value),
        None => Some(1),
    }
}

type Times = (
    Option<Located<Number>>,
    Option<Located<Vec<Located<Number>>>>,
);

/// `interval` or `times`, of a `record` table.
pub(super) fn read_sample_times(record: &Table<'_>, problems: &mut Problems) -> Option<Times> {
    let interval = match record.get("interval") {
        Some(item) => read_interval(item, problems).map(Some),
        None => Some(None),
    };
    let times = match record.get("times") {
        Some(item) => read_times(item, problems).map(Some),
        None => Some(None),
    };
    Some((interval?, times?))
}

/// `interval`, in the place of `every`.
fn read_interval(item: &Item<'_>, problems: &mut Problems) -> Option<Located<Number>> {
    let number = item.number(problems)?;
    if number.value.value <= 0.0 {
        problems.push(
            SceneProblemCause::OutOfRange {
                key: item.title.clone(),
                value: number.value.literal.clone(),
                allowed: "positive".to_owned(),
            },
            number.place(),
        );
        return None;
    }
    Some(number)
}

/// `times`, in the place of `every` and `interval`.
fn read_times(item: &Item<'_>, problems: &mut Problems) -> Option<Located<Vec<Located<Number>>>> {
    let times = item.list_of("a list of times", problems, Item::number)?;
    Some(Located::new(times, item.place()))
}

/// The observables of a `record` table; energy and every Casimir where it gives none.
pub(super) fn read_observables(
    record: Option<&Table<'_>>,
    section: &Place,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<Vec<ObservableSpec>> {
    if let Some(list) = record.and_then(|record| record.get("observables")) {
        let entries = list.list_of("a list of names and formulas", problems, read_observable)?;
        return Some(observe_vectors(system, entries.concat()));
    }
    let energy = Located::new("energy".to_owned(), section.clone());
    let casimirs = system.into_iter().flat_map(|system| &system.casimirs);
    let names = casimirs.map(|(name, _)| name.clone());
    let formulas = std::iter::once(energy).chain(names);
    Some(formulas.map(unnamed).collect())
}

fn unnamed(formula: Located<String>) -> ObservableSpec {
    ObservableSpec {
        name: None,
        formula,
    }
}

/// A name or a formula, or formulas by the names of their columns.
fn read_observable(item: &Item<'_>, problems: &mut Problems) -> Option<Vec<ObservableSpec>> {
    if !item.is_table() {
        return item.string(problems).map(|one| vec![unnamed(one)]);
    }
    let pairs = item.pairs(
        "a formula, or { name = \"formula\" }",
        problems,
        Item::formula,
    )?;
    let named = pairs.into_iter().map(|(name, formula)| ObservableSpec {
        name: Some(name),
        formula,
    });
    Some(named.collect())
}
