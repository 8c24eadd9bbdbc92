//! Every key of `[system]`, and of the tables in it.

use super::shape::{Beside, FORMULAS, Key, NUMBERS, Shape, key, table};

/// Shape of the values that variables, sites of families and parameters of sites begin with.
pub(super) const FIELDS: Shape = Shape::Names(&Shape::Either(&[
    Shape::Formula,
    NUMBERS,
    table(&COLUMN, &[&["file"]]),
]));

/// The same with rows of numbers for matrices.
const PARAMETERS: Shape = Shape::Names(&Shape::Either(&[
    Shape::Formula,
    NUMBERS,
    Shape::List(&NUMBERS),
    table(&COLUMN, &[&["file"]]),
]));

/// Lengths of axes, or names of the sites of one.
const LENGTHS: Shape = Shape::Either(&[
    Shape::Whole(1),
    Shape::List(&Shape::Whole(1)),
    Shape::List(&Shape::Text),
]);

/// The ends of an axis.
const ENDS: Shape = Shape::Words(&["periodic", "open"]);

pub(super) static COLUMN: [Key; 2] = [
    key(
        "file",
        Shape::Text,
        "A file beside the scene, CSV or JSON, with a row for each site, or an array of NumPy's (.npy)",
    ),
    key(
        "column",
        Shape::Text,
        "The name of its column, where it has several",
    )
    .otherwise("the only one"),
];

/// A system that has no formulas.
const NUMBERS_ALONE: &str = "a `library` system that computes numbers";

/// Keys of a system that is written out.
static LIBRARY_BESIDE: [Beside; 1] = [Beside::Keys {
    keys: &[
        "variables",
        "bracket",
        "constraints",
        "boundary",
        "convention",
        "hamiltonian",
    ],
    advice: "with `library` only `parameters`, `define`, `tables`, `families`, `casimirs`, `forces`, `torque`, `damping`, `friction` and \
              `noise` are allowed; remove it, or write the system out without `library`",
}];

/// Keys of a system that is written out, and those that are found.
static EQUATIONS_BESIDE: [Beside; 1] = [Beside::Keys {
    keys: &[
        "library",
        "families",
        "define",
        "tables",
        "constraints",
        "boundary",
        "convention",
        "hamiltonian",
        "casimirs",
    ],
    advice: "with `equations` only `variables`, `parameters`, `bracket = \"find\"`, `forces`, `torque`, `damping`, `friction` and `noise` are \
              allowed: the rest is found",
}];

static PARAMETERS_BESIDE: [Beside; 1] = [Beside::Note(
    "as values of sites: a bracket by a form or with constraints",
)];

static NOISE_BESIDE: [Beside; 2] = [
    Beside::Note("steps backward in time"),
    Beside::Note(NUMBERS_ALONE),
];

