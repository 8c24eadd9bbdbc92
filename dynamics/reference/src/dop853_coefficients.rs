//! Coefficients of Dormand and Prince's explicit pair of order 8(5,3).
//!
//! Source: E. Hairer and G. Wanner, `dop853.f` (University of Geneva, 1994), to Hairer, Nørsett,
//! Wanner, *Solving Ordinary Differential Equations I*, section II.5. Sparse rows of (index, value),
//! rounded to the nearest double; zeros are left out.

use crate::adaptive::Row;

/// Stages of a step, the last of which is evaluated at the new state.
pub(crate) const STAGES: usize = 12;

/// a_ij.
pub(crate) const MATRIX: [Row; STAGES] = [
    &[],
    &[(0, 0.05260015195876773)],
    &[(0, 0.0197250569845379), (1, 0.0591751709536137)],
    &[(0, 0.02958758547680685), (2, 0.08876275643042054)],
    &[
        (0, 0.2413651341592667),
        (2, -0.8845494793282861),
        (3, 0.924834003261792),
    ],
    &[
        (0, 0.037037037037037035),
        (3, 0.17082860872947386),
        (4, 0.12546768756682242),
    ],
    &[
        (0, 0.037109375),
        (3, 0.17025221101954405),
        (4, 0.06021653898045596),
        (5, -0.017578125),
    ],
    &[
        (0, 0.03709200011850479),
        (3, 0.17038392571223998),
        (4, 0.10726203044637328),
        (5, -0.015319437748624402),
        (6, 0.008273789163814023),
    ],
    &[
        (0, 0.6241109587160757),
        (3, -3.3608926294469414),
        (4, -0.868219346841726),
        (5, 27.59209969944671),
        (6, 20.154067550477894),
        (7, -43.48988418106996),
    ],
    &[
        (0, 0.47766253643826434),
        (3, -2.4881146199716677),
        (4, -0.590290826836843),
        (5, 21.230051448181193),
        (6, 15.279233632882423),
        (7, -33.28821096898486),
        (8, -0.020331201708508627),
    ],
    &[
        (0, -0.9371424300859873),
        (3, 5.186372428844064),
        (4, 1.0914373489967295),
        (5, -8.149787010746927),
        (6, -18.52006565999696),
        (7, 22.739487099350505),
        (8, 2.4936055526796523),
        (9, -3.0467644718982196),
    ],
    &[
        (0, 2.273310147516538),
        (3, -10.53449546673725),
        (4, -2.0008720582248625),
        (5, -17.9589318631188),
        (6, 27.94888452941996),
        (7, -2.8589982771350235),
        (8, -8.87285693353063),
        (9, 12.360567175794303),
        (10, 0.6433927460157636),
    ],
];

/// b_i, of order 8.
pub(crate) const WEIGHTS: Row = &[
    (0, 0.054293734116568765),
    (5, 4.450312892752409),
    (6, 1.8915178993145003),
    (7, -5.801203960010585),
    (8, 0.3111643669578199),
    (9, -0.1521609496625161),
    (10, 0.20136540080403034),
    (11, 0.04471061572777259),
];

/// b_i minus the weights of order 5.
pub(crate) const FIFTH_ORDER_ERROR: Row = &[
    (0, 0.01312004499419488),
    (5, -1.2251564463762044),
    (6, -0.4957589496572502),
    (7, 1.6643771824549864),
    (8, -0.35032884874997366),
    (9, 0.3341791187130175),
    (10, 0.08192320648511571),
    (11, -0.022355307863886294),
];

/// b_i minus the weights of order 3.
pub(crate) const THIRD_ORDER_ERROR: Row = &[
    (0, -0.18980075407240762),
    (5, 4.450312892752409),
    (6, 1.8915178993145003),
    (7, -5.801203960010585),
    (8, -0.4226823213237919),
    (9, -0.1521609496625161),
    (10, 0.20136540080403034),
    (11, 0.02265179219836082),
];

#[cfg(test)]
mod tests {
    use super::{FIFTH_ORDER_ERROR, MATRIX, Row, STAGES, THIRD_ORDER_ERROR, WEIGHTS};

    fn sum(row: Row, of: impl Fn(usize) -> f64) -> f64 {
        row.iter().map(|&(j, a)| a * of(j)).sum()
    }

    fn nodes() -> [f64; STAGES] {
        MATRIX.map(|row| sum(row, |_| 1.0))
    }

    /// Σ b_i c_i^{k−1} = 1/k for k ≤ 8; sums of eight terms of size 20 cancel to 1.
    #[test]
    fn the_weights_are_a_quadrature_of_order_eight() {
        let c = nodes();
        for k in 1..=8 {
            let moment = sum(WEIGHTS, |i| libm::pow(c[i], f64::from(k) - 1.0));
            assert!(
                (moment - 1.0 / f64::from(k)).abs() < 160.0 * f64::EPSILON,
                "{k}: {moment}"
            );
        }
    }

    /// Σ_i b_i (1 − c_i) Σ_j a_ij c_j^{k−1} = 1/(k(k+1)(k+2)), order conditions of trees of height 3.
    #[test]
    fn the_matrix_satisfies_conditions_of_order_eight() {
        let c = nodes();
        for k in 1..=6 {
            let power = f64::from(k);
            let inner = MATRIX.map(|row| sum(row, |j| libm::pow(c[j], power - 1.0)));
            let found = sum(WEIGHTS, |i| (1.0 - c[i]) * inner[i]);
            let expected = 1.0 / (power * (power + 1.0) * (power + 2.0));
            assert!(
                (found - expected).abs() < 640.0 * f64::EPSILON,
                "{k}: {found} {expected}"
            );
        }
    }

    /// The embedded methods integrate polynomials of their own orders, and no more.
    #[test]
    fn the_errors_vanish_to_their_orders() {
        let c = nodes();
        for (row, order) in [(FIFTH_ORDER_ERROR, 5), (THIRD_ORDER_ERROR, 3)] {
            for k in 1..=order + 1 {
                let moment = sum(row, |i| libm::pow(c[i], f64::from(k) - 1.0)).abs();
                assert_eq!(
                    moment < 160.0 * f64::EPSILON,
                    k <= order,
                    "{order}, {k}: {moment:e}"
                );
            }
        }
    }
}
