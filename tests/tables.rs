//! Tables as functions: splines against SciPy's, orbits in tabulated potentials and fields, what no step leaves.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::f64::consts::PI;

use leafwise::core::diagnostics::TensorDefect;
use leafwise::core::{BuildError, NumberArray, Registry, StepError, Walk};
use leafwise::expression::table::{Lookup, TableAxis, TableFunction};
use leafwise::scene::compose::{Observable, RecordedFormula};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise::walk::{Ended, Fault, Look, Watched, Why};
use leafwise_tests::scenes::end;
use serde_json::Value;

/// The run of a text with arrays in the place of its tables' files.
fn composed(text: &str, arrays: &[(&str, &[usize], Vec<f64>)]) -> ComposedRun {
    let mut registry = Registry::with_builtin();
    for (name, shape, numbers) in arrays {
        let (shape, numbers) = (shape.to_vec(), numbers.clone());
        registry.add_array(*name, NumberArray { shape, numbers });
    }
    let document = SceneDocument::parse("scene", text, &registry);
    let document = document.unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    compose(&document, &registry).unwrap_or_else(|refusal| panic!("{refusal}\n{text}"))
}

/// Values and derivatives of splines of random numbers, whose knots and ends are those of SciPy.
#[test]
fn splines_and_their_derivatives_are_those_of_scipy() {
    let cases: Value = serde_json::from_str(include_str!("data/tables.json")).expect("JSON");
    let number = |value: &Value| value.as_f64().expect("a number");
    let mut points = 0;
    for case in cases.as_array().expect("cases") {
        let axes = case["axes"].as_array().expect("axes").iter();
        let axes = axes.map(|axis| TableAxis {
            name: "x".to_owned(),
            first: number(&axis["first"]),
            last: number(&axis["last"]),
            nodes: number(&axis["nodes"]) as usize,
            is_periodic: axis["periodic"].as_bool().expect("a flag"),
        });
        let axes: Vec<TableAxis> = axes.collect();
        let numbers = case["numbers"]
            .as_array()
            .expect("numbers")
            .iter()
            .map(number);
        let degree = number(&case["degree"]);
        let numbers: Vec<f64> = numbers.collect();
        let table = TableFunction::new("f", axes.clone(), degree as u8, &numbers).expect("a table");
        for point in case["points"].as_array().expect("points") {
            let list = |key: &str| -> Vec<f64> {
                point[key]
                    .as_array()
                    .expect("a list")
                    .iter()
                    .map(number)
                    .collect()
            };
            let orders: Vec<u8> = list("orders").iter().map(|order| *order as u8).collect();
            let lookup = Lookup::of_orders(table, &orders).expect("a derivative");
            let (found, expected) = (lookup.at(&list("at")), number(&point["value"]));
            // Random numbers between not-a-knot ends make coefficients of up to 2^k a side; a derivative of order m adds
            // up 2^m of them over as many cells.
            let mut size = 1.0;
            for (axis, order) in axes.iter().zip(&orders) {
                let cells = axis.nodes as f64 - 1.0;
                let growth = libm::pow(2.0 * cells / (axis.last - axis.first), f64::from(*order));
                size *= growth * libm::pow(4.0, degree);
            }
            let allowed = 16.0 * f64::EPSILON * size;
            assert!(
                (found - expected).abs() <= allowed,
                "degree {degree}, orders {orders:?}: {found} {expected}, {allowed:e}"
            );
            points += 1;
        }
    }
    assert!(points >= 340, "{points}");
}

/// The pendulum at t from rest at the angle a: 2 asin(k sn(K + t, k)), k = sin(a/2), by arithmetic-geometric means.
fn pendulum(a: f64, t: f64) -> f64 {
    let k = libm::sin(a / 2.0);
    let mut means = vec![(1.0, libm::sqrt(1.0 - k * k), k)];
    // The differences are squared each time, and below round-off after six.
    for _ in 0..6 {
        let (a, b, _) = *means.last().expect("one");
        means.push((0.5 * (a + b), libm::sqrt(a * b), 0.5 * (a - b)));
    }
    let (last, ..) = *means.last().expect("one");
    let quarter = PI / (2.0 * last);
    let count = (means.len() - 1) as f64;
    let mut phi = libm::pow(2.0, count) * last * (quarter + t);
    for (a, _, c) in means[1..].iter().rev() {
        phi = 0.5 * (phi + libm::asin(c / a * libm::sin(phi)));
    }
    2.0 * libm::asin(k * libm::sin(phi))
}

