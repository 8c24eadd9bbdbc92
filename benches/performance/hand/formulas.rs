//! Methods' formulas as straight-line Rust, written by `cargo bench -p leafwise-benches --bench performance -- formulas`.

#![allow(
    clippy::all,
    reason = "written by a program, and read by a compiler alone"
)]

use leafwise::so3::functions::COTANGENT;

use super::newton::{Formulas, Full, Residual};

include!("../formulas/RigidBody2.rs");
include!("../formulas/RigidBody4.rs");
include!("../formulas/RigidBody8.rs");
include!("../formulas/LotkaVolterra2.rs");
include!("../formulas/LotkaVolterra4.rs");
include!("../formulas/LotkaVolterra8.rs");
include!("../formulas/HeavyTop2.rs");
include!("../formulas/HeavyTop4.rs");
include!("../formulas/HeavyTop8.rs");
