//! Values of a system, from its formulas or its own, in batches; refusals of what needs formulas.

use leafwise_core::system::{Casimir, Derivatives, Parameter, SystemInvariants};
use leafwise_core::{BuildError, Convention, PoissonSystem};
use leafwise_expression::Expression;

fn product(factors: &[Expression]) -> Expression {
    Expression::Product(factors.to_vec())
}

/// {x, y} = x y, {y, z} = a y z, H = x y² + z, with C = x y z named although it is no Casimir: only
/// values are asked for.
fn system() -> PoissonSystem {
    let [x, y, z] = [0, 1, 2].map(Expression::Variable);
    let a = Expression::Parameter(0);
    PoissonSystem::new(
        ["x", "y", "z"].map(str::to_owned).to_vec(),
        vec![Parameter {
            name: "a".to_owned(),
            value: 2.0,
        }],
        [
            ((0, 1), product(&[x.clone(), y.clone()])),
            ((1, 2), product(&[a, y.clone(), z.clone()])),
        ],
        Expression::Sum(vec![product(&[x.clone(), y.clone(), y.clone()]), z.clone()]),
        vec![Casimir {
            name: "volume".to_owned(),
            expression: product(&[x, y, z]),
        }],
        Convention::HamiltonianFirst,
    )
    .expect("a system")
}

/// Powers of two and small integers: every value below is exact.
const POINTS: [f64; 6] = [1.0, 2.0, 4.0, 3.0, -1.0, 0.5];

#[test]
fn compiled_values_are_those_of_the_formulas_at_every_point_of_a_batch() {
    let numbers = system().numbers().expect("code");
    assert_eq!(
        numbers.derivatives,
        Derivatives {
            tensor: true,
            hamiltonian: true,
            casimirs: true
        }
    );
    let mut evaluator = numbers.evaluator(&[2.0]);
    let mut out = [0.0; 6];
    // Π = [[0, xy, 0], [−xy, 0, 2yz], [0, −2yz, 0]] on v = (1, 10, 100), one vector for all points.
    evaluator
        .tensor(&POINTS, &[1.0, 10.0, 100.0], &mut out)
        .expect("values");
    assert_eq!(out, [20.0, 1598.0, -160.0, -30.0, -97.0, 10.0]);
    // One point, three unit vectors: the columns of Π.
    let mut columns = [0.0; 9];
    let units = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    evaluator
        .tensor(&POINTS[..3], &units, &mut columns)
        .expect("values");
    assert_eq!(columns, [0.0, -2.0, 0.0, 2.0, 0.0, -16.0, 0.0, 16.0, 0.0]);
    let mut energy = [0.0; 2];
    evaluator.hamiltonian(&POINTS, &mut energy).expect("values");
    assert_eq!(energy, [8.0, 3.5]);
    evaluator.gradient(&POINTS, &mut out).expect("values");
    assert_eq!(out, [4.0, 4.0, 1.0, 1.0, -6.0, 1.0]);
    let mut volume = [0.0; 2];
    evaluator.casimirs(&POINTS, &mut volume).expect("values");
    assert_eq!(volume, [8.0, -1.5]);
    evaluator
        .casimir_gradients(&POINTS, &mut out)
        .expect("values");
    assert_eq!(out, [8.0, 4.0, 2.0, -0.5, 1.5, -3.0]);
    // D²H v = (2y v_y, 2y v_x + 2x v_y, 0).
    evaluator
        .hessian(&POINTS, &[1.0, 1.0, 1.0], &mut out)
        .expect("values");
    assert_eq!(out, [4.0, 6.0, 0.0, -2.0, 4.0, 0.0]);
    // D(Πv)w = ((x w_y + y w_x) v_y, −(x w_y + y w_x) v_x + 2(y w_z + z w_y) v_z, …) for v = w = 1.
    let one = [1.0, 1.0, 1.0];
    evaluator
        .tensor_tangent(&POINTS, &one, &one, &mut out)
        .expect("values");
    assert_eq!(out, [3.0, 9.0, -12.0, 2.0, -3.0, 1.0]);
}

#[test]
fn a_system_without_formulas_has_the_same_values_and_names() {
    let formulas = system();
    let opaque = formulas.without_formulas("acme/test").expect("code");
    assert_eq!(opaque.variables(), formulas.variables());
    assert_eq!(opaque.parameters(), formulas.parameters());
    assert_eq!(opaque.casimir_names(), ["volume"]);
    assert_eq!((formulas.path(), opaque.path()), ("expressions", "numbers"));
    let mut values = [[0.0; 2]; 2];
    for (system, values) in [&formulas, &opaque].into_iter().zip(&mut values) {
        let mut invariants = SystemInvariants::new(system, &[2.0]).expect("code");
        assert_eq!(invariants.observables(), 2);
        invariants.evaluate(&POINTS[..3], values);
    }
    assert_eq!(values, [[8.0, 8.0]; 2]);
}

#[test]
fn a_part_that_needs_formulas_says_so() {
    let opaque = system().without_formulas("acme/test").expect("code");
    let refused = opaque.formulas("karasev-truncated").expect_err("numbers");
    assert!(matches!(
        refused,
        BuildError::NotOffered {
            part: "karasev-truncated",
            ..
        }
    ));
    let said = "karasev-truncated needs formulas of the system, and acme/test offers only numbers";
    assert_eq!(refused.to_string(), said);
}