/// The farthest from the true orbits at t = 30 of 24 that begin at rest, of a potential with so many nodes a period.
fn pendulum_error(degree: u32, nodes: usize) -> f64 {
    let period = (0..nodes).map(|i| -libm::cos(2.0 * PI * i as f64 / nodes as f64 - PI));
    let text = format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"p^2/2 + V(q)\"\n\
         [system.tables.V]\naxes = {{ q = [{:?}, {PI:?}] }}\nperiodic = [\"q\"]\ndegree = {degree}\n\
         [method]\nstepper = \"splitting\"\ncomposition = \"yoshida-6\"\ntime-step = 0.02\n\
         [run]\ninitial = [1, 0]\nsteps = 1500\n",
        -PI
    );
    let run = composed(&text, &[("V", &[nodes], period.collect())]);
    let errors = (0..24).map(|i| {
        let begin = 0.3 + 2.2 * f64::from(i) / 23.0;
        let mut walk = Walk::new(
            run.method.map(),
            &[],
            run.plan.epsilon,
            run.plan.h,
            &[begin, 0.0],
        );
        walk.advance(run.plan.steps).expect("every step");
        (walk.state()[0] - pendulum(begin, 30.0)).abs()
    });
    errors.fold(0.0, f64::max)
}

/// With twice the nodes the error of a cubic potential is some 12 times less, that of a quintic one 50 to 64 times. The
/// quintic errors are those of another program with splines of SciPy.
#[test]
fn a_tabulated_pendulum_converges_to_the_true_one() {
    let nodes = [16, 32, 64, 128];
    let cubic = nodes.map(|nodes| pendulum_error(3, nodes));
    let quintic = nodes.map(|nodes| pendulum_error(5, nodes));
    println!("cubic {cubic:?}, quintic {quintic:?}");
    for pair in cubic.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((9.0..18.0).contains(&ratio), "{cubic:?}");
    }
    for (found, expected) in quintic.into_iter().zip([1.7e-5, 2.7e-7, 5.3e-9, 1.1e-10]) {
        // Two digits, and what the integrators err by.
        assert!(
            (found - expected).abs() <= 0.06 * expected + 2e-12,
            "{quintic:?}"
        );
    }
}

/// The tokamak of `guiding-centre` with the components of A as tables of n by n nodes.
fn tokamak(degree: u32, n: usize, order: u32, (u, mu): (&str, &str), steps: u64) -> ComposedRun {
    let text = format!(
        "[system]\nvariables = [\"R\", \"Z\", \"phi\", \"u\"]\nparameters = {{ mu = {mu} }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"u^2/2 + mu*B\"\n\
         bracket = {{ one-form = [\"AR(R, Z) + u*BR/B\", \"AZ(R, Z) + u*BZ/B\", \"Aphi(R, Z) + u*Bphi/B\", \"0\"] }}\n\
         define = {{ BR = \"-D(Aphi(R, Z), Z)/R\", BZ = \"D(Aphi(R, Z), R)/R\", \
         Bphi = \"-R*(D(AZ(R, Z), R) - D(AR(R, Z), Z))\", B = \"sqrt(BR^2 + BZ^2 + Bphi^2/R^2)\" }}\n\
         [system.tables]\n\
         AR = {{ degree = {degree}, axes = {{ R = [0.88, 1.12], Z = [-0.12, 0.12] }} }}\n\
         AZ = {{ degree = {degree}, axes = {{ R = [0.88, 1.12], Z = [-0.12, 0.12] }} }}\n\
         Aphi = {{ degree = {degree}, axes = {{ R = [0.88, 1.12], Z = [-0.12, 0.12] }} }}\n\
         [method]\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\ntime-step = 125\n\
         [run]\ninitial = [1.05, 0, 0, {u}]\nsteps = {steps}\n\
         record = {{ observables = [\"Aphi(R, Z) + u*Bphi/B\"] }}\n"
    );
    let grid = |of: &dyn Fn(f64, f64) -> f64| {
        let node = |i: usize| 0.24 * i as f64 / (n as f64 - 1.0) - 0.12;
        let places = (0..n * n).map(|at| (1.0 + node(at / n), node(at % n)));
        places.map(|(r, z)| of(r, z)).collect::<Vec<f64>>()
    };
    let shape = &[n, n][..];
    composed(
        &text,
        &[
            ("AR", shape, grid(&|r, z| z / (2.0 * r))),
            ("AZ", shape, grid(&|r, _| -libm::log(r) / 2.0)),
            (
                "Aphi",
                shape,
                grid(&|r, z| ((r - 1.0) * (r - 1.0) + z * z) / 4.0),
            ),
        ],
    )
}

