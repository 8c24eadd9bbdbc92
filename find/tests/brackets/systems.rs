//! Classical equations.

use super::Rows;

pub const HENON_HEILES: Rows = &[
    ("q1", "p1"),
    ("q2", "p2"),
    ("p1", "-q1 - 2*q1*q2"),
    ("p2", "-q2 - q1^2 + q2^2"),
];
pub const LOTKA_VOLTERRA: Rows = &[
    ("a", "a*(b + c + d - 4)"),
    ("b", "b*(-a + c + d - 1)"),
    ("c", "c*(-a - b + d + 2)"),
    ("d", "d*(-a - b - c + 4)"),
];
/// The same with columns times 1, 2, 1/2, 3.
pub const RESCALED: Rows = &[
    ("a", "a*(2*b + c/2 + 3*d - 4)"),
    ("b", "b*(-a + c/2 + 3*d - 1)"),
    ("c", "c*(-a - 2*b + 3*d + 2)"),
    ("d", "d*(-a - 2*b - c/2 + 4)"),
];
pub const B5: Rows = &[("x", "y*z"), ("y", "-x*z"), ("z", "-0.51*x*y")];
/// m' = m × m/I + g × c, g' = g × m/I with I = (1, 1.5, 2), c = (0.3, 0.2, 0.9).
pub const HEAVY_TOP: Rows = &[
    ("m1", "m2*m3/2 - m3*m2/1.5 + 0.9*g2 - 0.2*g3"),
    ("m2", "m3*m1 - m1*m3/2 + 0.3*g3 - 0.9*g1"),
    ("m3", "m1*m2/1.5 - m2*m1 + 0.2*g1 - 0.3*g2"),
    ("g1", "g2*m3/2 - g3*m2/1.5"),
    ("g2", "g3*m1 - g1*m3/2"),
    ("g3", "g1*m2/1.5 - g2*m1"),
];
/// The same with I = (1, 1, 1.5), c = (0, 0, 1): Lagrange's top, with m3 and m3² beside the energy among its integrals.
pub const LAGRANGES_TOP: Rows = &[
    ("m1", "m2*m3/1.5 - m3*m2 + g2"),
    ("m2", "m3*m1 - m1*m3/1.5 - g1"),
    ("m3", "0"),
    ("g1", "g2*m3/1.5 - g3*m2"),
    ("g2", "g3*m1 - g1*m3/1.5"),
    ("g3", "g1*m2 - g2*m1"),
];
/// m' = m × m/I + p × p/M, p' = p × m/I with M = (1, 2, 1.6).
pub const KIRCHHOFF: Rows = &[
    ("m1", "m2*m3/2 - m3*m2/1.5 + p2*p3/1.6 - p3*p2/2"),
    ("m2", "m3*m1 - m1*m3/2 + p3*p1 - p1*p3/1.6"),
    ("m3", "m1*m2/1.5 - m2*m1 + p1*p2/2 - p2*p1"),
    ("p1", "p2*m3/2 - p3*m2/1.5"),
    ("p2", "p3*m1 - p1*m3/2"),
    ("p3", "p1*m2/1.5 - p2*m1"),
];
/// i a₁' = ā₂ a₃, i a₂' = ā₁ a₃, i a₃' = a₁ a₂ with a = x + i y.
pub const THREE_WAVE: Rows = &[
    ("x1", "x2*y3 - x3*y2"),
    ("x2", "x1*y3 - x3*y1"),
    ("x3", "x1*y2 + x2*y1"),
    ("y1", "-x2*x3 - y2*y3"),
    ("y2", "-x1*x3 - y1*y3"),
    ("y3", "-x1*x2 + y1*y2"),
];
pub const TODA: Rows = &[
    ("a1", "a1*(b2 - b1)"),
    ("a2", "a2*(b3 - b2)"),
    ("b1", "2*a1^2"),
    ("b2", "2*a2^2 - 2*a1^2"),
    ("b3", "-2*a2^2"),
];
/// May and Leonard's quadratic part with both coefficients −1/2.
pub const MAY_LEONARD: Rows = &[
    ("x", "-x*(x - (y + z)/2)"),
    ("y", "-y*(y - (x + z)/2)"),
    ("z", "-z*(z - (x + y)/2)"),
];
pub const MAXWELL_BLOCH: Rows = &[("x", "y"), ("y", "x*z"), ("z", "-x*y")];
/// m' = m × (m₁, m₂/2, (m₃ − 0.3)/3).
pub const ROTOR: Rows = &[
    ("x", "y*(z - 0.3)/3 - z*y/2"),
    ("y", "z*x - x*(z - 0.3)/3"),
    ("z", "x*y/2 - y*x"),
];
