//! Forces beside dH: maps along symplectic leaves of the declared order, against closed forms; what takes no forces says so.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

mod friction;
mod lattices;

use leafwise::core::part::PartParameters;
use leafwise::core::system::{Damping, Forces, Metric, MotionClass};
use leafwise::core::{BuildError, Method, PoissonSystem, Registry, Structure};
use leafwise::expression::Expression;
use leafwise::run::advice::{AdviceKind, JudgedStates, advise, states_ahead};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise_tests::methods::{increment, observe};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::orders::measure;
use leafwise_tests::scenes::{composed, document, end, until};
use leafwise_tests::strategies::{polynomial, positive_state, state};
use proptest::prelude::*;

/// Exact realizations of so(3)*, and one by collocation.
const OF_SO3: [&str; 5] = [
    "so3-exponential",
    "so3-cayley",
    "so3-group",
    "lie-poisson",
    "karasev-collocated",
];

/// H = −B m_z with |m| = 1: m_z = tanh(λBt + artanh m_z(0)), and m_x + i m_y turns by −Bt.
const SPIN: &str = "variables = [\"x\", \"y\", \"z\"]\nbracket = { lie-algebra = \"so3\" }\nparameters = { B = 1.3, k = 0.4 }\n\
                    hamiltonian = \"-B*z\"\ncasimirs = { spin = \"x^2 + y^2 + z^2\" }\ndamping = { rate = \"k\" }";

/// Of size 1.
const SPIN_START: [f64; 3] = [0.8, 0.0, -0.6];

fn atanh(x: f64) -> f64 {
    0.5 * (libm::log1p(x) - libm::log1p(-x))
}

fn spin_at(t: f64) -> [f64; 3] {
    let z = libm::tanh(0.4 * 1.3 * t + atanh(SPIN_START[2]));
    let (across, angle) = (libm::sqrt(1.0 - z * z), -1.3 * t);
    [across * libm::cos(angle), across * libm::sin(angle), z]
}

/// x″ = −x − 0.3 x′ as q′ = p, p′ = −q − 0.3 p: the force −0.3 p is η_q = 0.3 p.
const OSCILLATOR: &str = "variables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
                          hamiltonian = \"p^2/2 + q^2/2\"\nforces = [\"0.3*p\", \"0\"]";

/// From (1, 0).
fn oscillator_at(t: f64) -> [f64; 2] {
    let (fall, rate) = (0.15, libm::sqrt(1.0 - 0.15 * 0.15));
    let (sin, cos) = (libm::sin(rate * t), libm::cos(rate * t));
    let size = libm::exp(-fall * t);
    [size * (cos + fall / rate * sin), -size * sin / rate]
}

/// x″ = −x − 0.1 cos t by the force −0.1 cos t, beside a Hamiltonian that does not name the time.
const DRIVEN: &str = "variables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
                      hamiltonian = \"p^2/2 + q^2/2\"\nforces = [\"0.1*cos(t)\", 0]";

/// x = cos t − t sin(t)/20.
fn driven_at(t: f64) -> [f64; 2] {
    let (sin, cos) = (libm::sin(t), libm::cos(t));
    [cos - t * sin / 20.0, -sin - sin / 20.0 - t * cos / 20.0]
}

/// The fitted order of errors against the closed form at `time`.
fn assert_order(
    (system, method): (&str, &str),
    (initial, exact): (&[f64], &[f64]),
    time: f64,
    (order, steps): (f64, &[usize]),
) {
    let points: Vec<(f64, f64)> = steps
        .iter()
        .map(|&steps| {
            let run = until(system, method, &format!("{initial:?}"), (time, steps));
            (time / steps as f64, distance(&end(&run), exact))
        })
        .collect();
    // Rounding of hundreds of compensated steps, and of the closed form.
    let round_off = 64.0 * UNIT_ROUNDOFF * largest(exact);
    let measured = measure(&points, round_off, 2.0).expect("errors above round-off");
    println!("{method}: {measured}");
    assert!(measured.is(order, 2.0), "{method}: {measured}, {points:?}");
}

