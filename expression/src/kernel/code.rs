//! Straight-line code: three-address instructions over numbered slots.

use std::fmt;

use crate::analytic::{AnalyticFunction, FunctionPair, Member};
use crate::expression::{Binary, Function, Side};
use crate::words::counted;

/// One operation on slots; each slot holds one number a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instruction {
    /// out ← a + b.
    Add {
        /// Result slot.
        out: u32,
        /// Left operand.
        a: u32,
        /// Right operand.
        b: u32,
    },
    /// out ← a − b.
    Subtract {
        /// Result slot.
        out: u32,
        /// Left operand.
        a: u32,
        /// Right operand.
        b: u32,
    },
    /// out ← a·b.
    Multiply {
        /// Result slot.
        out: u32,
        /// Left operand.
        a: u32,
        /// Right operand.
        b: u32,
    },
    /// out ← a/b.
    Divide {
        /// Result slot.
        out: u32,
        /// Numerator.
        a: u32,
        /// Denominator.
        b: u32,
    },
    /// out ← −a.
    Negate {
        /// Result slot.
        out: u32,
        /// Operand.
        a: u32,
    },
    /// out ← |a|.
    Magnitude {
        /// Result slot.
        out: u32,
        /// Operand.
        a: u32,
    },
    /// out ← the larger of a and b, b where one is no number.
    Larger {
        /// Result slot.
        out: u32,
        /// Left operand.
        a: u32,
        /// Right operand.
        b: u32,
    },
    /// out ← the smaller of a and b, b where one is no number.
    Smaller {
        /// Result slot.
        out: u32,
        /// Left operand.
        a: u32,
        /// Right operand.
        b: u32,
    },
    /// out ← b where a is of this side of 0, else 0; 0 where a is no number.
    Keep {
        /// The side.
        side: Side,
        /// Result slot.
        out: u32,
        /// The number that has a side.
        a: u32,
        /// The number that is kept.
        b: u32,
    },
    /// out ← f(a), by `libm`.
    Apply {
        /// The function.
        function: Function,
        /// Result slot.
        out: u32,
        /// Argument.
        a: u32,
    },
    /// out ← f⁽ᵏ⁾(a), by the function's own code.
    ApplyAnalytic {
        /// The function.
        function: AnalyticFunction,
        /// k.
        order: u32,
        /// Result slot.
        out: u32,
        /// Argument.
        a: u32,
    },
    /// out ← f(a, b).
    ApplyTwo {
        /// The function.
        function: Binary,
        /// Result slot.
        out: u32,
        /// First argument.
        a: u32,
        /// Second argument.
        b: u32,
    },
    /// out ← a^b, by `libm::pow`.
    Power {
        /// Result slot.
        out: u32,
        /// Base.
        a: u32,
        /// Exponent.
        b: u32,
    },
}

impl Instruction {
    /// The result slot.
    pub fn output(&self) -> u32 {
        match *self {
            Self::Add { out, .. }
            | Self::Subtract { out, .. }
            | Self::Multiply { out, .. }
            | Self::Divide { out, .. }
            | Self::Negate { out, .. }
            | Self::Magnitude { out, .. }
            | Self::Larger { out, .. }
            | Self::Smaller { out, .. }
            | Self::Keep { out, .. }
            | Self::Apply { out, .. }
            | Self::ApplyAnalytic { out, .. }
            | Self::ApplyTwo { out, .. }
            | Self::Power { out, .. } => out,
        }
    }

    /// The operand slots; unary operations repeat theirs.
    pub fn operands(&self) -> [u32; 2] {
        match *self {
            Self::Add { a, b, .. }
            | Self::Subtract { a, b, .. }
            | Self::Multiply { a, b, .. }
            | Self::Divide { a, b, .. }
            | Self::Larger { a, b, .. }
            | Self::Smaller { a, b, .. }
            | Self::Keep { a, b, .. }
            | Self::ApplyTwo { a, b, .. }
            | Self::Power { a, b, .. } => [a, b],
            Self::Negate { a, .. }
            | Self::Magnitude { a, .. }
            | Self::Apply { a, .. }
            | Self::ApplyAnalytic { a, .. } => [a, a],
        }
    }

    /// The pair of functions that the operation is a member of.
    pub(super) fn pair(&self) -> Option<(&'static FunctionPair, Member)> {
        match *self {
            Self::Apply { function, .. } => function.pair(),
            Self::ApplyAnalytic {
                function, order: 0, ..
            } => function.pair(),
            _ => None,
        }
    }