const TRAPPED: (&str, &str) = ("4.306e-4", "2.25e-6");
const PASSING: (&str, &str) = ("1.623e-3", "2.448e-6");

/// How far splines of 9 by 9 and of 17 by 17 nodes lead from the orbit in the field's own formulas at T = 5·10⁴, of 1/20, 1/20,
/// φ and u. Another program found these distances with splines and a solver of SciPy; the same steps in both fields have them too.
#[test]
fn orbits_of_tabulated_fields_are_as_near_as_the_tables() {
    let cases = [
        (
            TRAPPED,
            [[4e-7, 3e-8, 5e-7, 1e-6], [2e-9, 3e-10, 3e-9, 6e-9]],
        ),
        (
            PASSING,
            [[3e-7, 5e-7, 4e-9, 1e-8], [2e-9, 3e-9, 3e-12, 1e-10]],
        ),
    ];
    for (orbit, errors) in cases {
        let exact = end(&leafwise_tests::scenes::composed(&format!(
            "[system]\nlibrary = \"guiding-centre\"\nparameters = {{ mu = {} }}\n\
             [method]\ndynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\ntime-step = 125\n\
             [run]\ninitial = [1.05, 0, 0, {}]\nsteps = 400\n",
            orbit.1, orbit.0
        )));
        for (n, errors) in [9, 17].into_iter().zip(errors) {
            let found = end(&tokamak(5, n, 4, orbit, 400));
            let sizes = [0.05, 0.05, f64::max(1.0, exact[2].abs()), exact[3].abs()];
            for (at, error) in errors.into_iter().enumerate() {
                let off = (found[at] - exact[at]).abs() / sizes[at];
                println!("{n} x {n}: {off:.1e}, {error:.0e}");
                // One digit is known; below 10⁻⁹ the other solver's error is of that size.
                assert!(
                    (off - error).abs() <= 0.5 * error + 1e-9,
                    "{n} x {n}: {off:e}, {error:e}"
                );
            }
        }
    }
}

/// Every table gives a closed two-form: toroidal momentum to round-off, cubic on 9 by 9 nodes as well, and steps that are Poisson
/// maps to 1e-12 from degree 5 on, at the orders that the degrees leave. From degree 5 on the momentum stays to 1e-13 of itself; the cubic tables'
/// Newton matrices jump, and their solves end a few units of R's last place away.
#[test]
fn steps_are_poisson_maps_whatever_the_table() {
    for (degree, n, order) in [(3, 9, 2), (5, 9, 4), (5, 17, 4), (7, 9, 6)] {
        for orbit in [TRAPPED, PASSING] {
            let run = tokamak(degree, n, order, orbit, 200);
            let values = run.system.parameter_values();
            let (map, plan) = (run.method.map(), &run.plan);
            let defect = TensorDefect::new(&run.system, map, &values, plan.epsilon, plan.h);
            let mut defect = defect.expect("code");
            // ϑ_φ = A_φ + u B_φ/B.
            let mut recorded = plan.observables.iter();
            let momentum = recorded.find_map(|observable| match observable {
                Observable::Formula {
                    formula: RecordedFormula::Written(expression),
                    ..
                } => Some(expression),
                _ => None,
            });
            let momentum = momentum.expect("it is recorded");
            let mut walk = run.walk();
            let first = momentum.evaluate(walk.state(), &values);
            let mut largest = 0.0_f64;
            for step in 0..200 {
                if step % 10 == 0 {
                    let found = defect.measure(walk.state()).expect("a tangent");
                    let relative = found.relative().expect("a tensor that is not 0");
                    largest = f64::max(largest, relative);
                }
                walk.step().expect("a step");
                let now = momentum.evaluate(walk.state(), &values);
                // |∂ϑ_φ/∂R| is below 1/16, and R about 1: so much are 200 steps of four units each.
                let allowed = match degree {
                    3 => 200.0 * 4.0 * f64::EPSILON / 16.0,
                    _ => 1e-13 * first.abs(),
                };
                assert!(
                    (now - first).abs() <= allowed,
                    "{degree} {n}: {now} {first}"
                );
            }
            // A cubic table's Newton matrix jumps at its nodes, where a solve ends before its tangent is that of its end.
            let allowed = if degree == 3 { 1e-9 } else { 1e-12 };
            assert!(largest <= allowed, "{degree} {n}: {largest:e}");
        }
    }
}