#[test]
fn a_damped_spin_follows_tanh_to_order_2_over_every_realization() {
    let exact = spin_at(3.0);
    for name in OF_SO3 {
        let method = format!("realization = \"{name}\"");
        let steps = [24, 48, 96, 192, 384];
        assert_order((SPIN, &method), (&SPIN_START, &exact), 3.0, (2.0, &steps));
    }
}

#[test]
fn compositions_raise_the_order_with_damping() {
    let exact = spin_at(3.0);
    let of = |composition: &str, order: f64, steps: &[usize]| {
        let method = format!("composition = \"{composition}\"");
        assert_order((SPIN, &method), (&SPIN_START, &exact), 3.0, (order, steps));
    };
    of("suzuki-4", 4.0, &[12, 17, 24, 34, 48, 68]);
    of("kahan-li-6", 6.0, &[12, 17, 24, 34, 48]);
    of("suzuki-umeno-8", 8.0, &[12, 15, 18, 22, 26]);
}

#[test]
fn a_damped_and_a_driven_oscillator_follow_their_closed_forms() {
    let steps = [40, 80, 160, 320, 640];
    for (system, exact) in [(OSCILLATOR, oscillator_at(4.0)), (DRIVEN, driven_at(4.0))] {
        assert_order((system, ""), (&[1.0, 0.0], &exact), 4.0, (2.0, &steps));
        let steps = [8, 12, 16, 24, 32];
        let of_four = "composition = \"suzuki-4\"";
        assert_order((system, of_four), (&[1.0, 0.0], &exact), 4.0, (4.0, &steps));
    }
}

/// max |C(x_k) − C(x_0)| / C(x_0) of C = |x|² over all steps, with what the state holds beyond a double.
fn spin_drift(run: &ComposedRun, steps: u64) -> f64 {
    let mut walk = run.walk();
    let spin = |x: &[f64], low: &[f64]| -> f64 {
        x.iter()
            .zip(low)
            .map(|(x, low)| x * x + 2.0 * x * low)
            .sum()
    };
    let start = spin(&run.plan.initial, &[0.0; 3]);
    let mut worst = 0.0_f64;
    for _ in 0..steps {
        walk.step().expect("a step");
        let now = spin(walk.state(), walk.compensation());
        worst = worst.max((now - start).abs() / start);
    }
    worst
}

/// The update is compensated; what remains is a random walk of increments with an error of some u times their size. They
/// fall with the motion towards its rest: their sum is that of a hundred steps of size 0.1 at most. Components die out through
/// numbers without digits, which collocation of the curve between both ends does not resolve.
#[test]
fn a_damped_spin_keeps_its_size_over_1e5_steps() {
    for name in OF_SO3 {
        let method = format!("realization = \"{name}\"");
        let steps = match name {
            "karasev-collocated" => 10_000,
            _ => 100_000,
        };
        let time = 0.1 * steps as f64;
        let run = until(SPIN, &method, &format!("{SPIN_START:?}"), (time, steps));
        let drift = spin_drift(&run, steps as u64);
        println!("{name}: {drift:.1e}");
        assert!(drift <= 1e-14, "{name}: {drift:e}");
    }
}

#[test]
#[ignore = "half a minute"]
fn a_damped_spin_keeps_its_size_over_1e7_steps() {
    let run = until(SPIN, "", &format!("{SPIN_START:?}"), (1e6, 10_000_000));
    let drift = spin_drift(&run, 10_000_000);
    println!("{drift:.1e}");
    assert!(drift <= 1e-14, "{drift:e}");
}

