//! The gradient of a function of a trajectory, by the initial state and the parameters: exact for the map that is stepped.
//!
//! A self-adjoint map is stepped back from the end of the run, so that nothing of it is kept.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::core::gradient::{GradientError, Plan, Trajectory};
use leafwise::prelude::*;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut pendulum = SystemBuilder::new();
    let [q, p] = pendulum.variables(["q", "p"]);
    let [g] = pendulum.parameters([("g", 1.0)]);
    pendulum.bracket(q, p, -1); // with ẋ = {H, x}: q̇ = p
    pendulum.hamiltonian(p * p / 2 - g * q.cos());
    let system = pendulum.build()?;
    let method = Registry::with_builtin().automatic(&system, 4)?;

    // The function is q at the end: its derivatives by the two samples, x_0 and x_1000, are (0, 0) and (1, 0).
    let plan = Plan {
        steps: 1000,
        every: 1000,
    };
    let cotangents = [0.0, 0.0, 1.0, 0.0];
    let along = |parameters: &[f64], initial: &[f64]| -> Result<_, GradientError> {
        let trajectory = Trajectory {
            map: &method,
            parameters,
            epsilon: 1.0,
            h: 0.02,
            goes_on: &|| true,
        };
        let reached = trajectory.run(initial, plan)?;
        let gradient = trajectory.pull(initial, &reached, &cotangents, plan, (true, None))?;
        Ok((reached.end(2).0[0], gradient))
    };
    let initial = [1.0, 0.3];
    let (_, gradient) = along(&[1.0], &initial)?;
    println!("by (q, p): {:?}", gradient.initial);
    println!("by g:      {:?}", gradient.parameters);
    println!("{}", gradient.growth);

    // The same by differences of two runs.
    let delta = 1e-5;
    let ends = [1.0 + delta, 1.0 - delta].map(|g| along(&[g], &initial).map(|(q, _)| q));
    let [above, below] = ends;
    let by_g = (above? - below?) / (2.0 * delta);
    assert!((gradient.parameters[0] / by_g - 1.0).abs() < 1e-6);
    Ok(())
}
