//! Loaded parts at work: what they compute is what the same parts compute when they are compiled in.

#![cfg(unix)]

mod support;
#[path = "support/twins.rs"]
mod twins;

use std::sync::Arc;

use leafwise_core::{
    Convention, Method, Part, PartParameters, PoissonSystem, RealizationData, Registry, StepError,
    StepMap, Structure, Walk,
};
use leafwise_expression::syntax::Scope;
use support::build::{Workshop, rust_example};
use support::orbits::{START, distance, end, expression, method, orbit, realization, rigid_body};
use support::{built_in, load};
use twins::{HeunTwin, RodriguesTwin, gyrostat_twin};

#[test]
fn a_realization_of_numbers_steps_to_the_same_bits_loaded_or_compiled_in() {
    let mut registry = built_in();
    load(&rust_example(), None, &mut registry).expect("the example");
    let system = rigid_body();
    let numbers = PartParameters::new().with("path", "numbers");
    let loaded = realization(&registry, "example/so3-rodrigues", &system, numbers);
    let loaded = loaded.expect("it fits");
    assert!(loaded.abilities().code().is_none());
    let dynamics = ("hamilton-jacobi", Some(2));
    let here = method(&registry, &system, Arc::new(RodriguesTwin), dynamics).expect("a method");
    let there = method(&registry, &system, loaded, dynamics).expect("a method");
    assert_eq!(there.path(), "evaluators");
    assert_eq!(there.properties(), here.properties());
    assert_eq!(there.properties().structure, Structure::Exact);
    assert_eq!(orbit(&system, &there, 500), orbit(&system, &here, 500));
}

#[test]
fn a_realization_of_formulas_is_a_built_in_one() {
    let mut registry = built_in();
    let plugin = load(&rust_example(), None, &mut registry).expect("the example");
    let system = rigid_body();
    // The same formulas without the library.
    let mut declared = plugin.declaration.parts[0].clone();
    declared.description.name = "compiled-in".to_owned();
    declared.description.parameters.clear();
    declared.functions = None;
    let Part::Realization(part) = declared.part().expect("its formulas") else {
        panic!("a realization");
    };
    let defaults = PartParameters::new;
    let here = part.build(&system, &defaults()).expect("it fits");
    let there = realization(&registry, "example/so3-rodrigues", &system, defaults());
    let there = there.expect("it fits");
    for order in [2, 6] {
        let dynamics = ("hamilton-jacobi", Some(order));
        let compose = |realization: &Arc<dyn RealizationData>| {
            method(&registry, &system, Arc::clone(realization), dynamics).expect("a method")
        };
        let (here, there) = (compose(&here), compose(&there));
        assert_eq!(there.path(), "one kernel");
        assert_eq!(orbit(&system, &there, 500), orbit(&system, &here, 500));
    }
    // Its series is that of its own chart: at order 6 it goes where Karasev's goes.
    let karasev = realization(&registry, "so3-exponential", &system, defaults());
    let compose = |realization, order| {
        let dynamics = ("hamilton-jacobi", Some(order));
        method(&registry, &system, realization, dynamics).expect("a method")
    };
    let oracle = orbit(&system, &compose(karasev.expect("it fits"), 10), 20);
    let error = |order: i64| {
        let own = orbit(&system, &compose(Arc::clone(&there), order), 20);
        distance(&own, &oracle)
    };
    let errors = [2, 4, 6].map(error);
    assert!(
        errors[1] < 1e-2 * errors[0] && errors[2] < 1e-2 * errors[1],
        "{errors:?}"
    );
    // Collective integrators need its derivatives, which formulas have.
    let collective = method(&registry, &system, there, ("collective", None));
    assert_eq!(
        collective.expect("a method").properties().structure,
        Structure::Exact
    );
}

fn c_example(workshop: &Workshop) -> std::path::PathBuf {
    workshop.compile("../../../examples/c/gyrostat")
}

