//! Karasev's coefficients α_(0) … α_(n) at a point, exact and compiled.

use leafwise_core::PoissonSystem;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Rational, Ring, Term};
use leafwise_karasev::{KarasevCurve, TruncatedKarasev};

use crate::methods::evaluate;
use crate::numbers::largest;

/// The coefficients at a point given in exact numbers, one vector after the other, as constants of
/// a ring: numbers, or functions of the system's parameters.
///
/// # Panics
/// When the tensor is outside the algebra.
pub fn exact(
    system: &PoissonSystem,
    order: usize,
    x: &[Rational],
    p: &[Rational],
) -> (Ring, Vec<Polynomial>) {
    let mut ring = Ring::new(x.len());
    let mut constants =
        |values: &[Rational]| values.iter().map(|v| ring.constant(v)).collect::<Vec<_>>();
    let (x, p) = (constants(x), constants(p));
    let mut curve = KarasevCurve::new(system.expressions().expect("formulas"), &x)
        .expect("a tensor in the algebra");
    let zero = vec![Polynomial::zero(); p.len()];
    for k in 0..order {
        curve
            .push(&mut ring, if k == 0 { &p } else { &zero })
            .expect("a tensor in the algebra");
    }
    let coefficients = (0..=order)
        .flat_map(|k| curve.source(&mut ring, k))
        .collect();
    (ring, coefficients)
}

/// The same from the truncated realization's compiled code.
///
/// # Panics
/// When the order is 0 or the tensor has no code.
pub fn compiled(system: &PoissonSystem, order: usize, x: &[f64], p: &[f64]) -> Vec<f64> {
    let part = TruncatedKarasev::new(system, order).expect("an order above 0");
    let mut graph = Graph::new();
    let inputs: Vec<Term> = (0..x.len() + p.len()).map(|i| graph.input(i)).collect();
    let (code_x, code_p) = inputs.split_at(x.len());
    let code = part.coefficients(&mut graph, code_x, code_p).expect("code");
    evaluate(system, &graph, &code.concat(), &[x, p].concat())
}

/// The size against which round-off of the compiled α_(k) is judged, for exact coefficients of
/// dimension `d`: ‖x‖ vᵏ at the rate v = 2‖α_(1)‖/‖x‖ of Y′ = Π(Y)p.
///
/// At ε = 1/v the curve moves by the state's own size, more than a step ever should; there, the
/// error of α_(k) over this size is what round-off of order k takes from α̂, relative to the state.
/// Digits that a coefficient loses because its summands cancel do not count further than that.
pub fn natural_size(expected: &[f64], d: usize, k: usize) -> f64 {
    let size = |k: usize| largest(&expected[k * d..][..d]);
    size(0) * libm::pow(2.0 * size(1) / size(0), k as f64)
}