pub(super) static SYSTEM: [Key; 18] = [
    key(
        "library",
        Shape::System,
        "A system of the library, by its id",
    )
    .not_beside(&LIBRARY_BESIDE),
    key(
        "variables",
        Shape::Either(&[
            Shape::List(&Shape::Text),
            Shape::Names(&Shape::Either(&[Shape::Whole(1), Shape::List(&Shape::Text)])),
        ]),
        "The coordinates' names, or vectors with their numbers of components: { r = 3, p = 3 } for r.x, r.y, r.z, p.x, …",
    )
    .not_beside(&[Beside::Note("a long lattice")]),
    key(
        "families",
        Shape::Names(&Shape::Either(&[
            LENGTHS,
            table(&VECTORS, &[&["components", "length"]]),
        ])),
        "Indexed variables of a lattice and how many there are: { q = 1000, p = 1000 }, \
         { q = [64, 64] } along two axes, { q = [\"Sun\", \"Earth\"] } by names, or vectors",
    )
    .not_beside(&[Beside::Note(NUMBERS_ALONE)]),
    key(
        "parameters",
        PARAMETERS,
        "Named numbers that formulas may use, or formulas of them, \"m1/(m1 + m2)\"; \"J[i]\" = a formula of i, a list or { file = \
         \"j.csv\" } for one at every site, \"J[i,j]\" for one at every two sites of a chain",
    )
    .otherwise("none")
    .not_beside(&PARAMETERS_BESIDE),
    key(
        "define",
        FORMULAS,
        "Names for formulas that other formulas use: { B = \"sqrt(x^2 + y^2)\" }",
    )
    .default("{}")
    .not_beside(&[Beside::Note(NUMBERS_ALONE)]),
    key(
        "tables",
        Shape::Names(&table(&LOOKUP, &[&["axes"]])),
        "Tables of numbers that formulas call as functions: { psi = { file = \"psi.npy\", axes = { R = [0.8, 1.2], Z = [-0.2, 0.2] } } } \
         for psi(R, Z)",
    )
    .otherwise("none")
    .not_beside(&[Beside::Note(NUMBERS_ALONE)]),
    key(
        "equations",
        Shape::Either(&[FORMULAS, Shape::List(&Shape::Formula)]),
        "The equations of motion, a formula of x' for each variable x, with bracket = \"find\": bracket and Hamiltonian \
         are found",
    )
    .not_beside(&EQUATIONS_BESIDE),
    key(
        "bracket",
        Shape::Either(&[
            Shape::Words(&["canonical", "contact", "find"]),
            KIND,
            table(&SUM, &[&["sum"]]),
            PAIRS,
        ]),
        "The Poisson tensor: { \"x,y\" = \"formula\" } for each pair that is not zero, a kind by its name, \"canonical\": q with p, \
         x with px, q' = dH/dp, \"contact\": such pairs and one variable s, or \"find\" with `equations`",
    ),
    key(
        "constraints",
        Shape::List(&Shape::Formula),
        "Dirac's bracket of second-class constraints, which are Casimirs of it: [\"x^2 + y^2 - \
         1\", \"x*px + y*py\"]",
    )
    .default("[]")
    .not_beside(&[Beside::Note("a long lattice")]),
    key(
        "boundary",
        Shape::Either(&[ENDS, Shape::List(&ENDS)]),
        "The ends of a lattice: they meet, or not; one for all axes, or one for each",
    )
    .default("\"periodic\""),
    key(
        "convention",
        Shape::Words(&["{H,x}", "{x,H}"]),
        "The equation of motion: x' = {H, x}, or x' = {x, H}",
    )
    .default("\"{H,x}\""),
    key(
        "hamiltonian",
        Shape::Formula,
        "H, a formula of the variables",
    ),
    key(
        "casimirs",
        Shape::Either(&[Shape::Words(&["find"]), FORMULAS]),
        "Functions that commute with all others, by names, or \"find\": the program looks for them",
    )
    .otherwise("none")
    .not_beside(&[Beside::Note(NUMBERS_ALONE)]),
    key(
        "forces",
        Shape::Either(&[Shape::List(&Shape::Formula), FORMULAS]),
        "A one-form added to dH, a formula for each variable, or { \"q[i]\" = \"0.1*p[i]\" } for \
         some: dH + forces moves the system, on its leaves; a force F on a momentum is -F for \
         its coordinate",
    )
    .otherwise("none")
    .not_beside(&[Beside::Note(NUMBERS_ALONE)]),
    key(
        "torque",
        Shape::Either(&[VECTOR, table(&TORQUE, &[])]),
        "A torque on a body with attitude, m1, m2, m3 and q0, q1, q2, q3: three formulas in the body, or { space = [\"0\", \"0\", \
         \"0.1\"] }",
    )
    .otherwise("none")
    .not_beside(&[Beside::Note(NUMBERS_ALONE), Beside::Note("a long lattice")]),
    key(
        "damping",
        table(&DAMPING, &[&["rate"]]),
        "A double bracket, under which energy falls and Casimirs stay: { rate = \"0.1\" }",
    )
    .otherwise("none")
    .not_beside(&[Beside::Note(NUMBERS_ALONE)]),
    key(
        "friction",
        Shape::Either(&[Shape::List(&Shape::Formula), FORMULAS]),
        "A velocity that is added to x', a formula for each variable, or { m3 = \"-0.1*m3\" } for some: x' = {H, x} + friction; \
         the tensor and Casimirs change by it, and steppers that are not Poisson maps take it",
    )
    .otherwise("none")
    .not_beside(&[
        Beside::Note(NUMBERS_ALONE),
        Beside::Note("Poisson maps, a contact bracket, a long lattice"),
    ]),
    key(
        "noise",
        Shape::List(&table(&NOISE, &[&["hamiltonian", "strength"]])),
        "Channels of noise, dx = {H, x} dt + strength {hamiltonian, x} dW (Stratonovich), on \
         leaves: [{ hamiltonian = \"x1\", strength = \"0.1\" }]",
    )
    .otherwise("none")
    .not_beside(&NOISE_BESIDE),
];

