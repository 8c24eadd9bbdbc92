//! Comparisons: the reference is as good as it says, fronts are fronts, failures are rows.

use crate::scenes::scene;
use leafwise::core::registry::StepperPart;
use leafwise::core::{Origin, PartInfo, PartKind, Registry, Structure};
use leafwise::scene::{SceneDocument, compose as compose_scene};
use leafwise::trade::{
    Bench, CompareOptions, Comparison, Cost, Grid, Judged, Knob, Reference, TradeError,
    TrialFailure, TuneOptions, Tuner, compare, comparison_page, distance, parse_method,
};
use serde_json::Value;

fn comparison(document: &SceneDocument, options: &CompareOptions) -> Comparison {
    let registry = Registry::with_builtin();
    let bench = Bench::new(document, &registry, None).expect("a bench");
    compare(&bench, options, &mut |_, _, _| true).expect("a comparison")
}

fn only(methods: &[&str]) -> CompareOptions {
    let registry = Registry::with_builtin();
    let read = |text: &&str| parse_method(text, &registry).expect("a method");
    CompareOptions {
        only: methods.iter().map(read).collect(),
        ..CompareOptions::default()
    }
}

/// The state after ten steps of a system's own method.
fn after_ten_steps(id: &str, initial: &[f64], step: f64, registry: &Registry) -> Vec<f64> {
    let document = scene(id, &format!("{initial:?}"), step, 10);
    let run = compose_scene(&document, registry).expect("a run");
    let mut walk = run.walk();
    walk.advance(10).expect("ten steps");
    walk.state()[..initial.len()].to_vec()
}

/// What rounding the initial state to doubles changes at the end: Σ_j |∂Φ/∂x_j| |x_j| ε/2, by differences.
fn carried_rounding(id: &str, initial: &[f64], step: f64, registry: &Registry) -> f64 {
    let end = after_ten_steps(id, initial, step, registry);
    let carried = |j: usize| {
        let (mut moved, change) = (initial.to_vec(), 1e-7 * initial[j].abs());
        moved[j] += change;
        let there = after_ten_steps(id, &moved, step, registry);
        match change == 0.0 {
            true => 0.0,
            false => distance(&there, &end) / 1e-7 * f64::EPSILON / 2.0,
        }
    };
    (0..initial.len()).map(carried).sum()
}

/// Against flows of 25 digits: two methods that agree to `error` are not both wrong by more, up to
/// the rounding of a few coordinates and of the initial state.
#[test]
fn the_reference_is_as_near_to_the_flow_as_it_says() {
    let text = include_str!("../../systems/reference/flows.json");
    let data: Value = serde_json::from_str(text).expect("reference data");
    let registry = Registry::with_builtin();
    for flow in data["flows"].as_array().expect("a list of flows") {
        let list = |key: &str| -> Vec<f64> {
            let list = flow[key].as_array().expect("a list").iter();
            list.map(|v| v.as_str().expect("a decimal").parse().expect("a number"))
                .collect()
        };
        let (id, initial) = (flow["system"].as_str().expect("a name"), list("initial"));
        let time = flow["time"].as_str().expect("a decimal");
        let step = time.parse::<f64>().expect("a number") / 10.0;
        let document = scene(id, &format!("{initial:?}"), step, 10);
        let bench = Bench::new(&document, &registry, None).expect("a bench");
        let reference = Reference::compute(&bench, Judged::AtTheEnd).expect("a reference");
        let error = distance(&reference.state, &list("final"));
        let round_off = 4.0 * f64::EPSILON * reference.norm();
        assert_eq!(reference.methods.len(), 2, "{id}");
        let carried = carried_rounding(id, &initial, step, &registry);
        let bound = reference.error + round_off + carried;
        assert!(error <= bound, "{id}: {error:e} over {bound:e}");
        assert!(reference.error <= 1e-12, "{id}: {:e}", reference.error);
    }
}

