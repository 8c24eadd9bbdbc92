//! l·S_l = [h^{l−1}] H(α(x, Σ_{k<l} hᵏ dS_k)).

use leafwise_core::dynamics::{Generating, GeneratingCode, GeneratingFunction};
use leafwise_core::realization::{SourceRecursion, SourceSeries};
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::series::{Tape, TaylorState};
use leafwise_expression::{
    AlgebraError, Arithmetic, DifferentialAlgebra, Graph, Polynomial, Rational, Ring,
};

/// The part's name.
pub(crate) const NAME: &str = "hamilton-jacobi";

/// Ŝ with S_1, S_3, …, S_{m−1} at ε = 1 for an even order m (paper, section 4.2), expanded. Even
/// coefficients vanish by Proposition 1 and are not formed.
///
/// # Errors
/// [`BuildError::Algebra`] where the tensor or the Hamiltonian is outside the exact algebra,
/// [`BuildError::NotOffered`] for a system of numbers.
pub fn generating_function(
    system: &PoissonSystem,
    series: &SourceSeries<'_>,
    order: usize,
) -> Result<GeneratingFunction, BuildError> {
    let mut ring = Ring::new(system.dimension());
    let source = (series.in_ring)(&mut ring, &coordinates(system))?;
    let (coefficients, gradients) = odd_coefficients(system, source, order, &mut ring)?;
    Ok(GeneratingFunction {
        ring,
        coefficients,
        gradients,
    })
}

/// The same, unless it takes more than `products` products of terms: then `None`.
///
/// # Errors
/// Those of [`generating_function`].
pub fn within(
    system: &PoissonSystem,
    series: &SourceSeries<'_>,
    order: usize,
    products: u64,
) -> Result<Option<GeneratingFunction>, BuildError> {
    let mut ring = Ring::limited(system.dimension(), products);
    let source = (series.in_ring)(&mut ring, &coordinates(system));
    let formed = source.and_then(|source| odd_coefficients(system, source, order, &mut ring));
    if ring.refusal().is_some() {
        return Ok(None);
    }
    let (coefficients, gradients) = formed?;
    Ok(Some(GeneratingFunction {
        ring,
        coefficients,
        gradients,
    }))
}

/// The same as straight-line code.
///
/// # Errors
/// Those of [`generating_function`].
pub fn generating_code(
    system: &PoissonSystem,
    series: &SourceSeries<'_>,
    order: usize,
) -> Result<GeneratingCode, BuildError> {
    let mut graph = Graph::limited(MOST_NODES);
    let source = (series.in_graph)(&mut graph, &coordinates(system))?;
    let (coefficients, gradients) = odd_coefficients(system, source, order, &mut graph)?;
    Ok(GeneratingCode {
        graph,
        coefficients,
        gradients,
    })
}

/// Operations of the longest series that is taken. A step of it takes milliseconds.
const MOST_NODES: usize = 1 << 18;

/// Those of a system, one after the other.
fn coordinates(system: &PoissonSystem) -> Vec<usize> {
    (0..system.dimension()).collect()
}

/// S_l and dS_l for odd l < m.
type Coefficients<E> = (Vec<E>, Vec<Vec<E>>);

fn odd_coefficients<A: DifferentialAlgebra>(
    system: &PoissonSystem,
    source: SourceRecursion<A>,
    order: usize,
    algebra: &mut A,
) -> Result<Coefficients<A::Element>, BuildError> {
    let d = system.dimension();
    let (mut coefficients, mut gradients) = (Vec::new(), Vec::new());
    let last = order.saturating_sub(1);
    for_each_coefficient(system, source, last, algebra, |algebra, l, s| {
        if l % 2 == 0 {
            return Ok(None);
        }
        let gradient = algebra.differential(&s, d)?;
        coefficients.push(s);
        gradients.push(gradient.clone());
        Ok(Some(gradient))
    })?;
    Ok((coefficients, gradients))
}

