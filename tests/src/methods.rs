//! Realizations, dynamic approximations and methods by part name; runs.

use std::sync::Arc;

use leafwise::core::{
    BuildError, Integrator, Method, PartParameters, PoissonSystem, RealizationData, Registry,
    StepError, StepMap,
};

/// `karasev-truncated` of order n.
///
/// # Panics
/// When the part refuses.
pub fn realization(system: &PoissonSystem, order: i64) -> Arc<dyn RealizationData> {
    Registry::with_builtin()
        .realization("karasev-truncated")
        .expect("a built-in realization")
        .build(system, &PartParameters::new().with("order", order))
        .expect("a realization of this order")
}

/// `karasev-truncated` of order n with `hamilton-jacobi` of order m.
///
/// # Panics
/// When a part refuses.
pub fn method(system: &PoissonSystem, n: i64, m: i64) -> Method {
    compose(system, n, m).expect("the parts fit")
}

/// The same, or its refusal.
///
/// # Errors
/// Where the parts do not fit the system.
///
/// # Panics
/// When a part refuses its order.
pub fn compose(system: &PoissonSystem, n: i64, m: i64) -> Result<Method, BuildError> {
    let dynamics = Registry::with_builtin()
        .dynamics("hamilton-jacobi")
        .expect("a built-in dynamic approximation")
        .build(&PartParameters::new().with("order", m))
        .expect("a dynamic approximation of this order");
    Method::compose(system, realization(system, n), dynamics)
}

/// The state after `steps` steps of size `epsilon`·`h` from `initial`.
///
/// # Errors
/// The first step's error.
pub fn run(
    system: &PoissonSystem,
    map: &dyn StepMap,
    (epsilon, h): (f64, f64),
    steps: usize,
    initial: &[f64],
) -> Result<Vec<f64>, StepError> {
    let parameters = system.parameter_values();
    let mut integrator = Integrator::new(map, &parameters, epsilon, h, initial);
    for _ in 0..steps {
        integrator.step()?;
    }
    Ok(integrator.state().to_vec())
}

/// One cold step from `x`: its increment.
///
/// # Errors
/// The solver's error.
pub fn increment(
    map: &dyn StepMap,
    parameters: &[f64],
    (epsilon, h): (f64, f64),
    x: &[f64],
) -> Result<Vec<f64>, StepError> {
    let mut increment = vec![0.0; x.len()];
    let mut outcome = [Ok(())];
    map.stepper(1, parameters, epsilon, h).increment(
        x,
        &vec![0.0; x.len()],
        &mut increment,
        &mut outcome,
    );
    let [outcome] = outcome;
    outcome.map(|()| increment)
}

/// The values of formulas at `x`.
///
/// # Panics
/// When a formula has no code.
pub fn observe(
    system: &PoissonSystem,
    formulas: &[&leafwise::expression::Expression],
    x: &[f64],
) -> Vec<f64> {
    let kernel = system
        .expressions()
        .expect("formulas")
        .observable_kernel(formulas)
        .expect("formulas with code");
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &system.parameter_values(), &[1.0], &[1.0]);
    let mut values = vec![0.0; formulas.len()];
    kernel.evaluate(&mut workspace, x, &mut values);
    values
}