#[test]
fn the_standard_methods_of_a_rigid_body_are_compared_and_the_front_is_theirs() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 50);
    let comparison = comparison(&document, &CompareOptions::default());
    let names: Vec<&str> = comparison.methods.iter().map(|m| m.name.as_str()).collect();
    for name in [
        "so3-exponential + hamilton-jacobi 2 energy-casimir",
        "so3-exponential + hamilton-jacobi 12 energy-casimir",
        "suzuki-umeno-8 of so3-exponential + hamilton-jacobi 4 energy-casimir",
        "sofroniou-spaletta-10 of splitting",
        "spherical-midpoint",
        "taylor",
        "dop853",
        "dormand-prince45",
        "gauss 3",
        "rk4",
    ] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    // Coordinates with a constant tensor, by Gauss methods of four orders.
    let lifts = names.iter().filter(|name| name.starts_with("clebsch"));
    let expected = [2, 4, 8, 16].map(|stages| format!("clebsch + collective {stages}"));
    assert!(lifts.eq(&expected), "{names:?}");
    let own: Vec<_> = comparison.methods.iter().filter(|m| m.is_own).collect();
    assert_eq!(own.len(), 1);
    assert_eq!(own[0].name, "karasev-truncated 6 + hamilton-jacobi 2");

    let measured = || {
        let points = comparison.points.iter();
        points.filter_map(|p| Some((&comparison.methods[p.method], p.outcome.as_ref().ok()?)))
    };
    let floor = comparison.reference.floor();
    for (method, a) in measured() {
        let (cost, error) = (a.operations.expect("counted"), a.error.max(floor));
        let beaten = |of_poisson: bool| {
            measured().any(|(_, b)| {
                let (c, e) = (b.operations.expect("counted"), b.error.max(floor));
                (!of_poisson || b.is_poisson) && c <= cost && e <= error && (c, e) != (cost, error)
            })
        };
        assert!(!(a.front.all && beaten(false)), "{}", method.name);
        assert!(
            !(a.front.poisson && (beaten(true) || !a.is_poisson)),
            "{}",
            method.name
        );
        // A Poisson map keeps the sphere: a few roundings of |x|² = 19 a step, added up.
        if method.structure == Structure::Exact {
            let drift = a.casimir_drift.expect("a Casimir");
            assert!(drift < 1e-12, "{}: {drift:e}", method.name);
            assert!(a.is_poisson, "{}, {} operations: {a:?}", method.name, cost);
        }
        if method.structure == Structure::None {
            assert!(!a.is_poisson, "{}", method.name);
        }
        assert!(a.wall.is_none(), "not asked for");
    }
    // The body's exact flow is the motion at any step: on the front no other Poisson map errs less.
    let on_front = measured().filter(|(_, m)| m.front.poisson);
    let most_accurate = on_front.min_by(|(_, a), (_, b)| a.error.total_cmp(&b.error));
    assert_eq!(most_accurate.expect("a front").0.name, "splitting whole");
    // Each method got as far as the reference can tell, spent what it may, or stands at the finest
    // of the grid: a 2048th of the scene's step.
    let finest = 50 * 2048;
    for at in 0..comparison.methods.len() {
        let last = comparison.points.iter().rfind(|p| p.method == at);
        let last = last.expect("every method has points");
        match &last.outcome {
            Ok(measured) => assert!(
                measured.error < 1e-10 || last.setting.steps == finest,
                "{}: {:e}",
                names[at],
                measured.error
            ),
            Err(failure) => assert!(
                matches!(failure, TrialFailure::OverBudget { .. }),
                "{}: {failure}",
                names[at]
            ),
        }
    }
}

#[test]
fn a_comparison_repeats_to_the_last_bit() {
    let document = scene("lotka-volterra-periodic", "[1, 1.9, 0.5]", 0.05, 60);
    let options = only(&["auto+hamilton-jacobi:6", "suzuki-4/splitting", "dop853"]);
    assert_eq!(
        comparison(&document, &options),
        comparison(&document, &options)
    );
}

