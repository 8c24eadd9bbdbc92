//! Steps that solve too many equations are refused before their code is formed, with what to try.

use leafwise::core::solver::{MOST_EQUATIONS, MOST_VARIABLES};
use leafwise::core::system::Convention;
use leafwise::core::{BuildError, Method, PartParameters, PoissonSystem, Registry, Walk};
use leafwise::expression::{Expression, Rational};

/// Oscillators, H = Σ (q_i² + p_i²), {q_i, p_i} = 1, as a list of so many pairs.
fn oscillators(pairs: usize) -> PoissonSystem {
    let names = ["q", "p"].map(|letter| (0..pairs).map(move |i| format!("{letter}{i}")));
    let square =
        |i: usize| Expression::Product(vec![Expression::Variable(i), Expression::Variable(i)]);
    PoissonSystem::new(
        names.into_iter().flatten().collect(),
        Vec::new(),
        (0..pairs).map(|i| ((i, pairs + i), Expression::Constant(Rational::one()))),
        Expression::Sum((0..2 * pairs).map(square).collect()),
        Vec::new(),
        Convention::HamiltonianFirst,
    )
    .expect("a system")
}

fn refusal<T>(built: Result<T, BuildError>) -> BuildError {
    built.map(|_| ()).expect_err("more than are solved")
}

fn too_many(equations: usize) -> BuildError {
    let most = MOST_EQUATIONS;
    BuildError::TooManyEquations { equations, most }
}

#[test]
fn steps_of_too_many_equations_are_refused() {
    let registry = Registry::with_builtin();
    let d = 5000;
    let system = oscillators(d / 2);
    let stepper = |name: &str, given: &PartParameters| {
        let part = registry.stepper(name).expect("a built-in part");
        refusal(part.build(&system, given))
    };
    let none = PartParameters::new();
    let two = none.clone().with("stages", 2);
    assert_eq!(stepper("gauss", &two), too_many(2 * d));
    assert_eq!(stepper("implicit-midpoint", &none), too_many(d));
    let fourth = none.clone().with("order", 4);
    assert_eq!(stepper("energy-preserving", &fourth), too_many(2 * d));
    let constant = registry.realization("constant").expect("a built-in part");
    let constant = constant.build(&system, &none).expect("it fits");
    let dynamics = registry
        .dynamics("hamilton-jacobi")
        .expect("a built-in part");
    let dynamics = dynamics.build(&none.with("order", 2)).expect("an order");
    assert_eq!(
        refusal(Method::compose(&system, constant, dynamics)),
        BuildError::TooManyVariables {
            variables: d,
            most: MOST_VARIABLES
        }
    );
}

/// Each stage has the equations of all coordinates.
#[test]
fn stages_count() {
    let registry = Registry::with_builtin();
    let gauss = registry.stepper("gauss").expect("a built-in part");
    let three = PartParameters::new().with("stages", 3);
    let pairs = MOST_EQUATIONS / 6 + 1;
    let built = gauss.build(&oscillators(pairs), &three);
    assert_eq!(refusal(built), too_many(6 * pairs));
}

/// Every stepper that a refusal names takes the step that was refused.
#[test]
fn steppers_that_are_named_instead_solve_nothing() {
    let registry = Registry::with_builtin();
    let system = oscillators(MOST_EQUATIONS / 2 + 1);
    let none = PartParameters::new();
    let midpoint = registry
        .stepper("implicit-midpoint")
        .expect("a built-in part");
    let told = registry.explain(&refusal(midpoint.build(&system, &none)));
    let (_, named) = told
        .split_once("; steppers that solve nothing: ")
        .expect("a list");
    let named: Vec<&str> = named.split(", ").collect();
    assert!(
        named.contains(&"splitting") && named.contains(&"rk4"),
        "{named:?}"
    );
    for name in named {
        let part = registry.stepper(name).expect("a part of the registry");
        let map = part.build(&system, &none).expect(name);
        let x = vec![0.5; system.dimension()];
        let mut walk = Walk::new(map.as_ref(), &[], 1.0, 0.01, &x);
        walk.step().expect(name);
    }
}
