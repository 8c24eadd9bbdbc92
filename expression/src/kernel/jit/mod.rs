//! Machine code for step kernels, bit-identical to the interpreter.

mod emit;
mod functions;
mod machine;
mod program;
mod registers;

pub(super) use machine::MachineCode;
