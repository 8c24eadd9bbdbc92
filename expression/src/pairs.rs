//! Pairs of functions that are computed at once.

use crate::analytic::{AnalyticFunction, FunctionPair, Member, Slope};
use crate::elementary;

/// Sine and cosine.
pub static SINE_AND_COSINE: FunctionPair = FunctionPair {
    names: ["sin", "cos"],
    values: elementary::sin_cos,
    lanes: elementary::sin_cos_lanes,
    lanes_alone: [elementary::sin_lanes, elementary::cos_lanes],
    near_zero: None,
};

/// eᶻ − 1 and e⁻ᶻ − 1.
pub static EXPONENTIALS: FunctionPair = FunctionPair {
    names: ["expm1", "expm1-mirrored"],
    values: elementary::exp_m1_mirrored,
    lanes: elementary::exp_m1_mirrored_lanes,
    lanes_alone: [
        elementary::exp_m1_lanes,
        elementary::exp_m1_of_negative_lanes,
    ],
    near_zero: Some(elementary::exp_m1_mirrored_near_zero),
};

/// f(z) = eᶻ − 1 without cancellation, f′ = 1 + f.
pub const EXPONENTIAL_MINUS_1: AnalyticFunction =
    AnalyticFunction::of_pair(&EXPONENTIALS, Member::First, || Slope {
        constant: 1,
        factor: 1,
        of: EXPONENTIAL_MINUS_1,
    });

/// g(z) = e⁻ᶻ − 1 without cancellation, g′ = −1 − g.
pub const EXPONENTIAL_MINUS_1_MIRRORED: AnalyticFunction =
    AnalyticFunction::of_pair(&EXPONENTIALS, Member::Second, || Slope {
        constant: -1,
        factor: -1,
        of: EXPONENTIAL_MINUS_1_MIRRORED,
    });

/// sin θ and 1 − cos θ.
pub static TURN: FunctionPair = FunctionPair {
    names: ["sine", "versine"],
    values: elementary::sin_and_versine,
    lanes: elementary::sin_and_versine_lanes,
    lanes_alone: [elementary::sine_lanes, elementary::versine_lanes],
    near_zero: Some(elementary::sin_and_versine_near_zero),
};

/// sin θ, whose derivative is 1 less the versine.
pub const SINE: AnalyticFunction = AnalyticFunction::of_pair(&TURN, Member::First, || Slope {
    constant: 1,
    factor: -1,
    of: VERSINE,
});

/// 1 − cos θ without cancellation, whose derivative is the sine.
pub const VERSINE: AnalyticFunction = AnalyticFunction::of_pair(&TURN, Member::Second, || Slope {
    constant: 0,
    factor: 1,
    of: SINE,
});

#[cfg(test)]
mod tests {
    use super::{EXPONENTIAL_MINUS_1, EXPONENTIAL_MINUS_1_MIRRORED, SINE, VERSINE};
    use crate::graph::{Graph, Term};
    use crate::kernel::Kernel;

    /// f⁽ᵏ⁾ for k up to 3 as code and as numbers against `libm`, a few ulps of the larger of the value and of 1 (the
    /// slopes add 1); the code of a pair and all its derivatives calls two functions.
    #[test]
    fn derivatives_are_expressed_by_the_pair_itself() {
        type Derivatives = fn(u32, f64) -> f64;
        let exact: [(_, Derivatives); 4] = [
            (EXPONENTIAL_MINUS_1, |k, z| match k {
                0 => libm::expm1(z),
                _ => libm::exp(z),
            }),
            (EXPONENTIAL_MINUS_1_MIRRORED, |k, z| match k {
                0 => libm::expm1(-z),
                _ if k % 2 == 0 => libm::exp(-z),
                _ => -libm::exp(-z),
            }),
            (SINE, |k, z| match k % 4 {
                0 => libm::sin(z),
                1 => libm::cos(z),
                2 => -libm::sin(z),
                _ => -libm::cos(z),
            }),
            (VERSINE, |k, z| match k % 4 {
                0 => 2.0 * libm::sin(0.5 * z) * libm::sin(0.5 * z),
                1 => libm::sin(z),
                2 => libm::cos(z),
                _ => -libm::sin(z),
            }),
        ];
        for pair in exact.chunks(2) {
            let mut graph = Graph::new();
            let x = graph.input(0);
            let mut outputs: Vec<Term> = Vec::new();
            for (function, _) in pair {
                let mut derivative = graph.apply_analytic(*function, 0, &x);
                for _ in 0..4 {
                    outputs.push(derivative.clone());
                    derivative = graph.derivative(&derivative, 0).expect("code");
                }
            }
            let kernel = Kernel::compile(&graph, &outputs, 0, 1);
            assert_eq!(kernel.step_operations().functions, 2);
            let mut workspace = kernel.workspace(1);
            kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
            for z in [-3.0, -0.4, 0.0, 1e-9, 0.2, 0.9, 2.5, 6.0] {
                let mut values = [0.0; 8];
                kernel.evaluate(&mut workspace, &[z], &mut values);
                for (at, value) in values.iter().enumerate() {
                    let ((function, exact), order) = (pair[at / 4], at as u32 % 4);
                    let number = function.derivative(order, z);
                    let mut lanes = [z; 5];
                    function.derivative_lanes(order, &mut lanes);
                    assert_eq!(lanes.map(f64::to_bits), [number.to_bits(); 5]);
                    let size = exact(order, z).abs();
                    let tolerance = f64::EPSILON
                        * if order == 0 {
                            2.0 * size
                        } else {
                            2.0 * size + 2.0
                        };
                    for found in [*value, number] {
                        let error = (found - exact(order, z)).abs();
                        assert!(error <= tolerance, "{function:?}^({order})({z}): {error:e}");
                    }
                }
            }
        }
    }
}
