//! `energy = "exact"`: H and Casimirs to round-off by multiples of Casimirs, which steps of H alone do not have.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::{Structure, Walk};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise_tests::scenes::{composed, end};

const BODY: &str = "[system]\nlibrary = \"rigid-body\"\n[method]\nrealization = \"so3-cayley\"\n\
    dynamics = { name = \"hamilton-jacobi\", order = ORDER }\nENERGY\ntime-step = STEP\n[run]\ninitial = [1, 3, 3]\nsteps = COUNT\n";

const TOP: &str = "[system]\nvariables = [\"m1\", \"m2\", \"m3\", \"g1\", \"g2\", \"g3\"]\n\
    bracket = { lie-algebra = \"e3\" }\nhamiltonian = \"m1^2/2 + m2^2/3 + m3^2/4 + 0.6*g1 + 0.3*g2 + 0.9*g3\"\n\
    casimirs = { gravity = \"(g1^2 + g2^2 + g3^2)/2\", vertical = \"m1*g1 + m2*g2 + m3*g3\" }\n[method]\nrealization = \"auto\"\n\
    dynamics = { name = \"hamilton-jacobi\", order = ORDER }\nENERGY\ntime-step = STEP\n[run]\ninitial = [0.5, 1.0, 1.5, 0.6, 0.0, 0.8]\nsteps = COUNT\n";

fn scene(text: &str, order: usize, is_exact: bool, (step, steps): (f64, u64)) -> ComposedRun {
    let energy = if is_exact { "energy = \"exact\"" } else { "" };
    let text = text.replace("ORDER", &order.to_string());
    let text = text.replace("ENERGY", energy);
    let text = text.replace("STEP", &format!("{step:?}"));
    composed(&text.replace("COUNT", &steps.to_string()))
}

/// The largest deviation of energy and Casimirs over all steps, in parts of the first values, and the last state.
fn followed(run: &ComposedRun) -> (Vec<f64>, Vec<f64>) {
    let mut invariants = run.invariants().expect("formulas");
    let mut walk = run.walk();
    let count = invariants.observables();
    let mut values = vec![0.0; count];
    invariants.evaluate(walk.state(), &mut values);
    let first = values.clone();
    let mut largest = vec![0.0_f64; count];
    let mut look = |walk: &Walk| {
        invariants.evaluate(walk.state(), &mut values);
        for ((largest, value), first) in largest.iter_mut().zip(&values).zip(&first) {
            *largest = largest.max((value / first - 1.0).abs());
        }
    };
    walk.watch(run.plan.steps, &mut look)
        .expect("a root at every step");
    (largest, run.own(walk.state()).to_vec())
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
}

/// The state at t = 20 by a method of high order and short steps.
fn reference(text: &str) -> Vec<f64> {
    end(&scene(text, 8, false, (0.005, 4000)))
}

/// H is rounded by an ulp for the rounding of the state, and one for its own; Casimirs walk at random with the steps.
#[test]
fn a_rigid_body_has_a_root_at_every_step() {
    let exact = reference(BODY);
    for order in [2, 4] {
        for (step, steps) in [(0.2, 100), (0.1, 200), (0.05, 400)] {
            let run = scene(BODY, order, true, (step, steps));
            assert_eq!(run.method.map().properties().structure, Structure::Leaves);
            let (drift, end) = followed(&run);
            let (plain, other) = followed(&scene(BODY, order, false, (step, steps)));
            let [own, given] = [distance(&end, &exact), distance(&other, &exact)];
            println!(
                "order {order}, h {step}: energy {:.1e} ({:.1e}), Casimir {:.1e}, state {own:.1e} ({given:.1e})",
                drift[0], plain[0], drift[1]
            );
            assert!(drift[0] <= 2.0 * f64::EPSILON, "{}", drift[0]);
            assert!(drift[1] <= 2e-15, "{}", drift[1]);
            assert!(own < given);
        }
    }
}

#[test]
fn the_heavy_top_takes_multiples_of_both_casimirs() {
    let exact = reference(TOP);
    for (step, steps) in [(0.1, 200), (0.05, 400)] {
        let (drift, end) = followed(&scene(TOP, 2, true, (step, steps)));
        let (plain, other) = followed(&scene(TOP, 2, false, (step, steps)));
        let [own, given] = [distance(&end, &exact), distance(&other, &exact)];
        println!(
            "h {step}: energy {:.1e} ({:.1e}), Casimirs {:.1e} {:.1e}, state {own:.1e} ({given:.1e})",
            drift[0], plain[0], drift[1], drift[2]
        );
        assert!(drift[0] <= 2e-15, "{}", drift[0]);
        assert!(drift[1].max(drift[2]) <= 1e2 * f64::EPSILON);
        assert!(2.0 * own < given, "{own:e} {given:e}");
    }
}

/// Over 10⁵ steps the energy has no trend: every step comes back to that of the first state.
#[test]
fn a_hundred_thousand_steps_have_no_trend() {
    let (drift, _) = followed(&scene(BODY, 4, true, (0.1, 100_000)));
    println!("energy {:.1e}, Casimir {:.1e}", drift[0], drift[1]);
    assert!(drift[0] <= 4.0 * f64::EPSILON, "{}", drift[0]);
    // A random walk of 10⁵ roundings.
    assert!(drift[1] <= 316.0 * 4.0 * f64::EPSILON, "{}", drift[1]);
}

