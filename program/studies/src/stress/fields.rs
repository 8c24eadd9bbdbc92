//! NaN and the infinities in every numeric field of a scene.

use leafwise_core::Registry;
use leafwise_core::part::{ParameterDefault, PartInfo, PartKind};
use leafwise_scene::document::scene_keys;
use leafwise_scene::{SceneDocument, compose};
use toml::{Table, Value};

use super::case::{Case, Outcome, StressError, StressOptions, Tally};

pub(super) const CASES: [Case; 2] = [
    Case {
        family: "scene-fields",
        name: "numbers",
        asked: "nan, inf, -inf and 1e999 in place of each number of scenes that between them hold \
                every key the reader knows",
        expected: "each is refused, at its place; a key that no such scene holds fails this case",
        run: numbers,
    },
    Case {
        family: "scene-fields",
        name: "part-parameters",
        asked: "nan, inf, -inf and 1e999 in each numeric parameter of each registered part",
        expected: "each is refused",
        run: parameters,
    },
];

/// Scenes that between them hold every key of [`scene_keys`].
pub const SCENES_WITH_EVERY_KEY: [&str; 25] = [
    include_str!("scenes/contact.toml"),
    include_str!("scenes/own-names.toml"),
    include_str!("scenes/torque.toml"),
    include_str!("scenes/equations.toml"),
    include_str!("scenes/orders.toml"),
    include_str!("scenes/written-parts.toml"),
    include_str!("scenes/pace.toml"),
    include_str!("scenes/ensemble-times.toml"),
    include_str!("scenes/forces.toml"),
    include_str!("scenes/chain.toml"),
    include_str!("scenes/log-canonical.toml"),
    include_str!("scenes/algebra-by-name.toml"),
    include_str!("scenes/structure-constants.toml"),
    include_str!("scenes/magnetic-field.toml"),
    include_str!("scenes/constraints.toml"),
    include_str!("scenes/sum-of-brackets.toml"),
    include_str!("scenes/two-form.toml"),
    include_str!("scenes/site-values.toml"),
    include_str!("scenes/tables.toml"),
    include_str!("scenes/files.toml"),
    include_str!("scenes/noise.toml"),
    include_str!("scenes/sweep-grid.toml"),
    include_str!("scenes/sweep-list.toml"),
    include_str!("scenes/sweep-file.toml"),
    include_str!("scenes/ensemble.toml"),
];

/// Other ways to draw, in the last scene.
const DRAWS: [(&str, &str); 6] = [
    ("ball = 0.1,", "box = [0.1, 0.2, 0.3],"),
    ("ball = 0.1,", "normal = 0.1,"),
    ("ball = 0.1,", "sphere = 0.1,"),
    ("ball = 0.1,", "leaf = 0.1,"),
    (
        "{ ball = 0.1, center = [1, 3.0, 3] }",
        "{ file = \"states.csv\" }",
    ),
    ("values = [1.2, 1.25, 1.3]", "range = [1.2, 1.3, 3]"),
];

fn scenes() -> impl Iterator<Item = String> {
    let last = SCENES_WITH_EVERY_KEY[SCENES_WITH_EVERY_KEY.len() - 1];
    let written = SCENES_WITH_EVERY_KEY.map(str::to_owned).into_iter();
    written.chain(DRAWS.map(|(from, to)| last.replacen(from, to, 1)))
}

/// Whether `path` is `key`, where `*` stands for a name, which may be dotted.
fn is_key(key: &str, path: &str) -> bool {
    fn is_same(key: &[&str], path: &[&str]) -> bool {
        match (key, path) {
            ([], []) => true,
            (["*", rest @ ..], [_, path @ ..]) => is_same(rest, path) || is_same(key, path),
            ([name, rest @ ..], [own, path @ ..]) => name == own && is_same(rest, path),
            _ => false,
        }
    }
    let [key, path] = [key, path].map(|text| text.split('.').collect::<Vec<_>>());
    is_same(&key, &path)
}

const BAD: [&str; 4] = ["nan", "inf", "-inf", "1e999"];

/// A number that no scene holds, to be replaced in its text.
const MARK: f64 = 271_828_182.5;

