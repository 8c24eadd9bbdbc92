//! Straight-line kernels: compiled from a graph, evaluated W lanes at a time.

mod allocate;
mod code;
mod compile;
mod interpreter;
mod workspace;

pub use code::{Code, Instruction, OperationCount};
pub use compile::Kernel;
pub use workspace::Workspace;
