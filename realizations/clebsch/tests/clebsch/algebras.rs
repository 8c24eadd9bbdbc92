//! e(3)*, so(4)* and sp(2m)*.

use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::{BuildError, PoissonSystem, StepError, StepMap, Structure, Walk};
use leafwise_tests::gauss::flow;
use leafwise_tests::library;
use leafwise_tests::methods::{increment, observe, run};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::orders::of_even_order;
use leafwise_tests::structure::structure_error;
use leafwise_tests::systems::from_formulas;
use proptest::collection::vec;
use proptest::prelude::*;

use super::common::{gauss, on_algebra, realize, there_and_back};

/// A quadratic H with a linear part on ten variables, positive.
fn on_sp4() -> PoissonSystem {
    let squares = (1..=10).map(|i| format!("{}*x{i}^2", 0.1 + 0.03 * f64::from(i * i % 7)));
    let others = (1..=9).map(|i| format!("{}*x{i}*x{}", 0.05 - 0.01 * f64::from(i % 4), i + 1));
    let linear = ["x1/7".to_owned(), "x10/5".to_owned()];
    let terms: Vec<String> = squares.chain(others).chain(linear).collect();
    // Of X J the half trace of the square, J the unit of the brackets.
    let square = "x1*x8 - x3^2 + x5*x10 - x7^2 + 2*x2*x9 - 2*x4*x6";
    on_algebra("sp(4)", &terms.join(" + "), &[("square", square)])
}

const ON_SP4: [f64; 10] = [0.7, 0.1, -0.2, 0.15, 0.5, 0.1, 0.05, 0.6, -0.1, 0.4];

/// A rigid body with a vector on e(3)*, other signs and another order than the library's: Γ first, λ = k.
fn top() -> PoissonSystem {
    from_formulas(
        &["g2", "g1", "g3", "m1", "m3", "m2"],
        &[("k", 0.8), ("a", 1.3)],
        &[
            ("m1,m2", "k*m3"),
            ("m2,m3", "k*m1"),
            ("m3,m1", "k*m2"),
            ("m1,g2", "k*g3"),
            ("m2,g3", "k*g1"),
            ("m3,g1", "k*g2"),
            ("m1,g3", "-k*g2"),
            ("m2,g1", "-k*g3"),
            ("m3,g2", "-k*g1"),
        ],
        "m1^2/2 + a*m2^2/2 + m3^2/3 + m1*m3/5 + g1/3 + g3 + a*g2^2/4",
        &[
            ("square", "g1^2 + g2^2 + g3^2"),
            ("vertical", "m1*g1 + m2*g2 + m3*g3"),
        ],
    )
}

fn systems() -> [(PoissonSystem, Vec<f64>, f64); 5] {
    let of = |id: &str, time_step: f64| {
        let problem = library(id);
        (problem.system, problem.initial, time_step)
    };
    [
        of("heavy-top", 0.4),
        of("se3", 0.6),
        of("so4", 0.8),
        (top(), vec![0.3, -0.5, 0.8, 1.0, 0.4, -0.7], 0.4),
        (on_sp4(), ON_SP4.to_vec(), 0.25),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn steps_are_poisson_maps(
        moved in vec(-0.5..0.5_f64, 10),
        stages in 1..=8_usize,
        part in 0.1..1.0_f64,
    ) {
        for (system, mut x, most) in systems() {
            x.iter_mut().zip(&moved).for_each(|(x, by)| *x += 0.5 * by);
            let method = gauss(&system, stages);
            let error = structure_error(&system, &method, part * most, &x).expect("a step");
            prop_assert!(
                error.tensor <= 64.0 && error.casimirs <= 64.0,
                "{}, {x:?}, {stages}, {part}: {error:?}", method.describe()
            );
            let back = there_and_back(&system, &method, part * most, &x);
            prop_assert!(back <= 256.0 * UNIT_ROUNDOFF * largest(&x), "{}: {back:e}", method.describe());
        }
    }

    /// A body's energy is of its own inertias.
    #[test]
    fn bodies_of_any_inertia_keep_their_structure(
        inertias in vec(0.3..3.0_f64, 3),
        vector in vec(-1.0..1.0_f64, 3),
        m in vec(-1.0..1.0_f64, 3),
    ) {
        let library = library("heavy-top").system;
        let mut parameters = library.parameter_values();
        parameters[..3].copy_from_slice(&inertias);
        let system = library.with_parameter_values(&parameters).expect("five");
        let x = [m, vector].concat();
        prop_assume!(largest(&x[3..]) > 0.1);
        let error = structure_error(&system, &gauss(&system, 4), 0.2, &x).expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{x:?}: {error:?}");
    }
}

/// The exact tangent of a step against differences of order 6.
#[test]
fn tangents_are_those_of_differences() {
    for (system, x, most) in systems() {
        let d = x.len();
        let (method, parameters) = (gauss(&system, 4), system.parameter_values());
        let mut instrument =
            TensorDefect::new(&system, &method, &parameters, 1.0, most).expect("a tensor");
        let tangent = instrument.measure(&x).expect("a step").tangent;
        let size = largest(&tangent);
        let at = |j: usize, by: f64| {
            let mut x = x.clone();
            x[j] += by;
            let step = increment(&method, &parameters, (1.0, most), &x).expect("a step");
            x.iter()
                .zip(&step)
                .map(|(x, by)| x + by)
                .collect::<Vec<f64>>()
        };
        let by = 2e-3;
        for j in 0..d {
            let pairs = [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)];
            let ends = pairs.map(|(k, c)| (at(j, k * by), at(j, -k * by), c));
            for i in 0..d {
                let sum: f64 = ends.iter().map(|(up, down, c)| c * (up[i] - down[i])).sum();
                let error = (sum / by - tangent[i * d + j]).abs();
                assert!(
                    error <= 1e-9 * size,
                    "{}: {i}, {j}: {error:e}",
                    method.describe()
                );
            }
        }
    }
}

