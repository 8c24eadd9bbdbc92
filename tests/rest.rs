//! Equilibria on leaves, and known bounds of their stability.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::orbit::{Rest, RestError, Verdict, rest};
use leafwise_tests::scenes::until;

const METHOD: &str = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";

fn found(system: &str, initial: &[f64]) -> Result<Rest, RestError> {
    let run = until(system, METHOD, &format!("{initial:?}"), (1.0, 10));
    rest(&run)
}

/// Where a verdict changes, by halving.
fn bound(mut is_unstable: impl FnMut(f64) -> bool, mut unstable: f64, mut other: f64) -> f64 {
    assert!(is_unstable(unstable) && !is_unstable(other));
    for _ in 0..32 {
        let middle = 0.5 * (unstable + other);
        if is_unstable(middle) {
            unstable = middle;
        } else {
            other = middle;
        }
    }
    0.5 * (unstable + other)
}

/// Free bodies turn about their axes in the leaf of |m| as the start has it: about the first and the last for all times, about
/// the second with the exponents ±|m| √((1/I₁ − 1/I₂)(1/I₂ − 1/I₃)).
#[test]
fn a_free_body_turns_about_its_axes() {
    let inertia = [1.0, 2.0, 3.0];
    let system = "variables = [\"m1\", \"m2\", \"m3\"]\nconvention = \"{x,H}\"\n\
        bracket = { \"m1,m2\" = \"-m3\", \"m2,m3\" = \"-m1\", \"m3,m1\" = \"-m2\" }\n\
        casimirs = { C = \"(m1^2 + m2^2 + m3^2)/2\" }\nhamiltonian = \"m1^2/2 + m2^2/4 + m3^2/6\"";
    for axis in 0..3 {
        let mut initial = [0.1, -0.05, 0.08];
        initial[axis] = 1.5;
        let size = libm::sqrt(initial.iter().map(|m| m * m).sum());
        let found = found(system, &initial).expect("an equilibrium");
        println!("{found:?}");
        assert_eq!(found.leaf, 2);
        assert!((found.state[axis] - size).abs() < 1e-12);
        let multiples = found.multiples.expect("∇H is along ∇C");
        assert!((multiples[0] - 1.0 / inertia[axis]).abs() < 1e-12);
        let [a, b] = [1, 2].map(|next| 1.0 / inertia[axis] - 1.0 / inertia[(axis + next) % 3]);
        let rate = size * libm::sqrt((a * b).abs());
        let [one, other] = found.eigenvalues[..] else {
            panic!("two")
        };
        if axis == 1 {
            assert_eq!(found.verdict, Verdict::Unstable);
            assert!((one.re.abs() - rate).abs() < 1e-12 && (one.re + other.re).abs() < 1e-12);
        } else {
            assert_eq!(found.verdict, Verdict::Stable);
            assert!((one.im.abs() - rate).abs() < 1e-12 && one.re.abs() < 1e-12);
        }
        // In the leaf H is curved by −(1/I_axis − 1/I_other).
        let mut expected = [-a, -b];
        expected.sort_by(f64::total_cmp);
        for (own, expected) in found.curvatures.iter().zip(expected) {
            assert!((own - expected).abs() < 1e-12);
        }
    }
    let alone = found(system, &[0.0, 0.0, 0.0]).expect("an equilibrium");
    assert_eq!((alone.verdict, alone.leaf), (Verdict::Alone, 0));
}

/// A symmetric top that sleeps upright with the angular velocity w, (I₁, I₁, I₃), the weight times the distance of its centre g.
fn sleeping((i1, i3, g): (f64, f64, f64), w: f64) -> Rest {
    let system = format!(
        "library = \"heavy-top\"\nparameters = {{ I1 = {i1:?}, I2 = {i1:?}, I3 = {i3:?}, chi1 = 0.0, chi3 = {g:?} }}"
    );
    found(&system, &[0.0, 0.0, i3 * w, 0.0, 0.0, 1.0]).expect("an equilibrium")
}