#[test]
fn what_fails_is_a_row_with_its_reason() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 50);
    let comparison = comparison(
        &document,
        &CompareOptions {
            steps: Some(Grid::parse("2,500,10000").expect("a list")),
            budget: Some(400_000),
            ..only(&[
                "so3-exponential+hamilton-jacobi:4",
                "log-canonical+hamilton-jacobi:2",
            ])
        },
    );
    let [coarse, good, long] = comparison.points.as_slice() else {
        panic!("{:?}", comparison.points);
    };
    assert!(
        matches!(coarse.outcome, Err(TrialFailure::Step { step: 0, .. })),
        "{coarse:?}"
    );
    assert!(good.outcome.is_ok());
    assert!(
        matches!(long.outcome, Err(TrialFailure::OverBudget { .. })),
        "{long:?}"
    );
    let [(name, reason)] = comparison.refused.as_slice() else {
        panic!("{:?}", comparison.refused);
    };
    assert!(
        name.starts_with("log-canonical") && reason.contains("does not fit"),
        "{reason}"
    );
}

/// Where no run came to its end nothing says that operations are not counted.
#[test]
fn a_comparison_without_a_run_is_in_operations() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 50);
    let comparison = comparison(
        &document,
        &CompareOptions {
            steps: Some(Grid::parse("10000").expect("a list")),
            budget: Some(1_000),
            ..only(&["splitting"])
        },
    );
    assert!(comparison.points.iter().all(|point| point.outcome.is_err()));
    assert_eq!(comparison.cost, Cost::Operations);
}

/// Long lattices go by sweeps for realization and dynamics, written out for steppers.
#[test]
fn a_lattice_of_64_sites_is_compared_by_sweeps_and_written_out() {
    let document = SceneDocument::parse(
        "lattice.toml",
        "[system]\nlibrary = \"volterra-lattice\"\nfamilies = { x = 64 }\n\
         [method]\nrealization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }\n\
         time-step = 0.1\n[run]\ninitial = { \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }\nsteps = 50\n",
        &Registry::with_builtin(),
    );
    let options = only(&[
        "auto+hamilton-jacobi:4",
        "kahan-li-6/auto+hamilton-jacobi:2",
        "suzuki-4/splitting",
        "dop853",
    ]);
    let comparison = comparison(&document.expect("a scene"), &options);
    assert_eq!(comparison.methods.len(), 4, "{:?}", comparison.refused);
    assert!(
        comparison.reference.error < 1e-11,
        "{:e}",
        comparison.reference.error
    );
    for (at, method) in comparison.methods.iter().enumerate() {
        let of_method = comparison.points.iter().filter(|p| p.method == at);
        let errors: Vec<f64> = of_method
            .filter_map(|p| Some(p.outcome.as_ref().ok()?.error))
            .collect();
        let smallest = errors.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(smallest < 1e-9, "{}: {errors:?}", method.name);
    }
}

