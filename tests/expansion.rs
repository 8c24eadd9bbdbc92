//! What exact algebra makes of a Hamiltonian, against integrations that expand nothing.

use leafwise::core::{PartParameters, PoissonSystem, Registry};
use leafwise_tests::gauss::flow;
use leafwise_tests::method;
use leafwise_tests::methods::{compose, run};
use leafwise_tests::numbers::distance;
use leafwise_tests::systems::from_formulas;
use proptest::prelude::*;

fn canonical(hamiltonian: &str) -> PoissonSystem {
    from_formulas(&["q", "p"], &[], &[("q,p", "-1")], hamiltonian, &[])
}

/// The distance of Hamilton–Jacobi steps of order m over time 0.4 from a Gauss method of high order.
fn error(system: &PoissonSystem, m: usize, initial: &[f64], steps: usize) -> f64 {
    let (time, map) = (0.4, method(system, 1, m));
    let found = run(system, &map, (1.0, time / steps as f64), steps, initial).expect("steps");
    distance(&found, &flow(system, initial, time, 64))
}

/// Potentials with 1/f of a sum with negative powers, by itself or in a derivative: order 4 shows.
/// Fields and their derivatives are of order 1 at q = 4, so that h⁴ t bounds the error by 1e-6.
#[test]
fn potentials_with_negative_powers_in_denominators_keep_the_order() {
    for potential in [
        "1/(1 - 2/q)",
        "1/(2 - 1/q)",
        "1/(1 + 2/q)",
        "1/(q - 2*p/q)",
        "1/(1 - 1/q^2)",
        "1/(2 + exp(-q))",
        "1/(1 - exp(-q/9))",
        "sqrt(1 - 1/q^2)",
        "(1 - 1/q)^(1/3)",
        "asin(1/q)",
        "acos(1/q)",
        "atanh(1/q)",
        "ln(3 - 2/q)",
        "1/(2*p + 3*q*p + 1)",
        "1/(q + p + q*p)",
    ] {
        let system = canonical(&format!("p^2/2 + {potential}"));
        let [coarse, fine] = [20, 40].map(|steps| error(&system, 4, &[4.0, 0.1], steps));
        assert!(coarse < 1e-6, "{potential}: {coarse:.1e}");
        // Round-off of forty steps.
        assert!(
            fine < coarse / 12.0 || fine < 1e-13,
            "{potential}: {coarse:.1e} {fine:.1e}"
        );
    }
}

/// (q^1000)^66 is q^66000: its field is 66 q^65999 at 1/1000. A power that the expansion cannot hold
/// is not taken for another one.
#[test]
fn a_power_too_large_to_expand_moves_as_itself_or_is_refused() {
    let system = canonical("p^2/2 + (q^1000)^66/1e3");
    let map = compose(&system, 1, 2);
    if let Ok(map) = map {
        let found = run(&system, &map, (1.0, 1e-7), 10, &[1.0, 0.1]).expect("steps");
        let expected = flow(&system, &[1.0, 0.1], 1e-6, 10);
        // Order 2 with frequencies of about 2e3: (h ω)² relative to a change of 6.6e-5.
        assert!(
            distance(&found, &expected) < 1e-10,
            "{found:?} {expected:?}"
        );
    }
}

/// Powers of shifted coordinates: expanded, their terms are up to 10²⁰ times their sums.
const SHIFTED: [(&str, f64); 9] = [
    ("(q - 10)^12", 10.9),
    ("(q - 10)^14", 10.9),
    ("(q - 10)^8", 10.9),
    ("(q - 10)^6", 10.7),
    ("(q - 100)^8", 100.9),
    ("(q - 100)^4", 100.9),
    ("(q - 1000)^4", 1000.9),
    ("(q - 1000)^5 + (q - 1000)^2", 1000.4),
    ("(q - 30)^4 + (q - 30)^2", 30.3),
];

/// Strang's product of the exact flows of p²/2 and of the potential, of order 2: without the potential's
/// digits errors do not fall with the step.
#[test]
fn splittings_keep_the_digits_of_shifted_powers() {
    let registry = Registry::with_builtin();
    let splitting = registry.stepper("splitting").expect("built in");
    for (potential, q) in SHIFTED {
        let initial = [q, 0.1];
        let system = canonical(&format!("p^2/2 + {potential}"));
        let system = system.with_near(&initial).expect("two coordinates");
        let map = splitting
            .build(&system, &PartParameters::new())
            .expect("it splits");
        let time = 0.4;
        let exact = flow(&system, &initial, time, 400);
        let [coarse, fine] = [400, 800].map(|steps| {
            let found = run(
                &system,
                map.as_ref(),
                (1.0, time / steps as f64),
                steps,
                &initial,
            );
            distance(&found.expect("explicit steps"), &exact)
        });
        assert!(coarse < 1e-4, "{potential}: {coarse:.1e}");
        let ratio = coarse / fine;
        assert!(
            (3.5..4.5).contains(&ratio),
            "{potential}: {coarse:.1e} {fine:.1e}"
        );
    }
}