fn numbers(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    let mut fields = 0;
    let mut seen = Vec::new();
    let registry = Registry::with_builtin();
    for text in scenes() {
        let document = SceneDocument::parse("case", &text, &registry)?;
        let scene = Value::Table(text.parse::<Table>().unwrap_or_default());
        let mut paths = Vec::new();
        walk(&scene, &mut Vec::new(), &mut seen, &mut paths);
        // One scene reads files, which are not there: its numbers are those of another scene.
        if !document.files().is_empty() {
            continue;
        }
        compose(&document, &registry).map_err(StressError::Refused)?;
        fields += paths.len();
        for path in &paths {
            let mut changed = scene.clone();
            replace(&mut changed, path, MARK);
            let marked = toml::to_string(&changed).unwrap_or_default();
            for bad in BAD {
                let text = marked.replace(&format!("{MARK:?}"), bad);
                let name = path.join(".");
                tally.take(text != marked && is_refused(&text), || {
                    format!("{name} = {bad} is taken")
                });
            }
        }
    }
    for key in scene_keys() {
        tally.take(seen.iter().any(|path| is_key(&key, path)), || {
            format!("no scene holds `{key}`")
        });
    }
    Ok(tally.outcome(|_| {
        format!(
            "{fields} fields refused, {} keys covered",
            scene_keys().len()
        )
    }))
}

/// Whether reading or composing refuses it, in words.
fn is_refused(text: &str) -> bool {
    let registry = Registry::with_builtin();
    match SceneDocument::parse("case", text, &registry) {
        Err(errors) => !errors.to_string().is_empty(),
        Ok(document) => compose(&document, &registry).is_err(),
    }
}

/// The paths of all keys, dotted and without indices of lists, and those of all numbers.
fn walk(
    value: &Value,
    path: &mut Vec<String>,
    keys: &mut Vec<String>,
    numbers: &mut Vec<Vec<String>>,
) {
    match value {
        Value::Integer(_) | Value::Float(_) => numbers.push(path.clone()),
        Value::Table(table) => {
            for (key, value) in table {
                path.push(key.clone());
                keys.push(path.join("."));
                walk(value, path, keys, numbers);
                path.pop();
            }
        }
        Value::Array(list) => {
            for (at, value) in list.iter().enumerate() {
                path.push(at.to_string());
                walk(value, path, keys, numbers);
                path.pop();
            }
        }
        _ => {}
    }
}

/// Puts a number where the path leads.
fn replace(value: &mut Value, path: &[String], number: f64) {
    let Some((first, rest)) = path.split_first() else {
        *value = Value::Float(number);
        return;
    };
    let inner = match value {
        Value::Table(table) => table.get_mut(first),
        Value::Array(list) => first.parse::<usize>().ok().and_then(|at| list.get_mut(at)),
        _ => None,
    };
    if let Some(inner) = inner {
        replace(inner, rest, number);
    }
}

fn parameters(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    let parts = Registry::with_builtin().parts().into_iter();
    for part in parts.filter(|part| part.kind != PartKind::System) {
        let numeric = part.parameters.iter().filter(|parameter| {
            matches!(
                parameter.default,
                ParameterDefault::Integer(_) | ParameterDefault::Real(_)
            )
        });
        for parameter in numeric {
            for bad in BAD {
                let scene = scene_with(part, parameter.name, bad);
                let name = format!("{} {} = {bad}", part.name, parameter.name);
                tally.take(is_refused(&scene), || format!("{name} is taken"));
            }
        }
    }
    Ok(tally.outcome(|count| format!("{count} settings refused")))
}

/// A scene whose method gives a parameter of a part.
fn scene_with(part: &PartInfo, parameter: &str, value: &str) -> String {
    let name = part.name;
    let given = format!("{{ name = \"{name}\", {parameter} = {value} }}");
    let method = match part.kind {
        PartKind::Realization => format!("realization = {given}\ndynamics = \"auto\""),
        PartKind::Dynamics => format!("realization = \"auto\"\ndynamics = {given}"),
        PartKind::Composition => {
            format!("realization = \"auto\"\ndynamics = \"auto\"\ncomposition = {given}")
        }
        _ => format!("stepper = {given}"),
    };
    format!(
        "[system]\nlibrary = \"rigid-body\"\n[method]\n{method}\ntime-step = 0.1\n\
         [run]\ninitial = [1, 3, 3]\nsteps = 1\n"
    )
}