#[test]
fn a_system_of_numbers_steps_to_the_same_bits_loaded_or_compiled_in() {
    let workshop = Workshop::new();
    let mut registry = built_in();
    load(&c_example(&workshop), None, &mut registry).expect("the example");
    let part = registry.system("example-c/gyrostat").expect("the gyrostat");
    let loaded = part.build(&PartParameters::new()).expect("its defaults");
    assert_eq!(loaded.variables(), ["x1", "x2", "x3"]);
    assert_eq!(loaded.casimir_names(), ["spin"]);
    assert_eq!(loaded.parameter_values(), [1.0, 0.75, 1.25, 0.3]);
    assert_eq!(loaded.path(), "numbers");
    let here = gyrostat_twin(&loaded);
    let run = |system: &PoissonSystem| {
        let defaults = PartParameters::new();
        let realization = realization(&registry, "karasev-collocated", system, defaults);
        let dynamics = ("hamilton-jacobi", Some(2));
        let method = method(&registry, system, realization.expect("it serves"), dynamics);
        orbit(system, &method.expect("a method"), 300)
    };
    let (there, here) = (run(&loaded), run(&here));
    assert_eq!(there, here);
    let spin = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>();
    let drift = (spin(end(&there)) - spin(START)).abs() / spin(START);
    assert!(drift <= 300.0 * f64::EPSILON, "{drift:e}");
    let refused = part.build(&PartParameters::new().with("I2", -1.0));
    let text = refused
        .expect_err("a negative moment of inertia")
        .to_string();
    let words = "example-c/gyrostat cannot be made: not supported: moments of inertia are positive";
    assert_eq!(text, words);
}

/// A system in C, a realization in Rust, each by numbers, and the program's own dynamics.
#[test]
fn parts_of_two_libraries_make_one_method() {
    let workshop = Workshop::new();
    let mut registry = built_in();
    load(&c_example(&workshop), None, &mut registry).expect("the system");
    load(&rust_example(), None, &mut registry).expect("the realization");
    let part = registry.system("example-c/gyrostat").expect("the gyrostat");
    let system = part.build(&PartParameters::new()).expect("its defaults");
    let mut orbits = Vec::new();
    for path in ["numbers", "expressions"] {
        let path = PartParameters::new().with("path", path);
        let realization = realization(&registry, "example/so3-rodrigues", &system, path);
        let realization = realization.expect("it takes the gyrostat's tensor");
        let dynamics = ("hamilton-jacobi", Some(2));
        let method = method(&registry, &system, realization, dynamics).expect("a method");
        orbits.push(orbit(&system, &method, 200));
    }
    let spin = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>();
    for orbit in &orbits {
        let drift = (spin(end(orbit)) - spin(START)).abs() / spin(START);
        assert!(drift <= 200.0 * f64::EPSILON, "{drift:e}");
    }
    assert!(distance(&orbits[0], &orbits[1]) <= 200.0 * 4.0 * f64::EPSILON);
    // The realization refuses other tensors, with its own words.
    let part = registry.system("example/epidemic").expect("the epidemic");
    let epidemic = part.build(&PartParameters::new()).expect("its defaults");
    for path in ["numbers", "expressions"] {
        let path = PartParameters::new().with("path", path);
        let refused = realization(&registry, "example/so3-rodrigues", &epidemic, path);
        let text = refused.expect_err("another tensor").to_string();
        assert!(text.contains("the tensor is not that of so(3)*"), "{text}");
    }
}

