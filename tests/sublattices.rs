//! Damped spins, sublattice after sublattice: closed forms of one spin, orders, lengths, bits.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::Registry;
use leafwise::core::diagnostics::fit_slope;
use leafwise::scene::compose;
use leafwise_tests::numbers::distance;
use leafwise_tests::scenes::{composed, document, end, until};

const METHOD: &str = "stepper = \"sublattices\"";

const SPIN: &str = "variables = [\"x\", \"y\", \"z\"]\nbracket = { lie-algebra = \"so3\" }\n\
                    parameters = { B = 1.3, rate = 0.4 }\nhamiltonian = \"-B*z\"\ndamping = { rate = \"rate\" }";

/// z = S tanh(λ B S t + artanh(z(0)/S)) in one step of any size and sign of the field, the angle about the field −B t.
#[test]
fn one_damped_spin_moves_along_its_closed_form() {
    let start: [f64; 3] = [0.9, -0.3, -1.2];
    let size = libm::sqrt(start.iter().map(|x| x * x).sum());
    for field in [1.3, -1.3, 1e-9, 0.0, 40.0] {
        for time in [1e-3, 0.7, 5.0] {
            let system = SPIN.replace("B = 1.3", &format!("B = {field:?}"));
            let state = end(&until(&system, METHOD, &format!("{start:?}"), (time, 1)));
            let z = size * libm::tanh(0.4 * field * size * time + libm::atanh(start[2] / size));
            let angle = libm::atan2(start[1], start[0]) - field * time;
            let across =
                size / libm::cosh(0.4 * field * size * time + libm::atanh(start[2] / size));
            let expected = [across * libm::cos(angle), across * libm::sin(angle), z];
            // The angle itself rounds by an ulp of its size.
            let bound = 8.0 * f64::EPSILON * (1.0 + (field * time).abs()) * size;
            let off = distance(&state, &expected);
            assert!(
                off < bound,
                "{field} {time}: {off:e}, {state:?} for {expected:?}"
            );
        }
    }
}

/// Roundings of lengths walk at random, whichever way the fields stand: 1040 cold spins, of which nearly all follow their field.
#[test]
fn lengths_of_damped_spins_drift_nowhere() {
    let run = composed(
        "[system]\nfamilies = { s = { components = [\"x\", \"y\", \"z\"], length = [40, 26] } }\nbracket = { lie-algebra = \"so3\" }\n\
         parameters = { a = 0.5, T = 0.05 }\nhamiltonian = \"-sum(i, j, dot(s[i,j], s[i+1,j] + s[i,j+1]))\"\ndamping = { rate = \"a\" }\n\
         noise = [{ hamiltonian = \"s.x[i,j]\", strength = \"sqrt(2*a*T)\" }, { hamiltonian = \"s.y[i,j]\", strength = \"sqrt(2*a*T)\" }]\n\
         [method]\nstepper = \"sublattices\"\nnoise = \"split\"\ntime-step = 0.05\n[run]\nsteps = 2000\n\
         initial = { \"s.x[i,j]\" = 0, \"s.y[i,j]\" = 0, \"s.z[i,j]\" = 1 }\n",
    );
    let state = end(&run);
    let sites = state.len() / 3;
    let length = |site: usize| {
        let s = [0, 1, 2].map(|c| state[c * sites + site]);
        // Exact to an ulp of the difference: sums of squares about 1.
        s.iter().fold(-1.0, |sum, s| libm::fma(*s, *s, sum))
    };
    let mean = (0..sites).map(length).sum::<f64>() / sites as f64;
    // Eight flows a step, each of which rounds three components by half an ulp of 1/2 at most.
    let walk = libm::sqrt(8.0 * 2000.0) * f64::EPSILON / libm::sqrt(12.0);
    let bound = 7.0 * walk / libm::sqrt(sites as f64);
    assert!(mean.abs() < bound, "{mean:e}, bound {bound:e}");
}

/// A lattice of spins of two kinds with rates of their own, and a field along z.
fn ferrimagnet(lengths: &str, indices: [&str; 3]) -> String {
    let [index, here, there] = indices;
    let bond = |a: &str, b: &str, at: &str| {
        let products = ["x", "y", "z"].map(|c| format!("{a}.{c}[{here}]*{b}.{c}[{at}]"));
        products.join(" + ")
    };
    format!(
        "families = {{ a = {{ components = [\"x\", \"y\", \"z\"], length = {lengths} }}, \
         b = {{ components = [\"x\", \"y\", \"z\"], length = {lengths} }} }}\n\
         bracket = {{ lie-algebra = \"so3\" }}\nparameters = {{ J = 0.7 }}\n\
         hamiltonian = \"sum({index}, J*({} + {}) - 0.3*a.z[{here}])\"\n\
         damping = {{ rate = 0.2, metric = {{ \"a.x[{here}]\" = 2, \"a.y[{here}]\" = 2, \"a.z[{here}]\" = 2, \
         \"b.x[{here}]\" = 1, \"b.y[{here}]\" = 1, \"b.z[{here}]\" = 1 }} }}",
        bond("a", "b", here),
        bond("b", "a", there)
    )
}

const KINDS: &str = "{ \"a.x[i]\" = \"0.6*cos(i)\", \"a.y[i]\" = \"0.6*sin(i)\", \"a.z[i]\" = \"0.8\", \
                     \"b.x[i]\" = \"cos(2*i)\", \"b.y[i]\" = 0, \"b.z[i]\" = \"sin(2*i)\" }";