/// Over an end state that is not known no method is better than another.
#[test]
fn nothing_stands_on_a_front_against_a_reference_that_is_not_known() {
    let file = format!("{}/../scenes/magnetic.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(file).expect("a scene");
    // To t = 1500 a change of the initial state grows by more than 1e16.
    let text = text.replace("steps   = 10000", "steps   = 15000");
    let document =
        SceneDocument::parse("magnetic.toml", &text, &Registry::with_builtin()).expect("a scene");
    let options = CompareOptions {
        steps: Some(Grid::parse("10000,20000").expect("a list")),
        budget: Some(1_000_000_000),
        ..only(&["kahan-li-8/splitting", "auto+hamilton-jacobi:4"])
    };
    let comparison = comparison(&document, &options);
    let horizon = comparison.horizon.as_ref().expect("a warning");
    assert!(horizon.known.is_some_and(|known| known.time < 1500.0));
    for point in &comparison.points {
        let measured = point.outcome.as_ref().expect("a run");
        assert!(measured.at_floor, "{:e}", measured.error);
        assert!(!measured.front.all && !measured.front.poisson);
    }
    let page = comparison_page(&comparison, &document, "leafwise compare").expect("drawn");
    assert!(page.contains(&horizon.to_string()), "the page says so too");
}

#[test]
fn methods_that_were_asked_for_and_do_not_fit_are_an_error_where_none_is_left() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 50);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let error = |options: &CompareOptions| match compare(&bench, options, &mut |_, _, _| true) {
        Err(error @ TradeError::NoMethods { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let none_fits = error(&only(&["log-canonical+hamilton-jacobi:2"]));
    assert!(none_fits.contains("does not fit"), "{none_fits}");
    let no_word = error(&only(&["auto+hamilton-jacobi:8:energy"]));
    assert!(
        no_word.contains("hamiltonian = energy is not allowed")
            && no_word.contains("given, energy-casimir"),
        "{no_word}"
    );
    let of_order_three = error(&CompareOptions {
        orders: Some(vec![3]),
        ..CompareOptions::default()
    });
    assert!(of_order_three.contains("of order 3"), "{of_order_three}");
}

#[test]
fn a_comparison_over_no_time_is_refused() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 0);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None);
    assert!(matches!(bench.err(), Some(TradeError::NoTime { .. })));
    let bench = Bench::new(&document, &registry, Some(1e300));
    assert!(matches!(bench.err(), Some(TradeError::TooLong { .. })));
    let bench = Bench::new(&document, &registry, Some(-3.0)).expect("backward");
    assert_eq!((bench.time(), bench.steps()), (-3.0, 15));
}

#[test]
fn the_page_shows_the_methods_on_the_front_and_nothing_is_fetched() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 50);
    let comparison = comparison(
        &document,
        &only(&["splitting", "dop853", "auto+hamilton-jacobi:8"]),
    );
    let page =
        comparison_page(&comparison, &document, "leafwise compare body.toml").expect("drawn");
    assert_eq!(page.matches("<svg ").count(), 6, "no times were measured");
    for text in [
        "so3-exponential + hamilton-jacobi 8",
        "dop853",
        "leafwise compare body.toml",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains("<script") && !page.contains("src=") && !page.contains("url("));
}

#[test]
fn methods_are_read_by_name_and_errors_say_what_is_wrong() {
    let registry = Registry::with_builtin();
    let name = |text| parse_method(text, &registry).map(|m| m.to_string());
    assert_eq!(name("gauss:3").expect("a stepper"), "gauss 3");
    assert_eq!(name("dop853:1e-9").expect("a stepper"), "dop853 1e-9");
    assert_eq!(
        name("yoshida-6/karasev-truncated:6+collective").expect("a pair"),
        "yoshida-6 of karasev-truncated 6 + collective"
    );
    assert_eq!(
        name("auto+hamilton-jacobi:8:energy-casimir").expect("a pair"),
        "auto + hamilton-jacobi 8 energy-casimir"
    );
    for (text, reason) in [
        ("gaus", "no stepper is called `gaus`"),
        (
            "so3-cayley+gauss",
            "no dynamic approximation is called `gauss`",
        ),
        ("none/rk4", "no composition is called `none`"),
        ("rk4:3", "`rk4` takes no parameter"),
    ] {
        let error = name(text).expect_err(text).to_string();
        assert!(error.contains(reason), "{error}");
    }
}

