//! Panics of plugins in Rust: caught inside the plugin, told as any other failure, fatal to one instance.

#![cfg(unix)]

mod support;

use leafwise_core::{PartParameters, PoissonSystem, Registry, StepError};
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_plugin_loader::{Refusal, SmokeFailure};
use support::build::rust_fixture;
use support::{load, probe};

/// A panic where the part is tried: refused in this process as in the child, and nothing of it stays.
#[test]
fn a_part_that_panics_is_refused_with_its_words() {
    let path = rust_fixture("panics");
    for probe in [None, Some(probe())] {
        let mut registry = Registry::empty();
        let error = load(&path, probe, &mut registry).expect_err("it panics");
        assert!(registry.parts().is_empty());
        let text = "part panics/always: increment: fatal: panic: index out of bounds: the len is 0 \
                    but the index is 3";
        assert!(error.to_string().contains(text), "{error}");
        let Refusal::Smoke { part, failure } = error.refusal else {
            panic!("{error}");
        };
        assert_eq!(part, "panics/always");
        assert!(matches!(failure, SmokeFailure::Call { .. }), "{failure:?}");
    }
}

fn oscillator() -> PoissonSystem {
    let names = ["x1", "x2"];
    let scope = Scope::new().with_variables(&names);
    let formula = |text: &str| {
        let formula = Formula::parse(text).and_then(|formula| formula.resolve(&scope, None));
        formula.expect("known names").expect("no boundary")
    };
    PoissonSystem::new(
        names.map(str::to_owned).to_vec(),
        Vec::new(),
        [((0, 1), formula("1"))],
        formula("(x1^2 + x2^2)/2"),
        Vec::new(),
        leafwise_core::Convention::HamiltonianFirst,
    )
    .expect("a system")
}

/// A panic far from where the part was tried: the step fails, its instance is called no more, and
/// another one of the same part works.
#[test]
fn a_panic_in_a_run_ends_its_instance_alone() {
    let mut registry = Registry::empty();
    load(&rust_fixture("panics_later"), Some(probe()), &mut registry).expect("it is tried near 1");
    let part = registry.stepper("panics/later").expect("a step map");
    let map = part.build(&oscillator(), &PartParameters::new());
    let map = map.expect("it serves every dimension");
    let mut stepper = map.stepper(1, &[], 1.0, 0.5);
    let mut step = |x: f64| -> Result<f64, StepError> {
        let (mut increment, mut outcome) = ([9.0; 2], [Ok(())]);
        stepper.increment(&[x, 0.0], &[0.0; 2], &mut increment, &mut outcome);
        let [outcome] = outcome;
        outcome.map(|()| increment[0])
    };
    assert_eq!(step(1.0), Ok(0.5));
    for text in [
        "panics/later failed: increment: fatal: panic: x1 = 3 is too large",
        "an earlier call broke this instance",
    ] {
        let error = step(3.0).expect_err("it panics").to_string();
        assert!(error.contains(text), "{error}");
    }
    let mut other = map.stepper(1, &[], 1.0, 0.5);
    let (mut increment, mut outcome) = ([9.0; 2], [Ok(())]);
    other.increment(&[1.0, 0.0], &[0.0; 2], &mut increment, &mut outcome);
    assert_eq!((increment, outcome), ([0.5, 0.0], [Ok(())]));
}
