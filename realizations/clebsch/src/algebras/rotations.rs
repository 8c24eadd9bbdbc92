//! so(3)* by Hopf's map y = (½(q₀q₁ + p₀p₁), ½(q₀p₁ − p₀q₁), ¼(q₀² + p₀² − q₁² − p₁²)).
//!
//! Fibres are the orbits of the turns q + ip ↦ e^{iφ}(q + ip), and 4|y| = |z|².

use std::sync::Arc;

use crate::algebra::{Algebra, canonical};
use crate::forms::Forms;

/// y in quarters.
const FORMS: [&[(i64, usize, usize)]; 3] = [
    &[(2, 0, 1), (2, 2, 3)],
    &[(2, 0, 3), (-2, 2, 1)],
    &[(1, 0, 0), (1, 2, 2), (-1, 1, 1), (-1, 3, 3)],
];

/// so(3).
pub fn algebra() -> Algebra {
    Algebra {
        name: "so(3)",
        forms: Forms::of_table(4, 4, &FORMS),
        omega: canonical(4, &[(0, 2), (1, 3)], -1),
        copies: 1,
        is_signed: false,
        section: Arc::new(|y, z, _| {
            z.copy_from_slice(&section(y));
            Ok(())
        }),
        settle: None,
        groups: &[],
    }
}

/// A z over y, the larger of its two complex numbers real.
pub fn section(y: &[f64]) -> [f64; 4] {
    let length = libm::hypot(libm::hypot(y[0], y[1]), y[2]);
    if length == 0.0 {
        return [0.0; 4];
    }
    let large = libm::sqrt(2.0 * (length + y[2].abs()));
    let [along, across] = [2.0 * y[0] / large, 2.0 * y[1] / large];
    match y[2] >= 0.0 {
        true => [large, along, 0.0, across],
        false => [along, large, -across, 0.0],
    }
}
