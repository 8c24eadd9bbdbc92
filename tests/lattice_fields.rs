//! Steppers that take fields alone, on lattices that are too long to be written out and on sums over pairs.

use leafwise_tests::numbers::distance;
use leafwise_tests::scenes::{composed, end, until};

/// Spins (a cos ki, a sin ki, c) on a ferromagnetic ring of 400 sites, 133 turns, with what the system has beside.
fn spiral(beside: &str) -> (String, String) {
    let system = format!(
        "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = 400 }} }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
         parameters = {{ J = 0.7, g = 0.3 }}\nhamiltonian = \"-J*sum(i, dot(s[i], s[i+1]))\"\n{beside}"
    );
    let initial = "{ \"s.x[i]\" = \"0.6*cos(2*pi*133*i/400)\", \"s.y[i]\" = \"0.6*sin(2*pi*133*i/400)\", \"s.z[i]\" = 0.8 }";
    (system, initial.to_owned())
}

/// Of which the angle has turned by −2Jc(1 − cos k) τ, and every length is times `scale`.
fn turned(tau: f64, scale: f64) -> Vec<f64> {
    let k = 2.0 * std::f64::consts::PI * 133.0 / 400.0;
    let angle = -2.0 * 0.7 * 0.8 * (1.0 - libm::cos(k)) * tau;
    let of = |f: fn(f64) -> f64, i: usize| scale * 0.6 * f(k * i as f64 + angle);
    let x = (0..400).map(|i| of(libm::cos, i));
    let y = (0..400).map(|i| of(libm::sin, i));
    x.chain(y).chain((0..400).map(|_| scale * 0.8)).collect()
}

/// The spiral is an exact solution; under friction −g s it turns as c e^(−gt) does.
#[test]
fn spirals_turn_as_they_do_by_any_baseline() {
    let friction = "friction = { \"s.x[i]\" = \"-g*s.x[i]\", \"s.y[i]\" = \"-g*s.y[i]\", \"s.z[i]\" = \"-g*s.z[i]\" }";
    let time = 3.0;
    let lasting = [
        ("", turned(time, 1.0)),
        (
            friction,
            turned((1.0 - libm::exp(-0.3 * time)) / 0.3, libm::exp(-0.3 * time)),
        ),
    ];
    for (beside, expected) in lasting {
        let (system, initial) = spiral(beside);
        let off = |method: &str, steps| {
            let run = until(&system, method, &initial, (time, steps));
            distance(&end(&run), &expected)
        };
        // Tolerances of 1e-12 a step of size 1, over few steps.
        assert!(off("stepper = \"dop853\"", 30) < 1e-10, "{beside}");
        assert!(
            off("stepper = \"dormand-prince45\"", 30) < 1e-10,
            "{beside}"
        );
        for (method, order) in [
            ("stepper = \"rk4\"", 4.0),
            ("stepper = \"gauss\"", 4.0),
            ("stepper = \"implicit-midpoint\"", 2.0),
        ] {
            let [coarse, fine] = [15, 30].map(|steps| off(method, steps));
            let slope = libm::log2(coarse / fine);
            assert!(
                (slope - order).abs() < 0.2,
                "{method} {beside}: {coarse:e} {fine:e}"
            );
        }
    }
}

/// s × B with B = J Σ neighbours + (0, 0, 0.3), at every site of a plane.
fn field(state: &[f64], lengths: [usize; 2], is_open: bool) -> Vec<f64> {
    let sites = lengths[0] * lengths[1];
    let at = |site: usize| [0, 1, 2].map(|c| state[c * sites + site]);
    let mut all = vec![0.0; state.len()];
    for site in 0..sites {
        let place = [site / lengths[1], site % lengths[1]];
        let mut b = [0.0, 0.0, 0.3];
        for axis in 0..2 {
            for by in [lengths[axis] - 1, 1] {
                let sum = place[axis] + by;
                let is_beyond = match by {
                    1 => sum >= lengths[axis],
                    _ => place[axis] == 0,
                };
                if is_open && is_beyond {
                    continue;
                }
                let mut there = place;
                there[axis] = sum % lengths[axis];
                let other = at(there[0] * lengths[1] + there[1]);
                b.iter_mut().zip(other).for_each(|(b, s)| *b += 0.7 * s);
            }
        }
        let s = at(site);
        for c in 0..3 {
            let [d, e] = [(c + 1) % 3, (c + 2) % 3];
            all[c * sites + site] = s[d] * b[e] - s[e] * b[d];
        }
    }
    all
}

