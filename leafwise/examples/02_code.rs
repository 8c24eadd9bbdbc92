//! A system written in Rust, without a scene: names, brackets, a Hamiltonian, and `automatic`.
//!
//! Formulas are sums, products and functions of quantities, exact as in a scene. `automatic` is the
//! method of `realization = "auto"`: here the closed form of a log-canonical tensor.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::core::diagnostics::measure_drift;
use leafwise::core::system::SystemInvariants;
use leafwise::prelude::*;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut species = SystemBuilder::new();
    let [x, y] = species.variables(["x", "y"]);
    let [a, b] = species.parameters([("a", 1.0), ("b", 0.5)]);
    species.bracket(x, y, x * y);
    species.hamiltonian(x + y - a * x.ln() - b * y.ln());
    let system = species.build()?;

    let method = Registry::with_builtin().automatic(&system, 4)?;
    println!("{}", method.realization().describe());
    let parameters = system.parameter_values();
    let mut walk = Walk::of(&method, &system, &[1.5, 0.8], 0.1);
    let energy = SystemInvariants::new(&system, &parameters)?;
    let drift = measure_drift(&mut walk, energy, 1000)?;
    println!(
        "H = {:.6}, off by at most {:.1e}",
        drift[0].initial, drift[0].largest
    );
    assert!(drift[0].largest < 1e-6);
    assert!(walk.state().iter().all(|x| *x > 0.0), "species stay alive");
    Ok(())
}