/// An anharmonic well from −1 to 1.25, of which a particle of this speed runs out at 1.25.
fn well(method: &str, run: &str) -> ComposedRun {
    let text = format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"p^2/2 + V(q)\"\n\
         [system.tables]\nV = {{ axes = {{ q = [-1, 1.25] }} }}\n\
         [method]\n{method}\ntime-step = 0.05\n[run]\nsteps = 1000\n{run}\n"
    );
    let node = |i: usize| 2.25 * i as f64 / 23.0 - 1.0;
    let values = (0..24).map(node).map(|q| q * q / 2.0 - 0.1 * q * q * q);
    composed(&text, &[("V", &[24], values.collect())])
}

fn ended(run: &ComposedRun) -> Ended {
    let course = run.course(&[]).expect("code");
    let parameters = run.system.parameter_values();
    let start = (parameters.as_slice(), run.plan.initial.as_slice());
    let mut walk = Watched::new(&course, run.method.map(), 1, start).expect("a walk");
    let mut take = |_: Look<'_>| Ok::<(), BuildError>(());
    walk.begin(&mut take).expect("a look");
    walk.advance(run.plan.steps, &mut take).expect("looks");
    walk.ended(0).expect("an end").clone()
}

const METHODS: [&str; 6] = [
    "dynamics = { name = \"hamilton-jacobi\", order = 4 }",
    "dynamics = { name = \"collective\", stages = 2 }",
    "stepper = \"splitting\"",
    "stepper = \"implicit-midpoint\"",
    "stepper = \"rk4\"",
    "stepper = \"taylor\"",
];

/// No step leaves a table: it is refused by the table's name, its axis and a value outside.
#[test]
fn a_step_out_of_a_table_is_refused_by_name() {
    for method in METHODS {
        let end = ended(&well(method, "initial = [0, 1.5]"));
        let Why::Failed(Fault::Step(StepError::OutsideTable(outside))) = end.why else {
            panic!("{method}: {end:?}");
        };
        assert_eq!((outside.table.name(), outside.axis), ("V", 0));
        assert!(
            outside.value > 1.25 && outside.value < 1.35,
            "{method}: {outside}"
        );
        assert!(
            end.state[0] <= 1.25 && end.state[0] > 1.15,
            "{method}: {end:?}"
        );
        let said = StepError::OutsideTable(outside).to_string();
        assert!(
            said.contains("outside the table `V`") && said.contains("`stop`"),
            "{said}"
        );
    }
}

/// A condition inside the table is located in the step that would leave it, as the advice says: on the wall to the last bit.
#[test]
fn a_condition_inside_a_table_ends_the_run_before_its_end() {
    for method in METHODS {
        for wall in [1.2, 1.24, 1.2499] {
            let run = format!("initial = [0, 1.5]\nstop = \"q > {wall}\"");
            let end = ended(&well(method, &run));
            assert_eq!(end.why, Why::Stopped, "{method} {wall}");
            assert!(end.state[0] > wall, "{method} {wall}: {end:?}");
            // The shortest part of a step is told apart to 4 units of 2⁻⁵².
            assert!(end.state[0] - wall < 2e-15, "{method} {wall}: {end:?}");
        }
    }
}

/// Where a formula has a value without its table, nothing is refused.
#[test]
fn a_table_behind_a_condition_may_be_left() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
         hamiltonian = \"p^2/2 + if(q < 1, V(q), q^2/2)\"\n\
         [system.tables]\nV = { axes = { q = [-2, 1.25] } }\n\
         [method]\ndynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.05\n\
         [run]\ninitial = [0, 1.5]\nsteps = 1000\n";
    let values = (0..24).map(|i| 3.25 * f64::from(i) / 23.0 - 2.0);
    let values = values.map(|q| q * q / 2.0).collect();
    let run = composed(text, &[("V", &[24], values)]);
    let found = end(&run);
    // 50 units of time of a harmonic oscillator.
    let expected = [1.5 * libm::sin(50.0), 1.5 * libm::cos(50.0)];
    for (a, b) in found.iter().zip(expected) {
        // Order 4: h⁴ t/720 and more.
        assert!((a - b).abs() < 5e-6, "{found:?} {expected:?}");
    }
}
