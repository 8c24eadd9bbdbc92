//! Friction that leaves the symplectic leaves: closed forms, and refusals of all maps along leaves.

use leafwise::core::part::PartParameters;
use leafwise::core::system::MotionClass;
use leafwise::core::{BuildError, Method, Registry, Structure};
use leafwise::scene::compose;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance};
use leafwise_tests::scenes::{document, end, until};

use super::{OSCILLATOR, assert_order, oscillator_at};

/// m′ = m × ∂H − γ m of a symmetric body.
const BODY: &str = "variables = [\"m1\", \"m2\", \"m3\"]\nparameters = { gamma = 0.3 }\nbracket = { lie-algebra = \"so3\" }\n\
                    convention = \"{x,H}\"\nhamiltonian = \"m1^2/4 + m2^2/4 + m3^2/2\"\n\
                    casimirs = { size2 = \"m1^2 + m2^2 + m3^2\" }\n\
                    friction = [\"-gamma*m1\", \"-gamma*m2\", \"-gamma*m3\"]";
const START: [f64; 3] = [1.0, 0.2, 0.7];

/// m₃ = m₃(0) e^{−γt}; m₁ + i m₂ shrinks alike and turns by −∫ m₃/2 dt.
fn body_at(t: f64) -> [f64; 3] {
    let rest = libm::exp(-0.3 * t);
    let angle = -0.5 * START[2] * (1.0 - rest) / 0.3;
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    [
        rest * (START[0] * cos - START[1] * sin),
        rest * (START[0] * sin + START[1] * cos),
        rest * START[2],
    ]
}

/// Baselines follow the state and |m| = e^{−γt} |m(0)|, of their order or to their tolerance.
#[test]
fn a_body_with_friction_shrinks_by_the_closed_form() {
    let exact = body_at(4.0);
    for (stepper, order) in [
        ("\"implicit-midpoint\"", 2.0),
        ("\"rk4\"", 4.0),
        ("{ name = \"gauss\", stages = 2 }", 4.0),
        ("{ name = \"gauss\", stages = 3 }", 6.0),
    ] {
        let method = format!("stepper = {stepper}");
        let steps = [10, 14, 20, 28, 40];
        assert_order((BODY, &method), (&START, &exact), 4.0, (order, &steps));
    }
    let size = |x: &[f64]| libm::sqrt(x.iter().map(|m| m * m).sum());
    for stepper in ["taylor", "dop853"] {
        let method = format!("stepper = {{ name = \"{stepper}\", tolerance = 1e-14 }}");
        let state = end(&until(BODY, &method, &format!("{START:?}"), (4.0, 40)));
        let shrunk = size(&state) / size(&START) / libm::exp(-1.2) - 1.0;
        println!(
            "{stepper}: state off by {:.1e}, |m| by {shrunk:.1e}",
            distance(&state, &exact)
        );
        // Forty steps, each with its tolerance and the rounding of its sum.
        assert!(distance(&state, &exact) <= 40.0 * 1e-14, "{stepper}");
        assert!(shrunk.abs() <= 40.0 * 1e-14, "{stepper}: {shrunk:e}");
    }
}

/// On a plane a friction of p is the one-form of a force, and both go the same way.
#[test]
fn friction_of_a_canonical_momentum_is_a_force() {
    let by_friction = OSCILLATOR.replace(
        "forces = [\"0.3*p\", \"0\"]",
        "friction = { p = \"-0.3*p\" }",
    );
    let method = "stepper = { name = \"gauss\", stages = 4 }";
    let [force, friction] = [OSCILLATOR, &by_friction]
        .map(|system| end(&until(system, method, "[1.0, 0.0]", (4.0, 40))));
    assert!(distance(&force, &friction) <= 64.0 * UNIT_ROUNDOFF);
    // A step of four stages errs by (4!)²/(8! 9!) h⁹ of the state, and rounds a few times.
    let steps = 40.0 * (libm::pow(0.1, 9.0) * 576.0 / (40_320.0 * 362_880.0) + 2.0 * UNIT_ROUNDOFF);
    assert!(distance(&friction, &oscillator_at(4.0)) <= steps);
}

