//! An observer of your own in the step loop: the period of a pendulum from its zero crossings.
//!
//! The loop is yours: look at the state after every step, and take what you need.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::prelude::*;

/// The arithmetic–geometric mean.
fn mean(a: f64, b: f64) -> f64 {
    (0..8)
        .fold((a, b), |(a, b), _| ((a + b) / 2.0, libm::sqrt(a * b)))
        .0
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut pendulum = SystemBuilder::new();
    let [q, p] = pendulum.variables(["q", "p"]);
    pendulum.bracket(q, p, -1); // with ẋ = {H, x}: q̇ = p
    pendulum.hamiltonian(p * p / 2 - q.cos());
    let system = pendulum.build()?;
    let method = Registry::with_builtin().automatic(&system, 4)?;

    let amplitude = 2.0;
    let mut walk = Walk::new(&method, &[], 1.0, 0.02, &[amplitude, 0.0]);
    let mut crossings = Vec::new();
    while crossings.len() < 11 {
        let (before, t) = (walk.state().to_vec(), walk.time());
        walk.step()?;
        let after = walk.state();
        if before[0] < 0.0 && after[0] >= 0.0 {
            // q is almost a straight line where it vanishes: q̈ = −sin q.
            crossings.push(t - before[0] / after[1].midpoint(before[1]));
        }
    }
    let period = (crossings[10] - crossings[0]) / 10.0;
    let exact = 2.0 * std::f64::consts::PI / mean(1.0, libm::cos(amplitude / 2.0));
    println!("period {period:.8}, exactly {exact:.8}");
    assert!((period - exact).abs() < 1e-6 * exact);
    Ok(())
}