/// Runge and Kutta's steps of the field written out by hand.
#[test]
fn a_plane_steps_as_its_field_written_by_hand() {
    for is_open in [false, true] {
        let boundary = if is_open { "open" } else { "periodic" };
        let run = composed(&format!(
            "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = [19, 21] }} }}\nboundary = \"{boundary}\"\n\
             bracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"-0.7*sum(i, j, dot(s[i,j], s[i+1,j]) + dot(s[i,j], s[i,j+1])) - 0.3*sum(i, j, s.z[i,j])\"\n\
             [method]\nstepper = \"rk4\"\ntime-step = 0.05\n[run]\nsteps = 20\n\
             initial = {{ \"s.x[i,j]\" = \"sin(i + 3*j)\", \"s.y[i,j]\" = \"cos(i*j)\", \"s.z[i,j]\" = \"sin(2*i - j)\" }}\n"
        ));
        let mut x = run.plan.initial.clone();
        let (lengths, h) = ([19, 21], 0.05);
        for _ in 0..20 {
            let beside = |x: &[f64], k: &[f64], part: f64| -> Vec<f64> {
                x.iter().zip(k).map(|(x, k)| x + part * h * k).collect()
            };
            let of = |x: &[f64]| field(x, lengths, is_open);
            let k1 = of(&x);
            let k2 = of(&beside(&x, &k1, 0.5));
            let k3 = of(&beside(&x, &k2, 0.5));
            let k4 = of(&beside(&x, &k3, 1.0));
            for at in 0..x.len() {
                x[at] += h / 6.0 * (k1[at] + 2.0 * k2[at] + 2.0 * k3[at] + k4[at]);
            }
        }
        // Twenty steps of some ten roundings each, in numbers of order 1.
        let off = distance(&end(&run), &x);
        assert!(off < 200.0 * f64::EPSILON * 2.0, "{boundary}: {off:e}");
    }
}

/// Sixteen vortices about one in the middle turn at (N − 1)Γ/4πR² + Γ/2πR², and the one in the middle stays there. Round-off is
/// all that it has, and no tolerance relative to itself can be met.
#[test]
fn adaptive_steps_take_bodies_at_rest_in_the_middle() {
    let system = "library = \"vortices\"\nfamilies = { x = 17, y = 17 }";
    for radius in [1.0, 1e6] {
        let place = |of: &str| format!("\"{radius}*min(i,1)*{of}(2*pi*i/(N-1))\"");
        let initial = format!(
            "{{ \"x[i]\" = {}, \"y[i]\" = {} }}",
            place("cos"),
            place("sin")
        );
        let time = 2.0 * radius * radius;
        for method in ["stepper = \"dop853\"", "stepper = \"dormand-prince45\""] {
            let run = until(system, method, &initial, (time, 10));
            let state = end(&run);
            let rate = (15.0 / 4.0 + 0.5) / std::f64::consts::PI / (radius * radius);
            let expected = (0..17).map(|i| {
                let angle = 2.0 * std::f64::consts::PI * f64::from(i) / 16.0 + rate * time;
                let size = if i == 0 { 0.0 } else { radius };
                [size * libm::cos(angle), size * libm::sin(angle)]
            });
            let expected: Vec<[f64; 2]> = expected.collect();
            for (i, [x, y]) in expected.iter().enumerate() {
                let off = libm::hypot(state[i] - x, state[17 + i] - y);
                assert!(off < 1e-10 * radius, "{method} {radius} {i}: {off:e}");
            }
        }
    }
}

