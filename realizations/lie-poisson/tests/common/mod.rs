//! Linear tensors by name for the tests of this crate.

use leafwise_core::PoissonSystem;
use leafwise_realization_claims::systems::{from_formulas, library};

/// Every algebra the claims are made for: compact, semidirect, split, nilpotent, solvable.
pub const ALGEBRAS: [&str; 7] = [
    "rigid-body",
    "so4",
    "se3",
    "heavy-top",
    "sl2",
    "heisenberg",
    "affine",
];

/// The system of one of [`ALGEBRAS`].
pub fn algebra(name: &str) -> PoissonSystem {
    match name {
        "sl2" => from_formulas(
            &["h", "e", "f"],
            &[("a", 0.8)],
            &[("h", "e", "2*e"), ("h", "f", "-2*f"), ("e", "f", "h")],
            "h^2/2 + a*e^2 + f^2/3 + e*f/4 + h/5",
            &["h^2 + 4*e*f"],
        ),
        "heisenberg" => from_formulas(
            &["q", "p", "c"],
            &[],
            &[("q", "p", "c")],
            "p^2/2 + q^2/2 + q^4/10 + c*q",
            &["c"],
        ),
        // Brackets that depend on a parameter, and an algebra that is not unimodular.
        "affine" => from_formulas(
            &["x", "y", "z"],
            &[("a", 0.7), ("b", 1.5)],
            &[("x", "y", "a*y + b*z"), ("x", "z", "a*z - b*y")],
            "x^2/2 + y^2 + z^2/3 + x*y/4",
            &[],
        ),
        id => library(id).system,
    }
}
