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
    r#"
    [system]
    variables   = ["x", "v"]
    bracket     = { canonical = [["x", "v"]] }
    hamiltonian = "v^2/2 + x^2/2"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.1
    [run]
    initial = [1, 0.5]
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["x", "v", "s"]
    bracket     = { contact = [["x", "v"]] }
    hamiltonian = "v^2/2 + x^2/2 + 0.1*s"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.1
    [run]
    initial = [1, 0.5, 0]
    steps   = 10
    "#,
    r#"
    [system]
    library = "attitude"
    torque  = { body = [0.1, 0, 0], space = [0, 0, 0.2] }
    [method]
    realization = "auto"
    time-step   = 0.1
    [run]
    initial = [1.0, 1.5, -0.7, 1.0, 0.0, 0.0, 0.0]
    steps   = 10
    "#,
    r#"
    [system]
    parameters = { a = 1.5 }
    equations  = { q = "p", p = "-a*sin(q)" }
    bracket    = "find"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.1
    [run]
    initial = [1, 0.5]
    steps   = 10
    "#,
    r#"
    plugins = []
    [system]
    variables   = ["x1", "x2", "x3"]
    parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1.25 }
    bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
    convention  = "{H,x}"
    hamiltonian = "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"
    define      = { spin2 = "x1^2 + x2^2 + x3^2" }
    casimirs    = { spin = "spin2" }
    [method]
    realization = { name = "karasev-truncated", order = 6 }
    dynamics    = { name = "hamilton-jacobi", order = 2 }
    composition = "suzuki-umeno-8"
    epsilon     = 0.1
    h           = 2
    chosen-at   = { I1 = 1.5 }
    [run]
    initial = [1, 3.0, 3]
    steps   = 10
    record  = { every = 1, observables = ["energy", "megno", "lyapunov", "sali"], states = ["x1"] }
    out     = "runs/case"
    "#,
    r#"
    [system]
    variables   = ["q", "p"]
    bracket     = { "q,p" = "1" }
    hamiltonian = "(q^2 + p^2)/2"
    [method]
    realization = { name = "closed-form", alpha = ["q - epsilon*p_p/2", "p + epsilon*p_q/2"], order = 2 }
    dynamics    = { name = "generating-function", S = ["H", 0.0], order = 2 }
    time-step   = 0.1
    [run]
    initial = [1.0, 0.5]
    steps   = 10
    "#,
    r#"
    [system]
    library = "kepler"
    [method]
    dynamics  = { name = "hamilton-jacobi", order = 2 }
    pace      = "(q1^2 + q2^2)^0.75"
    time-step = 0.1
    [run]
    initial = [0.5, 0, 0, 1.5]
    until   = 1.5
    stop    = "q1^2 + q2^2 > 4"
    section = { at = "q1 = 0", direction = "up", axes = ["q2", "p2"] }
    record  = { interval = 0.5 }
    [ensemble]
    members = 3
    initial = { ball = 0.01 }
    record  = { interval = 0.5 }
    "#,
    r#"
    [system]
    library = "rigid-body"
    [method]
    stepper   = "splitting"
    energy    = "exact"
    time-step = 0.1
    [run]
    initial = [1, 3, 3]
    steps   = 10
    [ensemble]
    members = 3
    initial = { ball = 0.01 }
    record  = { times = [0.25, 0.5] }
    "#,
    r#"
    [system]
    library    = "rigid-body"
    parameters = { I1 = 2.0 }
    forces     = [0.1, "0.2*x1", "x2"]
    damping    = { rate = 0.1, metric = [1, 2, 0.5] }
    [method]
    stepper   = { name = "dormand-prince45", tolerance = 1e-6 }
    time-step = 0.1
    [run]
    initial = [1, 3, 3]
    steps   = 10
    record  = { times = [0.25, 1] }
    "#,
    r#"
    [system]
    families    = { x = 64 }
    bracket     = { "x[i],x[i+1]" = "x[i]*x[i+1]" }
    boundary    = "periodic"
    hamiltonian = "sum(i, x[i])"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = { "x[i]" = "1 + 0.1*sin(2*pi*i/N)" }
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["x", "y"]
    bracket     = { log-canonical = [[0, 2.0], [-2, 0]] }
    hamiltonian = "x + y"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [1, 2]
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["x1", "x2", "x3"]
    bracket     = { lie-algebra = { name = "so3" } }
    hamiltonian = "x1^2 + x2^2/2"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [1, 2, 3]
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["l", "g1", "g2"]
    bracket     = { lie-algebra = { structure = [[1, 1, 1, 0]], representation = [[[0, -1], [1, 0]]] } }
    hamiltonian = "l^2/2 - g1"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [1, 2, 3]
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["x", "y", "z", "px", "py", "pz"]
    bracket     = { magnetic-field = ["0", "0", "1"] }
    hamiltonian = "(px^2 + py^2 + pz^2)/2"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [0, 0, 0, 1, 0, 1]
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["x", "y", "px", "py"]
    bracket     = { one-form = ["px", "py", 0, 0] }
    constraints = ["x^2 + y^2 - 1", "x*px + y*py"]
    hamiltonian = "(px^2 + py^2)/2 + y"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [1, 0, 0, 0.5]
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["a"]
    families    = { s = { components = ["x", "y", "z"], length = 2 }, q = 2, p = 2 }
    hamiltonian = "sum(i, q[i]*s.x[i] + p[i]^2/2) + a*sum(i<j, q[i]*q[j])"
    [system.bracket]
    sum = [
      { variables = ["s"], bracket = { lie-algebra = "so3" } },
      { variables = ["q", "p"], bracket = { "q[i],p[i]" = -1 }, constraints = [] },
      { variables = ["a"], bracket = {} },
    ]
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [1, 0, 0.5, 0.6, 0.8, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["q", "p"]
    bracket     = { two-form = { "q,p" = -1 } }
    hamiltonian = "p^2/2 + q^2/2"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [1, 0]
    steps   = 10
    "#,
    r#"
    [system]
    families    = { q = 2, p = 2 }
    parameters  = { "J[i]" = [1, 2.0], "J[1]" = 2.5 }
    bracket     = { "q[i],p[i]" = -1 }
    hamiltonian = "sum(i, p[i]^2/2 + J[i]*q[i]^2/2)"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = { "q[i]" = [1, 2], "p[i]" = 0 }
    steps   = 10
    "#,
    r#"
    [system]
    variables   = ["q", "p"]
    bracket     = { "q,p" = -1 }
    hamiltonian = "p^2/2 + V(q) + W(q, p)"
    [system.tables]
    V = { values = [1.5, 0.0, 0.5, 2.0], axes = { q = [-1.5, 2] }, periodic = ["q"], degree = 3 }
    W = { values = [[1, 0.5], [0.0, 2.0]], axes = { q = [-1.5, 2], p = [-2, 2] }, degree = 1 }
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = [0.5, 0.25]
    steps   = 10
    "#,
    r#"
    [system]
    families    = { q = 2, p = 2 }
    parameters  = { "J[i]" = { file = "j.csv", column = "J" } }
    tables      = { V = { file = "v.csv", column = "V", axes = { q = [-1, 1] } } }
    bracket     = { "q[i],p[i]" = -1 }
    hamiltonian = "sum(i, p[i]^2/2 + J[i]*V(q[i]))"
    [method]
    realization = "auto"
    dynamics    = "auto"
    time-step   = 0.05
    [run]
    initial = { "q[i]" = { file = "q.csv", column = "q" }, "p[i]" = 0 }
    steps   = 10
    "#,
    r#"
    [system]
    library = "rigid-body"
    noise   = [{ hamiltonian = "x1", strength = 0.1 }]
    [method]
    realization = "auto"
    noise       = "split"
    time-step   = 0.05
    [run]
    initial = [1, 3, 3]
    steps   = 10
    t0      = 0.5
    seed    = 1
    member  = 2
    "#,
    r#"
    [system]
    library = "rigid-body"
    [method]
    stepper   = "splitting"
    time-step = 0.05
    [run]
    initial = [1, 3, 3]
    steps   = 10
    [sweep]
    grid   = { "system.parameters.I2" = { range = [0.5, 1.5, 3] }, "method.time-step" = { logarithmic = [0.01, 0.1, 3.0] }, "run.steps" = [5, 10] }
    record = { observables = ["energy", "x1"] }
    out    = "runs/case"
    "#,
    r#"
    [system]
    library = "rigid-body"
    [method]
    stepper   = "splitting"
    time-step = 0.05
    [run]
    initial = [1, 3, 3]
    steps   = 10
    [sweep]
    list = [{ "method.time-step" = 0.1 }, { "run.initial" = [1, 2.5, 3], "run.steps" = 5 }]
    "#,
    r#"
    [system]
    library = "rigid-body"
    [method]
    stepper   = "splitting"
    time-step = 0.05
    [run]
    initial = [1, 3, 3]
    steps   = 10
    [sweep]
    file = "settings.csv"
    "#,
    r#"
    [system]
    library = "rigid-body"
    [method]
    stepper   = "splitting"
    time-step = 0.05
    [run]
    initial = [1, 3, 3]
    steps   = 10
    [ensemble]
    members      = 12
    seed         = 1
    initial      = { ball = 0.1, center = [1, 3.0, 3] }
    record       = { every = 2, observables = ["energy"], quantiles = [0.05, 0.5], drift-every = 1 }
    final-states = "csv"
    out          = "runs/case"
    [ensemble.parameters]
    I1 = { uniform = [0.9, 1.1] }
    I2 = { normal = [0.75, 0.005] }
    I3 = { values = [1.2, 1.25, 1.3] }
    "#,
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
