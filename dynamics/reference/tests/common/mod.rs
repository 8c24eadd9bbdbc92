//! Systems, maps and runs shared by the claims.

use std::sync::Arc;

use leafwise_core::system::Casimir;
use leafwise_core::{
    BuildError, Convention, PartParameters, PoissonSystem, Registry, StepMap, Walk,
};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_reference as _;

/// A system from formulas over x1, …, x_d; bracket entries by (i, j), from 1.
pub fn system(
    d: usize,
    bracket: &[((usize, usize), &str)],
    hamiltonian: &str,
    casimirs: &[&str],
    convention: Convention,
) -> PoissonSystem {
    let names: Vec<String> = (1..=d).map(|i| format!("x{i}")).collect();
    let scope = Scope::new().with_variables(&names);
    let formula = |text: &str| -> Expression {
        let formula = Formula::parse(text).expect("a formula");
        let resolved = formula.resolve(&scope, None).expect("known names");
        resolved.expect("a formula without sites")
    };
    let entries = bracket
        .iter()
        .map(|&((i, j), text)| ((i - 1, j - 1), formula(text)));
    let casimirs = casimirs.iter().enumerate().map(|(k, text)| Casimir {
        name: format!("c{k}"),
        expression: formula(text),
    });
    PoissonSystem::new(
        names.clone(),
        Vec::new(),
        entries,
        formula(hamiltonian),
        casimirs.collect(),
        convention,
    )
    .expect("a system")
}

/// The paper's Example 1.
pub fn rigid_body() -> PoissonSystem {
    system(
        3,
        &[((1, 2), "-x3"), ((1, 3), "x2"), ((2, 3), "-x1")],
        "x1^2/2 + x2^2/1.5 + x3^2/2.5",
        &["x1^2 + x2^2 + x3^2"],
        Convention::HamiltonianFirst,
    )
}

/// Cohen and Hairer's bounded Lotka–Volterra system.
pub fn lotka_volterra() -> PoissonSystem {
    system(
        3,
        &[
            ((1, 2), "-x1*x2/2"),
            ((1, 3), "x1*x3/2"),
            ((2, 3), "-x2*x3"),
        ],
        "2*x1 + x2 + 2*x3 + ln(x2) - 2*ln(x3)",
        &["2*ln(x1) + ln(x2) + ln(x3)"],
        Convention::HamiltonianFirst,
    )
}

/// The library's heavy top, in the textbooks' convention.
pub fn heavy_top() -> PoissonSystem {
    system(
        6,
        &[
            ((1, 2), "-x3"),
            ((2, 3), "-x1"),
            ((1, 3), "x2"),
            ((1, 5), "-x6"),
            ((2, 6), "-x4"),
            ((3, 4), "-x5"),
            ((1, 6), "x5"),
            ((2, 4), "x6"),
            ((3, 5), "x4"),
        ],
        "x1^2/2 + x2^2/1.5 + x3^2/2.5 + 0.3*x4 + x6",
        &["x4^2 + x5^2 + x6^2", "x1*x4 + x2*x5 + x3*x6"],
        Convention::HamiltonianSecond,
    )
}

/// Two spins with exchange and anisotropy, on so(3)* × so(3)*.
pub fn spins() -> PoissonSystem {
    system(
        6,
        &[
            ((1, 2), "x3"),
            ((1, 3), "-x2"),
            ((2, 3), "x1"),
            ((4, 5), "x6"),
            ((4, 6), "-x5"),
            ((5, 6), "x4"),
        ],
        "x1*x4 + x2*x5 + x3*x6 + x1^2/2 + x4^2/3 + x6/2",
        &["x1^2 + x2^2 + x3^2", "x4^2 + x5^2 + x6^2"],
        Convention::HamiltonianFirst,
    )
}

/// A pendulum with a coupled oscillator: a constant tensor.
pub fn pendulum() -> PoissonSystem {
    system(
        4,
        &[((1, 3), "1"), ((2, 4), "1")],
        "x3^2/2 + x4^2/2 - cos(x1) + x1*x2/4 + x2^2/2",
        &[],
        Convention::HamiltonianFirst,
    )
}

/// The state of [`rigid_body`] and [`lotka_volterra`] after time 1 from (1, 3, 3) and
/// (1, 1.9, 0.5): Taylor integration at 50 digits.
pub const RIGID_BODY_FLOW: ([f64; 3], [f64; 3]) = (
    [1.0, 3.0, 3.0],
    [3.7894873027779745, 1.9974783461358703, 0.8061428153887003],
);
pub const LOTKA_VOLTERRA_FLOW: ([f64; 3], [f64; 3]) = (
    [1.0, 1.9, 0.5],
    [3.777407973183465, 0.0675783869637859, 0.9852081563067037],
);

/// No parameter.
pub fn none() -> PartParameters {
    PartParameters::new()
}

/// The stepper of this name.
pub fn try_map(
    name: &str,
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    Registry::with_builtin()
        .stepper(name)
        .expect("the part is linked")
        .build(system, parameters)
}

/// The same where it must fit.
pub fn map(name: &str, system: &PoissonSystem, parameters: &PartParameters) -> Arc<dyn StepMap> {
    try_map(name, system, parameters).expect("it fits")
}

/// Every state of `steps` steps of εh = t, the first one included.
pub fn orbit(map: &dyn StepMap, t: f64, steps: usize, initial: &[f64]) -> Vec<Vec<f64>> {
    let mut walk = Walk::new(map, &[], 0.5, 2.0 * t, initial);
    let mut states = vec![initial.to_vec()];
    for _ in 0..steps {
        walk.step().expect("a step that converges");
        states.push(walk.state().to_vec());
    }
    states
}

/// The last of them.
pub fn run(map: &dyn StepMap, t: f64, steps: usize, initial: &[f64]) -> Vec<f64> {
    orbit(map, t, steps, initial).swap_remove(steps)
}

/// The largest change of a function along states, against 1 + |its first value|: the terms these
/// functions sum are of size 1 and above even where their sum is not.
pub fn drift(states: &[Vec<f64>], function: &Expression) -> f64 {
    let value = |x: &Vec<f64>| function.evaluate(x, &[]);
    let first = value(&states[0]);
    let changes = states.iter().map(|x| (value(x) - first).abs());
    changes.fold(0.0, f64::max) / (1.0 + first.abs())
}

/// The Euclidean distance of two states.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    libm::sqrt(squares.sum())
}

/// Every part with parameters that exercise it, with its order.
pub fn parts() -> Vec<(&'static str, PartParameters, usize)> {
    let mut parts = vec![
        ("rk4", none(), 4),
        ("dop853", none().with("tolerance", 0.1), 8),
        ("dormand-prince45", none().with("tolerance", 0.1), 5),
        ("implicit-midpoint", none(), 2),
        ("energy-preserving", none().with("order", 2), 2),
        ("energy-preserving", none().with("order", 4), 4),
        ("projection", none(), 4),
        (
            "projection",
            none().with("base", "gauss").with("stages", 3),
            6,
        ),
    ];
    for stages in 1..=4_i64 {
        parts.push(("gauss", none().with("stages", stages), 2 * stages as usize));
    }
    parts
}