pub(super) static LOOKUP: [Key; 6] = [
    key(
        "file",
        Shape::Text,
        "A file beside the scene: an array of NumPy's (.npy) of the axes' nodes; in CSV or JSON a column for one axis, for two a grid \
         of numbers, a row for each node of the first, for any a list of places and values",
    )
    .otherwise("an array given in Python")
    .not_beside(&[Beside::InPlaceOf {
        keys: &["values"],
        advice: "each gives all numbers; keep one of them",
    }]),
    key(
        "values",
        Shape::List(&Shape::Either(&[
            Shape::Number,
            Shape::List(&Shape::Either(&[Shape::Number, NUMBERS])),
        ])),
        "The numbers themselves: a list for one axis, a list of rows for two, a list of such lists for three",
    )
    .otherwise("those of the file"),
    key(
        "column",
        Shape::Text,
        "The name of its column, in a file of several columns",
    )
    .otherwise("the only one"),
    key(
        "axes",
        Shape::Names(&Shape::Entries(&[CONSTANT, CONSTANT])),
        "The first and the last node of each axis, one to three in the order of the arguments; nodes stand at equal \
         distances",
    ),
    key(
        "periodic",
        Shape::List(&Shape::Text),
        "Periodic axes: the file leaves out the last node, which equals the first",
    )
    .default("[]"),
    key(
        "degree",
        Shape::Whole(1),
        "The degree of the polynomials between nodes, 1 to 9; derivatives are continuous up to the one below it",
    )
    .default("5"),
];

/// A number, or a formula of numbers.
const CONSTANT: Shape = Shape::Formula;

pub(super) static NOISE: [Key; 2] = [
    key(
        "hamiltonian",
        Shape::Formula,
        "The Hamiltonian whose field moves at random, a formula of the variables",
    ),
    key(
        "strength",
        Shape::Formula,
        "A positive formula of the parameters",
    ),
];

/// The components of a vector.
const VECTOR: Shape = Shape::List(&Shape::Formula);

pub(super) static TORQUE: [Key; 2] = [
    key("body", VECTOR, "Its components in the body").otherwise("none"),
    key("space", VECTOR, "Its components in space, which are added").otherwise("none"),
];

pub(super) static DAMPING: [Key; 2] = [
    key(
        "rate",
        Shape::Formula,
        "The rate: a number that is not negative, or a formula of the state for feedback",
    ),
    key(
        "metric",
        Shape::Either(&[
            Shape::List(&Shape::Either(&[
                Shape::Formula,
                Shape::List(&Shape::Formula),
            ])),
            FORMULAS,
        ]),
        "The velocities that are damped: a diagonal, or { \"q[i]\" = \"1\" } for friction on q' alone, or \
         the rows of a symmetric matrix without negative eigenvalues",
    )
    .otherwise("all alike"),
];

pub(super) static VECTORS: [Key; 2] = [
    key(
        "components",
        Shape::List(&Shape::Text),
        "Names of a vector's components: of the family s, x at the site i is s.x[i]",
    ),
    key(
        "length",
        LENGTHS,
        "The number of vectors, one along each of two or three axes, [64, 64], or their names, [\"Sun\", \"Earth\"]",
    ),
];

/// Pairs by their names.
const CANONICAL: Shape = Shape::Words(&["canonical"]);

