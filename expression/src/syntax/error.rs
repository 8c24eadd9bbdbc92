//! Errors of a formula: kind, place and a valid spelling nearby.

use std::fmt;
use std::ops::Range;

use super::tree::Span;
use super::vocabulary::function_names;
use crate::arithmetic::AlgebraError;
use crate::rational::DecimalError;
use crate::words::counted;

/// An error in a formula: where, what, and the nearest valid spelling when there is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SyntaxError {
    /// The byte range of the formula's text that the error is about; empty at the text's end when
    /// something is missing there.
    pub span: Range<usize>,
    /// Kind of the error.
    pub kind: SyntaxErrorKind,
    /// Text that could stand in place of that at `span`.
    pub suggestion: Option<String>,
}

impl SyntaxError {
    pub(super) fn new(span: Span, kind: SyntaxErrorKind) -> Self {
        Self {
            span: span.start..span.end,
            kind,
            suggestion: None,
        }
    }

    pub(super) fn suggesting(mut self, suggestion: Option<impl Into<String>>) -> Self {
        self.suggestion = suggestion.map(Into::into);
        self
    }
}

impl fmt::Display for SyntaxError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.kind)?;
        match (&self.suggestion, &self.kind) {
            (Some(suggestion), _) => write!(formatter, "; did you mean `{suggestion}`?"),
            (None, SyntaxErrorKind::UnknownFunction { .. }) => {
                let names: Vec<&str> = function_names().collect();
                write!(formatter, "; there are {}", names.join(", "))
            }
            (None, _) => Ok(()),
        }
    }
}

impl std::error::Error for SyntaxError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.kind {
            SyntaxErrorKind::Number(error) => Some(error),
            _ => None,
        }
    }
}

