//! Very many steps: is the drift of a Casimir a random walk?

use leafwise_core::Walk;

use super::case::{Case, Outcome, StressError, StressOptions};
use super::setup::method;
use crate::verify::Problem;

pub(super) const CASES: [Case; 2] = [
    Case {
        family: "long",
        name: "paper",
        asked: "the Casimir |x|^2 of the rigid body over 10^6 steps (--long: 10^8) of the paper's \
                method, n = 6, m = 2, t = 0.2",
        expected: "below 1e-12 relative, and growing like a random walk, steps^(1/2): exponent \
                   below 0.75, where a drift of one sign has 1",
        run: paper,
    },
    Case {
        family: "long",
        name: "order-8",
        asked: "the same with n = 10, m = 8, t = 0.1",
        expected: "the same: below 1e-12, exponent below 0.75",
        run: order_eight,
    },
];

fn paper(options: &StressOptions) -> Result<Outcome, StressError> {
    measure(options.steps, 6, 2, 0.2)
}

fn order_eight(options: &StressOptions) -> Result<Outcome, StressError> {
    measure(options.steps, 10, 8, 0.1)
}

/// Samples of the Casimir along the orbit.
const SAMPLES: u64 = 1 << 14;

/// The relative drift below which a run of any length has to stay.
const LARGEST: f64 = 1e-12;

/// Between the exponents of a random walk and of a drift of one sign.
const LARGEST_EXPONENT: f64 = 0.75;

fn measure(steps: u64, n: i64, m: i64, t: f64) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("rigid-body")?;
    let parameters = problem.system.parameter_values();
    let method = method(&problem.system, n, m)?;
    let mut walk = Walk::new(&method, &parameters, 1.0, t, &problem.initial);
    // What the state holds beyond a double counts: the sum of squares alone is rounded to 3e-16.
    let start: f64 = problem.initial.iter().map(|x| x * x).sum();
    let casimir = |walk: &Walk| -> f64 {
        let (x, low) = (walk.state(), walk.compensation());
        x.iter()
            .zip(low)
            .map(|(x, low)| x * x + 2.0 * x * low)
            .sum()
    };
    let every = steps.div_ceil(SAMPLES).max(1);
    let mut samples = vec![0.0];
    let mut largest = 0.0_f64;
    walk.watch(steps, |walk| {
        let drift = (casimir(walk) - start) / start;
        largest = if drift.abs() <= largest {
            largest
        } else {
            drift.abs()
        };
        if walk.steps() % every == 0 {
            samples.push(drift);
        }
    })?;
    let exponent = growth_exponent(&samples);
    Ok(Outcome {
        is_met: largest < LARGEST && exponent < LARGEST_EXPONENT,
        measured: format!(
            "{largest:.1e} relative after {steps} steps, growing like steps^{exponent:.2}"
        ),
    })
}

/// Exponent H in √⟨(C_{k+τ} − C_k)²⟩ ∝ τ^H, fitted over τ = 16, 32, … up to a sixteenth of the samples. At that largest
/// τ sixteen windows are independent, and the root of the mean is known within 18 %.
fn growth_exponent(samples: &[f64]) -> f64 {
    let lags = (4..).map(|k| 1_usize << k);
    let points: Vec<(f64, f64)> = lags
        .take_while(|lag| 16 * lag < samples.len())
        .map(|lag| {
            let pairs = samples.iter().zip(&samples[lag..]);
            let count = (samples.len() - lag) as f64;
            let square: f64 = pairs.map(|(a, b)| (b - a) * (b - a)).sum();
            (libm::log(lag as f64), libm::log(libm::sqrt(square / count)))
        })
        .collect();
    let count = points.len() as f64;
    let x = points.iter().map(|p| p.0).sum::<f64>() / count;
    let y = points.iter().map(|p| p.1).sum::<f64>() / count;
    let (above, below) = points.iter().fold((0.0, 0.0), |(above, below), p| {
        (above + (p.0 - x) * (p.1 - y), below + (p.0 - x) * (p.0 - x))
    });
    above / below
}

#[cfg(test)]
mod tests {
    use super::growth_exponent;

    #[test]
    fn a_drift_has_exponent_1_and_a_random_walk_a_half() {
        let drift: Vec<f64> = (0..4096).map(f64::from).collect();
        assert!((growth_exponent(&drift) - 1.0).abs() < 1e-9);
        // Steps of ±1 from a linear congruential generator.
        let mut seed = 1_u64;
        let mut at = 0.0;
        let walk: Vec<f64> = (0..16384)
            .map(|_| {
                seed = seed
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                at += if seed >> 63 == 1 { 1.0 } else { -1.0 };
                at
            })
            .collect();
        assert!(
            (growth_exponent(&walk) - 0.5).abs() < 0.15,
            "{}",
            growth_exponent(&walk)
        );
    }
}
