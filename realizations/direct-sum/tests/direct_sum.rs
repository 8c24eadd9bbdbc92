//! The realization of a direct sum is exact.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use leafwise_core::{BuildError, PoissonSystem, RealizationData, Registry, StepMap, Walk};
use leafwise_direct_sum::DirectSum;
// Linked for the realizations that they register.
use leafwise_constant as _;
use leafwise_lie_poisson as _;
use leafwise_log_canonical as _;
use leafwise_so3 as _;
use leafwise_tests::methods::hamilton_jacobi;
use leafwise_tests::realizations::{assert_dual_pair, assert_orders, assert_poisson_steps};
use leafwise_tests::systems::from_formulas;

fn realization(system: &PoissonSystem) -> Result<Arc<dyn RealizationData>, BuildError> {
    Ok(Arc::new(DirectSum::realize(
        system,
        &Registry::with_builtin(),
    )?))
}

/// so(3)* beside two canonical coordinates, coupled by H.
fn body_and_pendulum() -> PoissonSystem {
    from_formulas(
        &["x", "y", "z", "q", "p"],
        &[("a", 1.5)],
        &[("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y"), ("q,p", "-a")],
        "x^2/2 + y^2/3 + z^2/5 + p^2/2 - cos(q) + z*q/4",
        &[("spin", "x^2 + y^2 + z^2")],
    )
}

/// Three species in a season: log-canonical beside the time and its energy.
fn species_in_seasons() -> PoissonSystem {
    from_formulas(
        &["x", "y", "z"],
        &[("a", 0.7)],
        &[("x,y", "x*y"), ("y,z", "a*y*z"), ("x,z", "-x*z")],
        "x + y + z + x*cos(t)/4",
        &[],
    )
}

/// Summands that are not contiguous: so(3)* rescaled, log-canonical, affine (sl(2)* in a place that is not its origin),
/// constant and a coordinate that rests, coupled by H.
fn five_summands() -> PoissonSystem {
    from_formulas(
        &["q", "x", "u", "a", "y", "v", "b", "c", "z", "p", "w"],
        &[("k", 0.8)],
        &[
            ("q,p", "-k"),
            ("x,y", "z/2"),
            ("y,z", "x/2"),
            ("z,x", "y/2"),
            ("u,v", "k*u*v"),
            ("a,b", "c + 1"),
            ("b,c", "a - k"),
            ("c,a", "-b"),
        ],
        "(q^2 + p^2)/2 + x^2/2 + y^2/3 + z^2 + u + v - ln(u) - ln(v) + a^2/2 + b*c/3 + q*x/4 + z*u/5 + a*p/6 + w*c",
        &[("spin", "x^2 + y^2 + z^2"), ("rest", "w")],
    )
}

/// A body, a pendulum and a second body whose coordinates stand between one another's, coupled by nothing.
fn three_apart() -> PoissonSystem {
    from_formulas(
        &["x", "q", "a", "y", "b", "p", "z", "c"],
        &[("k", 1.5)],
        &[
            ("x,y", "-z"),
            ("y,z", "-x"),
            ("z,x", "-y"),
            ("q,p", "-k"),
            ("a,b", "-c"),
            ("b,c", "-a"),
            ("c,a", "-b"),
        ],
        "x^2/2 + y^2/3 + z^2/5 + p^2/2 - cos(q) + a^2/3 + b^2/4 + k*c^2/7",
        &[("spin", "x^2 + y^2 + z^2"), ("other", "a^2 + b^2 + c^2")],
    )
}

/// Its summands, each with the places of its coordinates.
fn apart() -> [(Vec<usize>, PoissonSystem); 3] {
    let body = |names: [&str; 3], energy| {
        let [x, y, z] = names;
        let entries = [(x, y, z), (y, z, x), (z, x, y)];
        let entries = entries.map(|(i, j, k)| (format!("{i},{j}"), format!("-{k}")));
        let entries = entries.each_ref().map(|(at, e)| (at.as_str(), e.as_str()));
        from_formulas(&names, &[("k", 1.5)], &entries, energy, &[])
    };
    let pendulum = from_formulas(
        &["q", "p"],
        &[("k", 1.5)],
        &[("q,p", "-k")],
        "p^2/2 - cos(q)",
        &[],
    );
    [
        (
            vec![0, 3, 6],
            body(["x", "y", "z"], "x^2/2 + y^2/3 + z^2/5"),
        ),
        (vec![1, 5], pendulum),
        (
            vec![2, 4, 7],
            body(["a", "b", "c"], "a^2/3 + b^2/4 + k*c^2/7"),
        ),
    ]
}

