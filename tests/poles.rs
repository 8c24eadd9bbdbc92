//! No step crosses a pole of the equations of motion; places where they stay finite are crossed.

use leafwise::core::StepError;
use leafwise::scene::ComposedRun;
use leafwise_tests::scenes::composed;
use proptest::prelude::*;
use proptest::sample::select;

const METHODS: [&str; 9] = [
    r#"stepper = "splitting""#,
    r#"stepper = "rk4""#,
    r#"stepper = { name = "gauss", stages = 2 }"#,
    r#"stepper = { name = "energy-preserving", order = 4 }"#,
    r#"stepper = "implicit-midpoint""#,
    r#"stepper = "dop853""#,
    r#"stepper = "taylor""#,
    "stepper = \"splitting\"\ncomposition = \"triple-jump\"",
    r#"dynamics = { name = "hamilton-jacobi", order = 2 }"#,
];

fn scene(hamiltonian: &str, method: &str, step: f64, initial: [f64; 2]) -> ComposedRun {
    let [q, p] = initial;
    let text = format!(
        "[system]\nvariables = [\"q\", \"p\"]\nconvention = \"{{x,H}}\"\nbracket = {{ \"q,p\" = \"1\" }}\n\
         hamiltonian = \"{hamiltonian}\"\n[method]\n{method}\ntime-step = {step:?}\n\
         [run]\ninitial = [{q:?}, {p:?}]\nsteps = 20\n"
    );
    composed(&text)
}

/// The positions until a step is refused, and why it was.
fn positions(run: &ComposedRun) -> (Vec<f64>, Option<StepError>) {
    let mut walk = run.walk();
    let mut positions = vec![walk.state()[0]];
    for _ in 0..run.plan.steps {
        if let Err(error) = walk.step() {
            return (positions, Some(error));
        }
        positions.push(walk.state()[0]);
    }
    (positions, None)
}

#[test]
fn a_pole_in_the_way_of_an_explicit_step_is_named() {
    for (hamiltonian, denominator) in [
        ("p^2/2 + 1/(q - 2)^2", "2 - q"),
        ("p^2/2 - ln((2 - q)^2)", "2 - q"),
        ("p^2/2 + tan(q)^2", "cos(q)"),
        ("p^2/2 + 1/q^12 - 1/q^6", "q"),
    ] {
        let run = scene(hamiltonian, METHODS[0], 0.5, [1.5, 5.0]);
        let run = match denominator {
            "q" => scene(hamiltonian, METHODS[0], 0.5, [1.5, -9.0]),
            _ => run,
        };
        let (_, error) = positions(&run);
        let Some(StepError::Pole {
            denominator: named,
            before,
            after,
        }) = error
        else {
            panic!("{hamiltonian}: {error:?}");
        };
        assert_eq!(named, denominator, "{hamiltonian}");
        assert!(before * after < 0.0, "from {before} to {after}");
    }
}

/// A denominator that the scene has a name for is called by it.
#[test]
fn a_defined_denominator_has_its_name() {
    let run = composed(
        "[system]\nvariables = [\"q\", \"p\"]\nconvention = \"{x,H}\"\ndefine = { gap = \"2 - q\", V = \"1e-3/gap^3\" }\n\
         bracket = { \"q,p\" = 1 }\nhamiltonian = \"p^2/2 + V\"\n[method]\nstepper = \"rk4\"\n\
         time-step = 0.5\n[run]\ninitial = [1.5, 5]\nsteps = 20\n",
    );
    let (_, error) = positions(&run);
    let message = error.expect("a pole").to_string();
    assert!(
        message.contains("where gap = 0: it goes from 5.000e-1 to -"),
        "{message}"
    );
}

/// 1 + 1/(q − 3) is of one sign at both ends of a step from 1.5 to 4, with a pole of its own at 3 between.
#[test]
fn a_pole_beside_a_place_without_one_is_found() {
    let run = scene("p^2/2 + 1e-6/(1 + 1/(q - 3))", METHODS[0], 0.5, [1.5, 5.0]);
    let (_, error) = positions(&run);
    assert!(matches!(error, Some(StepError::Pole { .. })), "{error:?}");
}

/// q² − 1 is of one sign at both ends of a step from 1.5 to −1.5, with two poles between.
#[test]
fn two_poles_of_one_denominator_are_not_jumped_over() {
    for hamiltonian in ["p^2/2 + 1e-3/(q^2 - 1)", "p^2/2 + 1e-3*tan(1.5707963*q)^2"] {
        let run = scene(hamiltonian, METHODS[0], 0.5, [1.5, -6.0]);
        let (_, error) = positions(&run);
        assert!(matches!(error, Some(StepError::Pole { .. })), "{error:?}");
    }
}

/// Unless the step is 1, q′ = p and p′ = 2k/q³ differ by many orders, beside the pole too.
#[test]
fn a_pole_is_found_in_a_step_of_any_length() {
    for step in [1e-12, 1e-3, 1.0, 1e3, 1e12] {
        for weakness in [1e-3, 1e-9, 1e-15] {
            let strength = weakness / (step * step);
            let hamiltonian = format!("p^2/2 + {strength:?}/q^2");
            let run = scene(&hamiltonian, METHODS[0], step, [1.0, -1.5 / step]);
            let (_, error) = positions(&run);
            assert!(matches!(error, Some(StepError::Pole { .. })), "{error:?}");
        }
    }
}