/// A plane of pendulums of which all but one wave are at 0 up to round-off.
#[test]
fn adaptive_steps_take_coordinates_of_round_off_on_lattices() {
    let system = "families = { q = [30, 30], p = [30, 30] }\nbracket = \"canonical\"\nconvention = \"{x,H}\"\n\
                  hamiltonian = \"sum(i, j, p[i,j]^2/2 + (q[i+1,j] - q[i,j])^2/2 + (q[i,j+1] - q[i,j])^2/2)\"";
    let initial = "{ \"q[i,j]\" = \"sin(2*pi*i/3)\", \"p[i,j]\" = 0 }";
    let time = 3.0;
    for method in ["stepper = \"dop853\"", "stepper = \"dormand-prince45\""] {
        let state = end(&until(system, method, initial, (time, 6)));
        // ω² = 2(1 − cos k) of k = 2π/3.
        let now = libm::cos(libm::sqrt(3.0) * time);
        for (at, q) in state[..900].iter().enumerate() {
            let begin = libm::sin(2.0 * std::f64::consts::PI * (at / 30) as f64 / 3.0);
            assert!((q - begin * now).abs() < 1e-10, "{method} {at}: {q:e}");
        }
    }
}

/// A damped spiral by `splitting` is refused with what serves, and both that is named there do serve.
#[test]
fn what_is_advised_for_damping_takes_it() {
    let (system, initial) = spiral("damping = { rate = \"0.1\" }");
    let scene = |method: &str| {
        let text = format!(
            "[system]\n{system}\n[method]\n{method}\ntime-step = 0.05\n[run]\ninitial = {initial}\nsteps = 4\n"
        );
        let registry = leafwise_core::Registry::with_builtin();
        leafwise_scene::compose(&leafwise_tests::scenes::document(&text, &[]), &registry)
    };
    let Err(refusal) = scene("stepper = \"splitting\"") else {
        panic!("splitting takes damping");
    };
    let help = refusal.help.expect("help");
    assert!(
        help.starts_with("dynamics = \"one-form\" in the place of `stepper`"),
        "{help}"
    );
    let (_, names) = help.rsplit_once(": ").expect("steppers");
    let steppers = names
        .split(", ")
        .map(|name| format!("stepper = \"{name}\""));
    let methods = std::iter::once("dynamics = \"one-form\"".to_owned()).chain(steppers);
    let mut ends = Vec::new();
    for method in methods {
        let run = scene(&method).unwrap_or_else(|refusal| panic!("{method}: {refusal}"));
        ends.push(end(&run));
    }
    assert!(ends.len() >= 4, "{help}");
    for other in &ends[1..] {
        // Steps of 0.05 at rates up to 2: methods of order 2 differ by (0.1)^3 a step.
        assert!(
            distance(&ends[0], other) <= 4e-3,
            "{}",
            distance(&ends[0], other)
        );
    }
}

/// Chains of 20 to 32 sites in long steps, whose sizes within a step grow on and on: the error stays near the tolerance.
#[test]
fn adaptive_steps_of_chains_meet_their_tolerance() {
    let mut ran = 0;
    for (at, sites) in [12_usize, 20, 24, 29, 30, 32].into_iter().enumerate() {
        for stepper in ["dop853", "dormand-prince45", "taylor"] {
            for step in [1.0, 2.0] {
                let phase = 1.1 + 0.1 * at as f64;
                let run = composed(&format!(
                    "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = \"canonical\"\n\
                     hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2 - q[i]^2/2 + q[i]^4/4)\"\n\
                     [method]\nstepper = {{ name = \"{stepper}\", tolerance = 1e-12 }}\ntime-step = {step:?}\n\
                     [run]\nsteps = 4\ninitial = {{ \"q[i]\" = \"0.3*sin({phase:?}*i) + 0.1*cos(i^2)\", \"p[i]\" = 0 }}\n"
                ));
                let mut energy = run.invariants().expect("code");
                let mut value = [0.0];
                let mut at_state = |state: &[f64]| {
                    energy.evaluate(state, &mut value);
                    value[0]
                };
                let change = at_state(&end(&run)) - at_state(&run.plan.initial);
                // Up to 500 substeps of 1e-12 each of sizes of order 1, at 32 sites.
                let bound = 500.0 * 1e-12 * sites as f64;
                assert!(
                    change.abs() <= bound,
                    "{stepper} {sites} {step}: {change:e}"
                );
                ran += 1;
            }
        }
    }
    assert_eq!(ran, 36);
}