#[test]
fn gauss_methods_have_order_2s() {
    let sp4 = on_sp4();
    let of = |id: &str| {
        let problem = library(id);
        (problem.system, problem.initial)
    };
    let ((heavy, top), (so4, body)) = (of("heavy-top"), of("so4"));
    for (system, initial, time, rows) in [
        (
            &heavy,
            &top[..],
            2.0,
            [[40, 60, 90, 130], [16, 24, 34, 48], [8, 10, 13, 16]],
        ),
        (
            &so4,
            &body[..],
            20.0,
            [[80, 120, 180, 250], [40, 52, 68, 90], [12, 14, 17, 20]],
        ),
        (
            &sp4,
            &ON_SP4[..],
            2.0,
            [[40, 60, 90, 130], [16, 24, 34, 48], [9, 11, 14, 17]],
        ),
    ] {
        for (stages, steps) in [1, 2, 4].into_iter().zip(rows) {
            let method = gauss(system, stages);
            let properties = method.properties();
            assert_eq!(
                (
                    properties.order,
                    properties.structure,
                    properties.self_adjoint
                ),
                (2 * stages, Structure::Exact, Some(true))
            );
            let found = of_even_order(system, &method, initial, time, &steps);
            let found = found.unwrap_or_else(|| panic!("{stages}: too few errors above round-off"));
            let order = 2.0 * stages as f64;
            assert!(
                found.is(order, 2.0),
                "{}: measured {found}",
                method.describe()
            );
        }
        let end = flow(system, initial, time, 128);
        let found = run(system, &gauss(system, 8), (1.0, time / 10.0), 10, initial).expect("steps");
        assert!(distance(&found, &end) <= 1e-12, "{found:?}, {end:?}");
    }
}

/// Over 10⁵ steps Casimirs wander by the rounding of increments, and the energy has no trend above that.
#[test]
fn casimirs_and_energies_are_kept() {
    const STEPS: usize = 100_000;
    for (system, initial, most) in systems() {
        let method = gauss(&system, 8);
        let formulas = system.expressions().expect("formulas");
        let casimirs = formulas.casimirs().iter().map(|c| &c.expression);
        let functions: Vec<_> = std::iter::once(formulas.hamiltonian())
            .chain(casimirs)
            .collect();
        let parameters = system.parameter_values();
        let mut walk = Walk::new(&method, &parameters, 1.0, 0.5 * most, &initial);
        (0..STEPS).for_each(|_| walk.step().expect("a step"));
        let [before, after] = [&initial[..], walk.state()].map(|x| observe(&system, &functions, x));
        let pairs = after.iter().zip(&before);
        let drifts: Vec<f64> = pairs.map(|(after, before)| after - before).collect();
        let square: f64 = initial.iter().map(|x| x * x).sum();
        let wandered = 4.0 * libm::sqrt(STEPS as f64) * UNIT_ROUNDOFF * square;
        assert!(
            drifts[0].abs() <= 32.0 * wandered,
            "{}: energy {:e}",
            method.describe(),
            drifts[0]
        );
        for casimir in &drifts[1..] {
            assert!(
                casimir.abs() <= wandered,
                "{}: {casimir:e}, {wandered:e}",
                method.describe()
            );
        }
    }
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    for (system, initial, most) in systems() {
        let method = gauss(&system, 8);
        let parameters = system.parameter_values();
        let start = || Walk::new(&method, &parameters, 1.0, most, &initial);
        let (mut whole, mut resumed) = (start(), start());
        (0..20).for_each(|_| whole.step().expect("a step"));
        resumed
            .restore(&whole.checkpoint())
            .expect("its own checkpoint");
        for _ in 0..20 {
            whole.step().expect("a step");
            resumed.step().expect("a step");
            assert_eq!(whole.state(), resumed.state());
        }
    }
}

