//! One operation of a program in single assignment.

use crate::expression::{Function, Side};
use crate::kernel::code::Instruction;
use crate::kernel::distances::Distance;

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Source {
    /// A slot that the program only reads: an input, a coefficient or a constant.
    Slot(u32),
    /// The result of the operation of this number.
    Result(u32),
    /// A row of the program's own numbers, which stand in the scratch memory before it runs.
    Own(u32),
}

impl Source {
    /// The number of the operation.
    pub(super) fn result(self) -> Option<usize> {
        match self {
            Self::Result(result) => Some(result as usize),
            Self::Slot(_) | Self::Own(_) => None,
        }
    }
}

/// Where a result is in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Location {
    /// In a slot.
    Slot(u32),
    /// In a place of the scratch memory.
    Place(u32),
    /// In a row of the program's own numbers.
    Own(u32),
    /// In the array that the program moves along.
    Array(Distance),
}

/// Action of an operation on its operands a, b, c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// a + b.
    Add,
    /// a − b.
    Subtract,
    /// a·b.
    Multiply,
    /// a/b.
    Divide,
    /// −a.
    Negate,
    /// √a.
    SquareRoot,
    /// a·b + c, rounded once.
    TimesPlus,
    /// c − a·b, rounded once.
    TimesFrom,
    /// The bits that a and b have.
    And,
    /// |a|.
    Magnitude,
    /// The larger of a and b, b where one is no number.
    Larger,
    /// The smaller of a and b, b where one is no number.
    Smaller,
    /// b where a is of this side of 0, else 0; 0 where a is no number.
    Keep(Side),
    /// The function that the instruction calls; its slots mean nothing here.
    Call(Instruction),
}

impl Action {
    pub(super) fn of(instruction: Instruction) -> Self {
        match instruction {
            Instruction::Add { .. } => Self::Add,
            Instruction::Subtract { .. } => Self::Subtract,
            Instruction::Multiply { .. } => Self::Multiply,
            Instruction::Divide { .. } => Self::Divide,
            Instruction::Negate { .. } => Self::Negate,
            Instruction::Magnitude { .. } => Self::Magnitude,
            Instruction::Larger { .. } => Self::Larger,
            Instruction::Smaller { .. } => Self::Smaller,
            Instruction::Keep { side, .. } => Self::Keep(side),
            Instruction::Apply {
                function: Function::Sqrt,
                ..
            } => Self::SquareRoot,
            Instruction::Apply { .. }
            | Instruction::ApplyAnalytic { .. }
            | Instruction::ApplyTwo { .. }
            | Instruction::Power { .. } => Self::Call(instruction),
        }
    }

    /// Whether a and b may change places.
    pub(super) fn commutes(self) -> bool {
        matches!(
            self,
            Self::Add | Self::Multiply | Self::TimesPlus | Self::TimesFrom
        )
    }

    /// Whether it is one product and one sum.
    pub(super) fn is_fused(self) -> bool {
        matches!(self, Self::TimesPlus | Self::TimesFrom)
    }
}

/// One operation with its operands.
#[derive(Clone, Debug)]
pub(super) struct Operation {
    pub(super) action: Action,
    /// a, b and c; an action of fewer repeats its last.
    pub(super) operands: [Source; 3],
    /// Where the caller reads the result.
    pub(super) output: Option<Location>,
    /// Whether the operation just before it, which is then its operand, is the other one of a pair of
    /// functions: its call gives this result too.
    pub(super) is_second: bool,
}

impl Operation {
    pub(super) fn new(action: Action, operands: [Source; 3]) -> Self {
        Self {
            action,
            operands,
            output: None,
            is_second: false,
        }
    }

    /// The operands, each once.
    pub(super) fn sources(&self) -> impl Iterator<Item = Source> {
        let operands = self.operands;
        (0..3)
            .filter(move |&k| !operands[..k].contains(&operands[k]))
            .map(move |k| operands[k])
    }
}
