//! A system from the text of a scene: parse it, compose it, step it.
//!
//! The text is what a scene file holds; `compose` builds the system and the method that it names.
//! Over an exact realization a step is a Poisson map, so the Casimir stays where it is to round-off.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::prelude::*;

const SCENE: &str = r#"
    [system]
    variables   = ["x1", "x2", "x3"]
    parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1.25 }
    bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
    hamiltonian = "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"
    casimirs    = { spin = "x1^2 + x2^2 + x3^2" }
    [method]
    realization = "auto"
    dynamics    = { name = "hamilton-jacobi", order = 4 }
    time-step   = 0.1
    [run]
    initial = [1, 3, 3]
    steps   = 1000
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("rigid body", SCENE, &registry)?;
    let run = compose(&document, &registry)?;
    for (label, description) in run.method.parts(run.system.motion()) {
        println!("{label}: {description}");
    }

    let mut walk = run.walk();
    walk.advance(run.plan.steps)?;
    let x = walk.state();
    let spin: f64 = x.iter().map(|x| x * x).sum();
    println!("t = {:.0}: x = {x:.6?}, |x|² = {spin}", walk.time());
    assert!((spin - 19.0).abs() < 1e-13 * 19.0);
    Ok(())
}