/// A sleeping top is stable iff (I₃ω)² > 4 m g l I₁. Its energy alone is least in the leaf iff (I₃ − I₁)ω² > m g l:
/// with δγ, δm at right angles to the axis, H − λ₁ m·γ − λ₂|γ|²/2 has the form |δm|²/2I₁ − λ₁ δm·δγ − λ₂|δγ|²/2 with λ₁ = ω and
/// λ₂ = m g l − I₃ω².
#[test]
fn a_sleeping_top_wakes_at_the_known_bound() {
    for (i1, i3, g) in [(1.0, 0.6, 0.7), (0.8, 1.5, 1.0), (2.0, 0.3, 1.3)] {
        let top = (i1, i3, g);
        let exact = libm::sqrt(4.0 * g * i1) / i3;
        let own = bound(
            |w| sleeping(top, w).verdict == Verdict::Unstable,
            0.3 * exact,
            3.0 * exact,
        );
        println!("({i1}, {i3}, {g}): {own} and {exact}");
        assert!((own - exact).abs() < 1e-6, "{own} {exact}");
        let fast = sleeping(top, 40.0 * exact);
        if i3 > i1 {
            let exact = libm::sqrt(g / (i3 - i1));
            let own = bound(
                |w| sleeping(top, w).verdict != Verdict::Stable,
                0.3 * exact,
                3.0 * exact,
            );
            println!("energy: {own} and {exact}");
            assert!((own - exact).abs() < 1e-6, "{own} {exact}");
            assert_eq!(fast.verdict, Verdict::Stable);
        } else {
            assert_eq!(fast.verdict, Verdict::SpectrallyStable);
        }
        let multiples = fast.multiples.expect("both");
        // The library's Casimirs are |γ|² and m·γ.
        let w = 40.0 * exact;
        assert!((multiples[1] / w - 1.0).abs() < 1e-9);
        assert!((2.0 * multiples[0] / (g - i3 * w * w) - 1.0).abs() < 1e-9);
    }
}

/// The triangular points of the restricted problem are stable in the plane iff 27 μ(1 − μ) < 1 (E. Routh 1875).
#[test]
fn triangular_points_are_stable_up_to_rouths_value() {
    let at = |mu: f64| {
        let system = format!(
            "variables = [\"x\", \"y\", \"px\", \"py\"]\nparameters = {{ mu = {mu:?} }}\nbracket = \"canonical\"\n\
             hamiltonian = \"(px^2 + py^2)/2 + y*px - x*py - (1 - mu)/sqrt((x + mu)^2 + y^2) - mu/sqrt((x - 1 + mu)^2 + y^2)\""
        );
        let height = 0.5 * libm::sqrt(3.0);
        let near = [0.5 - mu + 0.01, height + 0.01, -height, 0.5 - mu];
        let found = found(&system, &near).expect("an equilibrium");
        assert!((found.state[0] - 0.5 + mu).abs() < 1e-10);
        found.verdict
    };
    let exact = 0.5 * (1.0 - libm::sqrt(23.0 / 27.0));
    let own = bound(|mu| at(mu) == Verdict::Unstable, 0.2, 0.01);
    println!("{own} and {exact}");
    assert!((own - exact).abs() < 1e-9, "{own} {exact}");
    assert_eq!(at(0.01), Verdict::SpectrallyStable);
}

/// A system of formulas in other units: x_i = X_i/s_i, t = T/τ and H = K/e have {X_i, X_j} = s_i s_j {x_i, x_j}/(τ e).
struct InUnits<'a> {
    names: &'a [&'a str],
    /// Pairs of coordinates with their brackets.
    brackets: &'a [(usize, usize, &'a str)],
    hamiltonian: &'a str,
    casimir: Option<&'a str>,
    initial: &'a [f64],
}

