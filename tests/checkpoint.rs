//! A run that stops and continues from its checkpoint has the same bits as one that does not.

use leafwise::core::Integrator;
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
            Integrator::new(
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
        // The second integrator has a history of its own, which the checkpoint must replace.
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
    let integrator = |problem: &leafwise_tests::Problem, method| {
        let parameters = problem.system.parameter_values();
        Integrator::new(method, &parameters, 0.1, 1.0, &problem.initial)
    };
    let foreign = integrator(&top, &top_method).checkpoint();
    let mut own = integrator(&body, &body_method);
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
