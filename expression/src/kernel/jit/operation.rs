//! One operation of a program in single assignment.

use crate::kernel::code::Instruction;

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Source {
    /// A slot that the program only reads: an input, a coefficient or a constant.
    Slot(u32),
    /// The result of the operation of this number.
    Result(u32),
}

/// One operation with its operands.
#[derive(Clone, Debug)]
pub(super) struct Operation {
    /// What it does; its slots mean nothing here.
    pub(super) instruction: Instruction,
    /// The operands; unary operations repeat theirs.
    pub(super) operands: [Source; 2],
    /// The slot that the caller reads the result from.
    pub(super) output: Option<u32>,
    /// Whether the operation just before it, which is then its operand, is the other one of a pair of
    /// functions: its call gives this result too.
    pub(super) is_second: bool,
}