/// The flow of H keeps the volume of so(3)*, and the friction's divergence is −3γ: det DΦ = e^{−3γh}.
#[test]
fn tangents_know_the_friction() {
    let h = 0.1;
    let run = until(
        BODY,
        "stepper = { name = \"gauss\", stages = 4 }",
        &format!("{START:?}"),
        (h, 1),
    );
    let mut walk = run.walk();
    walk.step().expect("a step");
    let tangent = walk.tangent(0).expect("a tangent");
    let volume = nalgebra::DMatrix::from_row_slice(3, 3, &tangent).determinant();
    // The ninth power of 0.1 times a field of size 1, over 9!, is below round-off.
    assert!(
        (volume - libm::exp(-0.9 * h)).abs() <= 64.0 * UNIT_ROUNDOFF,
        "{volume}"
    );
}

/// Every part whose steps are along leaves refuses, says why, and names those that take it.
#[test]
fn maps_along_leaves_refuse_friction_and_name_baselines() {
    let registry = Registry::with_builtin();
    let run = until(BODY, "stepper = \"rk4\"", &format!("{START:?}"), (1.0, 1));
    assert_eq!(run.system.motion(), MotionClass::OffLeaves);
    assert_eq!(run.method.map().properties().structure, Structure::None);
    let given = PartParameters::new();
    let realization = registry.realization("so3-exponential").expect("a part");
    // The realization is one of the tensor, which has no friction.
    let realization = realization.build(&run.system, &given).expect("it fits");
    let (mut taken, mut refused) = (0, 0);
    let mut judge = |name: &str, takes: MotionClass, built: Result<(), BuildError>| {
        if takes == MotionClass::OffLeaves {
            assert!(built.is_ok(), "{name}");
            taken += 1;
            return;
        }
        refused += 1;
        let error = built.expect_err(name);
        assert!(
            matches!(error, BuildError::Friction { .. }),
            "{name}: {error}"
        );
        let text = registry.explain(&error);
        assert!(
            text.contains("no such map follows the `friction`"),
            "{text}"
        );
        assert!(
            text.contains("the steppers ") && text.contains("rk4"),
            "{text}"
        );
        assert!(
            !text.contains("one-form,") && !text.contains("which keeps"),
            "{text}"
        );
    };
    for info in registry.parts() {
        if let Ok(part) = registry.dynamics(info.name) {
            let dynamics = part.build(&given).expect("defaults");
            let composed = Method::compose(&run.system, realization.clone(), dynamics);
            judge(info.name, info.takes, composed.map(drop));
        }
        if let Ok(part) = registry.stepper(info.name) {
            judge(
                info.name,
                info.takes,
                part.build(&run.system, &given).map(drop),
            );
        }
    }
    assert!(taken >= 6 && refused >= 8, "{taken} {refused}");
}

