//! A measured order with a tolerance that follows from the points.

use leafwise_core::diagnostics::{Slope, fit_slope};
use leafwise_core::{PoissonSystem, StepMap, Structure};

use crate::gauss::flow;
use crate::methods::run;
use crate::numbers::{UNIT_ROUNDOFF, distance, largest};

/// A fitted exponent and how far it may lie from the true one.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredOrder {
    /// The fit.
    pub slope: Slope,
    /// 3 standard errors, round-off of the smallest error, and the next-order term.
    ///
    /// For errors c τ^q (1 + k τ^r) the slope between two neighbouring points is q + r k τ^r, and
    /// so is its excess over q: from the coarsest pair to the finest it falls by the factor
    /// (τ_fine/τ_coarse)^r. The excess of the coarsest, which bounds that of the fit, is thus
    /// |s_coarse − s_fine| / (1 − (τ_fine/τ_coarse)^r).
    pub tolerance: f64,
}

/// Errors below this multiple of round-off are dropped.
const MARGIN: f64 = 10.0;

/// Fits error ≈ c·τ^q to points (τ, error) in any order, dropping those under ten times `roundoff`;
/// the next term is smaller by τ^`gap`. `None` with fewer than four points left.
pub fn measure(points: &[(f64, f64)], roundoff: f64, gap: f64) -> Option<MeasuredOrder> {
    let plateau = MARGIN * roundoff;
    let slope = fit_slope(points, plateau)?;
    let mut kept: Vec<_> = points.iter().filter(|p| p.1 > plateau).copied().collect();
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    if kept.len() < 4 {
        return None;
    }
    let local: Vec<f64> = kept
        .windows(2)
        .map(|w| libm::log(w[1].1 / w[0].1) / libm::log(w[1].0 / w[0].0))
        .collect();
    let (fine, coarse) = (local[0], local[local.len() - 1]);
    // The pairs' midpoints, on the logarithmic scale.
    let ratio = libm::sqrt(kept[0].0 * kept[1].0)
        / libm::sqrt(kept[kept.len() - 1].0 * kept[kept.len() - 2].0);
    let next = (coarse - fine).abs() / (1.0 - libm::pow(ratio, gap));
    let range = libm::log(kept[kept.len() - 1].0 / kept[0].0);
    let noise = roundoff / kept[0].1 / range;
    Some(MeasuredOrder {
        slope,
        tolerance: 3.0 * slope.standard_error + noise + next,
    })
}

/// The order of a self-adjoint map: its error after `time` against the flow, for each number of
/// steps. `None` where fewer than four errors are above a thousand roundings of the state.
///
/// # Panics
/// When a step fails.
pub fn of_even_order(
    system: &PoissonSystem,
    map: &dyn StepMap,
    initial: &[f64],
    time: f64,
    steps: &[usize],
) -> Option<MeasuredOrder> {
    let end = flow(system, initial, time, 64);
    let error = |&steps: &usize| {
        let h = time / steps as f64;
        let found = run(system, map, (1.0, h), steps, initial).expect("a step");
        (h, distance(&found, &end))
    };
    let points: Vec<_> = steps.iter().map(error).collect();
    measure(&points, 100.0 * UNIT_ROUNDOFF * largest(&end), 2.0)
}

/// Asserts that Gauss methods in the coordinates of a lift, `gauss(s)` of s stages, declare order 2s, exactness and
/// self-adjointness, and have this order: each s with the time and the numbers of steps that it is fitted to.
///
/// # Panics
/// Where one does not.
pub fn assert_gauss_orders<M: StepMap>(
    system: &PoissonSystem,
    gauss: impl Fn(usize) -> M,
    initial: &[f64],
    fits: &[(usize, f64, [usize; 4])],
) {
    for (stages, time, steps) in fits {
        let method = gauss(*stages);
        let properties = method.properties();
        let expected = (2 * stages, Structure::Exact, Some(true));
        let declared = (
            properties.order,
            properties.structure,
            properties.self_adjoint,
        );
        assert_eq!(declared, expected, "{stages} stages");
        let found = of_even_order(system, &method, initial, *time, steps);
        let found = found.unwrap_or_else(|| panic!("{stages}: too few errors above round-off"));
        let order = 2.0 * *stages as f64;
        assert!(found.is(order, 2.0), "{stages} stages: measured {found}");
    }
}

impl MeasuredOrder {
    /// Whether the fit is `expected` within its tolerance, and no neighbouring order is: the
    /// orders that could be confused lie `spacing` apart.
    pub fn is(&self, expected: f64, spacing: f64) -> bool {
        self.tolerance < spacing / 2.0 && (self.slope.exponent - expected).abs() <= self.tolerance
    }
}

impl std::fmt::Display for MeasuredOrder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Slope {
            exponent, points, ..
        } = self.slope;
        write!(f, "{exponent:.3} ± {:.3} ({points} points)", self.tolerance)
    }
}
