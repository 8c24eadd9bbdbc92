//! The equilibrium of a damped spin in a bath: Gibbs's measure, without samples and with them.

use std::sync::Arc;

use leafwise::core::Walk;
use leafwise::core::diagnostics::fit_slope;
use leafwise::scene::ComposedRun;
use leafwise_tests::scenes::composed;
use nalgebra::{DMatrix, DVector};

use super::{Nodes, SPIN, START, gauss, hermite, moved, noisy, normals};

/// A damped spin in a bath, x = B/kT = 2 λB/σ² = 2.
fn bath(method: &str, step: f64) -> ComposedRun {
    let channels = ["x", "y", "z"]
        .map(|m| format!("{{ hamiltonian = \"{m}\", strength = \"sqrt(2*rate*kT)\" }}"));
    let spin = SPIN.replace("s = 0.5", "rate = 0.5, kT = 0.5");
    composed(&format!(
        "[system]\n{spin}\ndamping = {{ rate = \"rate\" }}\nnoise = [{}]\n[method]\n{method}\ntime-step = {step:?}\n[run]\n\
         initial = {START:?}\nsteps = 10\n",
        channels.join(", ")
    ))
}

/// coth x − 1/x at x = 2.
fn langevin() -> f64 {
    1.0 / libm::tanh(2.0) - 0.5
}

/// The degree of spherical harmonics that stand for functions on the sphere.
const DEGREE: usize = 10;

/// Real spherical harmonics of mean square 1, at a point of the unit sphere: 1, √3 z, and so on.
fn harmonics(point: &[f64]) -> Vec<f64> {
    let (x, y, z) = (point[0], point[1], point[2]);
    let mut values = Vec::new();
    // (x + iy)^m, and (2m − 1)!!.
    let (mut real, mut imaginary, mut odd) = (1.0, 0.0, 1.0);
    for m in 0..=DEGREE {
        // d^m P_l/dz^m for l = m, m + 1, ….
        let (mut before, mut slope) = (0.0, odd);
        // (l − m)!/(l + m)!.
        let mut ratio = (1..=2 * m).fold(1.0, |ratio, k| ratio / k as f64);
        for l in m..=DEGREE {
            let (n, of) = (l as f64, m as f64);
            let size = libm::sqrt((2.0 * n + 1.0) * ratio * if m == 0 { 1.0 } else { 2.0 });
            values.push(size * slope * real);
            if m > 0 {
                values.push(size * slope * imaginary);
            }
            let next = ((2.0 * n + 1.0) * z * slope - (n + of) * before) / (n - of + 1.0);
            (before, slope) = (slope, next);
            ratio *= (n - of + 1.0) / (n + of + 1.0);
        }
        (real, imaginary) = (real * x - imaginary * y, real * y + imaginary * x);
        odd *= 2.0 * m as f64 + 1.0;
    }
    values
}

/// The mean of m_z under the measure that steps leave as it is: with E[Y_a(m_1)] = Σ_b A_ab Y_b(m_0), the means μ_a of the
/// harmonics obey μ_a = Σ_b A_ab μ_b and μ_0 = 1.
fn equilibrium(method: &str, step: f64) -> f64 {
    let run = bath(method, step);
    let nodes = Arc::new(Nodes {
        rule: hermite(6),
        channels: 3,
    });
    let map = noisy(&run).with_normals(normals(&nodes));
    let count = (DEGREE + 1) * (DEGREE + 1);
    let mut a = DMatrix::zeros(count, count);
    let turns = 2 * DEGREE + 2;
    for (z, weight) in gauss(DEGREE + 1, |k| k / libm::sqrt(4.0 * k * k - 1.0)) {
        for turn in 0..turns {
            let angle = 2.0 * std::f64::consts::PI * (turn as f64 + 0.5) / turns as f64;
            let across = libm::sqrt(1.0 - z * z);
            let from = [across * libm::cos(angle), across * libm::sin(angle), z];
            let states = moved(&run, &map, nodes.members(), (&from, 1));
            let mut means = DVector::zeros(count);
            for (member, m) in states.iter().enumerate() {
                let there = DVector::from_vec(harmonics(m));
                means.axpy(nodes.weight(member as u64), &there, 1.0);
            }
            let here = DVector::from_vec(harmonics(&from));
            a.ger(weight / turns as f64, &means, &here, 1.0);
        }
    }
    let inner = DMatrix::identity(count - 1, count - 1) - a.view((1, 1), (count - 1, count - 1));
    let given = a.view((1, 0), (count - 1, 1)).into_owned();
    let means = inner.lu().solve(&given).expect("one equilibrium");
    means[0] / libm::sqrt(3.0)
}

/// Steps x_1 − x_0 = ω × y with ω = t (B + λ y × B) + σΔW have the probability of their reverse times e^{−ΔH/kT}: where H is
/// linear the joint step leaves Gibbs's measure as it is, whatever the step, to the quadrature's error.
#[test]
fn the_joint_step_of_a_spin_in_a_field_is_in_detailed_balance() {
    let bias = equilibrium("realization = \"so3-exponential\"", 0.3) - langevin();
    println!("joint, hB = 0.3: bias {bias:e}");
    assert!(bias.abs() < 1e-7, "{bias:e}");
}

/// Without a sample.
#[test]
fn the_bias_of_equilibrium_is_of_second_order_where_noise_is_split() {
    let method = "realization = \"so3-exponential\"\nnoise = \"split\"";
    let bias = |h: f64| (h, (equilibrium(method, h) - langevin()).abs());
    let points = [0.3, 0.15, 0.075].map(bias);
    let slope = fit_slope(&points, 1e-7).expect("biases above the quadrature's error");
    println!("split: order {:.3} {points:?}", slope.exponent);
    assert!((slope.exponent - 2.0).abs() < 0.15, "{slope:?} {points:?}");
}

/// The density of m_z is e^{x m_z}, its mean coth x − 1/x, here within three standard errors of 2048 members' time averages, a
/// million samples, at hB = 0.3.
#[test]
fn a_damped_spin_reaches_equilibrium() {
    let run = bath("realization = \"so3-exponential\"", 0.3);
    let lanes = 2048;
    let each =
        |values: &[f64]| -> Vec<f64> { values.iter().flat_map(|v| vec![*v; lanes]).collect() };
    let (parameters, initial) = (each(&run.system.parameter_values()), each(&START));
    let mut all = Walk::side_by_side(run.method.map(), lanes, (&parameters, &initial), 1.0, 0.3);
    let mut sums = vec![0.0; lanes];
    for step in 0..540 {
        all.step().expect("a step");
        if step >= 50 {
            let z = &all.state()[2 * lanes..];
            sums.iter_mut()
                .zip(z)
                .for_each(|(sum, z)| *sum += z / 490.0);
        }
    }
    let (mean, exact) = (sums.iter().sum::<f64>() / lanes as f64, langevin());
    let squares: f64 = sums.iter().map(|m| (m - mean) * (m - mean)).sum();
    let error = libm::sqrt(squares) / lanes as f64;
    println!("<m_z> = {mean} +- {error}, coth x - 1/x = {exact}");
    assert!(
        (mean - exact).abs() < 3.0 * error,
        "{mean} ± {error} for {exact}"
    );
}
