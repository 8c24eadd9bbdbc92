//! e(3)* = se(3)* on T*ℍ: quaternions q with momenta p, m = ½ Im(q̄p), Γ the third row of the rotation |q|²R(q).
//!
//! Fibres are orbits of the turns (q, p) ↦ (uq, up) about the third axis of space and of the shifts p ↦ p + sq: |q|² = |Γ|. A state
//! with Γ = 0 and m ≠ 0 has no point over it.

use std::sync::Arc;

use leafwise_core::StepError;

use crate::algebra::{Algebra, NAME, canonical};
use crate::forms::Forms;

/// y = (m, Γ) in halves.
const FORMS: [&[(i64, usize, usize)]; 6] = [
    &[(1, 0, 5), (-1, 1, 4), (1, 3, 6), (-1, 2, 7)],
    &[(1, 0, 6), (-1, 2, 4), (1, 1, 7), (-1, 3, 5)],
    &[(1, 0, 7), (-1, 3, 4), (1, 2, 5), (-1, 1, 6)],
    &[(4, 1, 3), (-4, 0, 2)],
    &[(4, 2, 3), (4, 0, 1)],
    &[(2, 0, 0), (-2, 1, 1), (-2, 2, 2), (2, 3, 3)],
];

/// e(3).
pub fn algebra() -> Algebra {
    Algebra {
        name: "e(3)",
        forms: Forms::of_table(8, 2, &FORMS),
        omega: canonical(8, &[(0, 4), (1, 5), (2, 6), (3, 7)], 1),
        copies: 1,
        is_signed: false,
        section: Arc::new(|y, z, _| section(y, z)),
        settle: Some(settle),
        groups: &[4],
    }
}

/// (q, p) over (m, Γ) with p·q = 0: q with one component 0, p = 2qm/|q|².
fn section(y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
    let ([m1, m2, m3], [g1, g2, g3]) = ([y[0], y[1], y[2]], [y[3], y[4], y[5]]);
    let length = libm::hypot(libm::hypot(g1, g2), g3);
    z.fill(0.0);
    if length == 0.0 {
        return match [m1, m2, m3] == [0.0; 3] {
            true => Ok(()),
            false => Err(StepError::OutsideImage {
                part: NAME,
                reason: "the vector of e(3)* is 0 and the momentum is not",
                hint: "leave the vector out of the system, as a body that turns freely, or take another realization",
            }),
        };
    }
    let large = libm::sqrt(0.5 * (length + g3.abs()));
    let (first, second) = (-0.5 * g1 / large, 0.5 * g2 / large);
    let q = match g3 >= 0.0 {
        true => [large, second, first, 0.0],
        false => [first, 0.0, large, second],
    };
    let [a, b, c, d] = q;
    let factor = 2.0 / length;
    z[..4].copy_from_slice(&q);
    z[4] = -factor * (b * m1 + c * m2 + d * m3);
    z[5] = factor * (a * m1 + c * m3 - d * m2);
    z[6] = factor * (a * m2 + d * m1 - b * m3);
    z[7] = factor * (a * m3 + b * m2 - c * m1);
    Ok(())
}

/// p less its part along q, which neither m nor Γ sees, where that is the larger one.
fn settle(z: &mut [f64]) {
    let (q, p) = z.split_at_mut(4);
    let along: f64 = q.iter().zip(&*p).map(|(q, p)| q * p).sum();
    let [square, whole] = [&*q, &*p].map(|v| v.iter().map(|v| v * v).sum::<f64>());
    if square > 0.0 && 2.0 * along * along > square * whole {
        let part = along / square;
        for (p, q) in p.iter_mut().zip(q) {
            *p -= part * *q;
        }
    }
}