/// A kind of bracket by its name.
const KIND: Shape = table(
    &BRACKET,
    &[
        &["canonical"],
        &["contact"],
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
    "The direct sum of brackets, each over variables of its own: [{ variables = [\"q\", \
     \"p\"], bracket = { … } }, …]",
)
.not_beside(&[Beside::Note("any other entry of the bracket")])];

pub(super) static SUMMAND: [Key; 3] = [
    key(
        "variables",
        Shape::List(&Shape::Text),
        "The summand's variables and families, by their names",
    ),
    key(
        "bracket",
        Shape::Either(&[CANONICAL, KIND, PAIRS]),
        "The bracket of these variables, whose entries depend on no others",
    ),
    key(
        "constraints",
        Shape::List(&Shape::Formula),
        "Second-class constraints on these variables, for Dirac's bracket",
    )
    .default("[]"),
];

pub(super) static BRACKET: [Key; 7] = [
    key(
        "canonical",
        Shape::List(&Shape::List(&Shape::Text)),
        "Pairs of a coordinate and its momentum, q' = dH/dp and p' = -dH/dq under either convention: [[\"q\", \"p\"]]",
    )
    .not_beside(&[Beside::Note("any other entry of the bracket")]),
    key(
        "contact",
        Shape::List(&Shape::List(&Shape::Text)),
        "Pairs of a coordinate and its momentum, and one variable s more: q' = dH/dp, p' = -dH/dq - p dH/ds, s' = p dH/dp - H",
    )
    .not_beside(&[Beside::Note(
        "any other entry of the bracket, a sum, forces, noise, a pace, casimirs, constraints, a long lattice",
    )]),
    key(
        "lie-algebra",
        Shape::Either(&[
            Shape::Text,
            table(&LIE_ALGEBRA, &[&["name"], &["structure"]]),
        ]),
        "The linear bracket of a Lie algebra, by name (`leafwise list lie-algebras`) or by its \
         structure constants",
    )
    .not_beside(&[Beside::Note("any other entry of the bracket")]),
    key(
        "log-canonical",
        Shape::List(&NUMBERS),
        "{x_i, x_j} = a_ij x_i x_j: the rows of the antisymmetric matrix a",
    )
    .not_beside(&[Beside::Note("any other entry of the bracket")]),
    key(
        "magnetic-field",
        Shape::List(&Shape::Formula),
        "Positions and velocities with v' = v x B + ...: the formulas of B",
    )
    .not_beside(&[Beside::Note("any other entry of the bracket")]),
    key(
        "one-form",
        Shape::List(&Shape::Formula),
        "The tensor -(d theta)^-1: a formula of theta for each coordinate, as [\"p\", \"0\"] \
         over q, p",
    )
    .not_beside(&[Beside::Note(
        "any other entry of the bracket, a long lattice",
    )]),
    key(
        "two-form",
        Shape::Pairs(&Shape::Formula),
        "The tensor -omega^-1 of a closed omega: { \"q,p\" = \"-1\" }, each pair that is not \
         zero once",
    )
    .not_beside(&[Beside::Note(
        "any other entry of the bracket, a long lattice",
    )]),
];

pub(super) static LIE_ALGEBRA: [Key; 3] = [
    key("name", Shape::Text, "One of `leafwise list lie-algebras`").not_beside(&[
        Beside::InPlaceOf {
            keys: &["structure"],
            advice: "each gives the whole algebra; keep one of them",
        },
    ]),
    key(
        "structure",
        Shape::List(&Shape::Entries(&[
            Shape::Whole(1),
            Shape::Whole(1),
            Shape::Whole(1),
            CONSTANT,
        ])),
        "Structure constants [i, j, k, c] for [e_i, e_j] = ... + c e_k + ..., i < j: {x_i, \
         x_j} = -c x_k",
    ),
    key(
        "representation",
        Shape::List(&Shape::List(&NUMBERS)),
        "The semidirect product with vectors: a matrix for each e_i, [e_i, v] = its product \
         with v",
    )
    .otherwise("none"),
];