/// Steps from a first to one that has no root, at most so many, and why.
fn until_lost(run: &ComposedRun, steps: u64) -> (u64, Option<String>) {
    let mut walk = run.walk();
    for step in 0..steps {
        if let Err(error) = walk.advance(1) {
            return (step, Some(error.to_string()));
        }
    }
    (steps, None)
}

/// Newton's method in both multiples finds a root where lines of multiples lost it within t = 4. A step without one has errors of one
/// sign alone, which is told with its size.
#[test]
fn the_heavy_top_has_roots_until_none_is_there() {
    let mut whole = 0;
    for (step, steps) in [
        (0.2, 100),
        (0.13, 300),
        (0.1, 400),
        (0.07, 500),
        (0.05, 600),
    ] {
        let run = scene(TOP, 2, true, (step, steps));
        let (made, why) = until_lost(&run, steps);
        println!("h {step}: {made} of {steps} {why:?}");
        whole += usize::from(why.is_none());
        if let Some(why) = why {
            assert!(made as f64 * step > 20.0, "{why}");
            assert!(
                why.contains("the same sign") && why.contains("of H(x_0) = "),
                "{why}"
            );
        }
    }
    assert!(whole >= 3);
}

/// Over 10⁷ steps neither: the body's energy is within 4 roundings, that of the top, a sum of six terms, within 9, and the Casimir
/// walks by 4ε√n at most. The heavy top is that of Lagrange,
/// whose fast regular motion stays away from states without a root.
#[test]
#[ignore = "minutes"]
fn ten_million_steps_have_no_trend() {
    let steps = 10_000_000;
    let fast = TOP
        .replace(
            "m1^2/2 + m2^2/3 + m3^2/4 + 0.6*g1 + 0.3*g2 + 0.9*g3",
            "m1^2/2 + m2^2/2 + m3^2/1.2 + 0.9*g3",
        )
        .replace(
            "[0.5, 1.0, 1.5, 0.6, 0.0, 0.8]",
            "[0.3, 0.2, 3.0, 0.6, 0.0, 0.8]",
        );
    for (text, order, energy) in [(BODY, 4, 4.0 * f64::EPSILON), (fast.as_str(), 2, 2e-15)] {
        let run = scene(text, order, true, (0.1, steps));
        let (made, why) = until_lost(&scene(text, order, true, (0.1, 100_000)), 100_000);
        println!("{made} {why:?}");
        assert!(why.is_none());
        let (drift, _) = followed(&run);
        println!("energy {:.1e}, Casimirs {:?}", drift[0], &drift[1..]);
        assert!(drift[0] <= energy, "{}", drift[0]);
        let walk = 4.0 * f64::EPSILON * libm::sqrt(steps as f64);
        assert!(drift[1..].iter().all(|drift| *drift <= walk), "{drift:?}");
    }
}

/// The order is that of the steps: λ is bounded.
#[test]
fn the_order_stays() {
    for order in [2, 4] {
        let exact = reference(BODY);
        let errors = [40_u64, 80, 160, 320].map(|steps| {
            let step = 20.0 / steps as f64;
            (
                step,
                distance(
                    &followed(&scene(BODY, order, true, (step, steps))).1,
                    &exact,
                ),
            )
        });
        let slopes = errors
            .windows(2)
            .map(|pair| libm::log(pair[0].1 / pair[1].1) / libm::log(pair[0].0 / pair[1].0));
        let slopes: Vec<f64> = slopes.collect();
        println!("order {order}: {errors:?} {slopes:?}");
        assert!((slopes[2] - order as f64).abs() < 0.3, "{slopes:?}");
    }
}

/// A run that goes on from a checkpoint has the bits of one that does not stop.
#[test]
fn the_multiples_are_in_the_memory() {
    let run = scene(TOP, 2, true, (0.1, 50));
    let mut whole = run.walk();
    whole.advance(50).expect("steps");
    let mut first = run.walk();
    first.advance(23).expect("steps");
    let mut second = run.walk();
    second
        .restore(&first.checkpoint())
        .expect("of the same map");
    second.advance(27).expect("steps");
    assert_eq!(whole.checkpoint(), second.checkpoint());
}

#[test]
fn what_it_does_not_stand_beside_is_refused() {
    let registry = leafwise::core::Registry::with_builtin();
    let body = BODY
        .replace("ORDER", "2")
        .replace("STEP", "0.1")
        .replace("COUNT", "5");
    let body = body.replace("ENERGY", "energy = \"exact\"");
    let canonical = "[system]\nvariables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - cos(q)\"\n[method]\n\
        realization = \"auto\"\ndynamics = \"auto\"\nenergy = \"exact\"\ntime-step = 0.1\n[run]\ninitial = [1, 0]\nsteps = 5\n";
    for (text, message, help) in [
        (
            canonical.to_owned(),
            "declares no Casimirs",
            "a higher order",
        ),
        (
            body.replace("order = 2", "order = 2, hamiltonian = \"energy-casimir\""),
            "removes every multiple",
            "leave `hamiltonian` out",
        ),
        (
            body.replace(
                "realization = \"so3-cayley\"",
                "realization = { name = \"karasev-truncated\", order = 4 }",
            ),
            "do not keep Casimirs",
            "take an exact realization",
        ),
    ] {
        let document = SceneDocument::parse("refused.toml", &text, &registry).expect("a scene");
        let refused = compose(&document, &registry).err().expect(message);
        let said = refused.to_string();
        assert!(said.contains(message) && said.contains(help), "{said}");
    }
}
