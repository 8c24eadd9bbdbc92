//! The problems of the comparison: scene and hand-written field and flows of each.

use crate::hand::splitting::{Flows, exponential, rotate};

/// A problem of three dimensions.
pub trait Problem: Flows<State = [f64; 3]> {
    const TITLE: &'static str;
    /// The system's name in the library.
    const LIBRARY: &'static str;
    const INITIAL: [f64; 3];
    /// T.
    const TIME: f64;
    /// Exact realizations.
    const REALIZATIONS: &'static [&'static str];
    /// Coordinates with a constant tensor.
    const LIFT: &'static str;
    /// What the Hamilton–Jacobi series is made from.
    const HAMILTONIANS: &'static [&'static str];
    /// Poisson step maps of order 2 that take compositions: names, and what a scene calls them.
    const STEPPERS: &'static [(&'static str, &'static str)];
    /// Exact flows, which no composition improves.
    const EXACT: &'static [(&'static str, &'static str)] = &[];
    /// ẋ.
    fn field(x: &[f64; 3]) -> [f64; 3];
    /// The Casimir, and its largest summand.
    fn casimir(x: &[f64]) -> (f64, f64);
}

/// The rigid body of the paper, ẋ = −x × ω.
pub struct RigidBody;

/// 1/I.
const INVERSE: [f64; 3] = [1.0, 1.0 / 0.75, 1.0 / 1.25];

impl Problem for RigidBody {
    const TITLE: &'static str = "Rigid body";
    const LIBRARY: &'static str = "rigid-body";
    const INITIAL: [f64; 3] = [1.0, 3.0, 3.0];
    const TIME: f64 = 200.0;
    const REALIZATIONS: &'static [&'static str] = &["so3-exponential", "so3-cayley"];
    const LIFT: &'static str = "clebsch";
    const HAMILTONIANS: &'static [&'static str] = &["given", "energy-casimir"];
    const STEPPERS: &'static [(&'static str, &'static str)] = &[
        ("splitting", "\"splitting\""),
        ("spherical-midpoint", "\"spherical-midpoint\""),
    ];
    const EXACT: &'static [(&'static str, &'static str)] = &[(
        "splitting whole",
        "{ name = \"splitting\", bodies = \"whole\" }",
    )];

    #[inline(always)]
    fn field(x: &[f64; 3]) -> [f64; 3] {
        [
            x[1] * x[2] * (INVERSE[1] - INVERSE[2]),
            x[2] * x[0] * (INVERSE[2] - INVERSE[0]),
            x[0] * x[1] * (INVERSE[0] - INVERSE[1]),
        ]
    }

    fn casimir(x: &[f64]) -> (f64, f64) {
        let squares = [x[0] * x[0], x[1] * x[1], x[2] * x[2]];
        let largest = squares.iter().fold(0.0, |m: f64, s| m.max(*s));
        (squares.iter().sum(), largest)
    }
}

/// H − |x|²/(2 I₁) has two terms: a rotation about the second axis and one about the third.
impl Flows for RigidBody {
    type State = [f64; 3];
    const PIECES: usize = 2;

    #[inline(always)]
    fn flow(piece: usize, x: &mut [f64; 3], time: f64) {
        let [first, second, third] = x;
        if piece == 0 {
            let angle = time * (INVERSE[0] - INVERSE[1]) * *second;
            rotate(first, third, angle);
        } else {
            let angle = time * (INVERSE[2] - INVERSE[0]) * *third;
            rotate(first, second, angle);
        }
    }
}

/// The bounded Lotka–Volterra system of Cohen and Hairer.
pub struct LotkaVolterra;

impl Problem for LotkaVolterra {
    const TITLE: &'static str = "Periodic Lotka–Volterra";
    const LIBRARY: &'static str = "lotka-volterra-periodic";
    const INITIAL: [f64; 3] = [1.0, 1.9, 0.5];
    const TIME: f64 = 100.0;
    const REALIZATIONS: &'static [&'static str] = &["log-canonical"];
    const LIFT: &'static str = "logarithms";
    const HAMILTONIANS: &'static [&'static str] = &["given"];
    const STEPPERS: &'static [(&'static str, &'static str)] = &[
        ("splitting", "\"splitting\""),
        (
            "splitting 1 2 3",
            "{ name = \"splitting\", pieces = \"1 2 3\" }",
        ),
    ];

    #[inline(always)]
    fn field(x: &[f64; 3]) -> [f64; 3] {
        [
            x[0] * (0.5 * x[1] - x[2] + 1.5),
            x[1] * (2.0 * x[2] - x[0] - 2.0),
            x[2] * (x[0] - x[1] - 1.0),
        ]
    }

    fn casimir(x: &[f64]) -> (f64, f64) {
        let logarithms = [2.0 * libm::log(x[0]), libm::log(x[1]), libm::log(x[2])];
        let largest = logarithms.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
        (logarithms.iter().sum(), largest)
    }
}

/// One piece a variable: its value rests, the logarithms of the others grow linearly.
impl Flows for LotkaVolterra {
    type State = [f64; 3];
    const PIECES: usize = 3;

    #[inline(always)]
    fn flow(piece: usize, x: &mut [f64; 3], time: f64) {
        match piece {
            0 => {
                let grown = time * x[0];
                x[1] *= exponential(-grown);
                x[2] *= exponential(grown);
            }
            1 => {
                let grown = time * (x[1] + 1.0);
                x[0] *= exponential(0.5 * grown);
                x[2] *= exponential(-grown);
            }
            _ => {
                let grown = time * (x[2] - 1.0);
                x[0] *= exponential(-grown);
                x[1] *= exponential(2.0 * grown);
            }
        }
    }
}