impl InUnits<'_> {
    /// Found with these units, powers of two.
    fn found(&self, units: &[f64], (time, energy): (f64, f64)) -> Result<Rest, RestError> {
        let list = |words: Vec<String>| words.join(", ");
        let own = |i: usize| format!("X{i}");
        let define = self.names.iter().enumerate();
        let define = define.map(|(i, name)| format!("{name} = \"{}/({:e})\"", own(i), units[i]));
        let brackets = self.brackets.iter().map(|(i, j, bracket)| {
            let factor = units[*i] * units[*j] / (time * energy);
            format!("\"{},{}\" = \"({factor:e})*({bracket})\"", own(*i), own(*j))
        });
        let casimirs = self.casimir.map_or_else(String::new, |casimir| {
            format!("casimirs = {{ C = \"{casimir}\" }}\n")
        });
        let variables = (0..self.names.len()).map(|i| format!("\"{}\"", own(i)));
        let system = format!(
            "variables = [{}]\nconvention = \"{{x,H}}\"\ndefine = {{ {} }}\nbracket = {{ {} }}\n{casimirs}hamiltonian = \"({energy:e})*({})\"",
            list(variables.collect()),
            list(define.collect()),
            list(brackets.collect()),
            self.hamiltonian
        );
        let initial: Vec<f64> = self.initial.iter().zip(units).map(|(x, s)| x * s).collect();
        found(&system, &initial)
    }
}

const CANONICAL: [(usize, usize, &str); 1] = [(0, 1, "1")];
const PAIRS: [(usize, usize, &str); 2] = [(0, 2, "1"), (1, 3, "1")];
const SO3: [(usize, usize, &str); 3] = [(0, 1, "-m3"), (1, 2, "-m1"), (0, 2, "m2")];
const E3: [(usize, usize, &str); 9] = [
    (0, 1, "-m3"),
    (1, 2, "-m1"),
    (0, 2, "m2"),
    (0, 4, "-g3"),
    (0, 5, "g2"),
    (1, 3, "g3"),
    (1, 5, "-g1"),
    (2, 3, "-g2"),
    (2, 4, "g1"),
];

fn in_units() -> Vec<(InUnits<'static>, Verdict)> {
    let triangle = "(px^2 + py^2)/2 + y*px - x*py - 0.99/sqrt((x + 0.01)^2 + y^2) - 0.01/sqrt((x - 0.99)^2 + y^2)";
    let canonical = |hamiltonian, initial| InUnits {
        names: &["q", "p"],
        brackets: &CANONICAL,
        hamiltonian,
        casimir: None,
        initial,
    };
    let body = |initial| InUnits {
        names: &["m1", "m2", "m3"],
        brackets: &SO3,
        hamiltonian: "m1^2/2 + m2^2/4 + m3^2/6",
        casimir: Some("(m1^2 + m2^2 + m3^2)/2"),
        initial,
    };
    let top = |initial| InUnits {
        names: &["m1", "m2", "m3", "g1", "g2", "g3"],
        brackets: &E3,
        hamiltonian: "(m1^2 + m2^2)/2 + m3^2/1.2 + 0.7*g3",
        casimir: None,
        initial,
    };
    vec![
        (canonical("p^2/2 - cos(q)", &[0.2, 0.1]), Verdict::Stable),
        (canonical("p^2/2 - cos(q)", &[3.0, 0.1]), Verdict::Unstable),
        (canonical("p^2/2 - cos(q)", &[0.0, 0.0]), Verdict::Stable),
        (body(&[1.5, 0.1, -0.05]), Verdict::Stable),
        (body(&[0.1, 1.5, -0.05]), Verdict::Unstable),
        (body(&[0.0, 0.0, 1.5]), Verdict::Stable),
        (
            top(&[0.0, 0.0, 4.0, 0.0, 0.0, 1.0]),
            Verdict::SpectrallyStable,
        ),
        (top(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]), Verdict::Unstable),
        (
            InUnits {
                names: &["x", "y", "px", "py"],
                brackets: &PAIRS,
                hamiltonian: triangle,
                casimir: None,
                initial: &[0.495, 0.87, -0.866, 0.49],
            },
            Verdict::SpectrallyStable,
        ),
    ]
}

