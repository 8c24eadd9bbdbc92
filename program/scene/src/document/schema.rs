//! Every key that a scene may have, with the shape of its value: what the reader accepts, `--set` may set, and editors
//! complete.

use leafwise_core::PartKind;

use super::shape::{Beside, ENDS, FORMULAS, Key, NUMBERS, RANGE, Shape, choice, key, table};
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
                &["equations", "bracket"],
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
        "The initial state, the end, and what to keep",
    ),
    key(
        "ensemble",
        table(&ENSEMBLE, &[]),
        "Many initial states or parameter sets at once",
    )
    .otherwise("none"),
    key(
        "sweep",
        table(&SWEEP, &[&["grid"], &["list"], &["file"]]),
        "One run for each of many settings of the scene's keys",
    )
    .otherwise("none"),
    key(
        "plugins",
        Shape::List(&Shape::Either(&[Shape::Text, table(&PLUGIN, &[&["path"]])])),
        "Shared libraries whose parts the scene uses: paths, or names to search for",
    )
    .default("[]"),
];

static STEPPER_BESIDE: [Beside; 1] = [Beside::InPlaceOf {
    keys: &["realization", "dynamics"],
    advice: "a stepper replaces both parts",
}];

static TIME_STEP_BESIDE: [Beside; 1] = [Beside::InPlaceOf {
    keys: &["epsilon", "h"],
    advice: "give `epsilon` and `h`, or `time-step` alone: one step advances t by epsilon*h",
}];

/// The path of the noise.
const NOISE: &str = "system.noise";

/// Motions that a pace does not serve.
static PACE_BESIDE: [Beside; 3] = [
    Beside::Elsewhere {
        paths: &[
            "system.forces",
            "system.torque",
            "system.damping",
            "system.friction",
        ],
        message: "a pace serves motions of a Hamiltonian alone, and this system has forces",
        help: "take steps that are short enough everywhere",
    },
    Beside::Elsewhere {
        paths: &[NOISE],
        message: "a pace is not offered with noise: its steps are of no time in which \
                  the noise is white",
        help: "take steps that are short enough everywhere",
    },
    Beside::Note("a long lattice, a `library` system that computes numbers"),
];

static UNTIL_BESIDE: [Beside; 1] = [Beside::InPlaceOf {
    keys: &["steps"],
    advice: "give the number of `steps`, or the time `until` which they go",
}];

static STOP_BESIDE: [Beside; 1] = [Beside::Elsewhere {
    paths: &[NOISE],
    message: "`stop` is not offered with noise: its place is found by shorter steps, and these would draw new \
              noise",
    help: "record the quantity, and look where its samples end",
}];

static SECTION_BESIDE: [Beside; 1] = [Beside::Elsewhere {
    paths: &[NOISE],
    message: "a section is not offered with noise: a crossing is found by shorter steps, and these would draw new \
              noise",
    help: "record the quantity, and look where its samples change their sign",
}];

static SET_BESIDE: [Beside; 2] = [
    Beside::Elsewhere {
        paths: &["method.pace"],
        message: "events that change the state are not offered with a pace",
        help: "take the pace away: steps of the time itself",
    },
    Beside::Note("indicators of chaos"),
];

/// Keys that an interval between two samples does not stand beside, and the pace that it needs.
static INTERVAL_BESIDE: [Beside; 2] = [
    Beside::InPlaceOf {
        keys: &["every"],
        advice: "give `every`, a number of steps, or `interval`, a time",
    },
    Beside::Without {
        path: "method.pace",
        message: "`interval` is a time, and steps are all alike without a pace",
        help: "write `every`, a number of steps, or a pace = \"…\" into [method]",
    },
];

/// Keys that times of samples do not stand beside.
static TIMES_BESIDE: [Beside; 3] = [
    Beside::InPlaceOf {
        keys: &["every", "interval"],
        advice: "give one of them: a number of steps, a time between samples, or a list of times",
    },
    Beside::Elsewhere {
        paths: &[NOISE],
        message: "`times` are not offered with noise: a state between two steps is found by shorter steps, and \
                  these would draw new noise",
        help: "write every = …, a number of steps between two samples",
    },
    Beside::Note("a pace with `run.steps`"),
];

/// Scenes without a shadow energy, and without indicators of chaos.
static OBSERVABLES_BESIDE: [Beside; 2] = [
    Beside::Note("as `shadow-energy`: noise, a pace, forces, a long lattice"),
    Beside::Note("as `megno`, `lyapunov`, `sali`: noise"),
];

/// The key of [`MethodSection::chosen_at`](super::MethodSection::chosen_at).
pub const CHOSEN_AT: &str = "chosen-at";

