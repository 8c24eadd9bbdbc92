//! Machine code for x86-64 with AVX: registers as planned, one number, two, four or eight an
//! instruction, without a compiler's allocation of registers.

mod assembler;
mod emit;

use memmap2::{Mmap, MmapMut};

pub(super) use assembler::Width;

use super::executable::{Executable, Written};
use super::program::Program;
use super::registers::Plan;
use crate::analytic::AnalyticFunction;
use crate::kernel::distances::Distances;

/// Writes the program into executable memory, `width` of the `lanes` lanes at a time; `None` where the
/// platform forbids it.
pub(super) fn write(
    program: &Program,
    lanes: usize,
    width: Width,
    functions: &[AnalyticFunction],
    distances: Option<&Distances>,
) -> Option<Written> {
    if distances.is_some() && width == Width::One {
        return None;
    }
    // One register is left for what is neither held nor resident.
    let registers = width.registers() - 1;
    let plan = match distances {
        Some(distances) => Plan::along(program, registers, distances.inputs.len()),
        None => Plan::new(program, registers),
    };
    let code = emit::assemble(program, &plan, (lanes, width), functions, distances);
    let mut memory = MmapMut::map_anon(code.len()).ok()?;
    memory.copy_from_slice(&code);
    Some(Written {
        memory: Box::new(memory.make_exec().ok()?),
        bytes: code.len(),
        scratch: emit::scratch(program, &plan, width),
        limits: program
            .limits
            .iter()
            .flat_map(|limit| emit::own_row(limit.row, width).map(|at| (at, limit.bound)))
            .collect(),
    })
}

/// Written, then executable, never both.
impl Executable for Mmap {
    fn start(&self) -> *const u8 {
        self.as_ptr()
    }
}