/// Order 6 at h = 0.01: h⁶ times derivatives of a few hundred, and ulps of q.
#[test]
fn hamilton_jacobi_keeps_the_digits_of_shifted_powers() {
    for (potential, q) in SHIFTED.into_iter().chain([
        ("(q - 20)^5 + (q - 20)^2", 20.4),
        ("(q - 1000)^3 + (q - 1000)^2", 1000.4),
    ]) {
        let initial = [q, 0.1];
        let system = canonical(&format!("p^2/2 + {potential}"));
        let system = system.with_near(&initial).expect("two coordinates");
        let found = error(&system, 6, &initial, 40);
        let fine = error(&system, 6, &initial, 80);
        let round_off = 100.0 * f64::EPSILON * q;
        assert!(found < 1e-5, "{potential}: {found:.1e}");
        assert!(
            fine < found / 30.0 || fine < round_off,
            "{potential}: {found:.1e} {fine:.1e}"
        );
    }
}

/// A difference of coordinates far from the origin cancels as much as a difference from a number.
#[test]
fn powers_of_differences_of_coordinates_keep_their_digits() {
    let bracket = [("x,u", "-1"), ("y,v", "-1")];
    let names = ["x", "y", "u", "v"];
    let energy = "u^2/2 + v^2/2 + (x - y)^6 + (x - y)^2/2";
    let initial = [500.6, 500.0, 0.1, -0.1];
    let system = from_formulas(&names, &[], &bracket, energy, &[]);
    let system = system.with_near(&initial).expect("four coordinates");
    let found = error(&system, 4, &initial, 40);
    let fine = error(&system, 4, &initial, 80);
    assert!(
        found < 1e-6 && (fine < found / 12.0 || fine < 1e-11),
        "{found:.1e} {fine:.1e}"
    );
}

/// Where no motion is polynomial in time the flow cannot be computed from the formula: it is refused.
#[test]
fn a_splitting_whose_exponential_flow_cancels_is_refused() {
    let names = ["x", "y"];
    let system = from_formulas(&names, &[], &[("x,y", "x*y")], "(x - 100)^9 + y", &[]);
    let registry = Registry::with_builtin();
    let splitting = registry.stepper("splitting").expect("built in");
    let build = |near: [f64; 2]| {
        let system = system.with_near(&near).expect("two coordinates");
        splitting.build(&system, &PartParameters::new())
    };
    let refusal = build([100.5, 1.0]).err().expect("round-off");
    assert!(refusal.to_string().contains("cancel"), "{refusal}");
    assert!(build([0.5, 1.0]).is_ok(), "nothing cancels there");
}

/// 1/I^7 at I = 1e-46 is no double; the series as code forms no such power.
#[test]
fn a_body_of_the_size_of_a_molecule_turns() {
    let moments = [("a", 1.0e-46), ("b", 1.9e-46), ("c", 2.9e-46)];
    let bracket = [("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y")];
    let energy = "x^2/(2*a) + y^2/(2*b) + z^2/(2*c)";
    let initial = [0.3e-34, 1.1e-34, -0.7e-34];
    let system = from_formulas(&["x", "y", "z"], &moments, &bracket, energy, &[]);
    let system = system.with_near(&initial).expect("three coordinates");
    // The same body in units of 1e-46 and 1e-34: the time unit is 1e-12.
    let unit = |value: f64, unit: f64| value / unit;
    let moments = moments.map(|(name, value)| (name, unit(value, 1e-46)));
    let scaled = from_formulas(&["x", "y", "z"], &moments, &bracket, energy, &[]);
    let small = run(&system, &method(&system, 4, 8), (1.0, 1e-13), 20, &initial).expect("steps");
    let scaled_initial = initial.map(|x| unit(x, 1e-34));
    let large = run(
        &scaled,
        &method(&scaled, 4, 8),
        (1.0, 0.1),
        20,
        &scaled_initial,
    );
    let small: Vec<f64> = small.iter().map(|x| x / 1e-34).collect();
    // Round-off of twenty steps and of the units.
    assert!(distance(&small, &large.expect("steps")) < 1e-13);
}

/// The series ends with the order that is too long, not with the machine's memory.
#[test]
fn a_series_that_grows_too_long_is_refused_with_its_order() {
    let system = canonical("exp(q)*sin(p) + cos(q*p)");
    let refusal = compose(&system, 1, 20).expect_err("too long");
    let text = refusal.to_string();
    assert!(text.contains("S_") && text.contains("take order"), "{text}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Random quotients, roots and logarithms of sums with powers of either sign.
    #[test]
    fn random_potentials_keep_the_order(
        a in 1..5_i64, b in 1..5_i64, k in -3..4_i64, l in -3..4_i64, form in 0..6_usize,
    ) {
        let sum = format!("({a}*q^({k}) + {b}*q^({l}) + q*p/({a}+q))");
        let potential = match form {
            0 => format!("1/{sum}"),
            1 => format!("sqrt({sum})"),
            2 => format!("ln({sum})"),
            3 => format!("atan({sum})"),
            4 => format!("q/{sum}^2"),
            _ => format!("asinh(1/{sum})"),
        };
        let system = canonical(&format!("p^2/2 + ({potential})/20"));
        let initial = [1.5, 0.4];
        let [coarse, fine] = [40, 80].map(|steps| error(&system, 4, &initial, steps));
        prop_assert!(coarse < 1e-4, "{potential}: {coarse:.1e}");
        prop_assert!(fine < coarse / 8.0 || fine < 1e-12, "{potential}: {coarse:.1e} {fine:.1e}");
    }
}
