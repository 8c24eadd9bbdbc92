//! Straight-line kernels: compiled from a graph, evaluated W lanes at a time, by an interpreter or
//! as machine code.

mod aligned;
mod allocate;
mod along;
mod code;
mod compile;
mod distances;
mod draft;
mod emit;
mod execution;
mod interpreter;
#[cfg(all(feature = "jit", any(target_arch = "x86_64", target_arch = "aarch64")))]
#[allow(unsafe_code)]
mod jit;
mod kinds;
mod lookups;
#[cfg(not(all(feature = "jit", any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod no_jit;
mod sequence;
mod workspace;

pub use aligned::Aligned;
pub use code::{Code, Instruction, OperationCount};
pub use compile::Kernel;
pub use distances::{Distance, Passes};
pub use execution::{Execution, MachineCodeSize};
#[cfg(all(feature = "jit", any(target_arch = "x86_64", target_arch = "aarch64")))]
use jit::{MachineCode, Room};
#[cfg(not(all(feature = "jit", any(target_arch = "x86_64", target_arch = "aarch64"))))]
use no_jit::{MachineCode, Room};
pub use sequence::{Sequence, Value};
pub use workspace::{Workspace, apart};