pub(super) static METHOD: [Key; 11] = [
    key(
        "realization",
        Shape::Part(PartKind::Realization),
        "The geometric approximation",
    )
    .default("\"auto\""),
    key(
        "dynamics",
        Shape::Part(PartKind::Dynamics),
        "The dynamic approximation",
    )
    .default("\"auto\""),
    key(
        "composition",
        Shape::Part(PartKind::Composition),
        "A symmetric composition of steps, for higher order",
    )
    .default("\"none\""),
    key(
        "stepper",
        Shape::Part(PartKind::Stepper),
        "A step map in place of realization and dynamics",
    )
    .otherwise("none")
    .not_beside(&STEPPER_BESIDE),
    key("epsilon", Shape::Formula, "One factor of the time step"),
    key("h", Shape::Formula, "The other factor of the time step"),
    key(
        "time-step",
        Shape::Formula,
        "The time that one step advances t by, in place of epsilon and h: a number, or a formula of numbers such as \"2*pi/100\"; a negative one runs backwards in time",
    )
    .not_beside(&TIME_STEP_BESIDE),
    key(
        "pace",
        Shape::Formula,
        "dt/dtau, positive: steps are then of the fictitious time tau, and small in t where \
         the pace is",
    )
    .otherwise("none")
    .not_beside(&PACE_BESIDE),
    key(
        "noise",
        Shape::Words(&["joint", "split"]),
        "The way noise enters a step: with H, of order 1 in the mean, or as flows between two half \
         steps of H, of order 2",
    )
    .default("\"joint\""),
    key(
        "energy",
        Shape::Words(&["exact"]),
        "Keeps the energy to round-off, as well as the Casimirs: each step subtracts multiples of Casimirs from H. The steps are \
         not a Poisson map as a whole",
    )
    .otherwise("as the steps have it")
    .not_beside(&[Beside::Note("noise, forces, a pace, H that names t, a long lattice, steps that are not exact Poisson maps")]),
    key(
        CHOSEN_AT,
        Shape::Names(&Shape::Number),
        "Values of parameters from which the parts choose what they are made of",
    )
    .otherwise("the system's own values"),
];

const OBSERVABLES: Shape = Shape::List(&Shape::Either(&[Shape::Text, FORMULAS]));

pub(super) static RUN: [Key; 11] = [
    key(
        "initial",
        Shape::Either(&[Shape::List(&Shape::Formula), FIELDS]),
        "A number or formula for each variable in their order, or a formula for each variable or family; of a family \
         also a list or { file = \"q.csv\" }",
    ),
    key("steps", Shape::Whole(0), "The number of steps"),
    key(
        "until",
        Shape::Formula,
        "The time at the end, in place of steps; equal steps are shortened to come to it",
    )
    .not_beside(&UNTIL_BESIDE),
    key(
        "t0",
        Shape::Number,
        "The time t of formulas at the initial state. `until`, `times`, samples and reports count from 0 all the same",
    )
    .default("0"),
    key(
        "stop",
        Shape::Text,
        "An earlier end: a condition, as \"q1^2 + q2^2 > 1\", with `and`, `or` and `not`",
    )
    .otherwise("none")
    .not_beside(&STOP_BESIDE),
    key(
        "section",
        table(&SECTION, &[&["at"]]),
        "A surface whose crossings are recorded: { at = \"q1 = 0\", direction = \"up\" }",
    )
    .otherwise("none")
    .not_beside(&SECTION_BESIDE),
    key(
        "seed",
        Shape::Whole(0),
        "The seed of the random numbers of noise. An ensemble uses its own seed for its members",
    )
    .default("0"),
    key(
        "member",
        Shape::Whole(0),
        "The member of an ensemble with this seed whose random numbers these are",
    )
    .default("0"),
    key(
        "error",
        Shape::Words(&["estimate"]),
        "Estimates the error of the run's states when it is done, by a pass with half the step: three times the steps in all",
    )
    .otherwise("none: `run --error` turns it on")
    .not_beside(&[Beside::Note(
        "ensembles, sweeps; an estimate: noise, a pace, events that set, functions in pieces, a tolerance",
    )]),
    key("record", table(&RECORD, &[]), "Records to keep of the run").otherwise("every step"),
    key("out", Shape::Text, "The run directory").otherwise("`runs/` and the scene's name"),
];

pub(super) static SECTION: [Key; 4] = [
    key("at", Shape::Text, "The surface, as \"q1 = 0\""),
    key(
        "direction",
        Shape::Words(&["up", "down", "both"]),
        "Crossings that count: where left - right rises, where it falls, or all",
    )
    .default("\"both\""),
    key(
        "axes",
        Shape::List(&Shape::Text),
        "The two columns that the report draws over each other, as [\"q2\", \"p2\"]",
    )
    .otherwise("the first two columns that vary"),
    key(
        "set",
        Shape::Names(&Shape::Formula),
        "Values that coordinates take where the surface is crossed, by formulas of the state before: { p = \"-0.9*p\" }",
    )
    .otherwise("none: crossings are recorded alone")
    .not_beside(&SET_BESIDE),
];