/// dH/dt = −λ|ẋ_H|² holds of every step, to the rounding of H; of least energy on the sphere is the axis of the largest
/// inertia.
#[test]
fn a_damped_rigid_body_loses_energy_at_every_step_and_ends_on_its_largest_axis() {
    let system = "library = \"rigid-body\"\nparameters = { k = 0.2 }\ndamping = { rate = \"k\" }";
    let run = until(system, "", "[1.0, 0.1, 0.2]", (2000.0, 20_000));
    let formulas = run.system.expressions().expect("formulas").clone();
    let energy = |x: &[f64]| observe(&run.system, &[formulas.hamiltonian()], x)[0];
    let mut walk = run.walk();
    let mut last = energy(walk.state());
    for step in 0..20_000 {
        walk.step().expect("a step");
        let now = energy(walk.state());
        let slack = 8.0 * UNIT_ROUNDOFF * last;
        assert!(now <= last + slack, "step {step}: {last:e} to {now:e}");
        last = now;
    }
    let inertia = ["I1", "I2", "I3"].map(|name| {
        let parameters = run.system.parameters();
        let known = parameters.iter().find(|p| p.name == name);
        known.expect("an inertia").value
    });
    let largest_axis = (0..3).max_by(|i, j| inertia[*i].total_cmp(&inertia[*j]));
    let x = walk.state();
    let spin = libm::sqrt(x.iter().map(|x| x * x).sum());
    let axis = largest_axis.expect("three axes");
    // Deviations fall as e^{−κt}, κt in the hundreds; the energy is flat there, so that √u is what its rounding leaves.
    assert!(
        (x[axis].abs() - spin).abs() <= 1e-12 * spin,
        "{x:?} for {inertia:?}"
    );
    assert!(spin_drift(&run, 20_000) <= 1e-14);
}

/// Feedback that steers the energy to 0.4 on the spin's sphere, from above and from below.
#[test]
fn feedback_steers_the_energy_on_its_leaf() {
    for initial in ["[1.0, 0.1, 0.2]", "[0.1, 0.1, 1.0]"] {
        let system = "variables = [\"x\", \"y\", \"z\"]\nbracket = { lie-algebra = \"so3\" }\n\
                      define = { H = \"x^2/2 + y^2/3 + z^2/4\" }\nhamiltonian = \"H\"\n\
                      casimirs = { spin = \"x^2 + y^2 + z^2\" }\ndamping = { rate = \"5*(H - 0.4)\" }";
        // Of order 2 it settles by O(h²) beside it.
        let method = "composition = \"suzuki-umeno-8\"";
        let run = until(system, method, initial, (400.0, 8000));
        let formulas = run.system.expressions().expect("formulas").clone();
        let x = end(&run);
        let energy = observe(&run.system, &[formulas.hamiltonian()], &x)[0];
        assert!((energy - 0.4).abs() <= 1e-10, "{energy}");
        assert!(spin_drift(&run, 8000) <= 1e-14);
    }
}

/// Two solves of one equation differ by their residuals, a few hundred roundings of the increment, times a condition number
/// below ten; increments are below the state.
const TWO_SOLVES: f64 = 50.0 * UNIT_ROUNDOFF;

/// A run of one step of t from a state.
fn forced(
    bracket: &str,
    (hamiltonian, forces): (&str, [&str; 3]),
    realization: &str,
) -> ComposedRun {
    composed(&format!(
        "[system]\nvariables = [\"x\", \"y\", \"z\"]\nbracket = {bracket}\nhamiltonian = \"{hamiltonian}\"\nforces = {forces:?}\n\
         [method]\nrealization = \"{realization}\"\ntime-step = 0.01\n[run]\ninitial = [1.0, 1.0, 1.0]\nsteps = 1\n"
    ))
}

