//! Systems from formulas, and runs.

use leafwise_core::system::{Casimir, Parameter};
use leafwise_core::{Convention, PoissonSystem, StepError, StepMap, Stepper};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};
pub use leafwise_tests::gauss::flow as gauss;
pub use leafwise_tests::methods::observe;
pub use leafwise_tests::numbers::{distance, largest};

/// A system in the paper's convention, {H, x}, or in the literature's, {x, H}.
pub fn system(
    variables: &[&str],
    parameters: &[(&str, f64)],
    bracket: &[(&str, &str, &str)],
    hamiltonian: &str,
    casimirs: &[&str],
    convention: Convention,
) -> PoissonSystem {
    let names: Vec<&str> = parameters.iter().map(|p| p.0).collect();
    let scope = Scope::new()
        .with_variables(variables)
        .with_parameters(&names);
    let resolve = |text: &str| -> Expression {
        let formula = Formula::parse(text).unwrap_or_else(|error| panic!("`{text}`: {error}"));
        formula
            .resolve(&scope, None)
            .unwrap_or_else(|error| panic!("`{text}`: {error}"))
            .expect("no free index, no boundary")
    };
    let at = |name: &str| {
        variables
            .iter()
            .position(|v| *v == name)
            .expect("a variable")
    };
    let entries = bracket.iter().map(|&(a, b, text)| {
        let (i, j) = (at(a), at(b));
        let entry = resolve(text);
        if i < j {
            ((i, j), entry)
        } else {
            ((j, i), Expression::Negate(Box::new(entry)))
        }
    });
    let casimirs = casimirs.iter().map(|text| Casimir {
        name: (*text).to_owned(),
        expression: resolve(text),
    });
    let parameters = parameters.iter().map(|&(name, value)| Parameter {
        name: name.to_owned(),
        value,
    });
    PoissonSystem::new(
        variables.iter().map(|v| (*v).to_owned()).collect(),
        parameters.collect(),
        entries.collect::<Vec<_>>(),
        resolve(hamiltonian),
        casimirs.collect(),
        convention,
    )
    .expect("a well-formed system")
}

/// The paper's rigid body (Example 1).
pub fn rigid_body() -> PoissonSystem {
    system(
        &["x1", "x2", "x3"],
        &[("I1", 1.0), ("I2", 0.75), ("I3", 1.25)],
        &[
            ("x1", "x2", "-x3"),
            ("x2", "x3", "-x1"),
            ("x3", "x1", "-x2"),
        ],
        "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)",
        &["x1^2 + x2^2 + x3^2"],
        Convention::HamiltonianFirst,
    )
}

/// One step of one lane from `x`.
pub fn step(stepper: &mut dyn Stepper, x: &[f64]) -> Result<Vec<f64>, StepError> {
    let mut increment = vec![0.0; x.len()];
    let mut outcome = [Ok(())];
    stepper.increment(x, &vec![0.0; x.len()], &mut increment, &mut outcome);
    let [outcome] = outcome;
    outcome.map(|()| x.iter().zip(&increment).map(|(x, i)| x + i).collect())
}

/// The state after `steps` compensated steps over `time`.
pub fn run(
    system: &PoissonSystem,
    map: &dyn StepMap,
    initial: &[f64],
    time: f64,
    steps: usize,
) -> Result<Vec<f64>, StepError> {
    let parameters = system.parameter_values();
    let h = time / steps as f64;
    let mut walk = leafwise_core::Walk::new(map, &parameters, 1.0, h, initial);
    for _ in 0..steps {
        walk.step()?;
    }
    Ok(walk.state().to_vec())
}