/// Against Runge and Kutta's method of order 8 at a step where it is exact to 1e-12: written out, and on rings of two, three and
/// one kind of colours.
#[test]
fn steps_are_of_order_two() {
    let chain = |sites: usize, offset: usize| {
        format!(
            "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"-sum(i, s.x[i]*s.x[i+{offset}] + s.y[i]*s.z[i+1])\"\ndamping = {{ rate = 0.3 }}"
        )
    };
    let spins =
        "{ \"s.x[i]\" = \"0.6*cos(i)\", \"s.y[i]\" = \"0.6*sin(i)\", \"s.z[i]\" = \"0.8\" }";
    let cases = [
        (chain(6, 1), spins, 2),
        (chain(9, 1), spins, 3),
        (chain(12, 2), spins, 3),
        (ferrimagnet("10", ["i", "i", "i+1"]), KINDS, 2),
    ];
    for (system, initial, colours) in cases {
        let reference = end(&until(&system, "stepper = \"dop853\"", initial, (1.0, 100)));
        let points = [10, 20, 40].map(|steps| {
            let run = until(&system, METHOD, initial, (1.0, steps));
            let said = run.method.map().describe();
            assert!(said.contains(&format!("{colours} colours")), "{said}");
            (1.0 / steps as f64, distance(&end(&run), &reference))
        });
        let slope = fit_slope(&points, 1e-11).expect("errors above those of the reference");
        println!("{colours} colours: order {:.3} {points:?}", slope.exponent);
        assert!((slope.exponent - 2.0).abs() < 0.1, "{slope:?} {points:?}");
    }
}

/// Planes and boxes of any parity: a torus of 6 by 9 sites takes three colours, a box of even axes two, and one of 25 by 36 would take
/// ten and is refused where it is long. The motion is that of the implicit map, to the errors of both.
#[test]
fn planes_and_boxes_fall_into_sublattices() {
    let system = |lengths: &str, indices: &str| {
        let here = indices.replace(", ", ",");
        let bonds: Vec<String> = indices
            .split(", ")
            .map(|index| {
                let there = here.replace(index, &format!("{index}+1"));
                let bond = ["x", "y", "z"].map(|c| format!("s.{c}[{here}]*s.{c}[{there}]"));
                bond.join(" + ")
            })
            .collect();
        format!(
            "families = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {lengths} }} }}\nbracket = {{ lie-algebra = \"so3\" }}\n\
             hamiltonian = \"-sum({indices}, {})\"\ndamping = {{ rate = 0.3 }}",
            bonds.join(" + ")
        )
    };
    let mut compared = 0;
    for (lengths, indices, colours) in [("[6, 9]", "i, j", 3), ("[4, 6, 4]", "i, j, k", 2)] {
        let here = indices.replace(", ", ",");
        let initial = format!(
            "{{ \"s.x[{here}]\" = \"0.6*cos(i + 2*j)\", \"s.y[{here}]\" = \"0.6*sin(i + 2*j)\", \"s.z[{here}]\" = \"0.8\" }}"
        );
        let ends = ["", METHOD].map(|method| {
            let run = until(&system(lengths, indices), method, &initial, (1.0, 80));
            let said = run.method.map().describe();
            let is_own = said.contains(&format!("sublattices of {colours} colours"));
            assert_eq!(is_own, !method.is_empty(), "{said}");
            end(&run)
        });
        let apart = distance(&ends[0], &ends[1]);
        println!("{lengths}: {apart:e}");
        assert!(apart < 5e-3 && apart > 1e-9, "{lengths}: {apart:e}");
        compared += 1;
    }
    assert_eq!(compared, 2);
    let text = format!(
        "[system]\n{}\n[method]\n{METHOD}\ntime-step = 0.1\n[run]\nsteps = 1\n[run.initial]\n\"s.x[i,j]\" = 1\n\
         \"s.y[i,j]\" = 0\n\"s.z[i,j]\" = 0\n",
        system("[25, 36]", "i, j")
    );
    let refusal = compose(&document(&text, &[]), &Registry::with_builtin()).err();
    let message = refusal.expect("refused").to_string();
    assert!(message.contains("even length"), "{message}");
    composed(&text.replace("[25, 36]", "[26, 36]"));
}

/// Each is refused with what it is about.
#[test]
fn what_are_no_spins_in_fields_of_others_is_refused() {
    let cases = [
        (SPIN.replace("-B*z", "-B*z^2"), "depends on the spin itself"),
        (
            SPIN.replace("rate = \"rate\" }", "rate = \"rate\", metric = [1, 1, 2] }"),
            "different entries",
        ),
        (
            SPIN.replace("rate = \"rate\"", "rate = \"z^2\""),
            "depends on the spins",
        ),
        (
            SPIN.replace(
                "bracket = { lie-algebra = \"so3\" }",
                "bracket = { \"x,y\" = \"1\" }",
            ),
            "not those of a spin",
        ),
    ];
    for (system, says) in cases {
        let text = format!(
            "[system]\n{system}\n[method]\n{METHOD}\ntime-step = 0.1\n[run]\nsteps = 1\ninitial = [1, 0, 0]\n"
        );
        let refusal = compose(&document(&text, &[]), &Registry::with_builtin()).err();
        let message = refusal.expect(says).to_string();
        assert!(message.contains(says), "{message}");
    }
}
