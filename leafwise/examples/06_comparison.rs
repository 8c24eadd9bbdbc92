//! Two methods compared: the order of each, measured, and what their energies do.
//!
//! Both are over the same exact realization; one takes the generating function to h², the other to
//! h⁴. Errors against a run of much smaller steps fall as h² and h⁴, and so do the energies' errors.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::core::diagnostics::{fit_slope, measure_drift};
use leafwise::core::system::SystemInvariants;
use leafwise::prelude::*;

fn end(method: &Method, h: f64, time: f64) -> Result<Vec<f64>, StepError> {
    let mut walk = Walk::new(method, &[], 1.0, h, &[1.0, 3.0, 3.0]);
    while walk.time() < time - h / 2.0 {
        walk.step()?;
    }
    Ok(walk.state().to_vec())
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut body = SystemBuilder::new();
    let [x, y, z] = body.variables(["x", "y", "z"]);
    body.bracket(x, y, -z);
    body.bracket(y, z, -x);
    body.bracket(z, x, -y);
    body.hamiltonian(x * x / 2 + y * y / 1.5 + z * z / 2.5);
    let system = body.build()?;

    let registry = Registry::with_builtin();
    let exact = end(&registry.automatic(&system, 8)?, 0.005, 1.0)?;
    let mut largest = Vec::new();
    for m in [2, 4] {
        let method = registry.automatic(&system, m)?;
        let mut errors = Vec::new();
        for h in [0.1, 0.05, 0.025, 0.0125] {
            let off = end(&method, h, 1.0)?
                .iter()
                .zip(&exact)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            errors.push((h, off));
        }
        let order = fit_slope(&errors, 1e-12)
            .ok_or("too few errors above round-off")?
            .exponent;
        let mut walk = Walk::new(&method, &[], 1.0, 0.1, &[1.0, 3.0, 3.0]);
        let drift = measure_drift(&mut walk, SystemInvariants::new(&system, &[])?, 1000)?[0];
        println!(
            "m = {m}: order {order:.2}, energy off by {:.1e} in 1000 steps",
            drift.largest
        );
        assert!((order - f64::from(m)).abs() < 0.3);
        largest.push(drift.largest);
    }
    assert!(largest[1] < largest[0] / 10.0);
    Ok(())
}
