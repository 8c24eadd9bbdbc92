//! Machine code for step kernels, bit-identical to the interpreter.
//!
//! A program's operations are put in order ([`program`]), and its loads and stores planned
//! ([`registers`]). The steps are then written as machine code: by our own assembler where there is
//! AVX ([`avx`]), on ARM and Windows by Cranelift (`portable`). The assembler compiles in
//! microseconds and takes four or eight lanes an instruction.

mod assignment;
#[cfg(all(target_arch = "x86_64", not(windows)))]
mod avx;
mod executable;
mod functions;
mod machine;
mod operation;
#[cfg(any(target_arch = "aarch64", windows, leafwise_portable))]
mod portable;
mod program;
mod registers;
mod schedule;
#[cfg(test)]
mod tests;

pub(super) use machine::{MachineCode, Room};
