//! Leafwise from C, Fortran and Julia: scenes, integrators, runs and their gradients.
//!
//! The functions are those of `include/leafwise.h`, which is generated from this crate:
//! `cargo run -p leafwise-c --example header`. The library is built by `cargo build --release -p leafwise-c` as
//! `target/release/libleafwise_c.so`.
//!
//! - Objects are numbers, not pointers: one that was never given, or was freed, is an error code.
//! - Arrays are the caller's, with a length and a stride in doubles. Lengths are compared before anything is read.
//! - Each call returns a [`LeafwiseCode`]; [`leafwise_last_error`] has the message of this thread's last call.
//! - Calls may come from any thread. An integrator that steps in another thread is [`LeafwiseCode::LEAFWISE_BUSY`].
//! - The library is that of functional mock-up units too: the functions of FMI 3.0 for co-simulation, `fmi3…`.
//! - No panic leaves a call. Results have the bits of the program's.

#![allow(
    non_camel_case_types,
    non_snake_case,
    reason = "names of C: an enumeration's values stand in one namespace, and the standard FMI names its functions"
)]

mod call_error;
mod calls;
mod code;
mod fmi;
mod handle;
mod integrator;
mod samples;
mod scene;
mod strided;

pub use calls::*;
pub use code::LeafwiseCode;
pub use fmi::*;
pub use handle::LeafwiseHandle;
pub use scene::{LeafwiseName, LeafwiseShape};