#[test]
fn an_adaptive_method_is_varied_by_its_tolerance_unless_that_is_given() {
    let document = scene("rigid-body", "[1, 3, 3]", 0.2, 50);
    let open = comparison(&document, &only(&["dop853"]));
    assert_eq!(open.methods[0].knob, Knob::Tolerance);
    let tolerances: Vec<_> = open.points.iter().map(|p| p.setting.tolerance).collect();
    assert!(tolerances.len() > 8 && tolerances.iter().all(Option::is_some));
    let fixed = comparison(&document, &only(&["dop853:1e-9"]));
    assert_eq!(fixed.methods[0].knob, Knob::Steps);
    assert!(fixed.points.iter().all(|p| p.setting.tolerance.is_none()));
}

/// Every run stops at once: what is compared is what `tune` chooses among.
#[test]
fn compare_knows_every_method_that_tune_knows() {
    let document = scene("magnetic", "[1.0, 0.5, -0.5, 0.3, 0.2, 0.4]", 0.1, 20);
    let registry = Registry::with_builtin();
    let bench = Bench::new(&document, &registry, None).expect("a bench");
    let options = CompareOptions {
        budget: Some(1),
        ..CompareOptions::default()
    };
    let comparison = compare(&bench, &options, &mut |_, _, _| true).expect("a comparison");
    let compared: Vec<&str> = comparison.methods.iter().map(|m| m.name.as_str()).collect();
    let tuner = Tuner::new(&bench, &TuneOptions::default(), &mut |_| true).expect("methods");
    for name in tuner.methods() {
        assert!(compared.contains(&name), "{name} in {compared:?}");
    }
    assert!(
        compared.contains(&"kahan-li-8 of splitting"),
        "{compared:?}"
    );
    // What was stopped for its cost did not fail, and a system without Casimirs keeps none.
    let failures = comparison
        .points
        .iter()
        .filter_map(|p| p.outcome.as_ref().err());
    let (stopped, failed): (Vec<_>, Vec<_>) = failures.partition(|f| f.is_over_budget());
    assert!(stopped.len() > 40);
    // The longest steps of a grid may have no solution.
    let of_a_step = |f: &&TrialFailure| matches!(f, TrialFailure::Step { .. });
    assert!(failed.iter().all(of_a_step), "{failed:?}");
    let few = CompareOptions {
        steps: Some(Grid::List(vec![100])),
        ..only(&["splitting"])
    };
    let comparison = compare(&bench, &few, &mut |_, _, _| true).expect("a comparison");
    let measured = comparison.points[0].outcome.as_ref().expect("a run");
    assert_eq!(measured.casimir_drift, None);
}

/// Parts of plugins are named `plugin/part`; only behind a composition does a `/` stand for more.
#[test]
fn parts_with_a_slash_in_their_name_can_be_named() {
    let mut registry = Registry::with_builtin();
    let info = PartInfo {
        name: "acme/strang",
        ..PartInfo::of(PartKind::Stepper)
    };
    let part = StepperPart::new(Box::leak(Box::new(info)), |system, parameters| {
        let registry = Registry::with_builtin();
        registry.stepper("splitting")?.build(system, parameters)
    });
    let origin = Origin::built_in("a test", "1");
    registry.register(part.into(), origin).expect("a new name");
    let read = |text: &str| parse_method(text, &registry).map(|method| method.to_string());
    assert_eq!(read("acme/strang").expect("a stepper"), "acme/strang");
    let composed = read("suzuki-4/acme/strang").expect("a composition of it");
    assert_eq!(composed, "suzuki-4 of acme/strang");
    let said = |text: &str| read(text).expect_err("no method").to_string();
    assert!(said("other/splitting").contains("no composition is called `other`"));
    assert!(said("hamilton-jacobi:4").contains("auto+hamilton-jacobi:4"));
    assert!(said("lie-poisson").contains("lie-poisson+hamilton-jacobi:4"));
    assert!(said("suzuki-4").contains("suzuki-4/splitting"));
    let steps = Grid::parse("100-400").expect_err("no list").to_string();
    assert!(steps.contains("100..6400"), "{steps}");
}
