//! Typed failures: where, what, and what to try.

use std::fmt;
use std::ops::Range;

use leafwise_expression::{AlgebraError, Outside};
use thiserror::Error;

use crate::Pieces;
use crate::hint::Hint;

/// Why a part or a method could not be built.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BuildError {
    /// Sizes that do not agree.
    #[error("{what}: expected {expected}, found {found}")]
    Dimension {
        /// Quantity that has the wrong size, in words.
        what: String,
        /// The size that fits.
        expected: usize,
        /// The size given.
        found: usize,
    },
    /// A formula that the exact algebra cannot evaluate.
    #[error("{0}")]
    Algebra(#[from] AlgebraError),
    /// A part's parameter with a value outside its range.
    #[error("{part}: {parameter} = {value} is not allowed; {expected}")]
    Parameter {
        /// The part's name.
        part: &'static str,
        /// The parameter's name.
        parameter: String,
        /// The value given.
        value: String,
        /// Values that are allowed, with the nearest valid ones where there are such.
        expected: String,
    },
    /// A formula of a part's parameter that is wrong.
    #[error("{part}: formula {} of {parameter}: {problem}", position + 1)]
    Formula {
        /// The part's name.
        part: &'static str,
        /// The parameter's name.
        parameter: String,
        /// Its position among the formulas of the parameter, from 0.
        position: usize,
        /// The bytes of it that are meant; all where there are none.
        span: Option<Range<usize>>,
        /// Mistake in the formula, in words, and what to try.
        problem: String,
    },
    /// A parameter that the part does not have.
    #[error("{part} has no parameter `{parameter}`; it takes: {known}")]
    UnknownParameter {
        /// The part's name.
        part: &'static str,
        /// The parameter's name.
        parameter: String,
        /// The parameters it has.
        known: String,
    },
    /// A name that no registered part has.
    #[error("no {kind} is called `{name}`{}", suggestion.as_ref().map(|s| format!("; did you mean `{s}`?")).unwrap_or_default())]
    UnknownPart {
        /// The kind of part.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The nearest registered name.
        suggestion: Option<String>,
    },
    /// A step whose functions are differentiated by more variables than their code is formed for.
    #[error(
        "a step of it takes the derivatives by all {variables} variables, whose code is formed for at most {most}; \
         take a stepper that solves nothing, or write chains of coordinates as `families` of a lattice, which is formed \
         site by site"
    )]
    TooManyVariables {
        /// Their number.
        variables: usize,
        /// The greatest number.
        most: usize,
    },
    /// Equations of a step that are solved together, more than elimination is made for.
    #[error(
        "a step solves {equations} equations together by elimination, which is made for at most {most}; take a \
         stepper that solves none, or fewer stages, or write chains of coordinates as `families` of a lattice, which is \
         solved site by site"
    )]
    TooManyEquations {
        /// Their number.
        equations: usize,
        /// The greatest number.
        most: usize,
    },
    /// Formulas of a lattice that look too far for the lattice that they would be written out on.
    #[error(
        "the code of a site of this lattice reaches {reach} sites away, which needs {coordinates} coordinates written \
         out, of {most} at most; couple nearer sites, shorten the lattice to {most} coordinates{}",
        if *is_of_order { ", or take a method of lower order" } else { "" }
    )]
    NotLocal {
        /// The distance in sites.
        reach: usize,
        /// The coordinates of the lattice that would be written out.
        coordinates: usize,
        /// The greatest number of them.
        most: usize,
        /// Whether a lower order looks less far.
        is_of_order: bool,
    },
    /// Code of a lattice's site that looks further than was foreseen when it was written.
    #[error(
        "code of this lattice reaches {reach} sites away, and {foreseen} were expected; this is a defect of the method: \
         take another one, and report it to its author"
    )]
    LooksFurther {
        /// The distance.
        reach: usize,
        /// Distance for which the lattice that it was written on has room.
        foreseen: usize,
    },
    /// A scene's formula that does not fit the lattice it is written out on.
    #[error("{message}")]
    Lattice {
        /// Description of the mistake.
        message: String,
    },
    /// A composition of a map without the symmetry it needs.
    #[error("{composition} needs a self-adjoint map, and {map} is not known to be one")]
    NotComposable {
        /// The composition.
        composition: &'static str,
        /// The map.
        map: String,
    },
    /// A composition of a map whose factors it needs.
    #[error(
        "{composition} needs a step that is a product of a map of order 1 and its adjoint, which {map} does not offer"
    )]
    NoFactors {
        /// The composition.
        composition: &'static str,
        /// The map.
        map: String,
        /// Whether that is self-adjoint, as other compositions ask.
        is_self_adjoint: bool,
    },
    /// A composition of a splitting into other pieces than it needs.
    #[error("the composition needs {asked}, and {map} does not offer them: {reason}")]
    Pieces {
        /// The map.
        map: String,
        /// Pieces that the composition needs.
        asked: Pieces,
        /// The bracket that is not 0, or what else is missing.
        reason: String,
    },
    /// A system that a part does not fit.
    #[error("{part} does not fit this system: {reason}")]
    DoesNotFit {
        /// The part's name.
        part: &'static str,
        /// Why.
        reason: String,
    },
    /// Matrices that do not represent a tensor's Lie algebra.
    #[error(
        "{part}: the matrices are not a representation: [rho({0}), rho({1})] has {2} in row {3} and column {4}, and {{{0}, {1}}} \
         requires {5}; mind that brackets are the paper's, {{x_i, x_j}} with x' = {{H, x}}",
        bracket[0], bracket[1], values[0], entry[0] + 1, entry[1] + 1, values[1]
    )]
    NoRepresentation {
        /// The part's name.
        part: &'static str,
        /// The variables whose bracket fails.
        bracket: Box<[String; 2]>,
        /// The entry of the commutator that is farthest off, row and column from 0.
        entry: [usize; 2],
        /// It, in units of the first bracket that is not 0, and the one that the tensor asks for.
        values: Box<[String; 2]>,
    },
    /// A part that refuses its parameters, in its own words.
    #[error("{part} cannot be made: {reason}")]
    NotMade {
        /// The part's name.
        part: &'static str,
        /// Why.
        reason: String,
    },
    /// A part that needs more of a system of numbers than it offers.
    #[error("{part} needs {missing}, and {system} offers only numbers")]
    NotOffered {
        /// The part's name.
        part: &'static str,
        /// The system's.
        system: String,
        /// Data of the system that the part would need, in words.
        missing: &'static str,
    },
    /// A part that integrates ẋ = {H, x} alone, and a system with forces beside dH.
    #[error("{part} integrates only x' = {{H, x}}, and this system has forces")]
    Forces {
        /// The part.
        part: String,
    },
    /// A part whose steps are Poisson maps or stay on symplectic leaves, and a system with a friction.
    #[error(
        "{part} steps by Poisson maps or along symplectic leaves, and no such map follows the `friction` of this system, which is added \
         to x' unchanged: it changes the tensor, and Casimirs where there are any"
    )]
    Friction {
        /// The part.
        part: String,
    },
    /// A dynamic approximation that needs α̂ and β̂, over coordinates in which the tensor is constant.
    #[error(
        "{dynamics} cannot be combined with {realization}: its points are coordinates in which the tensor is constant"
    )]
    LiftAlone {
        /// The dynamic approximation.
        dynamics: String,
        /// The coordinates.
        realization: String,
    },
    /// Two parts that cannot be combined.
    #[error("{dynamics} cannot be combined with {realization}: {reason}")]
    Incompatible {
        /// The dynamic approximation.
        dynamics: String,
        /// The realization.
        realization: String,
        /// Ability that is missing, in words.
        reason: String,
    },
}

