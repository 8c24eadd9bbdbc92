//! Methods of `karasev-truncated` and `hamilton-jacobi`, or of the latter over any realization; runs.

use std::sync::Arc;

use leafwise_core::{BuildError, Method, PoissonSystem, RealizationData, StepError, StepMap, Walk};
use leafwise_expression::{Expression, Graph, Kernel, Term};
use leafwise_hamilton_jacobi::HamiltonJacobi;
use leafwise_karasev::TruncatedKarasev;

/// `karasev-truncated` of order n.
///
/// # Panics
/// When the part refuses.
pub fn realization(system: &PoissonSystem, order: usize) -> Arc<dyn RealizationData> {
    Arc::new(TruncatedKarasev::new(system, order).expect("a realization of this order"))
}

/// `hamilton-jacobi` of order m over a realization.
///
/// # Panics
/// When the order is odd or the parts do not fit.
pub fn hamilton_jacobi(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    m: usize,
) -> Method {
    let dynamics = HamiltonJacobi::new(m).expect("an even order");
    Method::compose(system, Arc::clone(realization), Arc::new(dynamics)).expect("the parts fit")
}

/// `karasev-truncated` of order n with `hamilton-jacobi` of order m.
///
/// # Panics
/// When a part refuses.
pub fn method(system: &PoissonSystem, n: usize, m: usize) -> Method {
    compose(system, n, m).expect("the parts fit")
}

/// The same, or its refusal.
///
/// # Errors
/// Where the parts do not fit the system.
///
/// # Panics
/// When a part refuses its order.
pub fn compose(system: &PoissonSystem, n: usize, m: usize) -> Result<Method, BuildError> {
    let dynamics = HamiltonJacobi::new(m).expect("an even order");
    Method::compose(system, realization(system, n), Arc::new(dynamics))
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
    let mut walk = Walk::new(map, &parameters, epsilon, h, initial);
    for _ in 0..steps {
        walk.step()?;
    }
    Ok(walk.state().to_vec())
}

/// Asserts that a run restored from its checkpoint after 20 steps takes 20 more with the same bits.
///
/// # Panics
/// Where it does not, and where a step fails.
pub fn assert_resumes(system: &PoissonSystem, map: &dyn StepMap, time_step: f64, initial: &[f64]) {
    const STEPS: usize = 20;
    let parameters = system.parameter_values();
    let start = || Walk::new(map, &parameters, 1.0, time_step, initial);
    let (mut whole, mut resumed) = (start(), start());
    (0..STEPS).for_each(|_| whole.step().expect("a step"));
    let kept = whole.checkpoint();
    resumed.restore(&kept).expect("its own checkpoint");
    for _ in 0..STEPS {
        whole.step().expect("a step");
        resumed.step().expect("a step");
        assert_eq!(whole.state(), resumed.state());
    }
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
pub fn observe(system: &PoissonSystem, formulas: &[&Expression], x: &[f64]) -> Vec<f64> {
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

/// The values of code at `inputs` and the system's parameters.
pub fn evaluate(
    system: &PoissonSystem,
    graph: &Graph,
    outputs: &[Term],
    inputs: &[f64],
) -> Vec<f64> {
    let parameters = system.parameter_values();
    let kernel = Kernel::compile(graph, outputs, parameters.len(), inputs.len());
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &parameters, &[1.0], &[1.0]);
    let mut values = vec![0.0; outputs.len()];
    kernel.evaluate(&mut workspace, inputs, &mut values);
    values
}
