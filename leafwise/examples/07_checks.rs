//! Is a system what it says? The Jacobi identity and the Casimirs, checked from code.
//!
//! Where exact algebra decides, the verdict is a proof; elsewhere the identity is sampled.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::core::diagnostics::{Verdict, check_casimir, check_jacobi};
use leafwise::prelude::*;

/// A body whose bracket {x, y} is −z, and {z, x} = −y times `factor`.
fn body(factor: impl Into<Expression>) -> Result<PoissonSystem, Box<dyn std::error::Error>> {
    let mut body = SystemBuilder::new();
    let [x, y, z] = body.variables(["x", "y", "z"]);
    body.bracket(x, y, -z);
    body.bracket(y, z, -x);
    body.bracket(z, x, -y * factor.into());
    body.hamiltonian(x * x + 2 * y * y + 3 * z * z);
    body.casimir("spin", x * x + y * y + z * z);
    body.casimir("height", z);
    Ok(body.build()?)
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let near = [1.0, 3.0, 3.0];
    let system = body(1)?;
    let jacobi = check_jacobi(&system, &[], &near)?;
    println!("Jacobi identity: {:?}", jacobi.verdict);
    assert_eq!(jacobi.verdict, Verdict::Proved);

    for (index, expected) in [Verdict::Proved, Verdict::Violated].into_iter().enumerate() {
        let check = check_casimir(&system, index, &[], &near)?;
        println!("{}: {:?}", system.casimir_names()[index], check.verdict);
        assert_eq!(check.verdict, expected);
    }

    let wrong = body(Quantity::Variable(2).exp())?;
    let jacobi = check_jacobi(&wrong, &[], &near)?;
    println!(
        "with a factor e^z: {:?} for {:?}, by {:.2}",
        jacobi.verdict, jacobi.worst, jacobi.residual
    );
    assert_eq!(jacobi.verdict, Verdict::Violated);
    Ok(())
}
