//! Steps of many equations, each of which couples a few coordinates.

use leafwise_core::{Convention, PartParameters, PoissonSystem, StepMap, Walk};

use crate::common::{map, none, run, system};

/// Implicit parts.
fn implicit() -> [(&'static str, PartParameters); 6] {
    [
        ("energy-preserving", none()),
        ("energy-preserving", none().with("order", 4)),
        ("implicit-midpoint", none()),
        ("gauss", none().with("stages", 2)),
        ("gauss", none().with("stages", 3)),
        ("projection", none().with("base", "gauss")),
    ]
}

/// So many pendula that do not know of one another.
fn pendula(count: usize) -> PoissonSystem {
    copies(count, "-cos(q)")
}

/// So many copies of a particle in a potential of q.
fn copies(count: usize, potential: &str) -> PoissonSystem {
    let pairs: Vec<((usize, usize), &str)> = (1..=count).map(|i| ((i, count + i), "1")).collect();
    let terms = (1..=count).map(|i| {
        let potential = potential.replace('q', &format!("x{i}"));
        format!("x{}^2/2 + {potential}", count + i)
    });
    let hamiltonian = terms.collect::<Vec<_>>().join(" + ");
    system(
        2 * count,
        &pairs,
        &hamiltonian,
        &[],
        Convention::HamiltonianFirst,
    )
}

/// The same number in half of the coordinates, and another one in the other half.
fn all(count: usize, [q, p]: [f64; 2]) -> Vec<f64> {
    [vec![q; count], vec![p; count]].concat()
}

/// A solve that needs no matrix takes operations in proportion to the coordinates, one that eliminates their cube.
#[test]
fn steps_of_many_equations_cost_as_much_as_their_fields() {
    for (name, parameters) in implicit() {
        let operations = |count: usize| {
            let map = map(name, &pendula(count), &parameters);
            let (mut stepper, x) = (map.stepper(1, &[], 0.5, 0.2), all(count, [0.5, 0.3]));
            let mut increment = vec![0.0; x.len()];
            let mut outcome = [Ok(())];
            stepper.increment(&x, &vec![0.0; x.len()], &mut increment, &mut outcome);
            assert_eq!(outcome, [Ok(())], "{name}");
            stepper.statistics().operations.expect("counted") as f64
        };
        let ratio = operations(128) / operations(64);
        assert!(ratio < 2.5, "{name} {parameters:?}: {ratio}");
    }
}

/// A standing wave: coordinates that are sums of others near 0 are round-off, which hides no convergence.
#[test]
fn coordinates_of_round_off_ask_for_no_matrix() {
    let chain = |count: usize| {
        let pairs: Vec<((usize, usize), &str)> =
            (1..=count).map(|i| ((i, count + i), "1")).collect();
        let terms = (1..=count).map(|i| {
            let next = i % count + 1;
            format!(
                "x{}^2/2 + (x{next} - x{i})^2/2 + (x{next} - x{i})^4/4",
                count + i
            )
        });
        let hamiltonian = terms.collect::<Vec<_>>().join(" + ");
        system(
            2 * count,
            &pairs,
            &hamiltonian,
            &[],
            Convention::HamiltonianFirst,
        )
    };
    for (name, parameters) in implicit().into_iter().take(5) {
        let operations = |count: usize| {
            let map = map(name, &chain(count), &parameters);
            let turn = std::f64::consts::TAU / count as f64;
            let wave = (0..count).map(|i| libm::sin(turn * i as f64));
            let mut walk = Walk::new(map.as_ref(), &[], 0.5, 0.2, &{
                let mut start: Vec<f64> = wave.collect();
                start.resize(2 * count, 0.0);
                start
            });
            (0..20).for_each(|_| walk.step().expect("a step"));
            walk.statistics().operations.expect("counted") as f64
        };
        let ratio = operations(256) / operations(128);
        assert!(ratio < 2.5, "{name} {parameters:?}: {ratio}");
    }
}

/// Each moves as one alone, whose few equations are solved by Newton's method: over short steps, and over steps as long as a
/// seventh to three sevenths of a period, where fixed points do not converge. Errors of a solve are round-off, which an orbit of 20
/// steps takes on by their angles: 20 · 10 of them at a few units each.
#[test]
fn many_equations_have_the_solution_of_few() {
    let count = 64;
    for (name, parameters) in implicit() {
        let [many, one] = [count, 1].map(|count| map(name, &pendula(count), &parameters));
        for (step, steps) in [(0.1, 20), (1.0, 20), (2.5, 4)] {
            let start = [0.5, 0.3];
            let expected = run(one.as_ref(), step, steps, &start);
            let found = run(many.as_ref(), step, steps, &all(count, start));
            for (at, value) in found.iter().enumerate() {
                let error = (value - expected[at / count]).abs();
                assert!(
                    error <= 1e3 * f64::EPSILON,
                    "{name} {parameters:?}, step {step}: {error:e}"
                );
            }
        }
    }
}

/// So many tops that do not know of one another: their moments one behind the other.
fn tops(count: usize) -> PoissonSystem {
    let of_one = |top: usize| {
        let [x, y, z] = [1, 2, 3].map(|c| 3 * top + c);
        [
            ((x, y), format!("-x{z}")),
            ((x, z), format!("x{y}")),
            ((y, z), format!("-x{x}")),
        ]
    };
    let entries: Vec<((usize, usize), String)> = (0..count).flat_map(of_one).collect();
    let entries: Vec<((usize, usize), &str)> = (entries.iter())
        .map(|(at, entry)| (*at, entry.as_str()))
        .collect();
    let terms = (0..count).map(|top| {
        let [x, y, z] = [1, 2, 3].map(|c| 3 * top + c);
        format!("x{x}^2/2 + x{y}^2/1.5 + x{z}^2/2.5")
    });
    let hamiltonian = terms.collect::<Vec<_>>().join(" + ");
    system(
        3 * count,
        &entries,
        &hamiltonian,
        &[],
        Convention::HamiltonianFirst,
    )
}

/// Spins of many equations turn as one alone does, keep their lengths to round-off, and need no matrix either.
#[test]
fn many_spins_turn_as_one_alone() {
    let start = [0.6, 0.64, -0.48];
    let maps = [64, 32, 1].map(|count| map("spherical-midpoint", &tops(count), &none()));
    let [more, many, one] = &maps;
    for (step, steps) in [(0.1, 200), (1.5, 20)] {
        let expected = run(one.as_ref(), step, steps, &start);
        let found = run(many.as_ref(), step, steps, &start.repeat(32));
        for spin in found.chunks_exact(3) {
            for (value, expected) in spin.iter().zip(&expected) {
                let error = (value - expected).abs();
                assert!(error <= 1e3 * f64::EPSILON, "step {step}: {error:e}");
            }
            let square: f64 = spin.iter().map(|x| x * x).sum();
            assert!((square - 1.0).abs() <= 16.0 * f64::EPSILON, "{square}");
        }
    }
    let operations = |map: &dyn StepMap| {
        let (mut stepper, x) = (
            map.stepper(1, &[], 0.5, 0.2),
            start.repeat(map.dimension() / 3),
        );
        let mut increment = vec![0.0; x.len()];
        stepper.increment(&x, &vec![0.0; x.len()], &mut increment, &mut [Ok(())]);
        stepper.statistics().operations.expect("counted") as f64
    };
    let ratio = operations(more.as_ref()) / operations(many.as_ref());
    assert!(ratio < 2.5, "{ratio}");
}

/// The derivative of a step is there too.
#[test]
fn many_equations_have_a_tangent() {
    let count = 48;
    for (name, parameters) in implicit().into_iter().take(5) {
        let tangent = |count: usize| {
            let map = map(name, &pendula(count), &parameters);
            let (mut stepper, x) = (map.stepper(1, &[], 0.5, 0.2), all(count, [0.5, 0.3]));
            let mut increment = vec![0.0; x.len()];
            stepper.increment(&x, &vec![0.0; x.len()], &mut increment, &mut [Ok(())]);
            stepper.tangent(0).expect("an exact tangent")
        };
        let (one, many) = (tangent(1), tangent(count));
        let d = 2 * count;
        for row in 0..d {
            for column in 0..d {
                let is_own = row % count == column % count;
                let own = one[2 * (row / count) + column / count];
                let expected = if is_own { own } else { 0.0 };
                let error = (many[row * d + column] - expected).abs();
                assert!(
                    error <= 1e2 * f64::EPSILON,
                    "{name} {parameters:?}: {error:e}"
                );
            }
        }
    }
}

/// Where several solutions solve a long step, many equations have the one that few have, which is connected with the state; where
/// few have none, many have none.
#[test]
fn many_equations_stay_on_the_branch_of_few() {
    let count = 48;
    let (mut solved, mut refused) = (0, 0);
    for potential in [
        "-cos(q)",
        "q^4/4",
        "q^4/4 - q^2/2",
        "0 - 1/(1 + q^2)",
        "q^2/2 + 0.3*sin(3*q)",
    ] {
        for (name, parameters) in implicit().into_iter().take(5) {
            let [many, one] =
                [count, 1].map(|count| map(name, &copies(count, potential), &parameters));
            for (step, angle) in [0.3, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0]
                .into_iter()
                .flat_map(|step| (0..4).map(move |k| (step, 1.7 * f64::from(k))))
            {
                let start = [1.5 * libm::cos(angle), 1.5 * libm::sin(angle)];
                let taken = |map: &dyn StepMap, x: &[f64]| {
                    let mut stepper = map.stepper(1, &[], 0.5, 2.0 * step);
                    let mut increment = vec![0.0; x.len()];
                    let mut outcome = [Ok(())];
                    stepper.increment(x, &vec![0.0; x.len()], &mut increment, &mut outcome);
                    outcome[0].clone().map(|()| increment)
                };
                let case =
                    format!("{name} {parameters:?}, {potential}, step {step} from {start:?}");
                let found = taken(many.as_ref(), &all(count, start));
                match (taken(one.as_ref(), &start), found) {
                    (Ok(expected), Ok(found)) => {
                        solved += 1;
                        let size = expected.iter().fold(1.0_f64, |most, v| most.max(v.abs()));
                        for (at, value) in found.iter().enumerate() {
                            let error = (value - expected[at / count]).abs();
                            // Stages of stiff steps multiply round-off by their Jacobian, some ten squared.
                            assert!(error <= 1e3 * f64::EPSILON * size, "{case}: {error:e}");
                        }
                    }
                    (Err(_), Err(_)) => refused += 1,
                    (expected, found) => panic!("{case}: {expected:?}, {found:?}"),
                }
            }
        }
    }
    assert!(solved > 400, "{solved} of {}", solved + refused);
}
