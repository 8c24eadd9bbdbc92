//! A run that stops and continues from its checkpoint has the same bits as one that does not.

use leafwise::core::{Registry, Setting, Stepper, Walk};
use leafwise::scene::SceneDocument;
use leafwise::scene::compose::{ComposedRun, compose};
use leafwise_tests::{library, method};

#[test]
fn a_restored_run_continues_to_the_same_bits() {
    for (id, n, m) in [
        ("rigid-body", 6, 4),
        ("lotka-volterra-periodic", 5, 2),
        ("gradient", 4, 4),
    ] {
        let problem = library(id);
        let method = method(&problem.system, n, m);
        let parameters = problem.system.parameter_values();
        let start = || {
            Walk::new(
                &method,
                &parameters,
                0.1,
                problem.time_step * 5.0,
                &problem.initial,
            )
        };
        let mut whole = start();
        for _ in 0..137 {
            whole.step().expect("a step");
        }
        let checkpoint = whole.checkpoint();
        // The second walk has a history of its own, which the checkpoint must replace.
        let mut restored = start();
        for _ in 0..3 {
            restored.step().expect("a step");
        }
        restored
            .restore(&checkpoint)
            .expect("a checkpoint of the same method");
        assert_eq!(restored.checkpoint(), checkpoint, "{id}: restored at once");
        for _ in 0..100 {
            whole.step().expect("a step");
            restored.step().expect("a step");
            assert_eq!(
                restored.state(),
                whole.state(),
                "{id} at step {}",
                whole.steps()
            );
            assert_eq!(restored.compensation(), whole.compensation(), "{id}");
        }
        assert_eq!(
            restored.checkpoint(),
            whole.checkpoint(),
            "{id}: the solver's memory"
        );
        assert_eq!(restored.steps(), 237, "{id}");
    }
}

#[test]
fn a_checkpoint_of_another_dimension_is_refused() {
    let (body, top) = (library("rigid-body"), library("heavy-top"));
    let (body_method, top_method) = (method(&body.system, 2, 2), method(&top.system, 2, 2));
    let walk = |problem: &leafwise_tests::Problem, method| {
        let parameters = problem.system.parameter_values();
        Walk::new(method, &parameters, 0.1, 1.0, &problem.initial)
    };
    let foreign = walk(&top, &top_method).checkpoint();
    let mut own = walk(&body, &body_method);
    assert_eq!(own.restore(&foreign), Err(3));
    let mut truncated = own.checkpoint();
    truncated.memory.pop();
    assert!(
        own.restore(&truncated).is_err(),
        "a memory of another length"
    );
    assert_eq!(
        own.state(),
        body.initial,
        "a refused checkpoint changes nothing"
    );
}

/// Systems of the library, and methods whose steppers take another step size and other parameters.
const KEPT: [(&str, &str); 6] = [
    ("rigid-body", "stepper = \"splitting\""),
    (
        "rigid-body",
        "stepper = \"splitting\"\ncomposition = \"suzuki-4\"",
    ),
    ("rigid-body", "stepper = \"rk4\""),
    (
        "rigid-body",
        "dynamics = { name = \"hamilton-jacobi\", order = 8 }",
    ),
    (
        "rigid-body",
        "realization = { name = \"karasev-truncated\", order = 4 }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 2 }\ncomposition = \"suzuki-4\"",
    ),
    (
        "lotka-volterra-periodic",
        "realization = { name = \"karasev-truncated\", order = 5 }\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }",
    ),
];

fn composed(library: &str, method: &str) -> ComposedRun {
    let registry = Registry::with_builtin();
    let initial = leafwise_tests::library(library).initial;
    let text = format!(
        "[system]\nlibrary = \"{library}\"\n[method]\n{method}\ntime-step = 0.1\n[run]\n\
         initial = {initial:?}\nsteps = 1\n"
    );
    let scene = SceneDocument::parse("scene.toml", &text, &registry).expect("a scene");
    compose(&scene, &registry).expect("a method")
}

/// Shorter steps on the way to an event take one stepper, and none of them knows of the others.
#[test]
fn a_stepper_of_another_step_size_has_the_bits_of_a_new_one() {
    for (library, method) in KEPT {
        let initial = leafwise_tests::library(library).initial;
        let run = composed(library, method);
        let parameters = run.system.parameter_values();
        let new = |h: f64| run.method.map().stepper(1, &parameters, 0.1, h);
        let increment = |stepper: &mut dyn Stepper| {
            let (d, mut outcome) = (initial.len(), [Ok(())]);
            let mut increment = vec![0.0; d];
            stepper.increment(&initial, &vec![1e-20; d], &mut increment, &mut outcome);
            assert_eq!(outcome, [Ok(())], "{method}");
            increment
        };
        let mut kept = new(1.0);
        let whole = increment(kept.as_mut());
        for part in [0.5, 0.37, 1e-9, 0.0, 0.999, 1.0] {
            assert!(kept.set(Setting::StepSize(part)), "{method}");
            let expected = increment(new(part).as_mut());
            // Whatever came between.
            assert_eq!(increment(kept.as_mut()), expected, "{method}, {part}");
            assert!(part == 1.0 || expected != whole);
            increment(kept.as_mut());
        }
        assert!(kept.set(Setting::StepSize(1.0)));
        assert_eq!(kept.statistics(), new(1.0).statistics(), "{method}");
        assert_eq!(increment(kept.as_mut()), whole, "{method}");
    }
}

/// Blocks of an ensemble take one walk, whose stepper takes other parameters or is made anew.
#[test]
fn a_walk_that_starts_again_has_the_bits_of_a_new_one() {
    let collective = (
        "rigid-body",
        "realization = \"clebsch\"\ndynamics = { name = \"collective\", stages = 8 }",
    );
    for (library, method) in KEPT.into_iter().chain([collective]) {
        let run = composed(library, method);
        let lanes = 11;
        let start = |size: f64| {
            let spread = |values: &[f64]| -> Vec<f64> {
                let rows = values.iter();
                rows.flat_map(|value| {
                    (0..lanes).map(move |lane| value * (1.0 + size * lane as f64))
                })
                .collect()
            };
            [
                spread(&run.system.parameter_values()),
                spread(&run.plan.initial),
            ]
        };
        let [first, second] = [start(0.01), start(-0.003)];
        let map = run.method.map();
        let new = |[parameters, initial]: &[Vec<f64>; 2]| {
            Walk::side_by_side(map, lanes, (parameters, initial), 1.0, 0.1)
        };
        let (mut kept, mut fresh) = (new(&first), new(&second));
        kept.advance(23).expect("steps");
        kept.rest(3);
        let (parameters, initial) = (&second[0], &second[1]);
        kept.start_again(map, (parameters, initial));
        assert_eq!((kept.steps(), kept.living()), (0, lanes));
        for walk in [&mut kept, &mut fresh] {
            walk.advance(17).expect("steps");
        }
        assert_eq!(kept.checkpoint(), fresh.checkpoint(), "{method}");
        assert_eq!(kept.statistics(), fresh.statistics(), "{method}");
    }
}