/// Leaves of lower dimension: rest rests, one sphere of so(4)* alone turns, a form of lower rank keeps it.
#[test]
fn singular_states_are_served() {
    for (system, initial, _) in systems() {
        let zero = vec![0.0; initial.len()];
        let end = run(&system, &gauss(&system, 4), (1.0, 0.1), 20, &zero);
        assert_eq!(end.expect("steps"), zero);
    }
    let so4 = library("so4").system;
    // m12 = m34, m13 = −m24, m14 = m23: of the two spheres one is a point.
    let left = [0.6, -0.3, 0.8, 0.8, 0.3, 0.6];
    let end = run(&so4, &gauss(&so4, 8), (1.0, 0.4), 10, &left).expect("steps");
    assert!(
        distance(&end, &flow(&so4, &left, 4.0, 64)) <= 1e-12,
        "{end:?}"
    );
    let sp4 = on_sp4();
    // z zᵀ.
    let z = [0.7, -0.2, 0.5, 0.4];
    let ones: Vec<f64> = (0..4)
        .flat_map(|a| (a..4).map(move |b| z[a] * z[b]))
        .collect();
    let end = run(&sp4, &gauss(&sp4, 8), (1.0, 0.1), 10, &ones).expect("steps");
    assert!(
        distance(&end, &flow(&sp4, &ones, 1.0, 64)) <= 1e-12,
        "{end:?}"
    );
}

#[test]
fn a_momentum_without_its_vector_is_refused() {
    let heavy = library("heavy-top").system;
    let refused = run(
        &heavy,
        &gauss(&heavy, 4),
        (1.0, 0.1),
        1,
        &[0.5, 0.1, 0.2, 0.0, 0.0, 0.0],
    );
    assert!(
        matches!(refused, Err(StepError::OutsideImage { .. })),
        "{refused:?}"
    );
}

#[test]
fn other_algebras_are_refused() {
    // The Heisenberg algebra.
    let other = from_formulas(&["x", "y", "z"], &[], &[("x,y", "z")], "x*y", &[]);
    let refused = realize(&other).map(|_| ());
    assert!(
        matches!(refused, Err(BuildError::DoesNotFit { .. })),
        "{refused:?}"
    );
}

/// All of the family, by a random H: their points have other signs.
#[test]
fn other_members_of_the_family_are_served() {
    for (name, d) in [("sp(2)", 3), ("so(2, 1)", 3), ("sp(6)", 21)] {
        let terms = (1..=d).map(|i| {
            let c = 0.2 + 0.07 * f64::from(i * 5 % 11);
            format!("{c}*x{i}^2 + {}*x{i}*x{}", 0.1 - 0.02 * c, i % d + 1)
        });
        let terms: Vec<String> = terms.collect();
        let system = on_algebra(name, &terms.join(" + "), &[]);
        for turn in [0.7, 1.0, 2.5] {
            let x: Vec<f64> = (0..d)
                .map(|i| 0.4 * libm::cos(turn * f64::from(i) + turn))
                .collect();
            let method = gauss(&system, 4);
            let error = structure_error(&system, &method, 0.1, &x).expect("a step");
            assert!(error.tensor <= 64.0, "{name}, {x:?}: {error:?}");
            let end = flow(&system, &x, 0.4, 64);
            let found = run(&system, &gauss(&system, 8), (1.0, 0.04), 10, &x).expect("steps");
            assert!(
                distance(&found, &end) <= 1e-12,
                "{name}: {found:?}, {end:?}"
            );
        }
    }
}
