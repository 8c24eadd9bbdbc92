//! The tuner: what it recommends holds what is asked, and compare's grid has nothing much cheaper.

use crate::scenes::scene;
use leafwise::core::Registry;
use leafwise::prelude::compose;
use leafwise::scene::SceneDocument;
use leafwise::trade::{
    Bench, CompareOptions, Comparison, Judged, Limit, Measured, Recommendation, Reference, Stage,
    Tolerances, TradeError, TuneOptions, Tuner, Tuning, compare, distance, parse_method,
};

fn asked(error: f64) -> Tolerances {
    Tolerances {
        error: Some(error),
        ..Tolerances::default()
    }
}

fn tune(tuner: &Tuner<'_>, asked: Tolerances) -> Tuning {
    tuner.tune(&asked, &mut |_| true).expect("a search")
}

/// Nothing on the grid that meets `error` is more than 1.3 times cheaper.
fn is_cheapest(
    found: &Recommendation,
    comparison: &Comparison,
    error: f64,
    counts: impl Fn(&Measured) -> bool,
) {
    let cost = found.measured.operations.expect("counted");
    for point in &comparison.points {
        let Ok(measured) = &point.outcome else {
            continue;
        };
        if measured.error > error || !counts(measured) {
            continue;
        }
        let other = measured.operations.expect("counted");
        assert!(
            cost as f64 <= 1.3 * other as f64,
            "{} takes {cost} for {error:e}, {} at {} only {other}",
            found.name,
            comparison.methods[point.method].name,
            point.setting
        );
    }
}

/// The scene as it would be written, stepped by itself.
fn rerun(found: &Recommendation, registry: &Registry) -> Vec<f64> {
    let document = SceneDocument::parse("tuned.toml", &found.scene, &Registry::with_builtin())
        .expect("a scene");
    let run = compose(&document, registry).expect("a run");
    let mut walk = run.walk();
    (0..run.plan.steps).for_each(|_| walk.step().expect("a step"));
    walk.state().to_vec()
}

fn tuned_at_1e_4_and_1e_8(document: &SceneDocument) {
    tuned_over(document, None);
}

fn tuned_over(document: &SceneDocument, time: Option<f64>) {
    let registry = Registry::with_builtin();
    let bench = Bench::new(document, &registry, time).expect("a bench");
    let tuner = Tuner::new(&bench, &TuneOptions::default(), &mut |_| true).expect("methods");
    let asked_for = [1e-4, 1e-8].map(|error| (error, tune(&tuner, asked(error))));
    // What costs more than a recommendation cannot show that it is dear.
    let found = |(_, tuning): &(f64, Tuning)| {
        let recommended = [&tuning.poisson, &tuning.any].map(Option::as_ref);
        recommended.map(|found| found.and_then(|found| found.measured.operations))
    };
    let dearest = asked_for.iter().flat_map(found).flatten().max();
    let options = CompareOptions {
        budget: dearest,
        ..CompareOptions::default()
    };
    let comparison = compare(&bench, &options, &mut |_, _, _| true).expect("a comparison");
    assert_eq!(tuner.reference(), &comparison.reference);
    for (error, tuning) in asked_for {
        let poisson = tuning.poisson.as_ref().expect("a Poisson map");
        let any = tuning.any.as_ref().expect("a method");
        for found in [poisson, any] {
            let state = rerun(found, &registry);
            let measured = distance(&state, &tuner.reference().state);
            assert_eq!(
                measured, found.measured.end_error,
                "{}: as it will be run",
                found.name
            );
            let measured = found.measured.error;
            assert!(measured >= found.measured.end_error);
            assert!(
                measured + tuner.reference().error <= error,
                "{}: {measured:e}",
                found.name
            );
            if let Some(predicted) = found.predicted {
                let operations = found.measured.operations.expect("counted") as f64;
                // The cost closely; the error by its order of magnitude, and from above alone: at
                // single steps terms of opposite sign cancel, which no neighbour can tell.
                let near = |a: f64, b: f64, factor: f64| a < factor * b && b < factor * a;
                assert!(
                    measured < 10.0 * predicted.error,
                    "{}: {predicted:?}",
                    found.name
                );
                assert!(
                    near(predicted.cost, operations, 1.5),
                    "{}: {predicted:?}",
                    found.name
                );
            }
        }
        assert!(poisson.measured.is_poisson);
        is_cheapest(poisson, &comparison, error, |m| m.is_poisson);
        is_cheapest(any, &comparison, error, |_| true);
        assert!(any.measured.operations <= poisson.measured.operations);
        let cost = |r: &Recommendation| r.measured.operations.expect("counted");
        for runner in &tuning.runners_up {
            let best = if runner.is_poisson { poisson } else { any };
            assert!(
                runner.cost >= cost(best) && runner.error <= error,
                "{runner:?}"
            );
        }
    }
}

