//! Methods' formulas as straight-line Rust, where `cargo bench -p leafwise-benches --bench performance -- formulas` has
//! written them.

#[cfg(has_formulas)]
pub use written::*;

#[cfg(has_formulas)]
mod written {
    #![allow(
        clippy::all,
        unused_variables,
        reason = "written by a program, and read by a compiler alone"
    )]

    use leafwise::expression::elementary::exp_m1_mirrored;

    use super::super::newton::{Formulas, Full, Residual, largest};

    include!("../formulas/RigidBody2.rs");
    include!("../formulas/RigidBody4.rs");
    include!("../formulas/RigidBody8.rs");
    include!("../formulas/LotkaVolterra2.rs");
    include!("../formulas/LotkaVolterra4.rs");
    include!("../formulas/LotkaVolterra8.rs");
    include!("../formulas/HeavyTop2.rs");
    include!("../formulas/HeavyTop4.rs");
    include!("../formulas/HeavyTop8.rs");
}

/// What stands for formulas that are not written, so that the bench builds, and can write them.
#[cfg(not(has_formulas))]
macro_rules! not_written {
    ($($name:ident: $dimension:literal,)*) => {$(
        pub struct $name;

        impl $name {
            pub fn new(_: &[f64; 0], _: f64, _: f64) -> Self {
                Self
            }
        }

        impl super::newton::Formulas<$dimension> for $name {
            const MOST_CHORDS: u32 = 0;
            fn residual(&self, _: &[f64; $dimension]) -> super::newton::Residual<$dimension> {
                unreachable!("formulas that are not written are not measured")
            }
            fn full(&self, _: &[f64; $dimension]) -> super::newton::Full<$dimension> {
                unreachable!("formulas that are not written are not measured")
            }
        }
    )*};
}

#[cfg(not(has_formulas))]
not_written! {
    RigidBody2: 3,
    RigidBody4: 3,
    RigidBody8: 3,
    LotkaVolterra2: 3,
    LotkaVolterra4: 3,
    LotkaVolterra8: 3,
    HeavyTop2: 6,
    HeavyTop4: 6,
    HeavyTop8: 6,
}