/// The words of a run, and what does not stand beside friction.
#[test]
fn scenes_say_that_casimirs_change_and_what_friction_does_not_stand_beside() {
    let run = until(
        BODY,
        "stepper = \"gauss\"",
        &format!("{START:?}"),
        (1.0, 10),
    );
    let work = run.work_of_forces().expect("words");
    assert!(
        work.contains("no Poisson map: the Casimirs change by the friction"),
        "{work}"
    );
    let structure = run.method.parts(run.system.motion());
    let structure = structure.iter().find(|(label, _)| *label == "Structure");
    let (_, structure) = structure.expect("a row");
    assert!(
        structure.contains("friction changes the tensor, and Casimirs where there are any"),
        "{structure}"
    );

    let text = format!(
        "[system]\n{BODY}\n[method]\nstepper = \"gauss\"\ntime-step = 0.1\n[run]\ninitial = {START:?}\nsteps = 1\n"
    );
    let registry = Registry::with_builtin();
    let cases = [
        ("system.friction", "[\"m1\"]", "1 entries where there are 3"),
        ("system.friction", "{ m4 = \"1\" }", "m4"),
        ("system.friction", "{ m1 = \"-k*m1\" }", "unknown name `k`"),
        (
            "method.pace",
            "\"1 + m1^2\"",
            "a pace serves motions of a Hamiltonian alone",
        ),
        (
            "method.stepper",
            "\"splitting\"",
            "no such map follows the `friction`",
        ),
        ("method.energy", "\"exact\"", "forces change the energy"),
        (
            "run.record.observables",
            "[\"shadow-energy\"]",
            "no shadow Hamiltonian",
        ),
    ];
    for (key, value, says) in cases {
        let document = document(&text, &[(key, value)]);
        let refusal = compose(&document, &registry).err();
        let message = refusal.unwrap_or_else(|| panic!("{key} = {value}")).message;
        println!("{key} = {value}: {message}");
        assert!(message.contains(says), "{key} = {value}: {message}");
    }
    let open = text.replace("stepper = \"gauss\"", "realization = \"auto\"");
    let refusal = compose(&document(&open, &[]), &registry)
        .err()
        .expect("refused");
    assert!(
        refusal
            .message
            .contains("a realization with a dynamics steps by Poisson maps")
            && refusal.message.contains("the steppers "),
        "{}",
        refusal.message
    );
    let ring = "[system]\nfamilies = { q = 2000, p = 2000 }\nbracket = { \"q[i],p[i]\" = \"1\" }\nconvention = \"{x,H}\"\n\
                hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2)\"\nfriction = { \"p[i]\" = \"-p[i]/10\" }\n\
                [method]\ntime-step = 0.1\n[run]\nsteps = 1\n[run.initial]\n\"q[i]\" = \"cos(2*pi*i/N)\"\n\"p[i]\" = 0\n";
    let refusal = compose(&document(ring, &[]), &registry)
        .err()
        .expect("refused");
    let sweeps = ring.replace("[method]\n", "[method]\nstepper = \"splitting\"\n");
    let second = compose(&document(&sweeps, &[]), &registry)
        .err()
        .expect("refused");
    for refusal in [refusal, second] {
        let help = refusal.help.expect("a help");
        let (_, names) = help.rsplit_once(": ").expect("names");
        let names: Vec<&str> = names.split(", ").collect();
        assert!(names.len() >= 5, "{help}");
        for name in names {
            let method = format!("[method]\nstepper = \"{name}\"\n");
            let taken = ring.replace("[method]\n", &method);
            let refusal = compose(&document(&taken, &[]), &registry).err();
            assert!(refusal.is_none(), "{name}: {refusal:?}");
        }
    }
}

/// The account of the energy names both kinds of work, and that a bracket without Casimirs has no leaf to leave.
#[test]
fn forces_beside_friction_are_in_the_account() {
    let with = |more: &str| {
        let system = OSCILLATOR.replace("forces = [\"0.3*p\", \"0\"]", more);
        let run = until(&system, "stepper = \"gauss\"", "[1.0, 0.0]", (1.0, 10));
        (
            run.system.motion(),
            run.work_of_forces(),
            run.force_keys.clone(),
        )
    };
    let (motion, work, keys) = with("forces = [\"0.3*p\", \"0\"]\nfriction = { q = \"-q/10\" }");
    let work = work.expect("words");
    assert_eq!(motion, MotionClass::OffLeaves);
    assert_eq!(keys, ["system.forces", "system.friction"]);
    assert!(
        work.contains("-<forces, {H, x}> + <dH, friction>")
            && work.contains("the friction changes the tensor"),
        "{work}"
    );
    assert!(!work.contains("leaf"), "{work}");
    // Zeros are no friction.
    for none in [
        "",
        "friction = {}",
        "friction = [0, 0]",
        "friction = { p = \"0.0\" }",
    ] {
        let (motion, work, keys) = with(none);
        assert_eq!((motion, work), (MotionClass::Hamiltonian, None), "{none}");
        assert!(keys.is_empty(), "{none}");
    }
    let (motion, ..) = with("friction = { p = \"0.1*p\" }");
    assert_eq!(motion, MotionClass::OffLeaves);
}
