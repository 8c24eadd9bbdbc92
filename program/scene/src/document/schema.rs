//! Every key that a scene may have, with the shape of its value: what the reader accepts, `--set` may set, and editors
//! complete.

use leafwise_core::PartKind;

use super::shape::{FORMULAS, Key, NUMBERS, Shape, key, table};
use super::system_schema::{FIELDS, SYSTEM};

/// The scene.
pub(super) static ROOT: Shape = table(&SCENE, &[&["system", "method", "run"]]);

pub(super) static SCENE: [Key; 6] = [
    key(
        "system",
        table(
            &SYSTEM,
            &[
                &["library"],
                &["variables", "bracket", "hamiltonian"],
                &["families", "bracket", "hamiltonian"],
            ],
        ),
        "The Poisson manifold and the Hamiltonian",
    ),
    key(
        "method",
        table(&METHOD, &[&["time-step"], &["epsilon", "h"]]),
        "The integrator and its step",
    ),
    key(
        "run",
        table(&RUN, &[&["initial", "steps"], &["initial", "until"]]),
        "Where to start, how far to go, what to keep",
    ),
    key(
        "ensemble",
        table(&ENSEMBLE, &[]),
        "Many initial states or parameter sets at once",
    ),
    key(
        "sweep",
        table(&SWEEP, &[&["grid"], &["list"], &["file"]]),
        "One run for each of many settings of the scene's keys",
    ),
    key(
        "plugins",
        Shape::List(&Shape::Either(&[Shape::Text, table(&PLUGIN, &[&["path"]])])),
        "Shared libraries whose parts the scene uses: paths, or names to search for",
    ),
];

/// The key of [`MethodSection::chosen_at`](super::MethodSection::chosen_at).
pub const CHOSEN_AT: &str = "chosen-at";

pub(super) static METHOD: [Key; 10] = [
    key(
        "realization",
        Shape::Part(PartKind::Realization),
        "The geometric approximation",
    ),
    key(
        "dynamics",
        Shape::Part(PartKind::Dynamics),
        "The dynamic approximation",
    ),
    key(
        "composition",
        Shape::Part(PartKind::Composition),
        "A symmetric composition of steps, for higher order",
    ),
    key(
        "stepper",
        Shape::Part(PartKind::Stepper),
        "A step map in place of realization and dynamics",
    ),
    key("epsilon", Shape::Number, "One factor of the time step"),
    key("h", Shape::Number, "The other factor of the time step"),
    key(
        "time-step",
        Shape::Number,
        "What one step advances t by, in place of epsilon and h",
    ),
    key(
        "pace",
        Shape::Formula,
        "dt/dtau, positive: steps are then of the fictitious time tau, and small in t where the pace is",
    ),
    key(
        "noise",
        Shape::Words(&["joint", "split"]),
        "How noise enters a step: with H, of order 1 in the mean, or as flows between two half steps of H, of order 2",
    ),
    key(
        CHOSEN_AT,
        Shape::Names(&Shape::Number),
        "Values of parameters from which the parts choose what they are made of",
    ),
];

const OBSERVABLES: Shape = Shape::List(&Shape::Either(&[Shape::Text, FORMULAS]));

pub(super) static RUN: [Key; 10] = [
    key(
        "initial",
        Shape::Either(&[NUMBERS, FIELDS]),
        "A number for each variable, or a formula for each variable or family; of a family also a list or { file = \"q.csv\" }",
    ),
    key("steps", Shape::Whole(0), "How many steps"),
    key(
        "until",
        Shape::Number,
        "The time at the end, in place of steps, beside a pace",
    ),
    key(
        "t0",
        Shape::Number,
        "What the time t of formulas is at the initial state, from which all times count; 0 where not said",
    ),
    key(
        "stop",
        Shape::Text,
        "Where the run ends before: a comparison, as \"q1^2 + q2^2 > 1\"",
    ),
    key(
        "section",
        table(&SECTION, &[&["at"]]),
        "A surface whose crossings are recorded: { at = \"q1 = 0\", direction = \"up\" }",
    ),
    key(
        "seed",
        Shape::Whole(0),
        "What the random numbers of noise depend on; 0 where not said. Members of an ensemble draw by its own",
    ),
    key(
        "member",
        Shape::Whole(0),
        "Whose random numbers these are: of the member of an ensemble with this seed; 0 where not said",
    ),
    key("record", table(&RECORD, &[]), "What to keep of the run"),
    key("out", Shape::Text, "The run directory"),
];

