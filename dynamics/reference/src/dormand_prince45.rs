//! Dormand and Prince's method of order 5(4), adaptive inside a step: the part `dormand-prince45`,
//! the method of MATLAB's `ode45`.

use std::sync::Arc;

use leafwise_core::part::{
    Compared, Elsewhere, Family, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::{BuildError, MotionClass, PoissonSystem, StepMap};

use crate::adaptive::{Pair, Row, TOLERANCE, adaptive_map};

static INFO: PartInfo = PartInfo {
    name: "dormand-prince45",
    summary: "Dormand-Prince 5(4), explicit, adaptive inside each time step: as ode45",
    declares: "order 5 before the tolerance takes over; not a Poisson map; not self-adjoint",
    domain: "any system, of formulas or of numbers",
    literature: "Dormand, Prince, A family of embedded Runge-Kutta formulae, J. Comput. Appl. \
                 Math. 6 (1980); Hairer, Norsett, Wanner, Solving Ordinary Differential Equations \
                 I, table II.5.2",
    parameters: &[TOLERANCE],
    family: Some(Family::Explicit),
    takes: MotionClass::OffLeaves,
    serves_numbers: Some(ServesNumbers { rank: 3, limit: "" }),
    compared: Some(Compared::at(4)),
    elsewhere: Some(Elsewhere {
        names: &["rk45", "ode45", "dopri", "dopri5", "dp45"],
        is: "the pair of Dormand and Prince of orders 5 and 4",
    }),
    ..PartInfo::of(PartKind::Stepper)
};

/// a_ij; the last row is b_i, so that the last stage stands at the new state.
const MATRIX: [Row; 7] = [
    &[],
    &[(0, 1.0 / 5.0)],
    &[(0, 3.0 / 40.0), (1, 9.0 / 40.0)],
    &[(0, 44.0 / 45.0), (1, -56.0 / 15.0), (2, 32.0 / 9.0)],
    &[
        (0, 19372.0 / 6561.0),
        (1, -25360.0 / 2187.0),
        (2, 64448.0 / 6561.0),
        (3, -212.0 / 729.0),
    ],
    &[
        (0, 9017.0 / 3168.0),
        (1, -355.0 / 33.0),
        (2, 46732.0 / 5247.0),
        (3, 49.0 / 176.0),
        (4, -5103.0 / 18656.0),
    ],
    WEIGHTS,
];

/// b_i.
const WEIGHTS: Row = &[
    (0, 35.0 / 384.0),
    (2, 500.0 / 1113.0),
    (3, 125.0 / 192.0),
    (4, -2187.0 / 6784.0),
    (5, 11.0 / 84.0),
];

/// b_i − b̂_i, b̂_i of order 4.
const ERROR: Row = &[
    (0, 71.0 / 57600.0),
    (2, -71.0 / 16695.0),
    (3, 71.0 / 1920.0),
    (4, -17253.0 / 339200.0),
    (5, 22.0 / 525.0),
    (6, -1.0 / 40.0),
];

static PAIR: Pair = Pair {
    matrix: &MATRIX,
    weights: WEIGHTS,
    errors: &[ERROR],
    order: 5,
    exponent: 5.0,
    first_same_as_last: true,
};

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    adaptive_map(&INFO, &PAIR, system, parameters)
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));

#[cfg(test)]
mod tests {
    use super::{ERROR, MATRIX, Row, WEIGHTS};

    /// Σ a_j f(j).
    fn sum(row: Row, f: impl Fn(usize) -> f64) -> f64 {
        row.iter().map(|&(j, a)| a * f(j)).sum()
    }

    /// Sums of up to seven terms of size 12.
    const ROUND_OFF: f64 = 7.0 * 12.0 * f64::EPSILON;

    /// Both methods meet the conditions Σ b c^{k−1} = 1/k, to orders 5 and 4, and with
    /// Σ_j a_ij c_j = c_i²/2 weighted by b those of the trees with one branching.
    #[test]
    fn quadrature_and_first_branching_conditions() {
        let c = MATRIX.map(|row| sum(row, |_| 1.0));
        let inner = MATRIX.map(|row| sum(row, |j| c[j]));
        let embedded = |f: &dyn Fn(usize) -> f64| sum(WEIGHTS, f) - sum(ERROR, f);
        for k in 1..=5_i32 {
            let power = |j: usize| (1..k).map(|_| c[j]).product::<f64>();
            let expected = 1.0 / f64::from(k);
            assert!((sum(WEIGHTS, power) - expected).abs() <= ROUND_OFF, "{k}");
            if k <= 4 {
                assert!((embedded(&power) - expected).abs() <= ROUND_OFF, "{k}");
            }
        }
        assert!(
            (embedded(&|j| c[j] * c[j] * c[j] * c[j]) - 0.2).abs() > 1e-4,
            "order 4 only"
        );
        for (weight, expected) in [(0, 1.0 / 6.0), (1, 1.0 / 8.0), (2, 1.0 / 10.0)] {
            let tree = |j: usize| inner[j] * (0..weight).map(|_| c[j]).product::<f64>();
            assert!(
                (sum(WEIGHTS, tree) - expected).abs() <= ROUND_OFF,
                "{weight}"
            );
            if weight < 2 {
                assert!((embedded(&tree) - expected).abs() <= ROUND_OFF, "{weight}");
            }
        }
    }

    /// c_i of the published table.
    #[test]
    fn rows_sum_to_the_nodes() {
        let nodes = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
        for (row, c) in MATRIX.iter().zip(nodes) {
            assert!((sum(row, |_| 1.0) - c).abs() <= ROUND_OFF, "{c}");
        }
    }
}