const XYZ: &[&str] = &["x", "y", "z"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Any one-form moves any system along its leaves: the Casimir changes by its slope times the error of a solve; and the
    /// step back undoes the step.
    #[test]
    fn random_one_forms_keep_casimirs_and_are_their_own_adjoints(
        hamiltonian in polynomial(XYZ),
        forces in [polynomial(XYZ), polynomial(XYZ), polynomial(XYZ)],
        body in state(3),
        species in positive_state(3),
        t in 0.001..0.004_f64,
    ) {
        let forces = [forces[0].as_str(), &forces[1], &forces[2]];
        // x² + y² + z² of slope 2√3, xyz of slope 3 relative to its smallest factor, and z.
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let product = |x: &[f64]| x.iter().product::<f64>();
        let last = |x: &[f64]| x[2];
        let spread = 2.0 * libm::sqrt(3.0);
        let smallest = species.iter().copied().fold(f64::INFINITY, f64::min);
        let of_product = 3.0 * largest(&species) / smallest;
        let log = "{ log-canonical = [[0, 1, -1], [-1, 0, 1], [1, -1, 0]] }";
        type Function<'a> = &'a dyn Fn(&[f64]) -> f64;
        let cases: [(&str, &str, &[f64], Function<'_>, f64); 6] = [
            ("{ lie-algebra = \"so3\" }", "so3-exponential", &body, &square, spread),
            ("{ lie-algebra = \"so3\" }", "so3-cayley", &body, &square, spread),
            ("{ lie-algebra = \"so3\" }", "lie-poisson", &body, &square, spread),
            ("{ lie-algebra = \"so3\" }", "karasev-collocated", &body, &square, spread),
            (log, "log-canonical", &species, &product, of_product),
            ("{ \"x,y\" = \"1\" }", "constant", &body, &last, 1.0),
        ];
        for (bracket, realization, x, casimir, slope) in cases {
            let run = forced(bracket, (&hamiltonian, forces), realization);
            let map = run.method.map();
            prop_assert_eq!(map.properties().structure, Structure::Leaves);
            let step = |t: f64, x: &[f64]| increment(map, &[], (1.0, t), x);
            let Ok(forth) = step(t, x) else { continue };
            let next: Vec<f64> = x.iter().zip(&forth).map(|(x, i)| x + i).collect();
            let change = (casimir(&next) - casimir(x)).abs() / casimir(x).abs();
            prop_assert!(change <= slope * TWO_SOLVES, "{realization}: {change:e}");
            let Ok(back) = step(-t, &next) else { continue };
            let error = largest(forth.iter().zip(&back).map(|(f, b)| f + b));
            prop_assert!(error <= TWO_SOLVES * largest(x), "{realization}: {error:e}");
        }
    }

    /// η = dV is closed: the map is Hamilton–Jacobi's of order 2 for H + V.
    #[test]
    fn closed_forces_are_a_hamiltonian(
        hamiltonian in polynomial(XYZ),
        x in state(3),
        t in 0.001..0.004_f64,
    ) {
        let bracket = "{ lie-algebra = \"so3\" }";
        // V = 0.3 x²y + 0.7 z³.
        let forces = ["0.6*x*y", "0.3*x^2", "2.1*z^2"];
        let run = forced(bracket, (&hamiltonian, forces), "so3-exponential");
        let whole = composed(&format!(
            "[system]\nvariables = [\"x\", \"y\", \"z\"]\nbracket = {bracket}\nhamiltonian = \"{hamiltonian} + 0.3*x^2*y + 0.7*z^3\"\n\
             [method]\nrealization = \"so3-exponential\"\ndynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = 0.01\n\
             [run]\ninitial = [1.0, 1.0, 1.0]\nsteps = 1\n"
        ));
        let step = |run: &ComposedRun| increment(run.method.map(), &[], (1.0, t), &x);
        if let (Ok(one), Ok(other)) = (step(&run), step(&whole)) {
            let error = distance(&one, &other);
            prop_assert!(error <= TWO_SOLVES * largest(&x), "{error:e}");
        }
    }
}

fn spin_system() -> PoissonSystem {
    until(SPIN, "", "[0.8, 0.0, -0.6]", (1.0, 10)).system
}

#[test]
fn parts_of_hamiltonian_motions_refuse_forces_and_name_what_takes_them() {
    let registry = Registry::with_builtin();
    let system = spin_system();
    let realization = registry.realization("so3-exponential").expect("a part");
    let realization = realization
        .build(&system, &PartParameters::new())
        .expect("it fits");
    let is_refused = |refused: Result<(), BuildError>, name: &str| {
        let error = refused.expect_err(name);
        assert!(
            matches!(error, BuildError::Forces { .. }),
            "{name}: {error}"
        );
        let text = registry.explain(&error);
        assert!(text.contains("one-form") && text.contains("rk4"), "{text}");
    };
    for info in registry.parts() {
        let given = PartParameters::new();
        if let Ok(part) = registry.dynamics(info.name) {
            let dynamics = part.build(&given).expect("defaults");
            let composed = Method::compose(&system, realization.clone(), dynamics.clone());
            let unfused = Method::compose_unfused(&system, realization.clone(), dynamics);
            match info.takes >= MotionClass::OnLeaves {
                true => assert!(composed.is_ok() && unfused.is_ok(), "{}", info.name),
                false => {
                    is_refused(composed.map(drop), info.name);
                    is_refused(unfused.map(drop), info.name);
                }
            }
        }
        if let Ok(part) = registry.stepper(info.name) {
            let built = part.build(&system, &given);
            match info.takes >= MotionClass::OnLeaves {
                true => assert!(built.is_ok(), "{}", info.name),
                false => is_refused(built.map(drop), info.name),
            }
        }
    }
    is_refused(
        leafwise::splitting::Splitting::new(&system).map(drop),
        "splitting",
    );
    is_refused(system.without_formulas("numbers").map(drop), "numbers");
    assert!(registry.automatic(&system, 2).is_ok());
    assert!(matches!(
        registry.automatic(&system, 4),
        Err(BuildError::NotMade { .. })
    ));
}

#[test]
fn without_forces_the_part_points_to_hamilton_jacobi() {
    let registry = Registry::with_builtin();
    let text = "[system]\nlibrary = \"rigid-body\"\n[method]\ndynamics = \"one-form\"\ntime-step = 0.1\n[run]\n\
                initial = [1.0, 0.1, 0.2]\nsteps = 1\n";
    let refusal = compose(&document(text, &[]), &registry)
        .err()
        .expect("refused");
    assert!(
        refusal.message.contains("hamilton-jacobi of order 2"),
        "{}",
        refusal.message
    );
}

/// A baseline of high order is an oracle of the same motion.
#[test]
fn baselines_integrate_the_forced_motion() {
    let exact = spin_at(3.0);
    for stepper in ["dop853", "taylor", "{ name = \"gauss\", stages = 4 }"] {
        let quoted = match stepper.starts_with('{') {
            true => stepper.to_owned(),
            false => format!("\"{stepper}\""),
        };
        let run = until(
            SPIN,
            &format!("stepper = {quoted}"),
            &format!("{SPIN_START:?}"),
            (3.0, 60),
        );
        let error = distance(&end(&run), &exact);
        assert!(error <= 1e-10, "{stepper}: {error:e}");
    }
}

#[test]
fn lists_of_other_lengths_are_refused() {
    let system = spin_system();
    let formulas = system.expressions().expect("formulas");
    let of = |one_form: usize, metric: Metric| {
        formulas.with_forces(Forces {
            one_form: vec![1.into(); one_form],
            damping: Some(Damping {
                rate: 1.into(),
                metric,
            }),
            friction: Vec::new(),
        })
    };
    assert!(of(3, Metric::identity(3, 3)).is_ok());
    for refused in [
        of(2, Metric::identity(3, 3)),
        of(3, Metric::identity(2, 2)),
        of(0, Metric::Full(vec![vec![1.into(); 3]; 2])),
        of(0, Metric::Full(vec![vec![1.into(); 2]; 3])),
    ] {
        assert!(matches!(refused, Err(BuildError::Dimension { .. })));
    }
}

/// What is wrong with a scene's forces, with the words that say so.
#[test]
fn scenes_say_what_is_wrong_with_their_forces() {
    let text = format!(
        "[system]\n{SPIN}\n[method]\ntime-step = 0.1\n[run]\ninitial = {SPIN_START:?}\nsteps = 1\n"
    );
    let registry = Registry::with_builtin();
    let cases = [
        ("system.forces", "[\"x\"]", "1 entries where there are 3"),
        ("system.forces", "[\"x\", \"y\", \"w\"]", "unknown name `w`"),
        ("system.damping.rate", "\"-k\"", "not negative"),
        (
            "system.damping.metric",
            "[1, 1]",
            "2 entries where there are 3",
        ),
        (
            "system.damping.metric",
            "[[1, 2, 0], [0, 1, 0], [0, 0, 1]]",
            "not symmetric",
        ),
        ("system.damping.metric", "[1, -1, 1]", "eigenvalue -1"),
        (
            "method.pace",
            "\"1 + x^2\"",
            "a pace serves motions of a Hamiltonian alone",
        ),
        (
            "method.dynamics",
            "\"hamilton-jacobi\"",
            "this system has forces",
        ),
        ("method.stepper", "\"splitting\"", "this system has forces"),
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
        assert!(message.contains(says), "{key} = {value}: {message}");
    }
    let unknown = SceneDocument::parse_with(
        "scene",
        &text,
        &[("system.damping.speed".to_owned(), "1".to_owned())],
        &registry,
    );
    assert!(unknown.is_err());
}

/// H + N names the variables of H alone, with forces beside it and without.
#[test]
fn a_perturbation_by_unknown_variables_is_refused() {
    let method = "realization = \"auto\"";
    let with = until(OSCILLATOR, method, "[1, 0]", (1.0, 1));
    let without = OSCILLATOR.replace("forces = [\"0.3*p\", \"0\"]", "");
    let without = until(&without, method, "[1, 0]", (1.0, 1));
    for (run, has_forces) in [(with, true), (without, false)] {
        let formulas = run.system.expressions().expect("formulas");
        assert_eq!(run.system.has_forces(), has_forces);
        let refused = formulas.with_perturbation(Expression::Variable(2));
        assert!(
            matches!(refused, Err(BuildError::Dimension { .. })),
            "{refused:?}"
        );
        assert!(formulas.with_perturbation(Expression::Variable(1)).is_ok());
    }
}

/// Over a truncated realization steps leave the leaf, and a warning says by how much; over an exact one they do not.
#[test]
fn a_realization_that_is_not_exact_gives_a_warning() {
    let registry = Registry::with_builtin();
    let warnings = |realization: &str| {
        let system = "library = \"lotka-volterra-periodic\"\ndamping = { rate = 0.1 }";
        let method = format!("realization = {realization}");
        let run = until(system, &method, "[1.0, 1.9, 0.5]", (10.0, 100));
        let advice = advise(&run, &registry, (&states_ahead(&run), JudgedStates::Ahead));
        let mut advice = advice.into_iter();
        advice.find(|advice| advice.kind == AdviceKind::LeftLeaf)
    };
    let found = warnings("{ name = \"karasev-truncated\", order = 2 }").expect("a warning");
    assert!(found.message.contains("of their size"), "{}", found.message);
    assert!(found.change.contains("auto"), "{}", found.change);
    assert_eq!(warnings("\"auto\""), None);
    assert_eq!(warnings("\"karasev-collocated\""), None);
}

/// In lanes every member has its own rate.
#[test]
fn lanes_have_forces_of_their_own_parameters() {
    let run = until(SPIN, "", &format!("{SPIN_START:?}"), (1.0, 10));
    let map = run.method.map();
    let rates = [0.0, 0.4, 2.0];
    let lanes = |values: &[f64; 3]| -> Vec<f64> {
        (values.iter())
            .flat_map(|value| vec![*value; rates.len()])
            .collect()
    };
    let mut parameters = vec![1.3; rates.len()];
    parameters.extend(rates);
    let mut together = vec![0.0; 3 * rates.len()];
    let mut outcome = vec![Ok(()); rates.len()];
    map.stepper(rates.len(), &parameters, 1.0, 0.1).increment(
        &lanes(&SPIN_START),
        &vec![0.0; 3 * rates.len()],
        &mut together,
        &mut outcome,
    );
    for (lane, rate) in rates.iter().enumerate() {
        let alone = increment(map, &[1.3, *rate], (1.0, 0.1), &SPIN_START).expect("a step");
        let own: Vec<f64> = (0..3).map(|i| together[i * rates.len() + lane]).collect();
        assert_eq!(own, alone, "rate {rate}");
    }
}