impl StepError {
    /// An increment with a component that is not finite.
    pub const OF_INCREMENT: Self = Self::NonFinite {
        what: "the increment",
    };
    /// A state with one.
    pub const OF_STATE: Self = Self::NonFinite {
        what: "the new state",
    };

    /// Advice, where the failure itself tells any.
    pub fn hint(&self) -> Option<Hint> {
        match self {
            Self::NoConvergence { .. } => Some(Hint::ReduceStepOrRaiseOrder),
            Self::LeftChart { .. } | Self::OutsideDomain { .. } => Some(Hint::ReduceStep),
            Self::OtherBranch { .. } | Self::LostSign { .. } | Self::Pole { .. } => {
                Some(Hint::ReduceStep)
            }
            Self::Singularity { .. } => Some(Hint::EndBefore),
            Self::NonFinite { .. } => Some(Hint::CheckInitialOrReduceStep),
            Self::OutsideTable(_) => Some(Hint::EndAtWall),
            Self::OutsideImage { hint, .. } => Some(Hint::OfPart(hint)),
            Self::OtherLength { .. } => Some(Hint::OfPart(
                "take steps of that length, and nothing that is located within them",
            )),
            Self::NoTangent | Self::Part { .. } => None,
        }
    }

    /// The cause in words, without the [hint](Self::hint).
    pub fn cause(&self) -> impl fmt::Display {
        fmt::from_fn(move |f| self.write_cause(f))
    }