#[test]
fn dynamics_of_numbers_are_those_of_the_built_in_part() {
    let workshop = Workshop::new();
    let mut registry = built_in();
    let plugin = load(&workshop.compile("bisections"), None, &mut registry).expect("six parts");
    assert!(
        plugin.tried.iter().all(|tried| tried.problems.len() >= 4),
        "{:?}",
        plugin.tried
    );
    let system = rigid_body();
    let cayley = || {
        let defaults = PartParameters::new();
        realization(&registry, "so3-cayley", &system, defaults).expect("it fits")
    };
    let built_in = method(&registry, &system, cayley(), ("hamilton-jacobi", Some(2)));
    let built_in = built_in.expect("a method");
    let expected = orbit(&system, &built_in, 100);
    for name in ["one-form", "embedding", "flow"] {
        for values in ["", "-values"] {
            let name = format!("bisections/{name}{values}");
            let own = method(&registry, &system, cayley(), (&name, None)).expect("a method");
            assert_eq!(own.properties(), built_in.properties());
            let error = distance(&orbit(&system, &own, 100), &expected);
            assert!(error <= 100.0 * 8.0 * f64::EPSILON, "{name}: {error:e}");
            let mut stepper = own.stepper(1, &system.parameter_values(), 1.0, 0.1);
            let mut outcome = [Ok(())];
            stepper.increment(&START, &[0.0; 3], &mut [0.0; 3], &mut outcome);
            assert_eq!(stepper.tangent(0).is_some(), values.is_empty(), "{name}");
        }
    }
    // Collocation takes a one-form into its own solve.
    let fused = |dynamics: (&str, Option<i64>)| {
        let defaults = PartParameters::new();
        let collocated = realization(&registry, "karasev-collocated", &system, defaults);
        method(&registry, &system, collocated.expect("it fits"), dynamics).expect("a method")
    };
    let (own, built_in) = (
        fused(("bisections/one-form", None)),
        fused(("hamilton-jacobi", Some(2))),
    );
    assert_eq!(
        (own.path(), built_in.path()),
        ("fused".to_owned(), "fused".to_owned())
    );
    let error = distance(&orbit(&system, &own, 100), &orbit(&system, &built_in, 100));
    assert!(error <= 100.0 * 8.0 * f64::EPSILON, "{error:e}");
    // A realization whose points are no pairs has a chart, which a one-form goes through.
    let group = || {
        let defaults = PartParameters::new().with("chart", "cayley");
        realization(&registry, "so3-group", &system, defaults).expect("it fits")
    };
    let refused = method(&registry, &system, group(), ("bisections/one-form", None));
    let text = refused.expect_err("the part says so").to_string();
    assert!(
        text.contains("points of S are to be pairs (x, p)"),
        "{text}"
    );
}