#[test]
fn the_rigid_body_is_tuned() {
    tuned_at_1e_4_and_1e_8(&scene("rigid-body", "[1, 3, 3]", 0.2, 100));
}

#[test]
fn the_periodic_lotka_volterra_system_is_tuned() {
    tuned_at_1e_4_and_1e_8(&scene(
        "lotka-volterra-periodic",
        "[1, 1.9, 0.5]",
        0.05,
        400,
    ));
}

#[test]
fn the_magnetic_particle_is_tuned() {
    let initial = "[1.0, 0.5, -0.5, 0.3, 0.2, 0.4]";
    tuned_at_1e_4_and_1e_8(&scene("magnetic", initial, 0.1, 200));
}

fn lattice(sites: usize, steps: u64) -> SceneDocument {
    let text = format!(
        "[system]\nlibrary = \"volterra-lattice\"\nfamilies = {{ x = {sites} }}\n[method]\n\
         realization = {{ name = \"karasev-truncated\", order = 2 }}\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = 0.1\n[run]\n\
         initial = {{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }}\nsteps = {steps}\n"
    );
    SceneDocument::parse("lattice.toml", &text, &Registry::with_builtin()).expect("a scene")
}

#[test]
fn a_lattice_of_64_sites_is_tuned() {
    tuned_at_1e_4_and_1e_8(&lattice(64, 200));
}

/// A scene of the gallery, with some of its values replaced.
fn of_the_gallery(name: &str, overrides: &[(&str, &str)]) -> SceneDocument {
    let file = format!("{}/../scenes/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(file).expect("a scene");
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    let overrides: Vec<_> = overrides.iter().map(owned).collect();
    SceneDocument::parse_with(name, &text, &overrides, &Registry::with_builtin()).expect("a scene")
}

#[test]
#[ignore = "a minute: the gallery's rigid body to its end, t = 200"]
fn the_rigid_body_is_tuned_to_the_end_of_its_scene() {
    tuned_over(&of_the_gallery("rigid_body.toml", &[]), None);
}

#[test]
#[ignore = "minutes: the gallery's orbit to its end, t = 900"]
fn the_periodic_lotka_volterra_system_is_tuned_to_the_end_of_its_scene() {
    tuned_over(&of_the_gallery("lotka_volterra_periodic.toml", &[]), None);
}

/// The orbit is chaotic: beyond t = 600 the round-off of one step grows above 1e-8 until the end.
#[test]
#[ignore = "minutes: the gallery's particle to t = 500"]
fn the_magnetic_particle_is_tuned_as_far_as_its_state_can_be_known() {
    tuned_over(&of_the_gallery("magnetic.toml", &[]), Some(500.0));
}

#[test]
#[ignore = "minutes: the gallery's lattice with 64 sites to its end, t = 100"]
fn a_lattice_of_64_sites_is_tuned_to_the_end_of_its_scene() {
    let sites = [("system.families.x", "64")];
    tuned_over(&of_the_gallery("volterra_lattice.toml", &sites), None);
}

#[test]
fn invariants_are_held_at_every_step_and_cost_what_they_cost() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 100);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    // Without the body's exact flow, which keeps everything.
    let methods = [
        "auto+hamilton-jacobi:4",
        "blanes-moan-6/splitting",
        "kahan-li-8/splitting",
        "dop853",
    ];
    let options = TuneOptions {
        only: methods
            .map(|text| parse_method(text, &registry).expect("a method"))
            .into(),
        ..TuneOptions::default()
    };
    let tuner = Tuner::new(&bench, &options, &mut |_| true).expect("methods");
    let loose = tune(&tuner, asked(1e-4));
    let held = tune(
        &tuner,
        Tolerances {
            energy: Some(1e-9),
            casimirs: Some(1e-12),
            ..asked(1e-4)
        },
    );
    let (loose, held) = (loose.any.expect("a method"), held.any.expect("a method"));
    assert!(
        loose.measured.energy_drift > 1e-9,
        "the energy is what is hard"
    );
    assert!(held.measured.error <= 1e-4 && held.measured.energy_drift <= 1e-9);
    assert!(held.measured.casimir_drift.expect("a Casimir") <= 1e-12);
    assert!(held.measured.operations > loose.measured.operations);

    // Invariants alone need no end state; relative ones are in units of H(0) and |x(0)|².
    let energy = tune(
        &tuner,
        Tolerances {
            energy: Some(1e-4),
            relative: true,
            ..Tolerances::default()
        },
    );
    let found = energy.any.expect("a method");
    let initial = 0.5 + 6.0 + 3.6;
    assert!(found.measured.energy_drift <= 1e-4 * initial);
    assert!(found.measured.operations < loose.measured.operations);
}

