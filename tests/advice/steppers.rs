//! Steppers that are no Poisson maps, and stages that no step feels.

use leafwise::core::Structure;
use leafwise::run::advice::AdviceKind;
use leafwise_tests::scenes::composed;

use super::{advice, body, changed, end, of_kind, scene};

/// Operations a step, and how far 32 steps lead from where Gauss's method of order 16 does in 128.
fn cost_and_error(text: &str) -> (f64, f64) {
    let run = composed(text);
    let step = run.plan.epsilon * run.plan.h;
    let method = format!(
        "stepper = {{ name = \"gauss\", stages = 8 }}\ntime-step = {:?}",
        step / 4.0
    );
    let exact = end(&body(&method), 128);
    let mut walk = run.walk();
    (0..32).for_each(|_| walk.step().expect("a step"));
    let apart = walk.state().iter().zip(&exact).map(|(a, b)| (a - b).abs());
    let operations = walk.statistics().operations_per_step();
    (operations.expect("counted"), apart.fold(0.0, f64::max))
}

#[test]
fn a_stepper_that_is_no_poisson_map_is_reported_where_splitting_is_one_for_no_more() {
    for stepper in ["implicit-midpoint", "gauss", "dormand-prince45"] {
        let text = body(&format!("stepper = \"{stepper}\"\ntime-step = 0.1"));
        let found = of_kind(&text, AdviceKind::NoPoissonMap).expect(stepper);
        let mended = changed(&text, &found);
        let properties = composed(&mended).method.map().properties();
        assert_eq!(properties.structure, Structure::Exact, "{mended}");
        assert_eq!(advice(&mended), [], "{stepper}");
        let ((own, before), (other, after)) = (cost_and_error(&text), cost_and_error(&mended));
        assert!(
            other <= 1.1 * own,
            "{stepper}: {other} operations, not {own}"
        );
        // Both to the 1e-11 of |x| that the advice's own measure tells apart.
        assert!(
            after <= before.max(1e-10),
            "{stepper}: {after:e}, not {before:e}"
        );
    }
    // Gauss methods are Poisson maps of constant tensors; these steppers are Poisson maps.
    let oscillator = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"-1\" }\n\
                      hamiltonian = \"(q^2 + p^2)/2\"\n[method]\nstepper = \"gauss\"\n\
                      time-step = 0.2\n[run]\ninitial = [1, 0]\nsteps = 100\n";
    assert_eq!(of_kind(oscillator, AdviceKind::NoPoissonMap), None);
    for stepper in ["splitting", "spherical-midpoint"] {
        let text = body(&format!("stepper = \"{stepper}\"\ntime-step = 0.2"));
        assert_eq!(advice(&text), [], "{stepper}");
    }
    // No pieces with exact flows: nothing to take instead.
    let gradient = scene(
        "gradient",
        "[0.8, 0.5, -0.4]",
        "stepper = \"rk4\"\ntime-step = 0.1",
    );
    assert_eq!(of_kind(&gradient, AdviceKind::NoPoissonMap), None);
}

#[test]
fn stages_that_no_step_feels_are_reported() {
    let text = |stages: u32, time_step: &str| {
        body(&format!(
            "stepper = {{ name = \"gauss\", stages = {stages} }}\ntime-step = {time_step}"
        ))
    };
    let long = text(8, "0.01");
    let found = of_kind(&long, AdviceKind::Stages).expect("a warning");
    let shorter = changed(&long, &found);
    assert_eq!(of_kind(&shorter, AdviceKind::Stages), None);
    let bound = 100.0 * f64::EPSILON * 4.5;
    let (a, b) = (end(&long, 100), end(&shorter, 100));
    assert!(
        a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= bound),
        "{a:?} {b:?}"
    );
    assert_eq!(of_kind(&text(3, "0.2"), AdviceKind::Stages), None);
}