    fn write_cause(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoConvergence {
                evaluations,
                correction,
            } => write!(
                f,
                "no convergence after {evaluations} evaluations (last correction {correction:.1e} relative to the state)"
            ),
            Self::LeftChart { ratio } => write!(
                f,
                "the step left the realization's chart: the last term of its series over the first, or a radius over \
                 its limit, is {ratio:.1e}"
            ),
            Self::OtherBranch { reached } => write!(
                f,
                "the solution of the step's equation that begins at the state was lost after {:.0} % of the way; \
                 another solution is not a step of the flow",
                100.0 * reached
            ),
            Self::LostSign { coordinate } => write!(
                f,
                "coordinate {coordinate}, whose sign the tensor keeps, fell below 1e-12 of itself in one step: its \
                 digits are lost in the sum"
            ),
            Self::Pole {
                denominator,
                before,
                after,
            } => write!(
                f,
                "the step crosses a pole of the equations of motion, where {denominator} = 0: it goes from {before:.3e} \
                 to {after:.3e}, and the flow does not cross it"
            ),
            Self::Singularity { percent } => write!(
                f,
                "the motion runs into a singularity after {percent:.0} % of the step, where its Taylor series' radius \
                 of convergence falls to 0"
            ),
            Self::NoTangent => f.write_str(
                "the map offers no exact tangent, so its tensor defect cannot be measured",
            ),
            Self::Part { part, message } | Self::OutsideDomain { part, message, .. } => {
                write!(f, "{part} failed: {message}")
            }
            Self::OutsideImage { part, reason, .. } => write!(
                f,
                "the coordinates of {part} do not reach the state: {reason}"
            ),
            Self::OtherLength { part, length, step } => write!(
                f,
                "{part} holds for steps of {length:?} alone, and this one is {step:?}"
            ),
            Self::OutsideTable(outside) => write!(f, "{outside}"),
            Self::NonFinite { what } => write!(
                f,
                "{what} is not finite: the state left the formulas' domain (ln of a negative number, a division by \
                 zero, a power without derivatives at 0) or overflowed"
            ),
        }
    }

    /// Whether it says that a solve failed, not that a function has no value: another path to the
    /// solution may then lead there.
    pub fn is_of_a_solve(&self) -> bool {
        matches!(self, Self::NoConvergence { .. } | Self::NonFinite { .. })
    }
}

