//! Machine code for x86-64 with AVX: registers as planned, one number, two, four or eight an
//! instruction, without the compiler's allocation of registers.

mod assembler;
mod emit;

pub(super) use assembler::Width;
pub(super) use emit::{assemble, scratch_len};
