//! The example realization is exact: α Poisson, β anti-Poisson, {α_i, β_j} = 0.

use leafwise_example_plugin::Rodrigues;
use leafwise_plugin_sdk::{ChartRealization, Realization};
use proptest::prelude::*;

/// {f_i, g_j}_ω = Σ_k ∂f_i/∂x_k ∂g_j/∂p_k − ∂f_i/∂p_k ∂g_j/∂x_k, and the sum of its terms' sizes.
fn bracket(f: &[f64], g: &[f64], i: usize, j: usize) -> (f64, f64) {
    let (mut value, mut size) = (0.0, 0.0);
    for k in 0..3 {
        for term in [
            f[i * 6 + k] * g[j * 6 + 3 + k],
            -f[i * 6 + 3 + k] * g[j * 6 + k],
        ] {
            value += term;
            size += term.abs();
        }
    }
    (value, size)
}

/// Π_ij(y) of so(3)*: {x1, x2} = −x3 and cyclic.
fn tensor(y: &[f64], i: usize, j: usize) -> f64 {
    match (3 + j - i) % 3 {
        1 => -y[(i + 2) % 3],
        2 => y[(i + 1) % 3],
        _ => 0.0,
    }
}

proptest! {
    #[test]
    fn alpha_is_poisson_beta_anti_poisson_and_they_commute(
        z in prop::array::uniform6(-3.0..3.0_f64),
        epsilon in 0.01..1.0_f64,
    ) {
        let mut part = Rodrigues;
        let (mut even, mut odd) = ([0.0; 18], [0.0; 18]);
        part.jacobian(epsilon, &z[..3], &z[3..], &mut even, &mut odd).unwrap();
        let (mut d_alpha, mut d_beta) = ([0.0; 18], [0.0; 18]);
        for at in 0..18 {
            let one = f64::from(u8::from(at % 7 == 0));
            d_alpha[at] = one + even[at] + odd[at];
            d_beta[at] = one + even[at] - odd[at];
        }
        let (mut alpha, mut beta) = ([0.0; 3], [0.0; 3]);
        part.alpha(epsilon, &z, &mut alpha).unwrap();
        part.beta(epsilon, &z, &mut beta).unwrap();
        for i in 0..3 {
            for j in 0..3 {
                // Six products of entries that are themselves sums of a few products: below 64 u of
                // the sum of their sizes, and of those of the tensor.
                let (source, size) = bracket(&d_alpha, &d_alpha, i, j);
                let expected = epsilon * tensor(&alpha, i, j);
                let scale = size + 10.0 * epsilon * (1.0 + epsilon) * (1.0 + epsilon);
                prop_assert!((source - expected).abs() <= 32.0 * f64::EPSILON * scale);
                let (target, _) = bracket(&d_beta, &d_beta, i, j);
                let expected = -epsilon * tensor(&beta, i, j);
                prop_assert!((target - expected).abs() <= 32.0 * f64::EPSILON * scale);
                let (mixed, _) = bracket(&d_alpha, &d_beta, i, j);
                prop_assert!(mixed.abs() <= 32.0 * f64::EPSILON * scale);
            }
        }
    }

    #[test]
    fn the_ends_without_cancellation_are_the_ends(
        z in prop::array::uniform6(-3.0..3.0_f64),
        epsilon in 0.01..1.0_f64,
    ) {
        let mut part = Rodrigues;
        let (mut alpha, mut beta, mut ends) = ([0.0; 3], [0.0; 3], [0.0; 9]);
        part.alpha(epsilon, &z, &mut alpha).unwrap();
        part.beta(epsilon, &z, &mut beta).unwrap();
        part.ends(epsilon, &z, &mut ends).unwrap();
        // Sums of numbers below 3 + 9 + 27·¼: a few roundings each.
        let tolerance = 8.0 * f64::EPSILON * 20.0;
        for i in 0..3 {
            prop_assert!((ends[i] + ends[3 + i] - beta[i]).abs() <= tolerance);
            prop_assert!((ends[6 + i] - (alpha[i] - beta[i])).abs() <= tolerance);
        }
    }
}