#[test]
fn what_cannot_be_held_says_what_keeps_it() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 10);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let only = |text: &str, budget: Option<u64>| {
        let options = TuneOptions {
            only: vec![parse_method(text, &registry).expect("a method")],
            budget,
            ..TuneOptions::default()
        };
        Tuner::new(&bench, &options, &mut |_| true).expect("a method")
    };
    let hamilton_jacobi = "so3-exponential+hamilton-jacobi:4";
    // Beyond the reference: nothing is run, and no shorter time helps against round-off.
    let tuning = tune(&only(hamilton_jacobi, None), asked(1e-16));
    assert!(tuning.poisson.is_none() && tuning.nearest.is_none() && tuning.runs == 0);
    assert_eq!(tuning.limit, Some(Limit::Reference));
    let horizon = tuning.horizon.expect("why");
    assert!(horizon.known.is_none() && horizon.wanted < horizon.round_off);
    assert!(horizon.to_string().contains("raise the bound"), "{horizon}");
    // So little that no run comes to its end: what was spent is reported all the same.
    let tuning = tune(&only(hamilton_jacobi, Some(100)), asked(1e-8));
    assert!(tuning.poisson.is_none() && tuning.nearest.is_none());
    assert_eq!(tuning.limit, Some(Limit::Budget));
    // Too dear.
    let tuning = tune(&only(hamilton_jacobi, Some(20_000)), asked(1e-8));
    let nearest = tuning.nearest.expect("something was run");
    assert_eq!(nearest.limit, Limit::Budget);
    assert_eq!(nearest.missed, "state");
    assert!(tuning.spent > 0 && tuning.runs > 0);
    assert!(nearest.ratio > 1.0 && nearest.error > 1e-8, "{nearest:?}");
    // Round-off: no step makes the energy exact.
    let tuning = tune(
        &only(hamilton_jacobi, None),
        Tolerances {
            energy: Some(1e-17),
            ..Tolerances::default()
        },
    );
    let nearest = tuning.nearest.expect("something was run");
    assert_eq!(
        (nearest.limit, nearest.missed.as_str()),
        (Limit::RoundOff, "energy")
    );
    // A Poisson map is asked for, and a baseline alone is allowed.
    let tuning = tune(&only("dop853", None), asked(1e-6));
    assert!(tuning.poisson.is_none() && tuning.any.is_some() && tuning.nearest.is_none());
    assert_eq!(tuning.limit, Some(Limit::Structure));
}

/// q̇ = −q and ṗ = p, or the reverse: of a change (q, −p)·δ at (1, 1) the length grows by
/// √((e^{2T} + e^{−2T})/2).
#[test]
fn the_growth_of_a_small_change_is_the_flows() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\n\
                hamiltonian = \"q*p\"\n[method]\nrealization = \"auto\"\n\
                dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.1\n[run]\n\
                initial = [1, 1]\nsteps = 100\n";
    let document =
        SceneDocument::parse("saddle.toml", text, &Registry::with_builtin()).expect("a scene");
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let reference = Reference::compute(&bench, Judged::AtTheEnd).expect("a reference");
    let growth = reference.horizon(&bench, 1e-9).growth.expect("followed");
    let expected = libm::sqrt((libm::exp(20.0) + libm::exp(-20.0)) / 2.0);
    // A change of 1e-8 of the state is rounded to 2e-8 of itself at each of 100 steps and when it is
    // made small again.
    assert!(
        (growth / expected - 1.0).abs() < 1e-5,
        "{growth:e} {expected:e}"
    );
}

