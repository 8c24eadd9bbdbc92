//! Machine code for step kernels, bit-identical to the interpreter.

mod emit;
mod functions;
mod machine;

pub(super) use machine::MachineCode;