/// Units of coordinates, time and energy change no verdict, nor an eigenvalue over that of time.
#[test]
fn equilibria_know_no_units() {
    let two = |n: i32| libm::exp2(f64::from(n));
    let mut cases = 0;
    for (system, verdict) in in_units() {
        let d = system.names.len();
        let own = system
            .found(&vec![1.0; d], (1.0, 1.0))
            .expect("an equilibrium");
        assert_eq!(own.verdict, verdict, "{}", system.hamiltonian);
        let size = own.eigenvalues[0].modulus();
        for (time, energy, base) in [
            (-30, 0, 0),
            (30, 0, 20),
            (0, 40, -20),
            (20, -20, 40),
            (-20, 20, 13),
        ] {
            // Each coordinate has a unit of its own: 2^±20 and the like.
            let units: Vec<f64> = (0..d as i32)
                .map(|i| two(base * (1 - 2 * (i % 2)) + 7 * (i % 3)))
                .collect();
            let found = system.found(&units, (two(time), two(energy)));
            let found = found.unwrap_or_else(|error| {
                panic!("{error}: {} {units:?} {time} {energy}", system.hamiltonian)
            });
            let said = format!(
                "{} {units:?} {time} {energy}: {found:?}",
                system.hamiltonian
            );
            assert_eq!(
                (found.verdict, found.leaf),
                (own.verdict, own.leaf),
                "{said}"
            );
            assert_eq!(found.eigenvalues.len(), own.eigenvalues.len());
            // Of equal sizes any may be the first.
            for b in &own.eigenvalues {
                let is_near = |a: &leafwise::orbit::Complex| {
                    let [re, im] = [a.re * two(time) - b.re, a.im * two(time) - b.im];
                    re.abs().max(im.abs()) < 1e-7 * size
                };
                assert!(found.eigenvalues.iter().any(is_near), "{said}\n{own:?}");
            }
            assert_eq!(found.multiples.is_some(), own.multiples.is_some(), "{said}");
            cases += 1;
        }
    }
    assert_eq!(cases, 45);
}

/// A motion that falls without end rests in no units.
#[test]
fn no_unit_makes_a_motion_rest() {
    let falling = InUnits {
        names: &["q", "p"],
        brackets: &CANONICAL,
        hamiltonian: "p^2/2 + q",
        casimir: None,
        initial: &[0.3, 0.2],
    };
    for (length, time) in [(0, 0), (-40, 0), (0, 60), (30, -60)] {
        let two = |n: i32| libm::exp2(f64::from(n));
        let found = falling.found(
            &[two(length), two(length - time)],
            (two(time), two(2 * length - 2 * time)),
        );
        assert!(matches!(found, Err(RestError::Moves { .. })), "{found:?}");
    }
}

#[test]
fn what_does_not_rest_is_refused() {
    let free = "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p + q^2\"";
    let refused = found(free, &[0.3, 0.2]);
    assert!(
        matches!(refused, Err(RestError::Moves { .. })),
        "{refused:?}"
    );
    let timed =
        "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 + q*sin(t)\"";
    let refused = found(timed, &[0.3, 0.2]);
    assert!(matches!(refused, Err(RestError::NotOffered { .. })));
}

/// Newton's method comes to the origin of populations and of bodies without Casimirs, which are no points of the leaves of other states.
#[test]
fn points_of_other_leaves_are_refused() {
    let populations = "variables = [\"x\", \"y\"]\nbracket = { log-canonical = [[0, 1], [-1, 0]] }\n\
        hamiltonian = \"x - ln(x) + y - 2*ln(y)\"";
    let body = "variables = [\"m1\", \"m2\", \"m3\"]\nconvention = \"{x,H}\"\n\
        bracket = { \"m1,m2\" = \"-m3\", \"m2,m3\" = \"-m1\", \"m3,m1\" = \"-m2\" }\n\
        hamiltonian = \"m1^2/2 + m2^2/4 + m3^2/6\"";
    let mut count = 0;
    for (system, initial) in [
        (populations, &[0.05, 0.05][..]),
        (populations, &[0.001, 0.001]),
        (body, &[1.0, 0.5, -0.2]),
    ] {
        match found(system, initial) {
            Ok(found) => assert_eq!(found.leaf, 2, "{found:?}"),
            Err(error) => {
                count += usize::from(matches!(
                    error,
                    RestError::OtherLeaf { .. } | RestError::NoValue { .. }
                ))
            }
        }
    }
    assert!(count > 0);
}