/// The gallery's particle is chaotic: at its end, t = 1000, no double holds its state to eight digits.
#[test]
fn a_motion_that_cannot_be_followed_is_reported_with_its_growth_and_the_time_to_take() {
    let document = of_the_gallery("magnetic.toml", &[]);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let options = TuneOptions {
        only: vec![parse_method("kahan-li-8/splitting", &registry).expect("a method")],
        ..TuneOptions::default()
    };
    let tuner = Tuner::new(&bench, &options, &mut |_| true).expect("a method");
    assert!(tuner.reference().error > 1e-8);
    let tuning = tune(&tuner, asked(1e-8));
    assert_eq!((tuning.limit, tuning.runs), (Some(Limit::Reference), 0));
    assert!(tuning.poisson.is_none() && tuning.any.is_none());
    let horizon = tuning.horizon.expect("why");
    // What rounding does at the beginning is larger than what is asked at the end.
    let growth = horizon.growth.expect("followed");
    let size = 1.3;
    assert!(growth * f64::EPSILON * size > 1e-8, "{growth:e}");
    // To the time that is offered it can be done.
    let known = horizon.known.expect("a shorter time");
    assert!(known.time < 1000.0 && 10.0 * known.error <= 1e-8);
    let shorter = bench.over(known.time).expect("a bench");
    let tuner = Tuner::new(&shorter, &options, &mut |_| true).expect("a method");
    let found = tune(&tuner, asked(1e-8)).poisson.expect("a Poisson map");
    assert!(found.measured.error + tuner.reference().error <= 1e-8);
    let message = horizon.to_string();
    assert!(
        message.contains(&format!("--time {}", known.time)),
        "{message}"
    );
}

#[test]
fn casimirs_are_not_asked_of_a_scene_without_any() {
    let initial = "[1.0, 0.5, -0.5, 0.3, 0.2, 0.4]";
    let document = scene("magnetic", initial, 0.1, 10);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let held = Tolerances {
        casimirs: Some(1e-12),
        ..asked(1e-4)
    };
    assert!(matches!(held.check(&bench), Err(TradeError::NoCasimirs)));
    let options = TuneOptions {
        only: vec![parse_method("splitting", &registry).expect("a method")],
        ..TuneOptions::default()
    };
    let tuner = Tuner::new(&bench, &options, &mut |_| true).expect("a method");
    let refused = tuner.tune(&held, &mut |_| true);
    assert!(matches!(refused, Err(TradeError::NoCasimirs)));
}

#[test]
fn a_search_repeats_and_can_be_ended() {
    let document = scene("lotka-volterra-periodic", "[1, 1.9, 0.5]", 0.05, 60);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let methods = ["auto+hamilton-jacobi:4", "kahan-li-6/splitting", "dop853"];
    let options = TuneOptions {
        only: methods
            .map(|text| parse_method(text, &registry).expect("a method"))
            .to_vec(),
        ..TuneOptions::default()
    };
    let tuner = Tuner::new(&bench, &options, &mut |_| true).expect("methods");
    let once = tune(&tuner, asked(1e-6));
    let again = tune(&tuner, asked(1e-6));
    let scenes = |t: &Tuning| [&t.poisson, &t.any].map(|r| r.as_ref().map(|r| r.scene.clone()));
    assert_eq!(scenes(&once), scenes(&again));
    assert_eq!((once.runs, once.spent), (again.runs, again.spent));
    assert!(once.is_complete);
}

/// Time is counted by whoever asks: here by the number of stages.
#[test]
fn a_search_that_is_ended_returns_what_it_has() {
    let document = scene("lotka-volterra-periodic", "[1, 1.9, 0.5]", 0.05, 60);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let (mut told, mut referred) = (0, false);
    let tuner = Tuner::new(&bench, &TuneOptions::default(), &mut |stage| {
        match stage {
            Stage::Building { .. } => told += 1,
            Stage::Reference => referred = true,
            Stage::Running { .. } => panic!("a run before the search"),
        }
        told <= 3
    })
    .expect("methods");
    assert!(referred && told > 3, "{told} methods");
    assert!((1..=3).contains(&tuner.methods().count()));
    assert!(tuner.unbuilt() > 0);
    for most in 0..6_u64 {
        let mut allowed = 0;
        let ended = tuner.tune(&asked(1e-6), &mut |_| {
            let is_allowed = allowed < most;
            allowed += u64::from(is_allowed);
            is_allowed
        });
        let ended = ended.expect("what it has");
        assert!(!ended.is_complete);
        assert!(ended.runs <= most);
        if most == 0 {
            assert_eq!((ended.runs, ended.limit), (0, Some(Limit::Ended)));
        }
        for found in ended.poisson.iter().chain(&ended.any) {
            assert!(found.measured.error <= 1e-6);
        }
    }
}