fn all() -> [PoissonSystem; 4] {
    [
        body_and_pendulum(),
        species_in_seasons(),
        five_summands(),
        three_apart(),
    ]
}

#[test]
fn the_maps_are_a_dual_pair() {
    for system in all() {
        let exact = realization(&system).expect("a direct sum");
        assert_dual_pair(&system, &exact, (-1.0..1.0, -1.0..1.0, 0.01..1.0), 16.0);
    }
}

#[test]
fn steps_are_poisson_and_keep_casimirs() {
    for system in all() {
        let exact = realization(&system).expect("a direct sum");
        assert_poisson_steps(&system, &exact, 0.5..1.5, 0.05);
    }
}

#[test]
fn the_order_is_that_of_the_dynamics() {
    let orders = [
        (2, [40, 57, 80, 113]),
        (4, [20, 28, 40, 57]),
        (6, [12, 16, 22, 30]),
    ];
    let both: [(_, &[f64]); 2] = [
        (body_and_pendulum(), &[0.8, 0.5, -0.6, 0.7, 0.4]),
        (
            five_summands(),
            &[0.6, 0.8, 1.3, 0.2, 0.5, 0.9, 0.7, -0.4, -0.6, 0.3, 0.1],
        ),
    ];
    for (system, initial) in both {
        let exact = realization(&system).expect("a direct sum");
        assert_orders(&system, &exact, (initial, 1.0), &orders);
    }
}

/// Of each summand the cheapest, constant ones together.
#[test]
fn every_summand_has_a_realization_of_its_own() {
    let described = |system: &PoissonSystem| realization(system).map(|exact| exact.describe());
    assert_eq!(
        described(&five_summands()).expect("a direct sum"),
        "direct-sum of constant, so3-exponential, log-canonical and lie-poisson"
    );
    let bodies = from_formulas(
        &["x", "y", "z", "u", "v", "w", "q", "p", "Q", "P"],
        &[],
        &[
            ("x,y", "-z"),
            ("y,z", "-x"),
            ("z,x", "-y"),
            ("u,v", "-w"),
            ("v,w", "-u"),
            ("w,u", "-v"),
            ("q,p", "-1"),
            ("Q,P", "-1"),
        ],
        "x*u + q*P",
        &[],
    );
    assert_eq!(
        described(&bodies).expect("a direct sum"),
        "direct-sum of 2 so3-exponential and constant"
    );
}

/// A coordinate that rests is a summand; where all is constant, or one entry joins all, there is no sum.
#[test]
fn what_is_no_such_sum_is_refused() {
    let with = |bracket: &[(&str, &str)]| {
        let system = from_formulas(&["x", "y", "z", "c"], &[], bracket, "x + y*c", &[]);
        realization(&system).map(|realization| realization.describe())
    };
    let body = [("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y")];
    let described = with(&body).expect("so(3)* beside a coordinate that rests");
    assert_eq!(described, "direct-sum of so3-exponential and constant");
    let unfit = |bracket: &[(&str, &str)], reason: &str| {
        let error = with(bracket).expect_err("not a direct sum");
        assert!(matches!(error, BuildError::DoesNotFit { .. }), "{error}");
        assert!(error.to_string().contains(reason), "{error}");
    };
    unfit(&[("x,y", "1"), ("z,c", "2")], "is not a direct sum");
    // Every coordinate enters the entry, or is joined by it.
    unfit(&[("x,y", "c + z")], "is not a direct sum");
    unfit(
        &[("x,y", "1 + x^2")],
        "its summand of x, y has no code in pairs",
    );
}

