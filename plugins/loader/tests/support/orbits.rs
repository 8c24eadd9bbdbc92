//! Methods of a registry, and where they go.

use std::sync::Arc;

use leafwise_core::system::{Casimir, Parameter};
use leafwise_core::{
    BuildError, Convention, Method, PartParameters, PoissonSystem, RealizationData, Registry,
    StepMap, Walk,
};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};

/// A formula's expression.
pub fn expression(scope: &Scope, text: &str) -> Expression {
    let formula = Formula::parse(text).expect("a formula");
    let resolved = formula.resolve(scope, None).expect("known names");
    resolved.expect("no boundary")
}

/// The rigid body by formulas, with moments of inertia as parameters.
pub fn rigid_body() -> PoissonSystem {
    let names = ["x1", "x2", "x3"];
    let parameters = [("I1", 1.0), ("I2", 0.75), ("I3", 1.25)];
    let scope = Scope::new()
        .with_variables(&names)
        .with_parameters(&parameters.map(|(name, _)| name));
    let formula = |text: &str| expression(&scope, text);
    PoissonSystem::new(
        names.map(str::to_owned).to_vec(),
        parameters
            .map(|(name, value)| Parameter {
                name: name.to_owned(),
                value,
            })
            .to_vec(),
        [
            ((0, 1), formula("-x3")),
            ((0, 2), formula("x2")),
            ((1, 2), formula("-x1")),
        ],
        formula("x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"),
        vec![Casimir {
            name: "spin".to_owned(),
            expression: formula("x1^2 + x2^2 + x3^2"),
        }],
        Convention::HamiltonianFirst,
    )
    .expect("a system")
}

/// A realization of a registry for a system.
pub fn realization(
    registry: &Registry,
    name: &str,
    system: &PoissonSystem,
    parameters: PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    registry.realization(name)?.build(system, &parameters)
}

/// A realization with dynamics of a registry, of an order or of none.
pub fn method(
    registry: &Registry,
    system: &PoissonSystem,
    realization: Arc<dyn RealizationData>,
    (dynamics, order): (&str, Option<i64>),
) -> Result<Method, BuildError> {
    let parameters = match order {
        Some(order) => PartParameters::new().with("order", order),
        None => PartParameters::new(),
    };
    let dynamics = registry.dynamics(dynamics)?.build(&parameters)?;
    Method::compose(system, realization, dynamics)
}

/// A state of the rigid body.
pub const START: [f64; 3] = [0.3, 1.0, -0.7];

/// The states after `steps` steps of 0.1.
pub fn orbit(system: &PoissonSystem, map: &dyn StepMap, steps: usize) -> Vec<[u64; 3]> {
    let mut walk = Walk::new(map, &system.parameter_values(), 1.0, 0.1, &START);
    (0..steps)
        .map(|_| {
            walk.step().expect("a step");
            [0, 1, 2].map(|i| walk.state()[i].to_bits())
        })
        .collect()
}

/// The states after `steps` steps of 0.1 of this many trajectories side by side, which start near each
/// other.
pub fn orbits(
    system: &PoissonSystem,
    map: &dyn StepMap,
    lanes: usize,
    steps: usize,
) -> Vec<Vec<[u64; 3]>> {
    let spread = |values: &[f64]| -> Vec<f64> {
        let own = |value: &f64| std::iter::repeat_n(*value, lanes);
        values.iter().flat_map(own).collect()
    };
    let mut start = spread(&START);
    for (at, x) in start.iter_mut().enumerate() {
        *x *= 1.0 + (at % lanes) as f64 / 64.0;
    }
    let parameters = spread(&system.parameter_values());
    let mut going = Walk::side_by_side(map, lanes, (&parameters, &start), 1.0, 0.1);
    let mut orbits = vec![Vec::new(); lanes];
    for _ in 0..steps {
        going.step().expect("a step");
        for (lane, orbit) in orbits.iter_mut().enumerate() {
            orbit.push([0, 1, 2].map(|j| going.state()[j * lanes + lane].to_bits()));
        }
    }
    orbits
}

/// The end of a trajectory as numbers.
pub fn end(orbit: &[[u64; 3]]) -> [f64; 3] {
    orbit[orbit.len() - 1].map(f64::from_bits)
}

/// The largest difference of two ends.
pub fn distance(a: &[[u64; 3]], b: &[[u64; 3]]) -> f64 {
    let (a, b) = (end(a), end(b));
    (0..3).fold(0.0, |largest, i| (a[i] - b[i]).abs().max(largest))
}