/// S_1 = H, which is the same in every chart.
///
/// # Errors
/// [`BuildError::Algebra`] where the Hamiltonian is outside the exact algebra,
/// [`BuildError::NotOffered`] for a system of numbers.
pub fn first_order(system: &PoissonSystem) -> Result<Generating, BuildError> {
    let system = system.formulas(NAME)?;
    let mut ring = Ring::new(system.dimension());
    let (coefficients, gradients) = energy(system, &mut ring)?;
    let function = GeneratingFunction {
        ring,
        coefficients,
        gradients,
    };
    let mut graph = Graph::limited(MOST_NODES);
    let (coefficients, gradients) = energy(system, &mut graph)?;
    let code = GeneratingCode {
        graph,
        coefficients,
        gradients,
    };
    Ok(if function.rounds_as(&code, system)? {
        Generating::Polynomials(function)
    } else {
        Generating::Code(code)
    })
}

/// H and dH.
fn energy<A: DifferentialAlgebra>(
    system: &SystemFormulas,
    algebra: &mut A,
) -> Result<Coefficients<A::Element>, BuildError> {
    let s = system
        .hamiltonian()
        .evaluate_in(algebra, &mut |algebra, at| Ok(algebra.coordinate(at)))?;
    let gradient = algebra.differential(&s, system.dimension())?;
    Ok((vec![s], vec![gradient]))
}

/// Every S_l up to `last`, the even ones too. The identity S_{2j} = 0 (Proposition 1) holds for any chart with
/// inv(x, p) = (x, −p) and tests the whole chain.
///
/// # Errors
/// Those of [`generating_function`].
pub fn all_coefficients(
    system: &PoissonSystem,
    series: &SourceSeries<'_>,
    last: usize,
) -> Result<(Ring, Vec<Polynomial>), BuildError> {
    let mut ring = Ring::new(system.dimension());
    let mut all = Vec::new();
    let source = (series.in_ring)(&mut ring, &coordinates(system))?;
    for_each_coefficient(system, source, last, &mut ring, |ring, _, s| {
        let gradient = ring.gradient(&s)?;
        all.push(s);
        Ok(Some(gradient))
    })?;
    Ok((ring, all))
}

/// Runs the recursion; `take(algebra, l, S_l)` returns dS_l, or `None` for 0.
fn for_each_coefficient<A: DifferentialAlgebra>(
    system: &PoissonSystem,
    mut source: SourceRecursion<A>,
    last: usize,
    algebra: &mut A,
    mut take: impl FnMut(&mut A, usize, A::Element) -> Result<Option<Vec<A::Element>>, BuildError>,
) -> Result<(), BuildError> {
    let system = system.formulas(NAME)?;
    let d = system.dimension();
    // What grows past a limit says at which order it does.
    let too_long = |l: usize| {
        move |error: AlgebraError| match error {
            AlgebraError::ExpansionTooLong
            | AlgebraError::CodeTooLong { .. }
            | AlgebraError::NumberTooLong => BuildError::NotMade {
                part: NAME,
                reason: format!(
                    "the coefficient S_{l} of its series grows too long ({error}): take order {} or \
                     less, and a composition such as suzuki-umeno-8 for a higher one",
                    l.saturating_sub(1).max(1).next_multiple_of(2)
                ),
            },
            other => other.into(),
        }
    };
    let mut tape = Tape::new();
    let energy = tape.record(system.hamiltonian())?;
    let mut state = TaylorState::new(&tape);
    let mut alpha: Vec<A::Element> = (0..d).map(|i| algebra.coordinate(i)).collect();
    for l in 1..=last {
        let extended = state.extend(&tape, algebra, |_, i| alpha[i].clone());
        extended.map_err(too_long(l))?;
        let s = algebra.scale(
            &Rational::new(1, l as i64),
            state.coefficient(energy, l - 1),
        );
        let gradient = match take(algebra, l, s)? {
            Some(gradient) => gradient,
            None => vec![algebra.zero(); d],
        };
        if let Some(refusal) = algebra.refusal() {
            return Err(too_long(l)(refusal.clone()));
        }
        if l < last {
            alpha = source(algebra, gradient)?;
        }
    }
    Ok(())
}
