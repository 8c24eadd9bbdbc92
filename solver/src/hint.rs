//! Advice for steps that could not be taken.

use std::fmt;

/// Advice for a step that could not be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hint {
    /// A shorter step εh.
    ReduceStep,
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

impl Hint {
    /// The advice in words, with `step` for what sets the length of a step.
    pub fn with_step(&self, step: &str) -> String {
        match self {
            Self::ReduceStep => format!("reduce {step}"),
            Self::ReduceStepOrRaiseOrder => {
                format!("reduce {step} or raise the realization's order")
            }
            Self::RaiseToleranceOrReduceStep => format!("raise its tolerance or reduce {step}"),
            Self::CheckInitialOrReduceStep => format!("check the initial state or reduce {step}"),
            Self::EndBefore => {
                "end the run before, or take a Poisson map of smaller steps if it only comes close"
                    .to_owned()
            }
            Self::EndAtWall => {
                "tabulate a larger box, or end the run a little inside of it by a condition, `stop`"
                    .to_owned()
            }
            Self::OfPart(advice) => (*advice).to_owned(),
        }
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.with_step("the time step"))
    }
}
