//! Advice for steps that could not be taken.

use std::fmt;

/// Advice for a step that could not be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hint {
    /// A shorter step εh.
    ReduceStep,
    /// A shorter step of the flow.
    ReduceTimeStep,
    /// A shorter step εh, or more terms of the realization.
    ReduceStepOrRaiseOrder,
    /// A larger tolerance of the stepper's own steps, or a shorter step εh.
    RaiseToleranceOrReduceStep,
    /// Another initial state, or a shorter step εh.
    CheckInitialOrReduceStep,
    /// A run that ends before a singularity of the motion, or shorter steps that pass it by.
    EndBefore,
    /// A table that reaches farther, or a run that ends before its end.
    EndAtWall,
    /// Advice of the part that failed, in its own words.
    OfPart(&'static str),
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ReduceStep => "reduce epsilon*h",
            Self::ReduceTimeStep => "reduce the time step",
            Self::ReduceStepOrRaiseOrder => "reduce epsilon*h or raise the realization's order",
            Self::RaiseToleranceOrReduceStep => "raise its tolerance or reduce epsilon*h",
            Self::CheckInitialOrReduceStep => "check `initial` or reduce epsilon*h",
            Self::EndBefore => {
                "end the run before, or take a Poisson map of smaller steps if it only comes close"
            }
            Self::EndAtWall => {
                "tabulate a larger box, or end the run a little inside of it by a condition, `stop`"
            }
            Self::OfPart(advice) => advice,
        })
    }
}