    /// The same operation with every slot renamed.
    pub(super) fn renamed(self, mut name: impl FnMut(u32) -> u32) -> Self {
        let out = name(self.output());
        self.over(out, self.operands().map(name))
    }

    /// The same operation over other slots; unary operations take the first.
    pub(super) fn over(self, out: u32, [a, b]: [u32; 2]) -> Self {
        match self {
            Self::Add { .. } => Self::Add { out, a, b },
            Self::Subtract { .. } => Self::Subtract { out, a, b },
            Self::Multiply { .. } => Self::Multiply { out, a, b },
            Self::Divide { .. } => Self::Divide { out, a, b },
            Self::Power { .. } => Self::Power { out, a, b },
            Self::Larger { .. } => Self::Larger { out, a, b },
            Self::Smaller { .. } => Self::Smaller { out, a, b },
            Self::Keep { side, .. } => Self::Keep { side, out, a, b },
            Self::ApplyTwo { function, .. } => Self::ApplyTwo {
                function,
                out,
                a,
                b,
            },
            Self::Negate { .. } => Self::Negate { out, a },
            Self::Magnitude { .. } => Self::Magnitude { out, a },
            Self::Apply { function, .. } => Self::Apply { function, out, a },
            Self::ApplyAnalytic {
                function, order, ..
            } => Self::ApplyAnalytic {
                function,
                order,
                out,
                a,
            },
        }
    }
}

/// A straight-line program: `slots[0..inputs]` are its inputs, `constants` stand in the slots they
/// name, `outputs` are read after the last instruction.
#[derive(Clone, Debug, Default)]
pub struct Code {
    /// The instructions in order.
    pub instructions: Vec<Instruction>,
    /// Numbers that stand in slots before the first instruction.
    pub constants: Vec<(u32, f64)>,
    /// The slots that hold the results.
    pub outputs: Vec<u32>,
    /// How many slots the program uses.
    pub slots: usize,
}

impl Code {
    /// The operations of one evaluation.
    pub fn count(&self) -> OperationCount {
        let mut count = OperationCount::default();
        for instruction in &self.instructions {
            match instruction {
                Instruction::Add { .. } | Instruction::Subtract { .. } => count.additions += 1,
                Instruction::Negate { .. } => count.negations += 1,
                Instruction::Magnitude { .. }
                | Instruction::Larger { .. }
                | Instruction::Smaller { .. }
                | Instruction::Keep { .. } => count.comparisons += 1,
                Instruction::Multiply { .. } => count.multiplications += 1,
                Instruction::Divide { .. } => count.divisions += 1,
                Instruction::Apply { .. }
                | Instruction::ApplyAnalytic { .. }
                | Instruction::ApplyTwo { .. }
                | Instruction::Power { .. } => count.functions += 1,
            }
        }
        count
    }
}

/// Exact numbers of operations of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OperationCount {
    /// Additions and subtractions.
    pub additions: usize,
    /// Multiplications.
    pub multiplications: usize,
    /// Divisions.
    pub divisions: usize,
    /// Sign changes.
    pub negations: usize,
    /// Magnitudes, the larger or smaller of two, and numbers kept on one side.
    pub comparisons: usize,
    /// Elementary functions and general powers.
    pub functions: usize,
}

impl OperationCount {
    /// Cost of an elementary function in arithmetic operations, roughly: those of `libm` take 5
    /// (square root) to 15 (exponential) times as long as a product.
    pub const FUNCTION: usize = 10;

    /// The count by which costs are compared: every arithmetic operation 1, every elementary
    /// function [`FUNCTION`](Self::FUNCTION).
    pub fn work(&self) -> u64 {
        let arithmetic = self.total() - self.functions;
        (arithmetic + Self::FUNCTION * self.functions) as u64
    }

    /// All of them.
    pub fn total(&self) -> usize {
        let arithmetic = self.additions + self.multiplications + self.divisions + self.negations;
        arithmetic + self.comparisons + self.functions
    }
}

impl fmt::Display for OperationCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} ({}, {}",
            counted(self.total(), "operation"),
            counted(self.additions, "addition"),
            counted(self.multiplications, "multiplication")
        )?;
        for (count, name) in [
            (self.divisions, "division"),
            (self.negations, "negation"),
            (self.comparisons, "comparison"),
            (self.functions, "function"),
        ] {
            if count > 0 {
                write!(f, ", {}", counted(count, name))?;
            }
        }
        write!(f, ")")
    }
}