pub(super) static SECTION: [Key; 3] = [
    key("at", Shape::Text, "The surface, as \"q1 = 0\""),
    key(
        "direction",
        Shape::Words(&["up", "down", "both"]),
        "Which crossings: where left - right rises, where it falls, or all",
    ),
    key(
        "axes",
        Shape::List(&Shape::Text),
        "The two columns that the report draws over each other, as [\"q2\", \"p2\"]",
    ),
];

pub(super) static RECORD: [Key; 5] = [
    key(
        "every",
        Shape::Whole(1),
        "Every how many steps a sample is kept",
    ),
    key(
        "interval",
        Shape::Number,
        "What time lies between two samples, in place of every, beside a pace",
    ),
    key(
        "times",
        NUMBERS,
        "The times of all samples, in place of every, as [0.5, 1, 10]",
    ),
    key(
        "observables",
        OBSERVABLES,
        "`energy`, names of Casimirs, formulas, or { name = \"formula\" }",
    ),
    key(
        "states",
        Shape::Either(&[Shape::Text, Shape::List(&Shape::Text)]),
        "\"all\", or the coordinates to keep: [\"q[0]\", \"q[::100]\", \"p\"]",
    ),
];

pub(super) static ENSEMBLE: [Key; 7] = [
    key(
        "members",
        Shape::Whole(1),
        "How many; as many as a file or a grid has where not said",
    ),
    key(
        "seed",
        Shape::Whole(0),
        "What the random numbers depend on, beside the member",
    ),
    key(
        "initial",
        table(
            &DRAWS,
            &[
                &["ball"],
                &["box"],
                &["normal"],
                &["sphere"],
                &["leaf"],
                &["file"],
            ],
        ),
        "Where members start",
    ),
    key(
        "parameters",
        Shape::Names(&table(
            &WAYS,
            &[&["uniform"], &["normal"], &["values"], &["range"]],
        )),
        "Parameters that differ from member to member",
    ),
    key("record", table(&ENSEMBLE_RECORD, &[]), "What is reduced"),
    key(
        "final-states",
        Shape::Words(&["none", "csv", "npy", "binary"]),
        "Whether each member's last state is kept",
    ),
    key("out", Shape::Text, "The run directory"),
];

const LENGTHS: Shape = Shape::Either(&[Shape::Number, NUMBERS]);

/// Beside a distribution.
pub(super) const CENTER: &str = "center";

/// Ways to draw initial states, and [`CENTER`].
pub(super) static DRAWS: [Key; 7] = [
    key("ball", Shape::Number, "Uniform in the ball of this radius"),
    key(
        "box",
        LENGTHS,
        "Uniform within these distances of each coordinate",
    ),
    key("normal", LENGTHS, "Normal, of these standard deviations"),
    key(
        "sphere",
        Shape::Number,
        "Uniform on the sphere of this radius",
    ),
    key(
        "leaf",
        Shape::Number,
        "As `ball`, moved onto the symplectic leaf of the centre",
    ),
    key(
        "file",
        Shape::Text,
        "The rows of a file beside the scene, CSV or JSON; columns may name parameters",
    ),
    key(
        CENTER,
        NUMBERS,
        "About what; the scene's initial state where not said",
    ),
];

