//! Property tests of an exact realization, ready to be called by the author of a new one.
//!
//! [`assert_dual_pair`], [`assert_poisson_steps`] and [`assert_orders`] are what every exact
//! realization keeps; the functions below them measure one identity at one point.

use std::ops::Range;
use std::sync::Arc;

use leafwise_core::diagnostics::RealizationInstrument;
use leafwise_core::{Ends, PoissonSystem, RealizationData, StepError, realization_evaluator};

use nalgebra::DMatrix;
use proptest::collection::vec;
use proptest::proptest;

use crate::methods::hamilton_jacobi;
use crate::numbers::{UNIT_ROUNDOFF, distance, largest};
use crate::orders::of_even_order;
use crate::structure::structure_error;

/// Asserts that α is a Poisson map and β an anti-Poisson map for επ, that they commute, that
/// β(x, p) = α(x, −p) and that both are x on the section, at random (x, p, ε).
///
/// The brackets may err by 10⁻¹³ of their largest summand, the ends by `roundings` of the state's.
///
/// # Panics
/// Where one of them fails, with the smallest such point.
pub fn assert_dual_pair(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    (x, p, epsilon): (Range<f64>, Range<f64>, Range<f64>),
    roundings: f64,
) {
    let d = system.dimension();
    proptest!(|(x in vec(x, d), p in vec(p, d), epsilon in epsilon)| {
        let error = dual_pair_error(system, realization, epsilon, &x, &p).expect("maps");
        assert!(error <= 1e-13, "the brackets of α and β: {error:e}");
        let ends = inversion_and_section_error(system, realization.as_ref(), epsilon, &x, &p);
        let error = ends.expect("maps") / UNIT_ROUNDOFF;
        assert!(error <= roundings, "β(x, p), α(x, -p) and the section: {error} roundings");
    });
}

/// Asserts that one step of `hamilton-jacobi` of order 2, 4, 6 or 8 is a Poisson map and keeps every
/// Casimir of the system, to 64 of the roundings that [`structure_error`] counts, at random x.
///
/// # Panics
/// Where it is not, with the smallest such point.
pub fn assert_poisson_steps(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    x: Range<f64>,
    time_step: f64,
) {
    let maps = [2, 4, 6, 8].map(|m| hamilton_jacobi(system, realization, m));
    proptest!(|(x in vec(x, system.dimension()), at in 0..maps.len())| {
        let error = structure_error(system, &maps[at], time_step, &x).expect("a step");
        let is_kept = error.tensor <= 64.0 && error.casimirs <= 64.0;
        assert!(is_kept, "{error:?}");
    });
}

/// Asserts that `hamilton-jacobi` of each order m has that order over the realization: the error
/// after `time` for each number of steps, of which those that fall below 10⁻¹³ of the state are dropped.
///
/// # Panics
/// Where a measured order is not m, or the points left do not tell it from its neighbours.
pub fn assert_orders(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    (initial, time): (&[f64], f64),
    orders: &[(usize, [usize; 4])],
) {
    for (m, steps) in orders {
        let map = hamilton_jacobi(system, realization, *m);
        let found = of_even_order(system, &map, initial, time, steps)
            .unwrap_or_else(|| panic!("m = {m}: too few errors above round-off"));
        assert!(found.is(*m as f64, 2.0), "m = {m}: measured {found}");
    }
}

/// The base x, β − x and α − β at a point of S, by the realization's code or numbers: see [`Ends`].
///
/// # Errors
/// The realization's [`StepError`].
///
/// # Panics
/// When it offers neither.
pub fn ends(
    system: &PoissonSystem,
    realization: &dyn RealizationData,
    epsilon: f64,
    z: &[f64],
) -> Result<Vec<f64>, StepError> {
    let mut evaluator = realization_evaluator(realization, &system.parameter_values(), epsilon)
        .expect("maps of some kind");
    let mut ends = vec![0.0; 3 * system.dimension()];
    evaluator.values(z, &mut ends)?;
    Ok(ends)
}

/// α and β at (x, p).
///
/// # Errors
/// The realization's [`StepError`].
pub fn source_and_target(
    system: &PoissonSystem,
    realization: &dyn RealizationData,
    epsilon: f64,
    x: &[f64],
    p: &[f64],
) -> Result<(Vec<f64>, Vec<f64>), StepError> {
    let ends = ends(system, realization, epsilon, &[x, p].concat())?;
    let ends = Ends::of(&ends);
    Ok((0..x.len())
        .map(|i| (ends.source(i), ends.target(i)))
        .unzip())
}

/// The largest of ε Π(α) − {α, α}, ε Π(β) + {β, β} and {α, β} over the largest summand of the
/// brackets, Σ_k |∂f/∂x^k| |∂g/∂p_k|.
///
/// # Errors
/// The realization's [`StepError`].
///
/// # Panics
/// When the realization has no maps on T*M.
pub fn dual_pair_error(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    epsilon: f64,
    x: &[f64],
    p: &[f64],
) -> Result<f64, StepError> {
    let parameters = system.parameter_values();
    let mut instrument =
        RealizationInstrument::new(system, realization, &parameters).expect("maps on T*M");
    let error = instrument.measure(epsilon, x, p)?;
    let mut evaluator =
        realization_evaluator(realization.as_ref(), &parameters, epsilon).expect("maps");
    let d = x.len();
    let mut tangents = vec![0.0; 4 * d * d];
    evaluator.jacobians(&[x, p].concat(), &mut tangents)?;
    let (target, increment) = tangents.split_at(2 * d * d);
    let target = DMatrix::from_row_slice(d, 2 * d, target);
    let source = &target + DMatrix::from_row_slice(d, 2 * d, increment);
    let summands = [&source, &target].map(|map| {
        let map = map.abs();
        (map.columns(0, d) * map.columns(d, d).transpose()).max()
    });
    let scale = largest(summands).max(error.scale);
    Ok(largest([error.source, error.target, error.dual_pair]) / scale)
}

/// The larger of |β(x, p) − α(x, −p)| and |α(σ(x)) − x|, |β(σ(x)) − x| over the size of x.
///
/// # Errors
/// The realization's [`StepError`].
pub fn inversion_and_section_error(
    system: &PoissonSystem,
    realization: &dyn RealizationData,
    epsilon: f64,
    x: &[f64],
    p: &[f64],
) -> Result<f64, StepError> {
    let minus: Vec<f64> = p.iter().map(|p| -p).collect();
    let (alpha, beta) = source_and_target(system, realization, epsilon, x, p)?;
    let (source, target) = source_and_target(system, realization, epsilon, x, &minus)?;
    let mut z = vec![f64::NAN; realization.space_dimension()];
    realization.section(x, &mut z);
    let fixed = ends(system, realization, epsilon, &z)?;
    let size = largest(alpha.iter().chain(&beta).chain(x).copied());
    let fixed = Ends::of(&fixed);
    let section = fixed.base.iter().zip(x).map(|(b, x)| b - x);
    let section = section.chain(fixed.offset.iter().chain(fixed.increment).copied());
    let inversion = distance(&beta, &source).max(distance(&alpha, &target));
    Ok(largest(section).max(inversion) / size)
}