/// Of the records of runs and ensembles alike.
const DRIFT_EVERY: Key = key(
    "drift-every",
    Shape::Whole(1),
    "Steps from one look at the drifts of energy and Casimirs to the next",
)
.default("1");

pub(super) static RECORD: [Key; 6] = [
    key(
        "every",
        Shape::Whole(1),
        "Steps from one sample to the next",
    )
    .default("1"),
    key(
        "interval",
        Shape::Number,
        "The time between two samples, in place of every, with a pace",
    )
    .otherwise("none")
    .not_beside(&INTERVAL_BESIDE),
    key(
        "times",
        NUMBERS,
        "The times of all samples, in place of every, as [0.5, 1, 10]",
    )
    .otherwise("none")
    .not_beside(&TIMES_BESIDE),
    key(
        "observables",
        OBSERVABLES,
        "`energy`, names of Casimirs, `spin-temperature`, `megno`, `lyapunov`, `sali`, formulas, or { name = \"formula\" }",
    )
    .otherwise("`energy` and every Casimir")
    .not_beside(&OBSERVABLES_BESIDE),
    key(
        "states",
        Shape::Either(&[Shape::Text, Shape::List(&Shape::Text)]),
        "\"all\", or the coordinates to keep: [\"q[0]\", \"q[::100]\", \"p\"]",
    )
    .otherwise("all of at most 64 coordinates, none of more"),
    DRIFT_EVERY,
];

pub(super) static ENSEMBLE: [Key; 7] = [
    key("members", Shape::Whole(1), "The number of members")
        .otherwise("as many as a file or a grid has"),
    key(
        "seed",
        Shape::Whole(0),
        "The seed of the random numbers, which depend on the member too",
    )
    .default("0"),
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
        "Initial states of the members",
    )
    .otherwise("the scene's initial state"),
    key(
        "parameters",
        Shape::Names(&table(
            &WAYS,
            &[&["uniform"], &["normal"], &["values"], &["range"]],
        )),
        "Parameters that differ from member to member",
    )
    .otherwise("none"),
    key("record", table(&ENSEMBLE_RECORD, &[]), "Statistics to take")
        .otherwise("the start and the end"),
    key(
        "final-states",
        Shape::Words(&["none", "csv", "npy", "binary"]),
        "The form in which each member's last state is kept",
    )
    .default("\"none\""),
    key("out", Shape::Text, "The run directory")
        .otherwise("`runs/` and the scene's name with `-ensemble`"),
];

const LENGTHS: Shape = Shape::Either(&[Shape::Number, NUMBERS]);

/// Beside a distribution.
pub(super) const CENTER: &str = "center";

/// Ways to draw initial states, and [`CENTER`].
pub(super) static DRAWS: [Key; 7] = [
    choice("ball", Shape::Number, "Uniform in the ball of this radius"),
    choice(
        "box",
        LENGTHS,
        "Uniform within these distances of each coordinate",
    ),
    choice("normal", LENGTHS, "Normal, of these standard deviations"),
    choice(
        "sphere",
        Shape::Number,
        "Uniform on the sphere of this radius",
    ),
    choice(
        "leaf",
        Shape::Number,
        "As `ball`, moved onto the symplectic leaf of the centre",
    )
    .not_beside(&[Beside::Note("a system without Casimirs")]),
    choice(
        "file",
        Shape::Text,
        "The rows of a file beside the scene, CSV or JSON; columns may name parameters",
    )
    .not_beside(&[Beside::Keys {
        keys: &[CENTER],
        advice: "the file holds the states themselves: remove center",
    }]),
    key(
        CENTER,
        Shape::Either(&[NUMBERS, FIELDS]),
        "The centre of the draws, as `initial` of [run]; coordinates that it does not name keep the scene's initial value",
    )
    .otherwise("the scene's initial state"),
];

/// Ways to draw a parameter.
pub(super) static WAYS: [Key; 4] = [
    choice("uniform", ENDS, "[from, to]"),
    choice("normal", ENDS, "[mean, standard deviation]"),
    choice(
        "values",
        NUMBERS,
        "One after the other: a direction of a grid",
    ),
    choice(
        "range",
        RANGE,
        "[from, to, count], equidistant: a direction of a grid",
    ),
];