#[test]
fn places_without_a_pole_are_crossed() {
    for hamiltonian in [
        "p^2/2 + sin(q)/q",
        "p^2/2 + (q^2 - 1)/(q - 1)",
        "p^2/2 + sqrt(q^2)",
        "p^2/2 + (1 - cos(q))/q^2",
        "p^2/2 + 1/q - cos(q)/q",
        "p^2/2 + (q^2)^(3/4)",
    ] {
        let run = scene(hamiltonian, METHODS[0], 0.37, [3.0, -4.0]);
        let (positions, error) = positions(&run);
        assert_eq!(error, None, "{hamiltonian}");
        assert!(
            positions.iter().any(|q| *q < 0.0),
            "{hamiltonian}: {positions:?}"
        );
    }
}

proptest! {
    /// Energy p²/2 + k/(q − c)ⁿ, k > 0, keeps the motion on one side of c, if n is even or q > c.
    #[test]
    fn a_repelled_particle_stays_on_its_side(
        method in select(METHODS.to_vec()),
        even in any::<bool>(),
        centre in -2.0..2.0_f64,
        start in 0.05..3.0_f64,
        velocity in 0.1..20.0_f64,
        strength in -3.0..1.0_f64,
        step in -2.5..0.7_f64,
    ) {
        let strength = libm::exp2(strength * 3.4);
        let step = libm::exp2(step * 3.4);
        let power = if even { 2 } else { 1 };
        let run = scene(
            &format!("p^2/2 + {strength:?}/(q - ({centre:?}))^{power}"),
            method,
            step,
            [centre + start, -velocity],
        );
        let (positions, _) = positions(&run);
        for q in &positions {
            prop_assert!(*q > centre, "{positions:?}");
        }
    }
}

/// Neighbours on a line that repel each other pass only over the pole of 1/(x[i+1] − x[i])².
#[test]
fn neighbours_of_a_long_chain_do_not_pass_each_other() {
    let scene = |coupling: &str, speed: f64| {
        let text = format!(
            "[system]\nfamilies = {{ u = 600, p = 600 }}\nconvention = \"{{x,H}}\"\n\
             bracket = {{ \"u[i],p[i]\" = \"1\" }}\nhamiltonian = \"sum(i, p[i]^2/2 + {coupling})\"\n[method]\nstepper = \"splitting\"\n\
             time-step = 0.1\n[run]\ninitial = {{ \"u[i]\" = \"0\", \"p[i]\" = \"{speed:?}*sin(2*pi*i/N)\" }}\nsteps = 40\n"
        );
        composed(&text)
    };
    let repelling = "1/(1 + u[i+1] - u[i])^2";
    let (_, error) = positions(&scene(repelling, 0.1));
    assert_eq!(error, None);
    let (_, error) = positions(&scene(repelling, 300.0));
    match error {
        Some(StepError::Pole { denominator, .. }) => {
            assert!(denominator.contains("u["), "{denominator}");
        }
        other => panic!("they meet: {other:?}"),
    }
    let soft = "1/(1 + (u[i+1] - u[i])^2)";
    let (_, error) = positions(&scene(soft, 300.0));
    assert_eq!(error, None);
}

/// Steps in one call are judged as steps one by one: signs and poles end both at the same step, with the same refusal,
/// state and counts.
#[test]
fn steps_in_one_call_are_checked_one_by_one() {
    let species = |hamiltonian: &str, initial: [f64; 2], step: f64| {
        composed(&format!(
            "[system]\nvariables = [\"x1\", \"x2\"]\nbracket = {{ log-canonical = [[0, -1], [1, 0]] }}\n\
             hamiltonian = \"{hamiltonian}\"\n[method]\nrealization = \"log-canonical\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = {step:?}\n\
             [run]\ninitial = {initial:?}\nsteps = 40\n"
        ))
    };
    let towards = |method: &str| scene("p^2/2 + 1/(q - 2)^2", method, 0.5, [-5.3, 5.0]);
    let cases = [
        // A predator from next to nothing: four steps go well, the fifth takes all of the prey.
        (species("x1 + x2", [16e-40, 16.0], 1.75), "lost sign"),
        (species("x1 + x2 + 1e-12/(x1 - 3)", [0.5, 4.0], 0.1), "pole"),
        (towards(METHODS[0]), "pole"),
        (towards(METHODS[1]), "pole"),
        (towards(METHODS[8]), "pole"),
    ];
    for (at, (run, refusal)) in cases.into_iter().enumerate() {
        let (mut one, mut many) = (run.walk(), run.walk());
        let failure = (0..40).find_map(|_| one.step().err());
        let named = match &failure {
            Some(StepError::LostSign { .. }) => "lost sign",
            Some(StepError::Pole { .. }) => "pole",
            _ => "none",
        };
        assert_eq!(named, refusal, "case {at}: {failure:?}");
        assert!(one.steps() >= 2, "case {at}: {} steps", one.steps());
        assert_eq!(many.advance(40).err(), failure, "case {at}");
        assert_eq!(one.checkpoint(), many.checkpoint(), "case {at}");
        assert_eq!(one.statistics(), many.statistics(), "case {at}");
        assert_eq!(one.statistics().failures, 1, "case {at}");
    }
}