/// The causes of a [`SyntaxError`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxErrorKind {
    /// A character that no formula contains.
    #[error("unexpected character `{character}`")]
    UnexpectedCharacter {
        /// The character.
        character: char,
    },
    /// The text ends too early.
    #[error("the formula ends where {expected} is expected")]
    UnexpectedEnd {
        /// Name of the part that should follow.
        expected: &'static str,
    },
    /// Something else stands where one thing is expected.
    #[error("expected {expected}, found `{found}`")]
    Expected {
        /// Name of the part that should stand there.
        expected: &'static str,
        /// Text that stands there.
        found: String,
    },
    /// A decimal outside what [`Rational::parse_decimal`](crate::rational::Rational::parse_decimal)
    /// reads.
    #[error("{0}")]
    Number(DecimalError),
    /// A decimal beyond the doubles.
    #[error("`{literal}` is beyond the largest double, 1.8e308")]
    NotFinite {
        /// The literal as written, cut after 40 characters.
        literal: String,
    },
    /// More numbers, names and signs than a formula may have.
    #[error(
        "the formula has more than {limit} numbers, names and signs; shorten it with `sum` or `define`"
    )]
    TooLong {
        /// The greatest number.
        limit: usize,
    },
    /// Parentheses, signs, powers, calls and divisions nested too deeply.
    #[error("the formula is nested more than {limit} levels deep; split it")]
    TooDeep {
        /// The greatest depth.
        limit: usize,
    },
    /// No variable, parameter or index of this name.
    #[error("unknown name `{name}`")]
    UnknownName {
        /// The name.
        name: String,
    },
    /// No function of this name.
    #[error("unknown function `{name}` (a product is written with `*`)")]
    UnknownFunction {
        /// The name.
        name: String,
    },
    /// An index name that neither a `sum` nor the surrounding key introduces.
    #[error("unknown index `{name}`; introduce it by the key or by `sum({name}, ...)`")]
    UnknownIndex {
        /// The name.
        name: String,
    },
    /// A name in brackets that no site of the chain has, where sites have names.
    #[error("no site is called `{name}`")]
    UnknownSite {
        /// The name.
        name: String,
        /// The names of all sites.
        names: Vec<String>,
    },
    /// A sum over an index that is called as a site.
    #[error("`{name}` is the name of a site; give the sum another index, as i")]
    SiteAsIndex {
        /// The name.
        name: String,
    },
    /// An index behind the name of a scalar variable or of a parameter.
    #[error("`{name}` is not a family and takes no index")]
    NotAFamily {
        /// The name.
        name: String,
    },
    /// A family without an index.
    #[error("`{name}` is a family; write one member as `{name}[i]`")]
    IndexMissing {
        /// The family.
        name: String,
    },
    /// A fixed site that the family does not have.
    #[error("`{name}` has the members {name}[0] to {name}[{last}], not {name}[{position}]",
        last = length.saturating_sub(1))]
    IndexOutOfRange {
        /// The family.
        name: String,
        /// The site asked for.
        position: i64,
        /// The number of its members.
        length: usize,
    },
    /// A fixed site beyond the end of an axis.
    #[error("`{name}` has the sites 0 to {last} along axis {axis}, not {position}",
        last = length.saturating_sub(1))]
    SiteOutOfRange {
        /// The family.
        name: String,
        /// The axis, from 0 on.
        axis: usize,
        /// The site that is written.
        position: i64,
        /// The number of sites along the axis.
        length: usize,
    },
    /// An offset from an index beyond half of a ring, where the other way round is shorter.
    #[error("the offset {offset} along axis {axis} is beyond half of a ring of {length} sites")]
    OffsetBeyondHalf {
        /// The axis, from 0 on.
        axis: usize,
        /// The offset.
        offset: i64,
        /// The number of sites along the axis.
        length: usize,
    },
    /// A member of a family with too few or too many sites.
    #[error("`{name}` has {axes} {}, and {written} {} written here: write {}",
        axes_word(*axes), if *written == 1 { "is" } else { "are" }, example(name, *axes))]
    AxesDiffer {
        /// The family.
        name: String,
        /// How many axes it has.
        axes: usize,
        /// How many sites are written.
        written: usize,
    },
    /// A key in which one index counts along two axes.
    #[error("the index `{name}` counts along two axes of one key: give each axis a separate index")]
    RepeatedIndex {
        /// The index.
        name: String,
    },
    /// An index of a sum that counts along no axis.
    #[error("the index `{name}` counts along no axis: use it in brackets, or leave it out")]
    AxisUnknown {
        /// The index.
        name: String,
    },
    /// An index that counts along axes of different lengths.
    #[error(
        "the index `{name}` counts along an axis of {} sites and along one of {}: give each axis a separate index",
        lengths[0], lengths[1]
    )]
    AxesOfLengths {
        /// The index.
        name: String,
        /// Two of the lengths.
        lengths: [usize; 2],
    },
    /// Two ordered indices of a sum that count along different axes.
    #[error(
        "the indices `{lower}` < `{name}` count along different axes: both must count along the same axis, as in x[{lower}]*x[{name}]"
    )]
    AxesApart {
        /// The lower index.
        lower: String,
        /// The other one.
        name: String,
    },
    /// A sum over the sites of a lattice with too few or too many indices.
    #[error("the lattice has {axes} axes, and the sum {indices} {}: write one an axis, {}",
        if *indices == 1 { "index" } else { "indices" }, sum_example(*axes))]
    SumOverAxes {
        /// How many axes the lattice has.
        axes: usize,
        /// How many indices the sum has.
        indices: usize,
    },
    /// `N` as a number on a lattice of several axes.
    #[error(
        "`N` as a number is the length of a chain, and this lattice has several axes: write the length of the axis as a number"
    )]
    LengthOfAxes,
    /// An index used as a number in a tensor or a Hamiltonian.
    #[error(
        "the index `{name}` is used as a number; tensors and Hamiltonians must be homogeneous \
         along the family, so an index is allowed only in brackets"
    )]
    IndexAsNumber {
        /// The index.
        name: String,
    },
    /// A vector where a number is meant.
    #[error("`{text}` is a vector, and a number is expected here")]
    VectorAsNumber {
        /// The vector as written.
        text: String,
        /// The names of its components, where it has names.
        components: Vec<String>,
    },
    /// A number where a vector is meant.
    #[error("`{text}` is no vector")]
    NoVector {
        /// The part that stands there.
        text: String,
        /// The names of vectors.
        vectors: Vec<String>,
    },
    /// Vectors of which one has more components.
    #[error("a vector of {first} components meets a vector of {second}")]
    UnlikeVectors {
        /// Components of one.
        first: usize,
        /// Components of the other.
        second: usize,
    },
    /// A product of two vectors by `*`.
    #[error("a product of two vectors is `dot(a, b)`, a number, or `cross(a, b)`, a vector")]
    TwoVectors,
    /// A cross product outside of three dimensions.
    #[error("`cross` needs vectors with three components, and these have {found}")]
    NoCrossProduct {
        /// Components of the vectors.
        found: usize,
    },
    /// A function of vectors with another number of arguments.
    #[error("`{name}` takes {count} {}", if *count == 1 { "vector" } else { "vectors" })]
    VectorArguments {
        /// The function.
        name: String,
        /// How many it takes.
        count: usize,
    },
    /// A `sum` over an index name that is already in use around it.
    #[error("the index `{name}` is already in use here; give this sum another one")]
    DuplicateIndex {
        /// The index.
        name: String,
    },
    /// `N` or `sum` where no family is declared.
    #[error("`{name}` needs the length of a family, and no family is declared")]
    LengthUnknown {
        /// `N` or `sum`.
        name: &'static str,
    },
    /// A constant exponent beyond [`POWER_LIMIT`](super::POWER_LIMIT).
    #[error("the exponent `{exponent}` is outside the range -{limit} to {limit}")]
    ExponentTooLarge {
        /// The exponent as written, cut after 40 characters.
        exponent: String,
        /// The greatest magnitude.
        limit: i64,
    },
    /// Sums that expand to more than [`TERM_LIMIT`](super::TERM_LIMIT) terms.
    #[error("the sums of this formula have more than {limit} terms")]
    TooManyTerms {
        /// The greatest number of terms.
        limit: usize,
    },
    /// Vectors that are written out in more than [`PART_LIMIT`](super::PART_LIMIT) parts.
    #[error(
        "the components of this vector have more than {limit} parts: name its norms and products by `define`"
    )]
    TooManyParts {
        /// The greatest number of parts.
        limit: usize,
    },
    /// A lattice's function that is not one term a site.
    #[error("this is not a combination of sums over sites, such as `sum(i, x[i]^2)/2`")]
    NotASumOverSites,
    /// A lattice's function that is not made of the terms of one site and of one pair of sites.
    #[error(
        "this is not a function of sums over sites and pairs, such as `sum(i, p[i]^2) + sum(i<j, (q[i] - q[j])^2)`"
    )]
    NotSumsOfPairs,
    /// A sum within a template, which couples every site with all others.
    #[error(
        "a sum within a sum, or within an entry of a bracket, couples every site with all others"
    )]
    SumInATemplate,
    /// A member of a family by its number within a template.
    #[error("`{name}` is a single site, and this formula repeats from site to site")]
    SiteInATemplate {
        /// The member as it is written.
        name: String,
    },
    /// A member of a family beyond an open end, where its value is needed.
    #[error("`{name}` lies beyond the open end of the lattice, and has no value")]
    OutsideBoundary {
        /// The member as it is written.
        name: String,
    },
    /// A state variable where only parameters, the index and numbers may stand.
    #[error("`{name}` depends on the state; only parameters, indices and numbers are allowed here")]
    NotAFunctionOfParameters {
        /// The variable, family or definition.
        name: String,
    },
    /// A parameter or a definition where a state variable is needed.
    #[error("`{name}` is not a state variable, and one is expected here")]
    NotAVariable {
        /// The parameter or definition.
        name: String,
    },
    /// A parameter for which no value was given.
    #[error("no value is given for the parameter `{name}`")]
    ParameterWithoutValue {
        /// The parameter.
        name: String,
    },
    /// A name that formulas use for something else.
    #[error("the name `{name}` is reserved in formulas; choose another")]
    ReservedName {
        /// The name.
        name: String,
    },
    /// A call of something that the scene has given a function's name.
    #[error(
        "`{name}` is a name of the scene here, not a function (a product is written with `*`); to use the \
         function, rename it in the scene"
    )]
    NameAndFunction {
        /// The name.
        name: String,
    },
    /// A table without a point.
    #[error("`{name}` is a table: write its arguments after it, in parentheses")]
    TableWithoutPoint {
        /// The table.
        name: String,
    },
    /// A table with too few or too many arguments.
    #[error("`{name}` is a table of {}, and {found} {} here: write `{name}({})`",
        counted(axes.len(), "variable"), if *found == 1 { "argument stands" } else { "arguments stand" }, axes.join(", "))]
    Arguments {
        /// The table.
        name: String,
        /// Its variables.
        axes: Vec<String>,
        /// How many arguments there are.
        found: usize,
    },
    /// An order of a table's derivative that is no whole number.
    #[error(
        "after its arguments `{name}` takes the orders of a derivative, whole numbers from 0 to 255"
    )]
    Orders {
        /// The table.
        name: String,
    },
    /// A derivative by what is no variable and no parameter.
    #[error("`{name}` is a formula; `D` differentiates by a variable or a parameter")]
    DerivativeByFormula {
        /// The definition.
        name: String,
    },
    /// A derivative that does not exist as a formula.
    #[error("there is no formula for this derivative: {reason}")]
    NoDerivative {
        /// Why.
        reason: AlgebraError,
    },
    /// A text that is not a name.
    #[error("`{name}` is not a name: use letters, digits and `_`, beginning with no digit")]
    InvalidName {
        /// The text.
        name: String,
    },
}

fn axes_word(axes: usize) -> &'static str {
    match axes {
        1 => "axis",
        _ => "axes",
    }
}

/// A sum over sites as it is written: `sum(i, j, …)`.
fn sum_example(axes: usize) -> String {
    let indices = ["i", "j", "k"];
    let indices = &indices[..axes.min(indices.len())];
    format!("`sum({}, …)`", indices.join(", "))
}

/// A member of a family as it is written: `x[i,j]`.
fn example(name: &str, axes: usize) -> String {
    let indices = ["i", "j", "k"];
    let sites = &indices[..axes.min(indices.len())];
    format!("`{name}[{}]`", sites.join(","))
}