/// Ways to draw a parameter.
pub(super) static WAYS: [Key; 4] = [
    key("uniform", NUMBERS, "[from, to]"),
    key("normal", NUMBERS, "[mean, standard deviation]"),
    key(
        "values",
        NUMBERS,
        "One after the other: a direction of a grid",
    ),
    key(
        "range",
        NUMBERS,
        "[from, to, count], equidistant: a direction of a grid",
    ),
];

pub(super) static ENSEMBLE_RECORD: [Key; 6] = [
    key(
        "every",
        Shape::Whole(1),
        "Every how many steps statistics are taken",
    ),
    key(
        "interval",
        Shape::Number,
        "What time lies between two statistics, in place of every, beside a pace",
    ),
    key(
        "times",
        NUMBERS,
        "The times of all statistics, in place of every, as [0.5, 1, 10]",
    ),
    key(
        "observables",
        OBSERVABLES,
        "`energy`, names of Casimirs, formulas, or { name = \"formula\" }",
    ),
    key("quantiles", NUMBERS, "Numbers between 0 and 1"),
    key(
        "drift-every",
        Shape::Whole(1),
        "Every how many steps drifts are taken in",
    ),
];

pub(super) static SWEEP: [Key; 5] = [
    key(
        "grid",
        Shape::Names(&Shape::Either(&[
            Shape::List(&Shape::Anything),
            table(&GRID_RANGES, &[&["range"], &["logarithmic"]]),
        ])),
        "All combinations: { \"system.parameters.a\" = { range = [0, 1, 50] }, \"method.time-step\" = [0.1, 0.2] }",
    ),
    key(
        "list",
        Shape::List(&Shape::Names(&Shape::Anything)),
        "Values given together: [{ \"method.stepper\" = \"rk4\", \"method.time-step\" = 0.1 }, …]",
    ),
    key(
        "file",
        Shape::Text,
        "A CSV file beside the scene: keys in the first row, a setting in each other",
    ),
    key(
        "record",
        table(&SWEEP_RECORD, &[]),
        "What is measured of each last state",
    ),
    key("out", Shape::Text, "The run directory"),
];

pub(super) static SWEEP_RECORD: [Key; 1] = [key(
    "observables",
    OBSERVABLES,
    "`energy`, names of Casimirs, formulas, or { name = \"formula\" }",
)];

/// Ways to write many values.
pub(super) static GRID_RANGES: [Key; 2] = [
    key("range", NUMBERS, "[from, to, count], equidistant"),
    key(
        "logarithmic",
        NUMBERS,
        "[from, to, count], of equal ratios; positive",
    ),
];

pub(super) static PLUGIN: [Key; 2] = [
    key(
        "path",
        Shape::Text,
        "A path, relative to the scene, or a name to search for",
    ),
    key("sha256", Shape::Text, "What the file must hash to"),
];

/// Paths of the keys, as `run.record.every`, which a test of every field has to cover. A `*` in a path stands for a
/// name that the scene chooses. Such names are left out where they are all that a table holds, as the values of
/// parameters, or the parameters of a part. Left out too are the keys of entries of lists.
pub fn scene_keys() -> Vec<String> {
    let mut paths = Vec::new();
    of_keys("", &SCENE, &mut paths);
    paths
}

fn of_keys(prefix: &str, keys: &[Key], paths: &mut Vec<String>) {
    for key in keys {
        let path = format!("{prefix}{}", key.name);
        paths.push(path.clone());
        of_shape(&path, &key.shape, paths);
    }
}

fn of_shape(path: &str, shape: &Shape, paths: &mut Vec<String>) {
    match shape {
        Shape::Table(table) => of_keys(&format!("{path}."), table.keys, paths),
        Shape::Names(each) => of_shape(&format!("{path}.*"), each, paths),
        Shape::Either(shapes) => shapes.iter().for_each(|shape| of_shape(path, shape, paths)),
        _ => {}
    }
}