/// Where H couples nothing, the code of an iteration, with and without Jacobians, has at most 1.1 of the operations of its summands'.
#[test]
fn a_product_costs_what_its_summands_do() {
    let body = from_formulas(
        &["x", "y", "z"],
        &[],
        &[("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y")],
        "x^2/2 + y^2/3 + z^2/5",
        &[],
    );
    let pendulum = from_formulas(&["q", "p"], &[], &[("q,p", "-1")], "p^2/2 - cos(q)", &[]);
    let both = from_formulas(
        &["x", "y", "z", "q", "p"],
        &[],
        &[("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y"), ("q,p", "-1")],
        "x^2/2 + y^2/3 + z^2/5 + p^2/2 - cos(q)",
        &[],
    );
    let of = |system: &PoissonSystem| {
        let registry = Registry::with_builtin();
        let exact = registry.exact_realization(system, false);
        exact.expect("an exact realization").realization
    };
    let work = |system: &PoissonSystem, order| {
        let method = hamilton_jacobi(system, &of(system), order);
        let newton = method.newton().expect("code");
        [newton.operations(), newton.residual_operations()].map(|count| count.work() as f64)
    };
    for order in [2, 4, 6] {
        let [product, first, second] = [&both, &body, &pendulum].map(|system| work(system, order));
        for kernel in 0..2 {
            let (product, apart) = (product[kernel], first[kernel] + second[kernel]);
            println!(
                "order {order}: {product} against {apart}, {:.3}",
                product / apart
            );
            assert!(
                product <= 1.1 * apart,
                "order {order}: {product} against {apart}"
            );
        }
    }
}

/// Summands that H does not couple are solved each by itself: their orbits are those of each alone, and the operations of all steps,
/// iterations, eliminations and starts included, are at most 1.1 times the sum of theirs.
#[test]
fn uncoupled_summands_move_as_each_alone() {
    const STEPS: u32 = 500;
    let initial = [0.8, 0.3, 0.5, 0.6, -0.4, 0.2, -0.7, 0.9];
    let run = |system: &PoissonSystem, initial: &[f64], order| {
        let registry = Registry::with_builtin();
        let exact = registry.exact_realization(system, false);
        let exact = exact.expect("an exact realization").realization;
        let method = hamilton_jacobi(system, &exact, order);
        let parameters = system.parameter_values();
        let mut walk = Walk::new(&method, &parameters, 1.0, 0.1, initial);
        walk.advance(STEPS.into()).expect("steps");
        let statistics = walk.statistics();
        (
            walk.state().to_vec(),
            statistics.operations.expect("code is counted"),
        )
    };
    for order in [2, 4, 6] {
        let (product, operations) = run(&three_apart(), &initial, order);
        let mut sum = 0;
        for (places, system) in apart() {
            let own: Vec<f64> = places.iter().map(|at| initial[*at]).collect();
            let (alone, operations) = run(&system, &own, order);
            sum += operations;
            // Sums may be formed in another order: a few roundings a step, which neighbouring orbits pull apart in proportion
            // to the steps.
            let bound = f64::from(STEPS * STEPS) * f64::EPSILON / 2.0;
            for (at, alone) in places.iter().zip(alone) {
                let difference = (product[*at] - alone).abs();
                assert!(difference <= bound, "order {order}, {at}: {difference:e}");
            }
        }
        println!("order {order}: {operations} operations against {sum}");
        assert!(
            operations as f64 <= 1.1 * sum as f64,
            "order {order}: {operations} operations against {sum}"
        );
    }
}

