//! Every key of `[system]`, and of the tables in it.

use super::shape::{FORMULAS, Key, NUMBERS, Shape, key, table};

/// Shape of the values that variables, sites of families and parameters of sites begin with.
pub(super) const FIELDS: Shape = Shape::Names(&Shape::Either(&[
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
        Shape::Either(&[Shape::List(&Shape::Formula), FORMULAS]),
        "A one-form beside dH, a formula for each variable, or { \"q[i]\" = \"0.1*p[i]\" } for some: dH + forces moves the system, on its leaves; a force F on a momentum is -F for its coordinate",
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
        Shape::Either(&[
            Shape::List(&Shape::Either(&[
                Shape::Formula,
                Shape::List(&Shape::Formula),
            ])),
            FORMULAS,
        ]),
        "Which velocities are damped: a diagonal, or { \"p[i]\" = \"1\" } for some of it, or the rows of a symmetric matrix without negative eigenvalues; all alike where not said",
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
