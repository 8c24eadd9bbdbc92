//! l·S_l = [h^{l−1}] H(α(x, Σ_{k<l} hᵏ dS_k)).

use leafwise_core::dynamics::GeneratingFunction;
use leafwise_core::realization::SourceSeries;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::series::{Tape, TaylorState};
use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};

/// Ŝ with S_1, S_3, …, S_{m−1} at ε = 1 for an even order m (paper, section 4.2). Even
/// coefficients vanish by Proposition 1 and are not formed.
///
/// # Errors
/// [`BuildError::Algebra`] where the tensor or the Hamiltonian is outside the exact algebra,
/// [`BuildError::NotOffered`] for a system of numbers.
pub fn generating_function(
    system: &PoissonSystem,
    series: &dyn SourceSeries,
    order: usize,
) -> Result<GeneratingFunction, BuildError> {
    let mut ring = Ring::new(system.dimension());
    let mut coefficients = Vec::new();
    let mut gradients: Vec<Vec<Polynomial>> = Vec::new();
    for_each_coefficient(
        system,
        series,
        order.saturating_sub(1),
        &mut ring,
        |ring, l, s| {
            if l % 2 == 0 {
                return Ok(None);
            }
            let gradient = ring.gradient(&s)?;
            coefficients.push(s);
            gradients.push(gradient.clone());
            Ok(Some(gradient))
        },
    )?;
    Ok(GeneratingFunction {
        ring,
        coefficients,
        gradients,
    })
}

/// S_1 = H, which is the same in every chart.
///
/// # Errors
/// [`BuildError::Algebra`] where the Hamiltonian is outside the exact algebra,
/// [`BuildError::NotOffered`] for a system of numbers.
pub fn first_order(system: &PoissonSystem) -> Result<GeneratingFunction, BuildError> {
    let system = system.formulas(crate::register::INFO.name)?;
    let mut ring = Ring::new(system.dimension());
    let s = system
        .hamiltonian()
        .evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))?;
    let gradient = ring.gradient(&s)?;
    Ok(GeneratingFunction {
        ring,
        coefficients: vec![s],
        gradients: vec![gradient],
    })
}

/// Every S_l up to `last`, the even ones too: the identity S_{2j} = 0 (Proposition 1) holds for
/// any chart with inv(x, p) = (x, −p) and tests the whole chain.
///
/// # Errors
/// Those of [`generating_function`].
pub fn all_coefficients(
    system: &PoissonSystem,
    series: &dyn SourceSeries,
    last: usize,
) -> Result<(Ring, Vec<Polynomial>), BuildError> {
    let mut ring = Ring::new(system.dimension());
    let mut all = Vec::new();
    for_each_coefficient(system, series, last, &mut ring, |ring, _, s| {
        let gradient = ring.gradient(&s)?;
        all.push(s);
        Ok(Some(gradient))
    })?;
    Ok((ring, all))
}

/// Runs the recursion; `take(ring, l, S_l)` returns dS_l, or `None` for 0.
fn for_each_coefficient(
    system: &PoissonSystem,
    series: &dyn SourceSeries,
    last: usize,
    ring: &mut Ring,
    mut take: impl FnMut(&mut Ring, usize, Polynomial) -> Result<Option<Vec<Polynomial>>, BuildError>,
) -> Result<(), BuildError> {
    let system = system.formulas(crate::register::INFO.name)?;
    let d = system.dimension();
    let mut tape = Tape::new();
    let energy = tape.record(system.hamiltonian())?;
    let mut state = TaylorState::new(&tape);
    let mut source = series.start(ring)?;
    let mut alpha: Vec<Polynomial> = (0..d).map(|i| ring.variable(i)).collect();
    for l in 1..=last {
        state.extend(&tape, ring, |_, i| alpha[i].clone())?;
        let s = ring.scale(
            &Rational::new(1, l as i64),
            state.coefficient(energy, l - 1),
        );
        let gradient = take(ring, l, s)?.unwrap_or_else(|| vec![Polynomial::zero(); d]);
        if l < last {
            alpha = source.push(ring, gradient)?;
        }
    }
    Ok(())
}
