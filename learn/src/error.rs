//! Pairs that nothing is learned from.

use leafwise_core::{BuildError, StepError};
use thiserror::Error;

/// Reason why nothing is learned.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum LearnError {
    /// Arrays of other shapes than pairs of states have.
    #[error(
        "{found} numbers do not form pairs of states of {dimension} coordinates: give as many states after a step as before it"
    )]
    Shape {
        /// d.
        dimension: usize,
        /// How many numbers there are.
        found: usize,
    },
    /// A number that is none.
    #[error("pair {pair} holds {value:?} {side} the step: leave this pair out")]
    NotFinite {
        /// Its number from 1.
        pair: usize,
        /// `before` or `after`.
        side: &'static str,
        /// NaN or infinity.
        value: f64,
    },
    /// Weights that are none.
    #[error(
        "the weight of each of {pairs} pairs must be a number of 0 or more, some above 0: {problem}"
    )]
    Weights {
        /// How many pairs there are.
        pairs: usize,
        /// The first thing wrong.
        problem: String,
    },
    /// Coordinates of which one varies by far more than another ever measures.
    #[error(
        "{large} varies by {spread:.1e} and {small} is at most {size:.1e}: in one sum of squares the small one would have no effect. Write the system in units in which both have similar sizes, {small}/{unit:e} in place of {small} in the pairs, the bracket and the realization"
    )]
    UnlikeUnits {
        /// The variable of the largest range.
        large: String,
        /// Its largest less its least value.
        spread: f64,
        /// The variable of the smallest values.
        small: String,
        /// The largest |x| of them.
        size: f64,
        /// A power of ten near the ratio of both.
        unit: f64,
    },
    /// States that do not move.
    #[error(
        "no pair moves: the states after the step equal those before it, and hold no information about H"
    )]
    NoMotion,
    /// Fewer equations than coefficients.
    #[error(
        "{} {equations} equations for {functions} coefficients: give {needed} pairs or more, or a lower degree",
        if *pairs == 1 { "1 pair gives".to_owned() } else { format!("{pairs} pairs give") }
    )]
    TooFew {
        /// How many pairs there are, each counted once.
        pairs: usize,
        /// Independent equations: the rank of Π for each pair.
        equations: usize,
        /// Functions of the basis.
        functions: usize,
        /// How many pairs would do.
        needed: usize,
    },
    /// More functions than are solved for.
    #[error("a basis of more than {most} functions: lower the degree")]
    TooManyFunctions {
        /// The most functions.
        most: usize,
    },
    /// More numbers than are kept.
    #[error(
        "{rows} equations for {functions} coefficients are more than {most} numbers: lower the degree, or give fewer pairs"
    )]
    TooLarge {
        /// Equations.
        rows: usize,
        /// Coefficients.
        functions: usize,
        /// The most numbers.
        most: usize,
    },
    /// A degree without functions, or too high a one.
    #[error("the degree {degree} is outside 1 to {most}")]
    Degree {
        /// The degree.
        degree: usize,
        /// The highest.
        most: usize,
    },
    /// Degrees or bounds of other variables.
    #[error("there are {found} degrees or bounds for {variables} variables: give one for each")]
    Degrees {
        /// How many there are.
        found: usize,
        /// How many variables there are.
        variables: usize,
    },
    /// Bounds of a box that are none.
    #[error(
        "{variable} from {least:?} to {largest:?} is not a range: give two numbers, the smaller one first"
    )]
    Bounds {
        /// The variable.
        variable: String,
        /// The first number.
        least: f64,
        /// The second one.
        largest: f64,
    },
    /// A table of no pair.
    #[error("a table needs pairs of states, and their number is 0: give 1 or more")]
    NoPairs,
    /// Too few states to keep one that measures the table.
    #[error(
        "a table needs {least} states or more, of which every fifth measures its error, and these are {states}"
    )]
    FewStates {
        /// How many there are.
        states: usize,
        /// How many would do.
        least: usize,
    },
    /// More pairs than are made.
    #[error("{pairs} pairs are more than {most}: give their number, or a lower degree")]
    TooManyPairs {
        /// How many pairs there would be.
        pairs: usize,
        /// The most.
        most: usize,
    },
    /// States from which a method has no steps.
    #[error(
        "from {failed} of {states} states of the region {steps} steps do not succeed: take a smaller region, or fewer steps"
    )]
    NoSteps {
        /// Of how many states a step fails.
        failed: usize,
        /// How many states there are.
        states: usize,
        /// Steps of each.
        steps: u64,
    },
    /// A region in which the generating function of many steps ends.
    #[error(
        "{steps} steps have no generating function in the whole region: det(1 + DΦ) is {determinant:.1e} of its value for no motion near x = {state:?}, as after half a turn about an equilibrium. Take fewer steps, or a smaller region"
    )]
    ChartEnds {
        /// Steps of the table.
        steps: u64,
        /// A state near the end.
        state: Vec<f64>,
        /// det(1 + DΦ)/2ᵈ there.
        determinant: f64,
    },
    /// A table that misses the steps.
    #[error(
        "a table of degree {degree} for {steps} steps leaves {:.0} % of the motion at states that no pair has, and has no step from {failed} of {states}: the realization ends within the region, or the degree is too low. Take fewer steps, a smaller region, or a higher degree", 100.0 * part
    )]
    NoTable {
        /// Steps of the table.
        steps: u64,
        /// Its degree.
        degree: usize,
        /// Root mean square of its error, relative to the motion.
        part: f64,
        /// From how many states it has no step.
        failed: usize,
        /// How many states there are.
        states: usize,
    },
    /// A period that is none.
    #[error("a Fourier basis needs a period above 0, and this one is {period:?}")]
    Period {
        /// The number that is given.
        period: f64,
    },
    /// A ridge that is none.
    #[error(
        "the ridge is a number of 0 or more, relative to columns of unit length, and this one is {ridge:?}"
    )]
    Ridge {
        /// The number that is given.
        ridge: f64,
    },
    /// ln x of a number that has none.
    #[error(
        "pair {pair} has {variable} = {value:?}, and ln {variable} is a function of the basis: leave out the pair, or the logarithms"
    )]
    Logarithm {
        /// Its number from 1.
        pair: usize,
        /// The variable.
        variable: String,
        /// Its value.
        value: f64,
    },
    /// A basis whose functions move nothing.
    #[error(
        "no function of the basis moves a state of the pairs: all of them are Casimirs there, or the tensor is 0"
    )]
    Singular,
    /// A pair that no step of the realization reaches.
    #[error(
        "pair {pair} is outside of the realization: {error}. The time between its states may be too long, or the pair is not a step of this system"
    )]
    Outside {
        /// Its number from 1.
        pair: usize,
        /// Failure of its ends there.
        error: StepError,
    },
    /// A realization without a chart.
    #[error(
        "{realization} has no points (x, p) on which a generating function is defined: name another realization"
    )]
    NoChart {
        /// Its description.
        realization: String,
    },
    /// A system or a method that is not built.
    #[error(transparent)]
    Build(#[from] BuildError),
}