#[test]
fn leaving_a_domain_is_reported_with_its_ratio() {
    let workshop = Workshop::new();
    let mut registry = built_in();
    load(&workshop.compile("walled"), None, &mut registry).expect("a realization");
    let system = rigid_body();
    let defaults = PartParameters::new;
    let walled = realization(&registry, "walled/cayley", &system, defaults()).expect("it fits");
    let dynamics = ("hamilton-jacobi", Some(2));
    let walled = method(&registry, &system, walled, dynamics).expect("a method");
    let cayley = realization(&registry, "so3-cayley", &system, defaults()).expect("it fits");
    let cayley = method(&registry, &system, cayley, dynamics).expect("a method");
    // Inside it is the Cayley chart, by values alone.
    let (own, expected) = (orbit(&system, &walled, 100), orbit(&system, &cayley, 100));
    assert!(distance(&own, &expected) <= 100.0 * 8.0 * f64::EPSILON);
    // |h grad H| is 1.5 or so at h = 1.
    let mut walk = Walk::new(&walled, &system.parameter_values(), 1.0, 1.0, &START);
    match walk.step() {
        Err(StepError::OutsideDomain { ratio, part, .. }) => {
            assert!((1.0..2.0).contains(&ratio), "{ratio}");
            assert_eq!(part, "walled/cayley");
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(walk.state(), START);
    // A system of another tensor is not served.
    let text = {
        let part = registry.realization("walled/cayley").expect("it is there");
        let other = pendulum_on_three();
        part.build(&other, &defaults())
            .expect_err("another tensor")
            .to_string()
    };
    assert!(
        text.contains("walled/cayley does not fit this system"),
        "{text}"
    );
    assert!(text.contains("the tensor is not that of so(3)*"), "{text}");
}

/// {x1, x2} = 1 and a Casimir x3.
fn pendulum_on_three() -> PoissonSystem {
    let scope = Scope::new().with_variables(&["x1", "x2", "x3"]);
    let formula = |text: &str| expression(&scope, text);
    PoissonSystem::new(
        ["x1", "x2", "x3"].map(str::to_owned).to_vec(),
        Vec::new(),
        [((0, 1), formula("1"))],
        formula("x2^2/2 - cos(x1)"),
        Vec::new(),
        Convention::HamiltonianFirst,
    )
    .expect("a system")
}

#[test]
fn a_step_map_of_numbers_steps_to_the_same_bits_on_any_number_of_lanes() {
    let workshop = Workshop::new();
    let mut registry = Registry::empty();
    load(&workshop.compile("steps"), None, &mut registry).expect("step maps");
    let system = rigid_body();
    let part = registry.stepper("steps/heun").expect("Heun's rule");
    let loaded = part.build(&system, &PartParameters::new().with("weight", 0.25));
    let (loaded, here) = (loaded.expect("it fits"), HeunTwin(system.clone()));
    assert_eq!(loaded.properties(), here.properties());
    assert_eq!(
        orbit(&system, loaded.as_ref(), 300),
        orbit(&system, &here, 300)
    );
    // Lanes 0 to 3 share their parameters, and so an instance and a call; lane 4 has others.
    let (lanes, d) = (5, 3);
    let inertia = |lane: usize| [1.0, 0.75, if lane == 4 { 2.0 } else { 1.25 }];
    let start = |lane: usize| [0.3 + 0.1 * lane as f64, 1.0, -0.7];
    let spread = |of: &dyn Fn(usize) -> [f64; 3]| -> Vec<f64> {
        (0..d * lanes)
            .map(|at| of(at % lanes)[at / lanes])
            .collect()
    };
    let mut stepper = loaded.stepper(lanes, &spread(&inertia), 1.0, 0.1);
    let mut increment = vec![0.0; d * lanes];
    let mut outcome = vec![Ok(()); lanes];
    stepper.increment(&spread(&start), &[0.0; 15], &mut increment, &mut outcome);
    for lane in 0..lanes {
        let mut alone = [0.0; 3];
        let mut single = here.stepper(1, &inertia(lane), 1.0, 0.1);
        single.increment(&start(lane), &[0.0; 3], &mut alone, &mut [Ok(())]);
        let own = [0, 1, 2].map(|i| increment[i * lanes + lane]);
        assert_eq!(own, alone, "lane {lane}");
    }
    assert_eq!(stepper.statistics().steps, 5);
}

#[test]
fn one_failing_lane_leaves_the_others_their_steps() {
    let workshop = Workshop::new();
    let mut registry = Registry::empty();
    load(&workshop.compile("steps"), None, &mut registry).expect("step maps");
    let system = rigid_body();
    let stepper = |name: &str| {
        let part = registry.stepper(name).expect("a step map");
        let map = part
            .build(&system, &PartParameters::new())
            .expect("it fits");
        map.stepper(3, &[1.0; 9], 1.0, 0.5)
    };
    let states = [0.5, 3.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut increment = [9.0; 9];
    let mut outcome = [Ok(()), Ok(()), Ok(())];
    let mut local = stepper("steps/local");
    local.increment(&states, &[0.0; 9], &mut increment, &mut outcome);
    assert_eq!(increment, [0.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!([&outcome[0], &outcome[2]], [&Ok(()), &Ok(())]);
    let error = outcome[1].clone().expect_err("outside");
    assert!(matches!(error, StepError::OutsideDomain { ratio: 1.5, .. }));
    // The part's own words and its name.
    let text = "steps/local failed: increment: outside its domain at point 0 (1.50 times as far as it \
                reaches): x1 is 2 or more; reduce the time step";
    assert_eq!(error.to_string(), text);
    assert_eq!(local.statistics().failures, 1);
    // A broken instance is called no more, not even to be ended: the fixture would abort. The other
    // lanes go on with a new one.
    let mut fragile = stepper("steps/fragile");
    for _ in 0..3 {
        fragile.increment(&states, &[0.0; 9], &mut increment, &mut outcome);
        assert_eq!(increment, [0.0; 9]);
        assert_eq!([&outcome[0], &outcome[2]], [&Ok(()), &Ok(())]);
        let text = outcome[1].clone().expect_err("it broke").to_string();
        assert_eq!(
            text,
            "steps/fragile failed: increment: fatal: x1 is too large"
        );
    }
    // One trajectory alone is told the same reason for as long as it asks.
    let part = registry.stepper("steps/fragile").expect("a step map");
    let map = part
        .build(&system, &PartParameters::new())
        .expect("it fits");
    let mut alone = map.stepper(1, &[1.0; 3], 1.0, 0.5);
    for _ in 0..2 {
        let mut outcome = [Ok(())];
        alone.increment(&[3.0; 3], &[0.0; 3], &mut [0.0; 3], &mut outcome);
        let text = outcome[0].clone().expect_err("it broke").to_string();
        assert!(text.contains("x1 is too large"), "{text}");
    }
}

/// A gyrostat of the gallery, whose functions differ from the example's at x1 > 2.
fn gyrostat_of(workshop: &Workshop, name: &str) -> PoissonSystem {
    let mut registry = Registry::empty();
    let path = workshop.compile(name);
    load(&path, None, &mut registry).expect("what is wrong shows later");
    let id = format!("gallery/{}", name.replace('_', "-"));
    let part = registry.system(&id).expect("a gyrostat");
    part.build(&PartParameters::new()).expect("its defaults")
}

/// What a call leaves unwritten is no result, whatever stood there before.
#[test]
fn an_output_that_is_not_written_is_a_failure() {
    let system = gyrostat_of(&Workshop::new(), "unwritten");
    let numbers = system.opaque().expect("numbers");
    let mut evaluator = numbers.numbers.evaluator(&system.parameter_values());
    let mut gradient = [7.0; 3];
    evaluator
        .gradient(&[1.5, 0.5, 2.0], &mut gradient)
        .expect("written");
    assert_eq!(gradient, [1.5, 0.5 / 0.75, 2.0 / 1.25 - 0.3]);
    let error = evaluator.gradient(&[2.5, 0.5, 2.0], &mut gradient);
    let text = error
        .expect_err("the last coordinate is missing")
        .to_string();
    assert_eq!(
        text,
        "gallery/unwritten failed: gradient: LW_OK, and the output at point 0 coordinate 2 is not written"
    );
}

/// Calls that change how the thread rounds are noticed within so many calls, and undone.
#[test]
#[cfg(target_arch = "x86_64")]
fn a_changed_rounding_is_noticed_and_undone() {
    let system = gyrostat_of(&Workshop::new(), "rounds_later");
    let numbers = system.opaque().expect("numbers");
    let sum = || std::hint::black_box(1.0) + std::hint::black_box(f64::EPSILON / 4.0);
    let mut evaluator = numbers.numbers.evaluator(&system.parameter_values());
    let mut gradient = [0.0; 3];
    let failed = (0..64).find_map(|_| evaluator.gradient(&[2.5, 0.5, 2.0], &mut gradient).err());
    let text = failed.expect("a change").to_string();
    assert!(
        text.contains("floating-point environment changed when it was called"),
        "{text}"
    );
    assert_eq!(sum(), 1.0);
    // Fewer calls: it is reported when the evaluator ends.
    evaluator
        .gradient(&[2.5, 0.5, 2.0], &mut gradient)
        .expect("a call");
    assert_ne!(sum(), 1.0);
    drop(evaluator);
    assert_eq!(sum(), 1.0);
    let change = leafwise_plugin_loader::change_of_arithmetic().expect("a change");
    assert!(change.contains("gallery/rounds-later"), "{change}");
    assert_eq!(leafwise_plugin_loader::change_of_arithmetic(), None);
}

/// An explicit method takes the memory of a few states, whatever derivatives a system has.
#[test]
fn a_long_system_of_numbers_needs_no_matrices() {
    use leafwise_reference as _;
    let system = gyrostat_of(&Workshop::new(), "long_chain");
    let built_in = built_in();
    let rk4 = built_in.stepper("rk4").expect("the rule");
    let map = rk4
        .build(&system, &PartParameters::new())
        .expect("values suffice");
    let d = system.dimension();
    let start: Vec<f64> = (0..d).map(|i| (i % 2) as f64).collect();
    let mut walk = Walk::new(map.as_ref(), &[], 1.0, 0.125, &start);
    walk.step().expect("a step");
    // x_2 begins at 1 and x_1 with dx_1/dt = {H, x_1} = -x_2: a rotation by 1/8, to the order of rk4.
    let (sin, cos) = (libm::sin(0.125), libm::cos(0.125));
    for pair in walk.state().chunks_exact(2) {
        assert!(
            (pair[0] + sin).abs() < 1e-6 && (pair[1] - cos).abs() < 1e-6,
            "{pair:?}"
        );
    }
}

/// LW_UNSUPPORTED of an optional function is as good as NULL in its place.
#[test]
fn a_derivative_that_no_instance_offers_is_not_there() {
    let system = gyrostat_of(&Workshop::new(), "unsupported");
    let offered = system.opaque().expect("numbers").numbers.derivatives;
    assert!(offered.casimirs && !offered.hamiltonian && !offered.tensor);
    use leafwise_reference as _;
    let built_in = built_in();
    let midpoint = built_in.stepper("implicit-midpoint").expect("the rule");
    let map = midpoint
        .build(&system, &PartParameters::new())
        .expect("values suffice");
    orbit(&system, map.as_ref(), 10);
}

/// Parts by formulas alone against the same formulas written here.
#[test]
fn formulas_need_no_functions() {
    let workshop = Workshop::new();
    let mut registry = built_in();
    load(&workshop.compile("formulas"), None, &mut registry).expect("three parts");
    let part = registry.system("formulas/pendulum").expect("the pendulum");
    let strong = PartParameters::new().with("strength", 2.0);
    let system = part.build(&strong).expect("its formulas");
    assert_eq!(system.path(), "expressions");
    assert_eq!(system.parameter_values(), [2.0]);
    let (start, t) = ([0.4, 0.3], 0.05);
    let run = |map: &dyn StepMap, steps: usize| {
        let mut walk = Walk::new(map, &[2.0], 1.0, t, &start);
        for _ in 0..steps {
            walk.step().expect("a step");
        }
        [0, 1].map(|i| walk.state()[i])
    };
    // S_1 = H over Karasev's realization is Hamilton–Jacobi of order 2.
    let karasev = || {
        let defaults = PartParameters::new();
        realization(&registry, "karasev-truncated", &system, defaults).expect("it fits")
    };
    let built_in = method(&registry, &system, karasev(), ("hamilton-jacobi", Some(2)));
    let energy = registry.dynamics("formulas/energy").expect("S = h H");
    let energy = energy.build(&strong).expect("a number");
    let own = Method::compose(&system, karasev(), energy).expect("a method");
    let built_in = built_in.expect("a method");
    assert_eq!(
        (own.path(), own.properties()),
        (built_in.path(), built_in.properties())
    );
    let (own, built_in) = (run(&own, 100), run(&built_in, 100));
    for i in 0..2 {
        assert!((own[i] - built_in[i]).abs() <= 100.0 * 2.0 * f64::EPSILON);
    }
    // The symplectic Euler rule, step by step.
    let euler = registry.stepper("formulas/euler").expect("the rule");
    let euler = euler.build(&system, &strong).expect("dimension 2");
    assert_eq!(euler.properties().structure, Structure::Exact);
    let mut expected = start;
    for _ in 0..10 {
        expected[1] -= t * 2.0 * libm::sin(expected[0]);
        expected[0] += t * expected[1];
    }
    let found = run(euler.as_ref(), 10);
    for i in 0..2 {
        assert!((found[i] - expected[i]).abs() <= 10.0 * 2.0 * f64::EPSILON);
    }
    // det DΦ = 1.
    let mut stepper = euler.stepper(1, &[2.0], 1.0, t);
    stepper.increment(&start, &[0.0; 2], &mut [0.0; 2], &mut [Ok(())]);
    let tangent = stepper.tangent(0).expect("formulas have derivatives");
    let area = tangent[0] * tangent[3] - tangent[1] * tangent[2];
    assert!((area - 1.0).abs() <= 4.0 * f64::EPSILON, "{area}");
    let wrong = registry.stepper("formulas/euler").expect("the rule");
    let text = wrong
        .build(&rigid_body(), &strong)
        .err()
        .expect("dimension 3")
        .to_string();
    assert!(
        text.contains("it serves dimension 2, and this system has 3"),
        "{text}"
    );
}