/// A lane of a product has the bits of its trajectory alone, one that failed disturbs no other and forgets, and a stepper that
/// is restored goes on to the same bits.
#[test]
fn uncoupled_summands_have_the_same_bits_in_lanes_and_from_memory() {
    const LANES: usize = 11;
    const LOST: usize = 4;
    let system = three_apart();
    let method = hamilton_jacobi(&system, &realization(&system).expect("a direct sum"), 4);
    let parameters = system.parameter_values();
    let d = system.dimension();
    let at = |i: usize, lane: usize| ((3 * i + 7 * lane + i * lane) % 19) as f64 / 19.0 - 0.45;
    let mut state: Vec<f64> = (0..d * LANES).map(|k| at(k / LANES, k % LANES)).collect();
    let spread: Vec<f64> = parameters.iter().flat_map(|k| [*k; LANES]).collect();
    let low = vec![0.0; d * LANES];
    let mut together = method.stepper(LANES, &spread, 1.0, 0.1);
    let mut alone: Vec<_> = (0..LANES)
        .map(|_| method.stepper(1, &parameters, 1.0, 0.1))
        .collect();
    for step in 0..40 {
        if step == 20 {
            let mut restored = method.stepper(LANES, &spread, 1.0, 0.1);
            restored
                .restore(&together.memory())
                .expect("its own memory");
            assert!(restored.restore(&[0.0]).is_err());
            together = restored;
        }
        // One summand's coordinate is no number once: the step fails as a whole.
        let kept = state[d / 2 * LANES + LOST];
        let is_lost = step == 10;
        if is_lost {
            state[d / 2 * LANES + LOST] = f64::NAN;
        }
        let (mut increment, mut outcome) = (vec![0.0; d * LANES], vec![Ok(()); LANES]);
        together.increment(&state, &low, &mut increment, &mut outcome);
        for (lane, stepper) in alone.iter_mut().enumerate() {
            let own: Vec<f64> = (0..d).map(|i| state[i * LANES + lane]).collect();
            let (mut change, mut result) = (vec![0.0; d], [Ok(())]);
            stepper.increment(&own, &low[..d], &mut change, &mut result);
            assert_eq!(outcome[lane], result[0]);
            assert_eq!(outcome[lane].is_err(), is_lost && lane == LOST);
            for (i, change) in change.iter().enumerate() {
                let found = increment[i * LANES + lane];
                assert_eq!(
                    found.to_bits(),
                    change.to_bits(),
                    "step {step}, lane {lane}, {i}"
                );
                assert!(outcome[lane].is_ok() || found == 0.0);
            }
            let (whole, single) = (together.tangent(lane), stepper.tangent(0));
            assert!(outcome[lane].is_err() || whole == single);
        }
        if is_lost {
            state[d / 2 * LANES + LOST] = kept;
        }
        state
            .iter_mut()
            .zip(&increment)
            .for_each(|(x, change)| *x += change);
    }
    assert_eq!(together.statistics().steps, 20 * LANES as u64);
}

/// Many steps in one call have the bits of as many calls, up to the step at which a summand is lost while its neighbours go on:
/// u' = u³ from 1 is gone at t = 1/2; u'' = −1/u² falls from rest at 1 into the pole at t = π/√8; and where
/// b' = 10b, a' = −30ab a check of the whole refuses the step that takes all digits of a.
#[test]
fn uncoupled_summands_go_their_whole_way_alone_to_the_same_bits() {
    for (energy, lost, v) in [
        ("u^3*v + a + b - ln(a*b)", 0.5, 0.2),
        ("v^2/2 - 1/u + a + b - ln(a*b)", 1.11, 0.0),
        ("(u^2 + v^2)/2 + 30*b + 10*ln(a)", 0.5, 0.0),
    ] {
        let system = from_formulas(
            &["q", "x", "y", "z", "p", "u", "v", "a", "b"],
            &[],
            &[
                ("q,p", "-1"),
                ("x,y", "-z"),
                ("y,z", "-x"),
                ("z,x", "-y"),
                ("u,v", "-1"),
                ("a,b", "a*b"),
            ],
            &format!("(q^2 + p^2)/2 + x^2/2 + y^2/4 + z^2/6 + {energy}"),
            &[],
        );
        let method = hamilton_jacobi(&system, &realization(&system).expect("a direct sum"), 2);
        let start = [0.3, 0.8, -0.4, 0.5, 0.1, 1.0, v, 1.2, 0.7];
        let walk = || Walk::new(&method, &[], 1.0, 0.01, &start);
        let (mut whole, mut single) = (walk(), walk());
        let mut failure = None;
        while failure.is_none() {
            failure = single.step().err();
        }
        let made = single.steps();
        println!("{energy}: {made} steps, then {failure:?}");
        assert!((0.5..1.2).contains(&(made as f64 * 0.01 / lost)), "{made}");
        let (mut before, mut beside) = (walk(), walk());
        before.advance(made).expect("steps");
        (0..made).for_each(|_| beside.step().expect("a step"));
        assert_eq!(before.checkpoint(), beside.checkpoint());
        assert_eq!(before.statistics(), beside.statistics());
        assert_eq!(whole.advance(1000).err(), failure);
        assert_eq!(whole.steps(), made);
        assert_eq!(whole.statistics(), single.statistics());
        assert_eq!(whole.checkpoint(), single.checkpoint());
        assert_eq!(whole.step(), single.step(), "what follows");
        assert_eq!(whole.checkpoint(), single.checkpoint());
    }
}