impl fmt::Display for StepError {
    /// The cause, and behind a semicolon the hint where there is one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_cause(f)?;
        match self.hint() {
            Some(hint) => write!(f, "; {hint}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for StepError {}

/// Why a step could not be taken. The state before the step is intact.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepError {
    /// The solver for β̂(L(y)) = x did not converge.
    NoConvergence {
        /// Evaluations spent on this step.
        evaluations: usize,
        /// The last Newton correction, relative to the state's components.
        correction: f64,
    },
    /// The solution lies outside the realization's chart: its series no longer decays, or its
    /// closed form ends.
    LeftChart {
        /// Size of the last term over that of the first; distance from the section over the radius.
        ratio: f64,
    },
    /// A solution that is not the one connected with the state before the step, or none that is:
    /// there the map is not near the flow.
    OtherBranch {
        /// The part of the way from the state to a solution that could be followed.
        reached: f64,
    },
    /// A coordinate whose sign the tensor keeps fell so far in one step that its digits are lost.
    LostSign {
        /// Which, from 1.
        coordinate: usize,
    },
    /// A denominator of the equations of motion changed its sign in one step: the flow does not cross
    /// its pole.
    Pole {
        /// The denominator, or one of its factors, by its name where the system has one for it.
        denominator: String,
        /// Its value before the pole.
        before: f64,
        /// Its value behind it.
        after: f64,
    },
    /// A motion whose Taylor series converges for shorter and shorter times: it ends.
    Singularity {
        /// The part of the step before it.
        percent: f64,
    },
    /// A diagnostic asked for the tangent of a map that offers none.
    NoTangent,
    /// A part outside the program could not evaluate one of its functions.
    Part {
        /// Its name.
        part: String,
        /// Message of the part.
        message: String,
    },
    /// The state lies outside the domain of a part outside the program.
    OutsideDomain {
        /// Its name.
        part: String,
        /// Distance from the section over the distance to which the domain reaches.
        ratio: f64,
        /// Message of the part.
        message: String,
    },
    /// A state that no point of a realization's coordinates lies over.
    OutsideImage {
        /// The realization.
        part: &'static str,
        /// Why.
        reason: &'static str,
        /// Hint on what to try.
        hint: &'static str,
    },
    /// A step of a map that holds for those of one length, |εh|, alone.
    OtherLength {
        /// The part.
        part: &'static str,
        /// That length.
        length: f64,
        /// εh.
        step: f64,
    },
    /// A table of the system's formulas that the step would leave, where they have no value without it.
    OutsideTable(Outside),
    /// A value that is not finite.
    NonFinite {
        /// Quantity that was being computed, in words.
        what: &'static str,
    },
}

#[cfg(test)]
mod tests {
    use super::{Hint, StepError};

    #[test]
    fn a_failed_step_tells_its_cause_and_its_hint_apart() {
        let ratio = 2.0;
        let (part, message) = ("acme/chart".to_owned(), "ends: x1; x2".to_owned());
        let outside = StepError::OutsideDomain {
            part: part.clone(),
            ratio,
            message: message.clone(),
        };
        let cases = [
            (
                StepError::NoConvergence {
                    evaluations: 20,
                    correction: 1e-3,
                },
                Some(Hint::ReduceStepOrRaiseOrder),
            ),
            (StepError::LeftChart { ratio }, Some(Hint::ReduceStep)),
            (
                StepError::OtherBranch { reached: 0.5 },
                Some(Hint::ReduceStep),
            ),
            (
                StepError::LostSign { coordinate: 1 },
                Some(Hint::ReduceStep),
            ),
            (
                StepError::Pole {
                    denominator: "q".to_owned(),
                    before: 1.0,
                    after: -1.0,
                },
                Some(Hint::ReduceStep),
            ),
            (
                StepError::Singularity { percent: 50.0 },
                Some(Hint::EndBefore),
            ),
            (StepError::NoTangent, None),
            (StepError::Part { part, message }, None),
            (outside, Some(Hint::ReduceStep)),
            (
                StepError::OutsideImage {
                    part: "clebsch",
                    reason: "no point lies over it",
                    hint: "take another realization",
                },
                Some(Hint::OfPart("take another realization")),
            ),
            (
                StepError::OF_INCREMENT,
                Some(Hint::CheckInitialOrReduceStep),
            ),
        ];
        for (error, hint) in cases {
            assert_eq!(error.hint(), hint, "{error}");
            let told = match hint {
                Some(hint) => format!("{}; {hint}", error.cause()),
                None => error.cause().to_string(),
            };
            assert_eq!(error.to_string(), told);
        }
    }
}