pub(super) static ENSEMBLE_RECORD: [Key; 6] = [
    key(
        "every",
        Shape::Whole(1),
        "Steps from one statistic to the next",
    )
    .otherwise("the start and the end")
    .not_beside(&[Beside::Note("`method.pace`")]),
    key(
        "interval",
        Shape::Number,
        "The time between two statistics, in place of every, with a pace",
    )
    .otherwise("none")
    .not_beside(&INTERVAL_BESIDE),
    key(
        "times",
        NUMBERS,
        "The times of all statistics, in place of every, as [0.5, 1, 10]",
    )
    .otherwise("none")
    .not_beside(&TIMES_BESIDE),
    key(
        "observables",
        OBSERVABLES,
        "`energy`, names of Casimirs, `spin-temperature`, `megno`, `lyapunov`, `sali`, formulas, or { name = \"formula\" }",
    )
    .otherwise("`energy` and every Casimir")
    .not_beside(&OBSERVABLES_BESIDE),
    key("quantiles", NUMBERS, "Numbers between 0 and 1").default("[]"),
    DRIFT_EVERY,
];

pub(super) static SWEEP: [Key; 5] = [
    choice(
        "grid",
        Shape::Names(&Shape::Either(&[
            Shape::List(&Shape::Anything),
            table(&GRID_RANGES, &[&["range"], &["logarithmic"]]),
        ])),
        "All combinations: { \"system.parameters.a\" = { range = [0, 1, 50] }, \
         \"method.time-step\" = [0.1, 0.2] }",
    ),
    choice(
        "list",
        Shape::List(&Shape::Names(&Shape::Anything)),
        "Values given together: [{ \"method.stepper\" = \"rk4\", \"method.time-step\" = 0.1 }, \
         …]",
    ),
    choice(
        "file",
        Shape::Text,
        "A CSV file beside the scene: keys in the first row, a setting in each other",
    ),
    key(
        "record",
        table(&SWEEP_RECORD, &[]),
        "Measurements of each last state",
    )
    .otherwise("`energy` and every Casimir"),
    key("out", Shape::Text, "The run directory")
        .otherwise("`runs/` and the scene's name with `-sweep`"),
];

pub(super) static SWEEP_RECORD: [Key; 1] = [key(
    "observables",
    OBSERVABLES,
    "`energy`, names of Casimirs, `spin-temperature`, `megno`, `lyapunov`, `sali`, formulas, or { name = \"formula\" }",
)
.otherwise("`energy` and every Casimir")];

/// Ways to write many values.
pub(super) static GRID_RANGES: [Key; 2] = [
    key("range", RANGE, "[from, to, count], equidistant")
        .not_beside(&[Beside::Note("`logarithmic`")]),
    key(
        "logarithmic",
        RANGE,
        "[from, to, count], of equal ratios; positive",
    )
    .not_beside(&[Beside::Note("`range`")]),
];

pub(super) static PLUGIN: [Key; 2] = [
    key(
        "path",
        Shape::Text,
        "A path, relative to the scene, or a name to search for",
    ),
    key("sha256", Shape::Text, "The SHA-256 that the file must have").otherwise("not checked"),
];

/// Paths of the keys, as `run.record.every`, which a test of every field has to cover. A `*` in a path stands for a
/// name that the scene chooses. Such names are left out where they are all that a table holds, as the values of
/// parameters, or the parameters of a part. Entries of lists have no name: `system.noise.strength`.
pub fn scene_keys() -> Vec<String> {
    each_key().into_iter().map(|(path, _)| path).collect()
}

/// Every key with its path, as [`scene_keys`] has it.
pub(super) fn each_key() -> Vec<(String, &'static Key)> {
    let mut keys = Vec::new();
    of_keys("", &SCENE, &mut keys);
    keys
}

/// The keys of the table that the last name of a path is a key of; none where the scene format has no such path.
pub(super) fn siblings(path: &str) -> &'static [Key] {
    let (table, name) = path.rsplit_once('.').unwrap_or(("", path));
    let mut names = table.split('.').filter(|name| !name.is_empty());
    match names.try_fold(&ROOT, |shape, name| shape.known(name)) {
        Some(shape) => shape.keys_with(name),
        None => &[],
    }
}

/// The key of this path, where the scene format has it.
pub(super) fn declared(path: &str) -> Option<&'static Key> {
    let name = path.rsplit('.').next()?;
    siblings(path).iter().find(|key| key.name == name)
}

fn of_keys(prefix: &str, keys: &'static [Key], all: &mut Vec<(String, &'static Key)>) {
    for key in keys {
        let path = format!("{prefix}{}", key.name);
        all.push((path.clone(), key));
        of_shape(&path, &key.shape, all);
    }
}

fn of_shape(path: &str, shape: &'static Shape, all: &mut Vec<(String, &'static Key)>) {
    match shape {
        Shape::Table(table) => of_keys(&format!("{path}."), table.keys, all),
        Shape::Names(each) => of_shape(&format!("{path}.*"), each, all),
        Shape::List(each) | Shape::Pairs(each) => of_shape(path, each, all),
        Shape::Either(shapes) => shapes.iter().for_each(|shape| of_shape(path, shape, all)),
        _ => {}
    }
}