/// It was built when the scene was read, so that there is time for it.
#[test]
fn no_time_at_all_leaves_the_scenes_own_method() {
    let document = scene("lotka-volterra-periodic", "[1, 1.9, 0.5]", 0.05, 60);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let tuner = Tuner::new(&bench, &TuneOptions::default(), &mut |_| false).expect("its own");
    assert_eq!(tuner.methods().count(), 1);
    let options = TuneOptions {
        only: vec![parse_method("dop853", &registry).expect("a method")],
        ..TuneOptions::default()
    };
    let none = Tuner::new(&bench, &options, &mut |_| false).map(|_| ());
    let said = none.expect_err("nothing is built").to_string();
    assert!(
        said.contains("the time ended before it was formed"),
        "{said}"
    );
}

/// The distance of a perihelion and the speed there. The energy and e are exact numbers of them: what a rounded initial
/// state puts into the period would be a hundred units of round-off of the state at the next perihelion.
const PERIHELION: f64 = 0.125;
const SPEED: f64 = 3.875;

/// The orbit from there: x(t) = a (cos E − e, √(1 − e²) sin E), E − e sin E = t/√a³, with e = r v² − 1 = 0.877 and
/// a = r/(1 − e).
fn kepler(t: f64) -> [f64; 4] {
    let e = PERIHELION * SPEED * SPEED - 1.0;
    let (a, b) = (PERIHELION / (1.0 - e), libm::sqrt((1.0 - e) * (1.0 + e)));
    let frequency = 1.0 / (a * libm::sqrt(a));
    let mean = frequency * t;
    // E − e sin E rises with E: bisection down to the last bit, some 60 halvings of 2.
    let (mut low, mut high) = (mean - 1.0, mean + 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if middle - e * libm::sin(middle) < mean {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (sin, cos) = (libm::sin(low), libm::cos(low));
    let rate = a * frequency / (1.0 - e * cos);
    [a * (cos - e), a * b * sin, -sin * rate, b * cos * rate]
}

/// Two and a half revolutions end at the aphelion, where errors are smallest: the closed orbit shows that what is
/// asked at every step holds at the perihelia, and that what is asked at the end does not.
#[test]
fn what_is_asked_of_a_kepler_orbit_holds_at_every_step() {
    let text = format!(
        "[system]\nvariables = [\"q1\", \"q2\", \"p1\", \"p2\"]\nconvention = \"{{x,H}}\"\n\
         bracket = {{ \"q1,p1\" = \"1\", \"q2,p2\" = \"1\" }}\n\
         hamiltonian = \"(p1^2 + p2^2)/2 - 1/sqrt(q1^2 + q2^2)\"\n[method]\n\
         stepper = \"splitting\"\ntime-step = 0.01\n[run]\n\
         initial = [{PERIHELION:?}, 0, 0, {SPEED:?}]\nsteps = 1608\n"
    );
    let document =
        SceneDocument::parse("kepler.toml", &text, &Registry::with_builtin()).expect("a scene");
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let error = 1e-6;
    let largest = |judged: Judged| {
        let options = TuneOptions {
            only: ["kahan-li-8/splitting", "blanes-moan-6/splitting"]
                .map(|text| parse_method(text, &registry).expect("a method"))
                .to_vec(),
            judged,
            ..TuneOptions::default()
        };
        let tuner = Tuner::new(&bench, &options, &mut |_| true).expect("methods");
        let found = tune(&tuner, asked(error)).poisson.expect("a Poisson map");
        let tuned = SceneDocument::parse("tuned.toml", &found.scene, &Registry::with_builtin());
        let run = compose(&tuned.expect("a scene"), &registry).expect("a run");
        let mut walk = run.walk();
        let mut largest = 0.0_f64;
        let mut end = 0.0;
        for _ in 0..run.plan.steps {
            walk.step().expect("a step");
            end = distance(walk.state(), &kepler(walk.time()));
            largest = largest.max(end);
        }
        // The reference's own error, an estimate by another method that may err as much; and that of t = k h: h rounded,
        // times an acceleration of 64 at the perihelion.
        let known = 2.0 * tuner.reference().error + 64.0 * 16.0 * f64::EPSILON;
        let said = &found.measured;
        assert!(
            (end - said.end_error).abs() <= known,
            "{end:e}, said {:e}",
            said.end_error
        );
        let judged_error = match judged {
            Judged::AtEveryStep => largest,
            Judged::AtTheEnd => end,
        };
        assert!(
            (judged_error - said.error).abs() <= known,
            "{judged_error:e}, said {:e}, known to {known:e}",
            said.error
        );
        assert!(judged_error <= error, "{judged_error:e}");
        largest
    };
    assert!(largest(Judged::AtEveryStep) <= error);
    assert!(largest(Judged::AtTheEnd) > 10.0 * error);
}
