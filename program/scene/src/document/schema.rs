//! Every key that a scene may have, with the shape of its value: what the reader accepts, `--set` may set, and editors
//! complete.

use leafwise_core::PartKind;

/// A key of a table.
pub(super) struct Key {
    pub name: &'static str,
    pub shape: Shape,
    /// One line, for editors.
    pub about: &'static str,
}

/// What a value may be.
pub(super) enum Shape {
    Text,
    /// A string, or a number that stands for itself.
    Formula,
    Number,
    /// A whole number of at least this.
    Whole(u64),
    /// Any value.
    Anything,
    Words(&'static [&'static str]),
    List(&'static Shape),
    Table(Keys),
    /// A table of names that the scene chooses.
    Names(&'static Shape),
    /// A table of pairs of variables, `"x,y"`.
    Pairs(&'static Shape),
    Either(&'static [Shape]),
    /// A part by its name, or a table with the name and its parameters.
    Part(PartKind),
    /// A system of the library.
    System,
}

/// A parameter of a part.
static PARAMETER: Shape = Shape::Either(&[Shape::Text, Shape::List(&Shape::Formula)]);

/// What a key leads to.
pub(super) enum Inner<'a> {
    Known(&'a Shape),
    /// Nothing: these are the keys.
    Unknown(Vec<&'static str>),
    /// Nothing: the value is no table.
    Keyless,
}

impl Shape {
    /// What a key in a value of this shape leads to.
    pub(super) fn inner(&self, name: &str) -> Inner<'_> {
        match self {
            Self::Table(table) => match table.keys.iter().find(|key| key.name == name) {
                Some(key) => Inner::Known(&key.shape),
                None => Inner::Unknown(names(table.keys).collect()),
            },
            Self::Names(each) | Self::Pairs(each) => Inner::Known(each),
            Self::Part(_) => Inner::Known(&PARAMETER),
            Self::Either(shapes) => {
                let mut best = Inner::Keyless;
                for shape in *shapes {
                    match shape.inner(name) {
                        known @ Inner::Known(_) => return known,
                        Inner::Keyless => {}
                        unknown @ Inner::Unknown(_) => best = unknown,
                    }
                }
                best
            }
            _ => Inner::Keyless,
        }
    }
}

/// The keys of a table.
pub(super) struct Keys {
    pub keys: &'static [Key],
    /// Sets of keys, of which one has to be there whole.
    pub needs: &'static [&'static [&'static str]],
}

/// Whether a key of this name is among `keys`.
pub(super) fn has(keys: &[Key], name: &str) -> bool {
    keys.iter().any(|key| key.name == name)
}

/// The names of keys.
pub(super) fn names(keys: &[Key]) -> impl Iterator<Item = &'static str> + Clone {
    keys.iter().map(|key| key.name)
}

const fn key(name: &'static str, shape: Shape, about: &'static str) -> Key {
    Key { name, shape, about }
}

const fn table(keys: &'static [Key], needs: &'static [&'static [&'static str]]) -> Shape {
    Shape::Table(Keys { keys, needs })
}

const NUMBERS: Shape = Shape::List(&Shape::Number);
const FORMULAS: Shape = Shape::Names(&Shape::Formula);

/// What variables, sites of families and parameters of sites begin with.
const FIELDS: Shape = Shape::Names(&Shape::Either(&[
    Shape::Formula,
    NUMBERS,
    table(&COLUMN, &[&["file"]]),
]));

pub(super) static COLUMN: [Key; 2] = [
    key(
        "file",
        Shape::Text,
        "A file beside the scene, CSV or JSON, with a row for each site",
    ),
    key(
        "column",
        Shape::Text,
        "The name of its column, where it has several",
    ),
];

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

pub(super) static SYSTEM: [Key; 14] = [
    key(
        "library",
        Shape::System,
        "A system of the library, by its id",
    ),
    key(
        "variables",
        Shape::List(&Shape::Text),
        "The coordinates' names",
    ),
    key(
        "families",
        Shape::Names(&Shape::Either(&[
            Shape::Whole(1),
            table(&VECTORS, &[&["components", "length"]]),
        ])),
        "Indexed variables of a lattice and how many there are: { q = 1000, p = 1000 }, or vectors",
    ),
    key(
        "parameters",
        FIELDS,
        "Named numbers that formulas may use; \"J[i]\" = a formula of i, a list or { file = \"j.csv\" } for one at every site",
    ),
    key(
        "define",
        FORMULAS,
        "Names for formulas that other formulas use: { B = \"sqrt(x^2 + y^2)\" }",
    ),
    key(
        "bracket",
        Shape::Either(&[KIND, PAIRS, table(&SUM, &[&["sum"]])]),
        "The Poisson tensor: { \"x,y\" = \"formula\" } for each pair that is not zero, or a kind by its name",
    ),
    key(
        "constraints",
        Shape::List(&Shape::Formula),
        "Dirac's bracket of second-class constraints, which are Casimirs of it: [\"x^2 + y^2 - 1\", \"x*px + y*py\"]",
    ),
    key(
        "boundary",
        Shape::Words(&["periodic", "open"]),
        "Whether the ends of a lattice meet",
    ),
    key(
        "convention",
        Shape::Words(&["{H,x}", "{x,H}"]),
        "The equation of motion: x' = {H, x}, or x' = {x, H}",
    ),
    key(
        "hamiltonian",
        Shape::Formula,
        "H, a formula of the variables",
    ),
    key(
        "casimirs",
        FORMULAS,
        "Functions that commute with all others, by names",
    ),
    key(
        "forces",
        Shape::List(&Shape::Formula),
        "A one-form beside dH, a formula for each variable: dH + forces moves the system, on its leaves; a force F on a momentum is -F for its coordinate",
    ),
    key(
        "damping",
        table(&DAMPING, &[&["rate"]]),
        "A double bracket, under which energy falls and Casimirs stay: { rate = \"0.1\" }",
    ),
    key(
        "noise",
        Shape::List(&table(&NOISE, &[&["hamiltonian", "strength"]])),
        "Channels of noise, dx = {H, x} dt + strength {hamiltonian, x} dW (Stratonovich), on leaves: [{ hamiltonian = \"x1\", strength = \"0.1\" }]",
    ),
];

pub(super) static NOISE: [Key; 2] = [
    key(
        "hamiltonian",
        Shape::Formula,
        "Whose field moves at random, a formula of the variables",
    ),
    key(
        "strength",
        Shape::Formula,
        "A positive formula of the parameters",
    ),
];

pub(super) static DAMPING: [Key; 2] = [
    key(
        "rate",
        Shape::Formula,
        "The rate: a number that is not negative, or a formula of the state for feedback",
    ),
    key(
        "metric",
        Shape::List(&Shape::Either(&[
            Shape::Formula,
            Shape::List(&Shape::Formula),
        ])),
        "Which velocities are damped: a diagonal, or the rows of a symmetric matrix without negative eigenvalues; all alike where not said",
    ),
];

pub(super) static VECTORS: [Key; 2] = [
    key(
        "components",
        Shape::List(&Shape::Text),
        "Names of a vector's components: of the family s, x at the site i is s.x[i]",
    ),
    key("length", Shape::Whole(1), "How many vectors there are"),
];

/// A kind of bracket by its name.
const KIND: Shape = table(
    &BRACKET,
    &[
        &["lie-algebra"],
        &["log-canonical"],
        &["magnetic-field"],
        &["one-form"],
        &["two-form"],
    ],
);

const PAIRS: Shape = Shape::Pairs(&Shape::Formula);

pub(super) static SUM: [Key; 1] = [key(
    "sum",
    Shape::List(&table(&SUMMAND, &[&["variables", "bracket"]])),
    "The direct sum of brackets, each over variables of its own: [{ variables = [\"q\", \"p\"], bracket = { … } }, …]",
)];

pub(super) static SUMMAND: [Key; 3] = [
    key(
        "variables",
        Shape::List(&Shape::Text),
        "The summand's variables and families, by their names",
    ),
    key(
        "bracket",
        Shape::Either(&[KIND, PAIRS]),
        "The bracket of these variables, whose entries depend on no others",
    ),
    key(
        "constraints",
        Shape::List(&Shape::Formula),
        "Second-class constraints on these variables, for Dirac's bracket",
    ),
];

pub(super) static BRACKET: [Key; 5] = [
    key(
        "lie-algebra",
        Shape::Either(&[
            Shape::Text,
            table(&LIE_ALGEBRA, &[&["name"], &["structure"]]),
        ]),
        "The linear bracket of a Lie algebra, by name (`leafwise list lie-algebras`) or by its structure constants",
    ),
    key(
        "log-canonical",
        Shape::List(&NUMBERS),
        "{x_i, x_j} = a_ij x_i x_j: the rows of the antisymmetric matrix a",
    ),
    key(
        "magnetic-field",
        Shape::List(&Shape::Formula),
        "Positions and velocities with v' = v x B + ...: the formulas of B",
    ),
    key(
        "one-form",
        Shape::List(&Shape::Formula),
        "The tensor -(d theta)^-1: a formula of theta for each coordinate, as [\"p\", \"0\"] over q, p",
    ),
    key(
        "two-form",
        Shape::Pairs(&Shape::Formula),
        "The tensor -omega^-1 of a closed omega: { \"q,p\" = \"-1\" }, each pair that is not zero once",
    ),
];

pub(super) static LIE_ALGEBRA: [Key; 3] = [
    key("name", Shape::Text, "One of `leafwise list lie-algebras`"),
    key(
        "structure",
        Shape::List(&NUMBERS),
        "Structure constants [i, j, k, c] for [e_i, e_j] = ... + c e_k + ..., i < j: {x_i, x_j} = -c x_k",
    ),
    key(
        "representation",
        Shape::List(&Shape::List(&NUMBERS)),
        "The semidirect product with vectors: a matrix for each e_i, [e_i, v] = its product with v",
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

pub(super) static RUN: [Key; 9] = [
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

/// The paths of the keys, as `run.record.every`: what a test of every field has to cover. `*` stands for a name that
/// the scene chooses; where that is all a table holds, such as the values of parameters, or the parameters of a part,
/// it is not among them. Nor are the keys of entries of lists.
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
